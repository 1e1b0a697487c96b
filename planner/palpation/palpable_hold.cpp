#include "planner/palpation/palpable_hold.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/surface_normals.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    /// Distances from one vertex along the surface's edges, mm; infinite where no path leads.
    std::vector<double> ways_from(VertexId from, const TriMesh& surface, const std::vector<std::vector<VertexId>>& next)
    {
        std::vector<double> way(next.size(), std::numeric_limits<double>::infinity());
        std::set<std::pair<double, VertexId>> open { { 0.0, from } };
        way[static_cast<std::size_t>(from)] = 0.0;
        while (!open.empty()) {
            const auto [so_far, v] = *open.begin();
            open.erase(open.begin());
            for (const VertexId n : next[static_cast<std::size_t>(v)]) {
                const double there = so_far + (surface.vertices.row(n) - surface.vertices.row(v)).norm();
                double& best = way[static_cast<std::size_t>(n)];
                if (there >= best)
                    continue;
                open.erase({ best, n });
                best = there;
                open.emplace(there, n);
            }
        }
        return way;
    }

    /// A vertex of the largest piece of the surface, by number of vertices.
    VertexId in_largest_piece(const TriMesh& surface, const std::vector<std::vector<VertexId>>& next)
    {
        std::vector<char> seen(next.size(), 0);
        VertexId best = surface.triangles.front()[0];
        std::size_t most = 0;
        for (std::size_t v = 0; v < next.size(); ++v) {
            if (seen[v] != 0 || next[v].empty())
                continue;
            std::vector<VertexId> piece { static_cast<VertexId>(v) };
            seen[v] = 1;
            for (std::size_t i = 0; i < piece.size(); ++i)
                for (const VertexId n : next[static_cast<std::size_t>(piece[i])])
                    if (std::exchange(seen[static_cast<std::size_t>(n)], char { 1 }) == 0)
                        piece.push_back(n);
            if (piece.size() > most) {
                most = piece.size();
                best = static_cast<VertexId>(v);
            }
        }
        return best;
    }

    /// Distance of each vertex from the nearer end of the body along its surface, mm. The two ends of a vessel are the
    /// two places farthest from each other. Only the largest piece has ends; the distance is infinite on all others.
    std::vector<double> ways_from_ends(const TriMesh& surface)
    {
        std::vector<std::vector<VertexId>> next(static_cast<std::size_t>(surface.vertices.rows()));
        for (const auto& triangle : surface.triangles)
            for (std::size_t c = 0; c < 3; ++c)
                next[static_cast<std::size_t>(triangle[c])].push_back(triangle[(c + 1) % 3]);
        const auto farthest = [](const std::vector<double>& way) {
            std::size_t best = 0;
            for (std::size_t v = 0; v < way.size(); ++v)
                if (std::isfinite(way[v]) && (!std::isfinite(way[best]) || way[v] > way[best]))
                    best = v;
            return static_cast<VertexId>(best);
        };
        const VertexId a = farthest(ways_from(in_largest_piece(surface, next), surface, next));
        const std::vector<double> from_a = ways_from(a, surface, next);
        const VertexId b = farthest(from_a);
        const std::vector<double> from_b = ways_from(b, surface, next);
        const double apart = from_a[static_cast<std::size_t>(b)];
        std::vector<double> short_of(next.size(), std::numeric_limits<double>::infinity());
        for (std::size_t v = 0; v < short_of.size(); ++v)
            if (std::isfinite(from_a[v]))
                short_of[v] = std::min(apart - from_a[v], apart - from_b[v]);
        return short_of;
    }

    /// Tells which holder of the request holds a vertex of the surface.
    class Holder {
    public:
        Holder(const mesh::LabelVolume& labels, const PalpableRequest& request, bool hollow, const TriMesh& surface)
            : labels_(labels)
            , low_(surface.vertices.colwise().minCoeff().transpose())
            , high_(surface.vertices.colwise().maxCoeff().transpose())
        {
            const bool chosen = !request.held.empty();
            std::vector<std::string> wanted = request.held;
            if (!chosen)
                wanted = hollow ? std::vector<std::string> { "border", "heart", "spine", "ends:20" }
                                : std::vector<std::string> { "border", "back:12" };
            for (const std::string& name : wanted)
                add(name, chosen, request);
            if (std::any_of(holders_.begin(), holders_.end(), [](const One& one) { return one.ends; }))
                from_end_ = ways_from_ends(surface);
        }

        /// The number of the first holder that holds the vertex, or nothing.
        std::optional<std::size_t> holds(VertexId v, const Vec3& point, const Vec3& outward) const
        {
            for (std::size_t h = 0; h < names.size(); ++h)
                if (holders_[h].ends            ? from_end_[static_cast<std::size_t>(v)] <= holders_[h].depth
                        : holders_[h].axis >= 0 ? beyond(holders_[h], point)
                                                : beside(holders_[h], point, outward))
                    return h;
            return std::nullopt;
        }

        std::vector<std::string> names;

    private:
        struct One {
            int axis = -1; ///< 0 to 2: a side of the body
            double sign = 1.0, depth = 0.0;
            bool border = false, ends = false;
            std::vector<Label> labels;
        };

        void add(const std::string& name, bool chosen, const PalpableRequest& request)
        {
            One one;
            const std::size_t colon = name.find(':');
            if (name == "border")
                one.border = true;
            else if (colon != std::string::npos)
                one = side(name, colon);
            else {
                for (const mesh::LabelInfo& info : labels_.table)
                    if (info.name == name || (name == "spine" && info.name.starts_with("vertebra")))
                        one.labels.push_back(info.id);
                if (one.labels.empty() && chosen)
                    label_of(labels_, name, "held");
                if (one.labels.empty())
                    return;
            }
            if (std::find(request.structure.begin(), request.structure.end(), name) != request.structure.end()) {
                if (!chosen)
                    return;
                throw InputError("a structure does not hold itself", "held " + name, { "held" });
            }
            names.push_back(name);
            holders_.push_back(one);
        }

        static One side(const std::string& name, std::size_t colon)
        {
            constexpr std::array<std::pair<const char*, std::pair<int, double>>, 6> kSides { { { "left", { 0, 1.0 } },
                { "right", { 0, -1.0 } }, { "back", { 1, 1.0 } }, { "front", { 1, -1.0 } }, { "head", { 2, 1.0 } },
                { "foot", { 2, -1.0 } } } };
            One one;
            for (const auto& [word, where] : kSides)
                if (name.substr(0, colon) == word) {
                    one.axis = where.first;
                    one.sign = where.second;
                }
            const char* const end = name.data() + name.size();
            const auto read = std::from_chars(name.data() + colon + 1, end, one.depth);
            one.ends = name.substr(0, colon) == "ends";
            if ((one.axis < 0 && !one.ends) || read.ec != std::errc {} || read.ptr != end || !(one.depth > 0.0)
                || !std::isfinite(one.depth))
                throw InputError("a side is head, foot, front, back, left, right or ends, and mm, such as foot:10",
                    "held " + name, { "held" });
            return one;
        }

        bool beyond(const One& one, const Vec3& point) const
        {
            const double end = one.sign > 0.0 ? high_[one.axis] : -low_[one.axis];
            return one.sign * point[one.axis] >= end - one.depth;
        }

        bool beside(const One& one, const Vec3& point, const Vec3& outward) const
        {
            // The reach exceeds the half voxel between the smooth surface and the voxels, and does not extend beyond
            // the neighbouring organ.
            constexpr double kReach = 2.0, kStep = 0.5; // largest voxel edges
            const double voxel = labels_.grid.spacing.maxCoeff();
            for (double way = kStep; way <= kReach; way += kStep) {
                const Vec3 there = point + way * voxel * outward;
                const Vec3 index = labels_.grid.index(there);
                bool in_image = true;
                for (int axis = 0; axis < 3; ++axis)
                    in_image = in_image && index[axis] >= -0.5
                        && index[axis] <= labels_.grid.size[static_cast<std::size_t>(axis)] - 0.5;
                if (!in_image)
                    return one.border;
                const Label label = mesh::label_at(labels_, there);
                if (std::find(one.labels.begin(), one.labels.end(), label) != one.labels.end())
                    return true;
            }
            return false;
        }

        const mesh::LabelVolume& labels_;
        Vec3 low_, high_;
        std::vector<One> holders_;
        std::vector<double> from_end_; ///< distance of each vertex from the nearer end along the surface, mm
    };

} // namespace

