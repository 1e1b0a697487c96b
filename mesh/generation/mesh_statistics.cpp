#include "mesh/generation/mesh_statistics.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/statistics.h"
#include "mesh/base/triangle.h"

#include <algorithm>
#include <cmath>

namespace retractor::mesh {

namespace {

    constexpr int kVoxelSamples = 3; ///< samples per axis in voxels that a distance border crosses
    constexpr int kTetSplits = 3; ///< divides an element at the corridor's border into at most 2^9 parts

    using Corners = std::array<Vec3, 4>;

    /// Volume (mm^3) of the part of a tetrahedron within `radius` of the polyline. A tetrahedron that the border
    /// crosses is bisected at its longest edge; the centroid decides for the smallest parts.
    double volume_within(const std::vector<Vec3>& polyline, double radius, const Corners& c, int splits)
    {
        const double volume = std::abs(tet_volume(c[0], c[1], c[2], c[3]));
        const Vec3 centroid = (c[0] + c[1] + c[2] + c[3]) / 4.0;
        double reach = 0.0;
        for (const Vec3& p : c)
            reach = std::max(reach, (p - centroid).norm());
        const double distance = polyline_distance(polyline, centroid);
        if (distance + reach <= radius)
            return volume;
        if (distance - reach > radius)
            return 0.0;
        if (splits == 0)
            return distance <= radius ? volume : 0.0;
        std::array<int, 2> longest { 0, 1 };
        const auto length = [&](const std::array<int, 2>& e) {
            return (c[static_cast<std::size_t>(e[0])] - c[static_cast<std::size_t>(e[1])]).squaredNorm();
        };
        for (const auto& edge : kTetEdges)
            if (length(edge) > length(longest))
                longest = edge;
        const auto a = static_cast<std::size_t>(longest[0]), b = static_cast<std::size_t>(longest[1]);
        Corners first = c, second = c;
        first[a] = second[b] = 0.5 * (c[a] + c[b]);
        return volume_within(polyline, radius, first, splits - 1) + volume_within(polyline, radius, second, splits - 1);
    }

    void add_voxel_volumes(
        const LabelField& field, const LocalLines& lines, const MeshSizing& sizing, std::vector<LabelFit>& fit)
    {
        const WallVoxels& wall = field.wall();
        const double volume = wall.spacing.prod();
        const CorridorDistance corridor(lines.corridor, field.lower(), field.upper());
        const CorridorDistance region(lines.region, field.lower(), field.upper());
        for (int k = 0; k < wall.size[2]; ++k)
            for (int j = 0; j < wall.size[1]; ++j)
                for (int i = 0; i < wall.size[0]; ++i) {
                    const int label = wall.voxels[wall.offset(i, j, k)];
                    if (label == 0)
                        continue;
                    LabelFit& of = fit[static_cast<std::size_t>(label - 1)];
                    const Vec3 centre = wall.centre(i, j, k);
                    of.voxel_volume_mm3 += sizing.region_mm > 0.0 && !wall.whole[static_cast<std::size_t>(label - 1)]
                        ? volume * region.share(sizing.region_mm, centre, wall.spacing, kVoxelSamples)
                        : volume;
                    if (!lines.corridor.empty())
                        of.corridor_voxel_volume_mm3
                            += volume * corridor.share(sizing.corridor_radius_mm, centre, wall.spacing, kVoxelSamples);
                }
    }

    void add_mesh_volumes(const TetMesh& local, const std::vector<int>& number, const std::vector<Vec3>& corridor,
        const MeshSizing& sizing, std::vector<LabelFit>& fit)
    {
        for (TetId t = 0; t < static_cast<TetId>(local.tet_count()); ++t) {
            const Corners c = tet_corners(local, t);
            RETRACTOR_ASSERT(number[local.labels[static_cast<std::size_t>(t)]] > 0);
            LabelFit& of = fit[static_cast<std::size_t>(number[local.labels[static_cast<std::size_t>(t)]] - 1)];
            of.mesh_volume_mm3 += std::abs(tet_volume(c[0], c[1], c[2], c[3]));
            if (!corridor.empty())
                of.corridor_mesh_volume_mm3 += volume_within(corridor, sizing.corridor_radius_mm, c, 3 * kTetSplits);
        }
    }

    /// Distance (mm) along the normal from a point on a face, with label `inside` behind the face, to the place where
    /// the label function changes from or to that label; the search ends at `reach`.
    double distance_to_interface(
        const LabelField& field, const Vec3& p, const Vec3& normal, int inside, double step, double reach)
    {
        const bool in = field.at(p) == inside;
        const Vec3 way = in ? normal : Vec3(-normal);
        for (double d = step; d < reach; d += step)
            if ((field.at(p + d * way) == inside) != in)
                return d - 0.5 * step;
        return reach;
    }

