#include "planner/palpable.h"

#include "mesh/base/error.h"
#include "mesh/hybrid_model.h"
#include "mesh/surface_normals.h"
#include "mesh/wall_shell.h"
#include "planner/words.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

namespace retractor {

namespace {

    constexpr Label kUsual = 1, kStiff = 2;
    constexpr double kVesselWall = 2.0, kWallEdge = 5.0; ///< mm
    constexpr const char* kVessel = "vessel";

    const LabelInfo& label_of(const LabelVolume& labels, const std::string& name, const char* where)
    {
        if (const LabelInfo* info = find_label(labels.table, name))
            return *info;
        throw InputError("there is no structure \"" + name + "\"; there are " + names_of(labels.table), where);
    }

    void check_range(double value, double low, double high, const char* what, const char* where)
    {
        if (value >= low && value <= high)
            return;
        std::array<char, 96> limits {};
        std::snprintf(limits.data(), limits.size(), " lies between %g and %g, not at %g", low, high, value);
        throw InputError(what + std::string(limits.data()), where);
    }

    void check_request(const LabelVolume& labels, const PalpableRequest& request)
    {
        if (request.structure.empty())
            throw InputError("names what to palpate; there are " + names_of(labels.table), "--structure");
        for (const std::string& name : request.structure)
            label_of(labels, name, "--structure");
        if (request.wall_mm && *request.wall_mm != 0.0)
            check_range(*request.wall_mm, 0.5, 20.0, "a wall's thickness (mm; 0: solid)", "--wall");
        if (request.edge_mm)
            check_range(*request.edge_mm, 1.0, 40.0, "the length of edges (mm)", "--edge");
        if (request.youngs_modulus_MPa)
            check_range(*request.youngs_modulus_MPa, 1e-4, 1e4, "Young's modulus (MPa)", "--young");
        if (request.poissons_ratio)
            check_range(*request.poissons_ratio, 0.0, 0.495, "Poisson's ratio", "--poisson");
        for (const StiffPlace& place : request.stiff) {
            check_range(place.youngs_modulus_MPa, 1e-4, 1e4, "Young's modulus (MPa)", "--stiff");
            if (!place.where.is_sphere())
                label_of(labels, place.where.label, "--stiff");
            else if (!(place.where.centre.allFinite() && place.where.radius_mm > 0.0))
                throw InputError("a ball has a finite centre and a positive radius", "--stiff");
        }
        std::set<std::string> names;
        for (const auto& [name, point] : request.sites)
            if (name.empty() || !point.allFinite() || !names.insert(name).second)
                throw InputError("sites have names of their own and finite points", "--site " + name);
    }

    bool is_hollow(const LabelVolume& labels, const PalpableRequest& request)
    {
        if (request.wall_mm)
            return *request.wall_mm > 0.0;
        return std::all_of(request.structure.begin(), request.structure.end(), [&](const std::string& name) {
            return label_of(labels, name, "--structure").material.starts_with(kVessel);
        });
    }

    bool holds_blood(const LabelVolume& labels, const PalpableRequest& request)
    {
        return std::all_of(request.structure.begin(), request.structure.end(), [&](const std::string& name) {
            const std::string& material = label_of(labels, name, "--structure").material;
            return material.starts_with(kVessel) || material == "heart";
        });
    }

    /// The structure alone, ready to be meshed; a hollow one as a single label.
    LabelVolume structure_alone(const LabelVolume& labels, const PalpableRequest& request, bool hollow)
    {
        LabelVolume alone { labels.grid, labels.voxels, {} };
        std::vector<Label> becomes(std::size_t { std::numeric_limits<Label>::max() } + 1, 0);
        for (std::size_t s = 0; s < request.structure.size(); ++s) {
            LabelInfo info = label_of(labels, request.structure[s], "--structure");
            if (becomes[info.id] != 0)
                throw InputError("is named twice", "--structure " + request.structure[s]);
            if (std::find(labels.voxels.begin(), labels.voxels.end(), info.id) == labels.voxels.end())
                throw InputError("has no voxel", "--structure " + request.structure[s]);
            const Label id = hollow ? kUsual : static_cast<Label>(s + 1);
            becomes[info.id] = id;
            info.id = id;
            info.role = Role::wall;
            if (!hollow || s == 0)
                alone.table.push_back(info);
        }
        for (Label& voxel : alone.voxels)
            voxel = becomes[voxel];
        return alone;
    }