void hold_surface(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request, bool hollow, std::vector<std::string>& notes)
{
    const Holder holder(labels, request, hollow, surface);
    const Points normals = mesh::vertex_normals(surface);
    std::vector<char> used(static_cast<std::size_t>(surface.vertices.rows()), 0);
    for (const auto& triangle : surface.triangles)
        for (const VertexId v : triangle)
            used[static_cast<std::size_t>(v)] = 1;
    std::vector<bool> holds(holder.names.size(), false);
    for (std::size_t v = 0; v < used.size(); ++v) {
        const auto row = static_cast<Eigen::Index>(v);
        if (used[v] == 0)
            continue;
        const auto by = holder.holds(
            static_cast<VertexId>(v), surface.vertices.row(row).transpose(), normals.row(row).transpose());
        if (!by)
            continue;
        scene.body.roles[v] = datasets::VertexRole::fixed;
        holds[*by] = true;
    }
    std::vector<std::string> held;
    for (std::size_t h = 0; h < holds.size(); ++h)
        if (holds[h])
            held.push_back(holder.names[h]);
    notes.push_back("held at: " + (held.empty() ? "nothing" : joined(held)));
}

void refuse_floating(datasets::PalpationScene& scene, std::vector<std::string>& notes)
{
    constexpr double kCrumb = 0.02; // share of all elements
    constexpr std::size_t kLeastFixed = 3;
    datasets::ElasticModel& body = scene.body;
    const std::vector<int> piece_of = mesh::connected_pieces(body.mesh);
    const int pieces = 1 + *std::max_element(piece_of.begin(), piece_of.end());
    std::vector<std::size_t> tets(static_cast<std::size_t>(pieces), 0);
    std::vector<std::set<VertexId>> fixed(static_cast<std::size_t>(pieces));
    for (std::size_t t = 0; t < piece_of.size(); ++t) {
        ++tets[static_cast<std::size_t>(piece_of[t])];
        for (const VertexId v : body.mesh.tet(static_cast<TetId>(t)))
            if (body.roles[static_cast<std::size_t>(v)] == datasets::VertexRole::fixed)
                fixed[static_cast<std::size_t>(piece_of[t])].insert(v);
    }
    std::size_t dropped = 0;
    std::vector<char> stays(tets.size(), 1);
    for (std::size_t p = 0; p < tets.size(); ++p) {
        if (fixed[p].size() >= kLeastFixed)
            continue;
        if (static_cast<double>(tets[p]) > kCrumb * static_cast<double>(piece_of.size()))
            throw InputError("nothing holds " + std::string(pieces > 1 ? "a piece of it" : "it")
                    + ": name what does, such as heart,spine or foot:10"
                    + (pieces > 1 ? "; thin tissue that fell apart needs shorter edges" : ""),
                scene.name,
                pieces > 1 ? std::vector<std::string> { "held", "edge_mm" } : std::vector<std::string> { "held" });
        stays[p] = 0;
        ++dropped;
    }
    if (dropped == 0)
        return;
    notes.push_back(std::to_string(dropped) + " small pieces that nothing holds are left out");
    std::vector<VertexId> number(body.mesh.vertex_count(), -1), kept;
    datasets::ElasticModel rest;
    for (std::size_t t = 0; t < piece_of.size(); ++t) {
        if (stays[static_cast<std::size_t>(piece_of[t])] == 0)
            continue;
        for (const VertexId v : body.mesh.tet(static_cast<TetId>(t))) {
            VertexId& n = number[static_cast<std::size_t>(v)];
            if (n < 0) {
                n = static_cast<VertexId>(kept.size());
                kept.push_back(v);
                rest.roles.push_back(body.roles[static_cast<std::size_t>(v)]);
            }
            rest.mesh.nodes.push_back(n);
        }
        rest.mesh.labels.push_back(body.mesh.labels[t]);
        rest.youngs_modulus.push_back(body.youngs_modulus[t]);
        rest.poissons_ratio.push_back(body.poissons_ratio[t]);
    }
    rest.mesh.vertices = body.mesh.vertices(kept, Eigen::all);
    body = std::move(rest);
}

} // namespace retractor::planner