    void surface_distances(
        const TetMesh& local, const std::vector<int>& number, const LabelField& field, MeshStatistics& statistics)
    {
        // Every face between two labels is counted once, from the tetrahedron with the larger label number.
        const std::vector<FaceRecord> faces = sorted_faces(local);
        const double step = 0.05 * field.wall().spacing.minCoeff();
        const double reach = 4.0 * field.wall().spacing.maxCoeff();
        std::vector<std::pair<double, double>> samples; // distance, area
        double area_sum = 0.0, weighted = 0.0;
        const auto middle_of = [&](const TetFace& face) -> Vec3 {
            const auto [a, b, c] = triangle_corners(local.vertices, face_vertices(local, face));
            return (a + b + c) / 3.0;
        };
        const auto sample = [&](const TetFace& face) {
            const auto [a, b, c] = triangle_corners(local.vertices, face_vertices(local, face));
            const Vec3 normal = unit_normal(a, b, c);
            const double area = triangle_area(a, b, c);
            const int inside = field.merged(number[local.labels[static_cast<std::size_t>(face.tet)]], middle_of(face));
            for (const Vec3& p : { Vec3((a + b + c) / 3.0), Vec3((4 * a + b + c) / 6.0), Vec3((a + 4 * b + c) / 6.0),
                     Vec3((a + b + 4 * c) / 6.0) }) {
                const double d = distance_to_interface(field, p, normal, inside, step, reach);
                samples.emplace_back(d, area / 4.0);
                area_sum += area / 4.0;
                weighted += d * area / 4.0;
            }
        };
        // Between elements of the coarse model there is no interface that the mesh follows.
        const auto label_of = [&](const FaceRecord& r) {
            return field.merged(number[local.labels[static_cast<std::size_t>(r.face.tet)]], middle_of(r.face));
        };
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const bool paired = i + 1 < faces.size() && faces[i + 1].key == faces[i].key;
            if (!paired)
                sample(faces[i].face);
            else if (label_of(faces[i]) != label_of(faces[i + 1]))
                sample((label_of(faces[i]) > label_of(faces[i + 1]) ? faces[i] : faces[i + 1]).face);
            i += paired;
        }
        if (samples.empty())
            return;
        std::sort(samples.begin(), samples.end());
        statistics.surface_distance_mean_mm = weighted / area_sum;
        statistics.surface_distance_p95_mm
            = weighted_percentile(samples, 0.95, area_sum, [](const auto& s) { return s.second; })->first;
    }

    void angles(const TetMesh& mesh, MeshStatistics& statistics)
    {
        std::vector<double> smallest;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Corners c = tet_corners(mesh, t);
            const auto angle = dihedral_angles_deg(c[0], c[1], c[2], c[3]);
            smallest.push_back(*std::min_element(angle.begin(), angle.end()));
        }
        std::sort(smallest.begin(), smallest.end());
        statistics.dihedral_worst_deg = smallest.front();
        statistics.dihedral_p01_deg = smallest[smallest.size() / 100];
    }

    int piece_count(const TetMesh& mesh)
    {
        const std::vector<int> piece = connected_pieces(mesh);
        return piece.empty() ? 0 : *std::max_element(piece.begin(), piece.end()) + 1;
    }

} // namespace

MeshStatistics mesh_statistics(const TetMesh& mesh, const LabelVolume& labels, const LabelField& field,
    const LocalLines& lines, const MeshSizing& sizing)
{
    RETRACTOR_ASSERT(lines.corridor.size() == sizing.corridor.size());
    RETRACTOR_ASSERT(lines.region.size() == sizing.corridor.size() + sizing.coarse_path.size());
    MeshStatistics statistics;
    statistics.vertices = mesh.vertex_count();
    statistics.tets = mesh.tet_count();
    statistics.bytes = mesh.vertex_count() * sizeof(Vec3) + mesh.nodes.size() * sizeof(VertexId)
        + mesh.labels.size() * sizeof(Label);

    std::vector<int> number(65536, 0);
    for (std::size_t n = 0; n < field.wall().labels.size(); ++n) {
        const Label label = field.wall().labels[n];
        number[label] = static_cast<int>(n) + 1;
        statistics.fit.push_back({ .label = label });
    }
    TetMesh local = mesh;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        local.vertices.row(v)
            = (labels.grid.direction.transpose() * (mesh.vertices.row(v).transpose() - labels.grid.origin)).transpose();
    if (labels.grid.direction.determinant() < 0.0) // mirrored axes turn the elements inside out in the local frame
        for (std::size_t t = 0; t < local.tet_count(); ++t)
            std::swap(local.nodes[4 * t + 2], local.nodes[4 * t + 3]);

    add_voxel_volumes(field, lines, sizing, statistics.fit);
    add_mesh_volumes(local, number, lines.corridor, sizing, statistics.fit);
    std::erase_if(
        statistics.fit, [](const LabelFit& fit) { return fit.voxel_volume_mm3 == 0.0 && fit.mesh_volume_mm3 == 0.0; });
    double voxels = 0.0, tets = 0.0;
    for (const LabelFit& fit : statistics.fit) {
        voxels += fit.voxel_volume_mm3;
        tets += fit.mesh_volume_mm3;
    }
    statistics.total_volume_error = voxels > 0.0 ? std::abs(tets - voxels) / voxels : 0.0;
    if (mesh.tet_count() == 0)
        return statistics;

    surface_distances(local, number, field, statistics);
    angles(mesh, statistics);
    statistics.pieces = piece_count(mesh);
    for (const Label label : field.wall().labels)
        if (const std::string& name = find_label(labels.table, label)->name; name.starts_with("rib"))
            if (const TetMesh rib = part_with_labels(mesh, std::span(&label, 1)); rib.tet_count() > 0)
                statistics.rib_pieces[name] = piece_count(rib);
    return statistics;
}

} // namespace retractor::mesh
