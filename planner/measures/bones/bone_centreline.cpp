#include "planner/measures/bones/bone_centreline.h"

#include "mesh/base/assert.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace retractor::planner {

namespace {

    /// Least thickness of a slice; a rib is about as thick, and bends little over this length.
    constexpr double kSliceMm = 10.0;
    /// Least thickness of a slice in mean edges, so that each slice has vertices all round.
    constexpr double kSliceEdges = 1.5;
    /// The first slices stand askew; each round stands them across the line that it was given. What is left askew
    /// hardly changes a moment, because the centroid of a slanted section lies on the bone's axis too.
    constexpr int kRounds = 4;

    struct Neighbour {
        std::size_t vertex = 0;
        double edge_mm = 0.0;
    };

    struct CornerGraph {
        std::vector<std::vector<Neighbour>> of; ///< empty for midpoints
        std::vector<double> volume_mm3; ///< share of each corner in its elements; 0 for midpoints
        double mean_edge_mm = 0.0;
    };

    CornerGraph corner_graph(const mesh::TetMesh& bone)
    {
        CornerGraph graph;
        graph.of.resize(bone.vertex_count());
        graph.volume_mm3.assign(bone.vertex_count(), 0.0);
        double edges = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(bone.tet_count()); ++t) {
            const auto nodes = bone.tet(t);
            for (std::size_t a = 0; a < 4; ++a)
                graph.volume_mm3[static_cast<std::size_t>(nodes[a])] += 0.25 * mesh::tet_volume(bone, t);
            for (const auto& [i, j] : mesh::kTetEdges) {
                const auto a = static_cast<std::size_t>(nodes[static_cast<std::size_t>(i)]),
                           b = static_cast<std::size_t>(nodes[static_cast<std::size_t>(j)]);
                const double length = (point_at(bone.vertices, static_cast<VertexId>(a))
                    - point_at(bone.vertices, static_cast<VertexId>(b)))
                                          .norm();
                graph.of[a].push_back({ b, length });
                graph.of[b].push_back({ a, length });
                graph.mean_edge_mm += length;
                edges += 1.0;
            }
        }
        graph.mean_edge_mm /= std::max(edges, 1.0);
        return graph;
    }

    /// Distances along edges from a corner; infinite for midpoints.
    std::vector<double> distances_from(const CornerGraph& graph, std::size_t start)
    {
        std::vector<double> distance(graph.of.size(), std::numeric_limits<double>::infinity());
        using Entry = std::pair<double, std::size_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        distance[start] = 0.0;
        open.emplace(0.0, start);
        while (!open.empty()) {
            const auto [reached, v] = open.top();
            open.pop();
            if (reached > distance[v])
                continue;
            for (const Neighbour& next : graph.of[v])
                if (reached + next.edge_mm < distance[next.vertex]) {
                    distance[next.vertex] = reached + next.edge_mm;
                    open.emplace(distance[next.vertex], next.vertex);
                }
        }
        return distance;
    }

    std::size_t farthest(const std::vector<double>& distance)
    {
        std::size_t at = 0;
        for (std::size_t v = 0; v < distance.size(); ++v)
            if (std::isfinite(distance[v]) && (!std::isfinite(distance[at]) || distance[v] > distance[at]))
                at = v;
        return at;
    }

    /// The least and the largest distance of a corner.
    std::pair<double, double> range_of(const CornerGraph& graph, const std::vector<double>& along)
    {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t v = 0; v < along.size(); ++v)
            if (!graph.of[v].empty()) {
                low = std::min(low, along[v]);
                high = std::max(high, along[v]);
            }
        return { low, high };
    }

    /// The centroids of slices of equal thickness; a slice without vertices is left out. A vertex counts in the two
    /// slices between whose middles it lies, so that the centroids do not jump when the slices turn a little.
    std::vector<Vec3> slice_centroids(
        const mesh::TetMesh& bone, const CornerGraph& graph, const std::vector<double>& along, std::size_t slices)
    {
        const auto [low, high] = range_of(graph, along);
        std::vector<Vec3> sum(slices, Vec3::Zero());
        std::vector<double> volume(slices, 0.0);
        for (std::size_t v = 0; v < along.size(); ++v) {
            if (graph.of[v].empty())
                continue;
            const auto last = static_cast<double>(slices - 1);
            const double part
                = std::clamp((along[v] - low) / (high - low) * static_cast<double>(slices) - 0.5, 0.0, last);
            const auto slice = static_cast<std::size_t>(part);
            const double share = part - static_cast<double>(slice);
            const auto add = [&](std::size_t to, double weight) {
                sum[to] += weight * point_at(bone.vertices, static_cast<VertexId>(v));
                volume[to] += weight;
            };
            add(slice, (1.0 - share) * graph.volume_mm3[v]);
            if (share > 0.0)
                add(slice + 1, share * graph.volume_mm3[v]);
        }
        std::vector<Vec3> centroids;
        for (std::size_t slice = 0; slice < slices; ++slice)
            if (volume[slice] > 0.0)
                centroids.emplace_back(sum[slice] / volume[slice]);
        return centroids;
    }

    /// Position of a point along a line of points. The first and last segment go on beyond the line.
    double project(const std::vector<Vec3>& line, const std::vector<double>& start_mm, const Vec3& point)
    {
        double nearest = std::numeric_limits<double>::infinity(), along = 0.0;
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
            const Vec3 segment = line[i + 1] - line[i];
            const double length = segment.norm();
            double t = (point - line[i]).dot(segment) / length;
            if (i > 0)
                t = std::max(t, 0.0);
            if (i + 2 < line.size())
                t = std::min(t, length);
            const double distance = (point - line[i] - t / length * segment).norm();
            if (distance < nearest)
                nearest = distance, along = start_mm[i] + t;
        }
        return along;
    }

    std::vector<double> project_all(const mesh::TetMesh& bone, const CornerGraph& graph, const std::vector<Vec3>& line)
    {
        std::vector<double> start_mm { 0.0 };
        for (std::size_t i = 0; i + 1 < line.size(); ++i)
            start_mm.push_back(start_mm.back() + (line[i + 1] - line[i]).norm());
        std::vector<double> along(bone.vertex_count(), 0.0);
        for (std::size_t v = 0; v < along.size(); ++v)
            if (!graph.of[v].empty())
                along[v] = project(line, start_mm, point_at(bone.vertices, static_cast<VertexId>(v)));
        return along;
    }

    /// Gives each midpoint the mean of its edge's ends, and moves the first end to 0.
    BoneCentreline finished(const mesh::TetMesh& bone, const CornerGraph& graph, std::vector<double> along)
    {
        const auto [low, high] = range_of(graph, along);
        for (std::size_t v = 0; v < along.size(); ++v)
            along[v] -= low;
        if (bone.nodes_per_tet == 10)
            for (TetId t = 0; t < static_cast<TetId>(bone.tet_count()); ++t)
                for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                    const auto nodes = bone.tet(t);
                    if (mesh::is_straight(nodes, e))
                        continue;
                    const auto& [a, b] = mesh::kTetEdges[e];
                    along[static_cast<std::size_t>(nodes[4 + e])] = 0.5
                        * (along[static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)])]
                            + along[static_cast<std::size_t>(nodes[static_cast<std::size_t>(b)])]);
                }
        return { high - low, std::move(along) };
    }

} // namespace

BoneCentreline bone_centreline(const mesh::TetMesh& bone)
{
    const BoneCentreline none { 0.0, std::vector<double>(bone.vertex_count(), 0.0) };
    if (bone.tet_count() == 0)
        return none;
    const CornerGraph graph = corner_graph(bone);
    const auto corner = static_cast<std::size_t>(bone.tet(0)[0]);
    std::vector<double> along = distances_from(graph, farthest(distances_from(graph, corner)));
    const double thickness = std::max(kSliceMm, kSliceEdges * graph.mean_edge_mm);
    for (int round = 0; round < kRounds; ++round) {
        const auto [low, high] = range_of(graph, along);
        const auto slices = static_cast<std::size_t>(std::max(0.0, std::round((high - low) / thickness)));
        if (slices < 3)
            return none;
        const std::vector<Vec3> line = slice_centroids(bone, graph, along, slices);
        if (line.size() < 2)
            return none;
        along = project_all(bone, graph, line);
    }
    return finished(bone, graph, std::move(along));
}

} // namespace retractor::planner