    constexpr double kVoxels = 1.25; ///< smoothed by so many at the least: single voxels tell no shape

    /// A Gaussian along one axis of the grid; at the image's border the border's voxels go on.
    void blur_along(std::vector<float>& values, const std::array<int, 3>& size, std::size_t axis, double sigma_voxels)
    {
        const int reach = static_cast<int>(std::ceil(3.0 * sigma_voxels));
        std::vector<float> weights, line(static_cast<std::size_t>(size[axis]));
        for (int d = -reach; d <= reach; ++d)
            weights.push_back(static_cast<float>(std::exp(-0.5 * d * d / (sigma_voxels * sigma_voxels))));
        const float sum = std::accumulate(weights.begin(), weights.end(), 0.0F);
        std::size_t step = 1;
        for (std::size_t a = 0; a < axis; ++a)
            step *= static_cast<std::size_t>(size[a]);
        for (std::size_t start = 0; start < values.size(); ++start) {
            if (start / step % line.size() != 0)
                continue;
            for (std::size_t i = 0; i < line.size(); ++i)
                line[i] = values[start + i * step];
            for (int i = 0; i < size[axis]; ++i) {
                float value = 0.0F;
                for (int d = -reach; d <= reach; ++d)
                    value += weights[static_cast<std::size_t>(d + reach)]
                        * line[static_cast<std::size_t>(std::clamp(i + d, 0, size[axis] - 1))];
                values[start + static_cast<std::size_t>(i) * step] = value / sum;
            }
        }
    }

    /// A body without what is much thinner than `sigma_mm` and with its dents filled: fingers meet organs, not single
    /// voxels. Where labels meet, each point goes to the one that has most round it.
    LabelVolume smoothed(LabelVolume body, double sigma_mm)
    {
        ImageGrid& grid = body.grid;
        std::array<int, 3> low = grid.size, high { 0, 0, 0 };
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i)
                    if (body.voxels[grid.offset(i, j, k)] != 0) {
                        const std::array<int, 3> at { i, j, k };
                        for (std::size_t a = 0; a < 3; ++a) {
                            low[a] = std::min(low[a], at[a]);
                            high[a] = std::max(high[a], at[a]);
                        }
                    }
        std::array<int, 3> size {};
        for (std::size_t a = 0; a < 3; ++a) {
            const int margin = 1 + static_cast<int>(std::ceil(3.0 * sigma_mm / grid.spacing[static_cast<int>(a)]));
            low[a] = std::max(0, low[a] - margin);
            size[a] = std::min(grid.size[a] - 1, high[a] + margin) - low[a] + 1;
        }
        const auto each = [&](auto&& act) {
            std::size_t n = 0;
            for (int k = 0; k < size[2]; ++k)
                for (int j = 0; j < size[1]; ++j)
                    for (int i = 0; i < size[0]; ++i)
                        act(body.voxels[grid.offset(low[0] + i, low[1] + j, low[2] + k)], n++);
        };
        const std::size_t count
            = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
        std::vector<float> most(count, 0.0F), sum(count, 0.0F), share(count);
        std::vector<Label> winner(count, 0);
        for (const LabelInfo& info : body.table) {
            each([&](Label voxel, std::size_t n) { share[n] = voxel == info.id ? 1.0F : 0.0F; });
            for (std::size_t axis = 0; axis < 3; ++axis)
                blur_along(share, size, axis, sigma_mm / grid.spacing[static_cast<int>(axis)]);
            for (std::size_t n = 0; n < count; ++n) {
                sum[n] += share[n];
                if (share[n] > most[n]) {
                    most[n] = share[n];
                    winner[n] = info.id;
                }
            }
        }
        each([&](Label& voxel, std::size_t n) { voxel = sum[n] > 0.5F ? winner[n] : Label { 0 }; });
        if (std::all_of(body.voxels.begin(), body.voxels.end(), [](Label v) { return v == 0; }))
            throw InputError("is too thin to be meshed: thinner than its wall, or than two voxels",
                "--structure " + body.table.front().name);
        return body;
    }

    double volume_of(const LabelVolume& alone)
    {
        return alone.grid.voxel_volume()
            * static_cast<double>(
                std::count_if(alone.voxels.begin(), alone.voxels.end(), [](Label v) { return v != 0; }));
    }

    TetMesh meshed(const LabelVolume& alone, double edge_mm, const Job& job)
    {
        MeshSizing sizing;
        sizing.coarse_edge_mm = edge_mm;
        HybridModel model = build_hybrid_model(alone, sizing, job);
        if (model.status == MeshStatus::nothing_to_mesh)
            throw SolverError("the structure was not meshed: " + model.message
                    + "; what is thin takes edges shorter than " + in_words(edge_mm, 1) + " mm (--edge)",
                alone.table.front().name);
        if (model.status != MeshStatus::done)
            throw SolverError("the structure was not meshed: " + model.message, alone.table.front().name);
        return std::move(model.wall);
    }

    TriMesh boundary_of(const TetMesh& mesh)
    {
        TriMesh surface { mesh.vertices, {}, {} };
        for (const TetFace& face : boundary_faces(mesh))
            surface.triangles.push_back(face_vertices(mesh, face));
        return surface;
    }

    Vec3 centroid(const TriMesh& surface, std::size_t t)
    {
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : surface.triangles[t])
            sum += surface.vertices.row(v).transpose();
        return sum / 3.0;
    }

    Vec3 area_normal(const TriMesh& surface, std::size_t t)
    {
        const auto& [a, b, c] = surface.triangles[t];
        const Vec3 pa = surface.vertices.row(a).transpose(), pb = surface.vertices.row(b).transpose(),
                   pc = surface.vertices.row(c).transpose();
        return 0.5 * (pb - pa).cross(pc - pa);
    }

    /// Along the surface's edges from one vertex, mm; infinite where no way leads.
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

    /// A vertex of the piece of the surface that has most of them.
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

    /// How far each vertex is from the nearer end of the body, along its surface, mm: a vessel's two ends are the
    /// places farthest from each other. Of several pieces the largest has ends; infinite on all others.
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

    /// What holds a vertex of the surface.
    class Holder {
    public:
        Holder(const LabelVolume& labels, const PalpableRequest& request, bool hollow, const TriMesh& surface)
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

        /// The number of the first holder that holds it, or none.
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
                for (const LabelInfo& info : labels_.table)
                    if (info.name == name || (name == "spine" && info.name.starts_with("vertebra")))
                        one.labels.push_back(info.id);
                if (one.labels.empty() && chosen)
                    label_of(labels_, name, "--held");
                if (one.labels.empty())
                    return;
            }
            if (std::find(request.structure.begin(), request.structure.end(), name) != request.structure.end()) {
                if (!chosen)
                    return;
                throw InputError("a structure does not hold itself", "--held " + name);
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
                    "--held " + name);
            return one;
        }

        bool beyond(const One& one, const Vec3& point) const
        {
            const double end = one.sign > 0.0 ? high_[one.axis] : -low_[one.axis];
            return one.sign * point[one.axis] >= end - one.depth;
        }

        bool beside(const One& one, const Vec3& point, const Vec3& outward) const
        {
            // Past the half voxel that the smooth surface may stand off the voxels', short of the next organ but one.
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
                const Label label = label_at(labels_, there);
                if (std::find(one.labels.begin(), one.labels.end(), label) != one.labels.end())
                    return true;
            }
            return false;
        }

        const LabelVolume& labels_;
        Vec3 low_, high_;
        std::vector<One> holders_;
        std::vector<double> from_end_; ///< per vertex, along the surface, mm
    };

    /// Roles of the surface's vertices (numbers of `mesh`), and what is to be said of them.
    void hold(PalpationScene& scene, const TriMesh& surface, const Holder& holder, std::vector<std::string>& notes)
    {
        const Points normals = vertex_normals(surface);
        std::vector<char> used(static_cast<std::size_t>(surface.vertices.rows()), 0);
        for (const auto& triangle : surface.triangles)
            for (const VertexId v : triangle)
                used[static_cast<std::size_t>(v)] = 1;
        std::vector<std::size_t> count(holder.names.size(), 0);
        for (std::size_t v = 0; v < used.size(); ++v) {
            const auto row = static_cast<Eigen::Index>(v);
            if (used[v] == 0)
                continue;
            const auto by = holder.holds(
                static_cast<VertexId>(v), surface.vertices.row(row).transpose(), normals.row(row).transpose());
            if (!by)
                continue;
            scene.body.roles[v] = VertexRole::fixed;
            ++count[*by];
        }
        std::string held;
        for (std::size_t h = 0; h < count.size(); ++h)
            if (count[h] > 0)
                held += (held.empty() ? "" : ", ") + holder.names[h] + " (" + std::to_string(count[h]) + " vertices)";
        notes.push_back("held at: " + (held.empty() ? "nothing" : held));
    }

    /// Pieces that nothing holds would float.
    void refuse_floating(PalpationScene& scene, std::vector<std::string>& notes)
    {
        constexpr double kCrumb = 0.02; // of all elements
        constexpr std::size_t kLeastFixed = 3;
        ElasticModel& body = scene.body;
        const std::vector<int> piece_of = connected_pieces(body.mesh);
        const int pieces = 1 + *std::max_element(piece_of.begin(), piece_of.end());
        std::vector<std::size_t> tets(static_cast<std::size_t>(pieces), 0);
        std::vector<std::set<VertexId>> fixed(static_cast<std::size_t>(pieces));
        for (std::size_t t = 0; t < piece_of.size(); ++t) {
            ++tets[static_cast<std::size_t>(piece_of[t])];
            for (const VertexId v : body.mesh.tet(static_cast<TetId>(t)))
                if (body.roles[static_cast<std::size_t>(v)] == VertexRole::fixed)
                    fixed[static_cast<std::size_t>(piece_of[t])].insert(v);
        }
        std::size_t dropped = 0;
        std::vector<char> stays(tets.size(), 1);
        for (std::size_t p = 0; p < tets.size(); ++p) {
            if (fixed[p].size() >= kLeastFixed)
                continue;
            if (static_cast<double>(tets[p]) > kCrumb * static_cast<double>(piece_of.size()))
                throw InputError("nothing holds " + std::string(pieces > 1 ? "a piece of it" : "it")
                        + ": name what does by --held, such as heart,spine or foot:10"
                        + (pieces > 1 ? "; what is thin and fell apart takes shorter edges (--edge)" : ""),
                    scene.name);
            stays[p] = 0;
            ++dropped;
        }
        if (dropped == 0)
            return;
        notes.push_back(std::to_string(dropped) + " small pieces that nothing holds are left out");
        std::vector<VertexId> number(body.mesh.vertex_count(), -1), kept;
        ElasticModel rest;
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

    void give_elasticity(PalpationScene& scene, const LabelVolume& labels, const LabelTable& alone,
        const MaterialTable& materials, const PalpableRequest& request, std::vector<std::string>& notes)
    {
        ElasticModel& body = scene.body;
        std::vector<std::array<double, 2>> of(alone.size());
        for (std::size_t s = 0; s < alone.size(); ++s) {
            const Material& material = find_material(materials, alone[s].material);
            of[s] = { request.youngs_modulus_MPa.value_or(material.youngs_modulus_MPa),
                request.poissons_ratio.value_or(material.poissons_ratio) };
            notes.push_back(alone[s].name + ": Young's modulus " + in_words(of[s][0], of[s][0] < 0.1 ? 4 : 2)
                + " MPa, Poisson's ratio " + in_words(of[s][1], 2)
                + (request.youngs_modulus_MPa ? ", as asked" : " (" + material.name + ": " + material.source + ")"));
        }
        std::vector<std::size_t> changed(request.stiff.size(), 0);
        for (std::size_t t = 0; t < body.mesh.tet_count(); ++t) {
            const auto& [young, poisson] = of[std::size_t { body.mesh.labels[t] } - 1];
            body.youngs_modulus.push_back(young);
            body.poissons_ratio.push_back(poisson);
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : body.mesh.tet(static_cast<TetId>(t)))
                middle += 0.25 * body.mesh.vertices.row(v).transpose();
            for (std::size_t p = 0; p < request.stiff.size(); ++p) {
                const TargetSpec& where = request.stiff[p].where;
                if (where.is_sphere() ? (middle - where.centre).norm() > where.radius_mm
                                      : label_at(labels, middle) != find_label(labels.table, where.label)->id)
                    continue;
                body.youngs_modulus.back() = request.stiff[p].youngs_modulus_MPa;
                if (scene.organs.empty())
                    body.mesh.labels[t] = kStiff;
                ++changed[p];
            }
        }
        for (std::size_t p = 0; p < changed.size(); ++p) {
            if (changed[p] == 0)
                throw InputError("no element of the structure lies there", "--stiff " + std::to_string(p + 1));
            notes.push_back("stiff-" + std::to_string(p + 1) + ": " + std::to_string(changed[p]) + " elements of "
                + in_words(request.stiff[p].youngs_modulus_MPa, 2) + " MPa");
        }
    }

    /// Places to press on the surface that fingers see.
    class Sites {
    public:
        Sites(PalpationScene& scene, const TriMesh& surface)
            : scene_(scene)
            , surface_(surface)
        {
            std::vector<Vec3> fixed;
            for (const auto& triangle : surface.triangles)
                for (const VertexId v : triangle)
                    if (scene.body.roles[static_cast<std::size_t>(v)] == VertexRole::fixed)
                        fixed.emplace_back(surface.vertices.row(v).transpose());
            for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
                double nearest = std::numeric_limits<double>::infinity();
                for (const Vec3& point : fixed)
                    nearest = std::min(nearest, (point - centroid(surface, t)).squaredNorm());
                from_fixed_.push_back(std::sqrt(nearest));
            }
        }

        /// Farthest towards `direction` where the surface looks there and a fingertip has room beside what is held.
        void add_towards(const std::string& name, const Vec3& direction)
        {
            constexpr double kLooks = 0.85; // cosine
            for (const double room : { 15.0, 8.0, 4.0 }) { // mm
                std::optional<std::size_t> best;
                for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
                    if (from_fixed_[t] >= room && area_normal(surface_, t).normalized().dot(direction) > kLooks
                        && (!best || centroid(surface_, t).dot(direction) > centroid(surface_, *best).dot(direction)))
                        best = t;
                if (best)
                    return add(name, *best);
            }
        }

        void add_nearest(const std::string& name, const Vec3& point)
        {
            std::size_t best = 0;
            for (std::size_t t = 1; t < surface_.triangles.size(); ++t)
                if ((centroid(surface_, t) - point).squaredNorm() < (centroid(surface_, best) - point).squaredNorm())
                    best = t;
            add(name, best);
        }

    private:
        void add(const std::string& name, std::size_t t)
        {
            const Vec3 at = centroid(surface_, t), outward = area_normal(surface_, t).normalized();
            scene_.sites.push_back({ name, at, outward });
            // A second finger or thumb: as far as one spans, where it would push about the other way.
            constexpr double kSpan = 60.0, kAgainst = 0.5;
            std::optional<std::size_t> opposite;
            double aside = std::numeric_limits<double>::infinity();
            for (std::size_t o = 0; o < surface_.triangles.size(); ++o) {
                const Vec3 way = centroid(surface_, o) - at;
                const double through = -way.dot(outward);
                if (through <= 0.0 || through > kSpan || from_fixed_[o] <= 0.0
                    || area_normal(surface_, o).normalized().dot(outward) > -kAgainst)
                    continue;
                const double off = (way + through * outward).norm();
                const double cost = off + 0.1 * through; // the near wall of what lies there, not of what lies beyond
                if (off < 0.5 * through && cost < aside) {
                    aside = cost;
                    opposite = o;
                }
            }
            if (opposite)
                scene_.sites.push_back({ name + "-opposite", centroid(surface_, *opposite),
                    area_normal(surface_, *opposite).normalized() });
        }

        PalpationScene& scene_;
        const TriMesh& surface_;
        std::vector<double> from_fixed_;
    };

    void add_sites(
        PalpationScene& scene, const TriMesh& surface, const LabelVolume& labels, const PalpableRequest& request)
    {
        Sites sites(scene, surface);
        sites.add_towards("front", -Vec3::UnitY());
        sites.add_towards("left", Vec3::UnitX());
        sites.add_towards("right", -Vec3::UnitX());
        for (std::size_t p = 0; p < request.stiff.size(); ++p) {
            const TargetSpec& where = request.stiff[p].where;
            Vec3 middle = where.centre;
            if (!where.is_sphere()) {
                std::size_t count = 0;
                middle.setZero();
                const Label id = find_label(labels.table, where.label)->id;
                for (int k = 0; k < labels.grid.size[2]; ++k)
                    for (int j = 0; j < labels.grid.size[1]; ++j)
                        for (int i = 0; i < labels.grid.size[0]; ++i)
                            if (labels.voxels[labels.grid.offset(i, j, k)] == id) {
                                middle += labels.grid.world(Vec3(i, j, k));
                                ++count;
                            }
                middle /= static_cast<double>(count); // elements lie there: there are voxels
            }
            sites.add_nearest("stiff-" + std::to_string(p + 1), middle);
        }
        for (const auto& [name, point] : request.sites)
            sites.add_nearest(name, point);
    }

    std::string name_of(const PalpableRequest& request)
    {
        std::string name;
        for (const std::string& part : request.structure)
            name += (name.empty() ? "" : " and ") + part;
        return name;
    }

    /// The surface that fingers see; the scene's mesh and roles made. Where no wall fits the outline is smoothed more.
    TriMesh make_wall(PalpationScene& scene, const LabelVolume& alone, double wall_mm, double edge_mm, bool blood,
        std::vector<std::string>& notes, const Job& job)
    {
        constexpr double kMore = 1.5;
        constexpr int kTries = 4;
        double smoothing = std::max(wall_mm, kVoxels * alone.grid.spacing.maxCoeff());
        TriMesh outer;
        WallShell shell;
        for (int tried = 1;; ++tried, smoothing *= kMore) {
            outer = largest_closed_surface(meshed(smoothed(alone, smoothing), edge_mm, job));
            try {
                shell = make_wall_shell(outer, wall_mm, kUsual);
                break;
            } catch (const SolverError& error) {
                if (tried == kTries)
                    throw SolverError(std::string(error.what()) + " (--wall, --edge)", error.where());
            }
        }
        notes.push_back("its outline is smoothed by " + in_words(smoothing, 1)
            + " mm: branches and bumps thinner than that are left out");
        notes.push_back("a wall of " + in_words(wall_mm, 1) + " mm beneath the labelled outline, "
            + (blood ? "blood pressing inside" : "empty inside: no blood presses"));
        if (shell.thinned > 0)
            notes.push_back("the wall is thinner, down to " + in_words(shell.thinnest_mm, 2) + " mm, under "
                + std::to_string(shell.thinned) + " of " + std::to_string(outer.vertices.rows())
                + " vertices, where the vessel is narrow or bends sharply");
        outer.vertices = shell.mesh.vertices.topRows(outer.vertices.rows());
        scene.body.mesh = std::move(shell.mesh);
        scene.body.roles.assign(scene.body.mesh.vertex_count(), blood ? VertexRole::inner_wall : VertexRole::free);
        std::fill_n(scene.body.roles.begin(), outer.vertices.rows(), VertexRole::free);
        return outer;
    }

} // namespace

std::string names_of(const LabelTable& table)
{
    std::string names;
    for (const LabelInfo& info : table)
        names += (names.empty() ? "" : ", ") + info.name;
    return names;
}

Palpable make_palpable(
    const LabelVolume& labels, const MaterialTable& materials, const PalpableRequest& request, const Job& job)
{
    check_request(labels, request);
    const Stopwatch watch;
    const bool hollow = is_hollow(labels, request);
    const LabelVolume alone = structure_alone(labels, request, hollow);
    Palpable made;
    PalpationScene& scene = made.scene;
    scene.name = name_of(request);
    constexpr double kElementsAcross = 10.0;
    const double edge = request.edge_mm.value_or(
        hollow ? kWallEdge : std::clamp(std::cbrt(volume_of(alone)) / kElementsAcross, 3.0, 20.0));
    TriMesh surface;
    if (hollow)
        surface = make_wall(
            scene, alone, request.wall_mm.value_or(kVesselWall), edge, holds_blood(labels, request), made.notes, job);
    else {
        scene.body.mesh = meshed(smoothed(alone, kVoxels * labels.grid.spacing.maxCoeff()), edge, job);
        scene.body.roles.assign(scene.body.mesh.vertex_count(), VertexRole::free);
        surface = boundary_of(scene.body.mesh);
        if (alone.table.size() > 1)
            for (const LabelInfo& info : alone.table)
                scene.organs.push_back({ info.id, info.name });
    }
    give_elasticity(scene, labels, alone.table, materials, request, made.notes);
    hold(scene, surface, Holder(labels, request, hollow, surface), made.notes);
    if (hollow) // what holds the outside of a wall holds its inside too
        for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
            if (scene.body.roles[static_cast<std::size_t>(v)] == VertexRole::fixed)
                scene.body.roles[static_cast<std::size_t>(v + surface.vertices.rows())] = VertexRole::fixed;
    refuse_floating(scene, made.notes);
    if (!hollow)
        surface = boundary_of(scene.body.mesh); // some vertices may be gone
    add_sites(scene, surface, labels, request);
    if (scene.sites.empty())
        throw InputError("no place is free to be pressed: less must hold it (--held)", scene.name);
    check_elastic_model(scene.body);
    if (job.cancelled())
        throw SolverError("cancelled", scene.name);
    record_part(job, "palpable structure", watch,
        static_cast<std::size_t>(scene.body.mesh.vertices.size()) * sizeof(double)
            + scene.body.mesh.nodes.size() * sizeof(VertexId));
    return made;
}

} // namespace retractor
