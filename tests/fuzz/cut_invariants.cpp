#include "tests/fuzz/cut_invariants.h"
#include "tests/support/cutting/pinched_vertices.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <sstream>
#include <unordered_map>

namespace retractor::fuzz {

namespace {

    constexpr double kOnBlade = 1e-7; // of the blade's size: what is nearer counts as on it
    constexpr double kVolume = 1e-12; // relative, where nothing moves
    constexpr double kSurface = 0.05; // of the local edge: what snapping may carry a surface away
    constexpr double kExtent = 0.1; // of the local edge: what depth and ends may be off
    constexpr double kRoundOff = 1e-9; // of the body's size

    using FaceKey = std::array<VertexId, 3>;

    Vec3 at(const mesh::TetMesh& mesh, VertexId v) { return mesh.vertices.row(v).transpose(); }

    template <class... Parts> void add(Findings& findings, const char* invariant, const Parts&... parts)
    {
        std::ostringstream text;
        text.precision(6);
        (text << ... << parts);
        findings.push_back({ invariant, text.str() });
    }

    /// Lists by vertex, laid out one after the other.
    template <class Record> class ByVertex {
    public:
        ByVertex(std::size_t vertices)
            : end_(vertices + 1, 0)
        {
        }
        void count(VertexId v) { ++end_[static_cast<std::size_t>(v) + 1]; }
        void lay_out()
        {
            std::partial_sum(end_.begin(), end_.end(), end_.begin());
            records_.resize(end_.back());
            next_.assign(end_.begin(), end_.end() - 1);
        }
        void put(VertexId v, const Record& record) { records_[next_[static_cast<std::size_t>(v)]++] = record; }
        std::size_t vertices() const { return next_.size(); }
        std::span<Record> of(std::size_t v) { return { records_.data() + end_[v], end_[v + 1] - end_[v] }; }

    private:
        std::vector<std::size_t> end_, next_;
        std::vector<Record> records_;
    };

    std::uint64_t packed(VertexId a, VertexId b)
    {
        return static_cast<std::uint64_t>(a) << 32U | static_cast<std::uint64_t>(b);
    }

    /// Corners in order, and whether putting them so took an odd permutation.
    bool sort_corners(FaceKey& v)
    {
        bool odd = false;
        const auto order = [&](std::size_t i, std::size_t j) {
            if (v[i] > v[j]) {
                std::swap(v[i], v[j]);
                odd = !odd;
            }
        };
        order(0, 1);
        order(1, 2);
        order(0, 1);
        return odd;
    }

    struct FaceRecord {
        std::uint64_t others = 0; ///< the two larger corners
        mesh::TetFace face;
        bool odd = false;
    };

    /// Matches the faces of a mesh.
    void match_faces(
        const mesh::TetMesh& mesh, std::vector<mesh::TetFace>& boundary, std::size_t& different, Findings& findings)
    {
        ByVertex<FaceRecord> faces(mesh.vertex_count());
        const auto for_all = [&](auto&& visit) {
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                for (int corner = 0; corner < 4; ++corner) {
                    FaceKey v = mesh::face_vertices(mesh, { t, corner });
                    const bool odd = sort_corners(v);
                    visit(v, FaceRecord { packed(v[1], v[2]), { t, corner }, odd });
                }
        };
        for_all([&](const FaceKey& v, const FaceRecord&) { faces.count(v[0]); });
        faces.lay_out();
        for_all([&](const FaceKey& v, const FaceRecord& record) { faces.put(v[0], record); });
        for (std::size_t v = 0; v < faces.vertices(); ++v) {
            const std::span<FaceRecord> own = faces.of(v);
            std::stable_sort(
                own.begin(), own.end(), [](const FaceRecord& a, const FaceRecord& b) { return a.others < b.others; });
            for (std::size_t i = 0; i < own.size();) {
                std::size_t j = i + 1;
                while (j < own.size() && own[j].others == own[i].others)
                    ++j;
                if (j - i > 2)
                    add(findings, "faces", "a face of ", j - i, " elements, one is ", own[i].face.tet);
                else if (j - i == 2 && own[i].odd == own[i + 1].odd)
                    add(findings, "faces", "elements ", own[i].face.tet, " and ", own[i + 1].face.tet,
                        " lie on one side of their face");
                else if (j - i == 1)
                    boundary.push_back(own[i].face);
                ++different;
                i = j;
            }
        }
    }

    std::size_t count_edges(const mesh::TetMesh& mesh)
    {
        ByVertex<VertexId> edges(mesh.vertex_count());
        const auto for_all = [&](auto&& visit) {
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                for (const auto& e : mesh::kTetEdges) {
                    const auto n = mesh.tet(t);
                    const auto [a, b]
                        = std::minmax(n[static_cast<std::size_t>(e[0])], n[static_cast<std::size_t>(e[1])]);
                    visit(a, b);
                }
        };
        for_all([&](VertexId a, VertexId) { edges.count(a); });
        edges.lay_out();
        for_all([&](VertexId a, VertexId b) { edges.put(a, b); });
        std::size_t count = 0;
        for (std::size_t v = 0; v < edges.vertices(); ++v) {
            const std::span<VertexId> own = edges.of(v);
            std::sort(own.begin(), own.end());
            count += static_cast<std::size_t>(std::unique(own.begin(), own.end()) - own.begin());
        }
        return count;
    }

    /// Groups of things that are joined one by one.
    class Groups {
    public:
        explicit Groups(std::size_t count)
            : parent_(count)
            , groups_(static_cast<long>(count))
        {
            std::iota(parent_.begin(), parent_.end(), std::size_t { 0 });
        }
        std::size_t root(std::size_t i)
        {
            while (parent_[i] != i)
                i = parent_[i] = parent_[parent_[i]];
            return i;
        }
        void join(std::size_t i, std::size_t j)
        {
            i = root(i);
            j = root(j);
            if (i == j)
                return;
            parent_[std::max(i, j)] = std::min(i, j);
            --groups_;
        }
        long count() const { return groups_; }

    private:
        std::vector<std::size_t> parent_;
        long groups_;
    };

    /// A surface's counts.
    struct Surface {
        std::size_t vertices = 0, edges = 0;
        long shells = 0; ///< parts joined by edges
        std::vector<std::pair<VertexId, int>> pinched; ///< vertices with more than one fan, and how many
        bool closed = true; ///< two faces at each edge
    };

    Surface look_at_surface(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& boundary, Findings& findings)
    {
        struct Wing {
            VertexId to = 0, from = 0; ///< the other corners
            std::size_t face = 0;
        };
        ByVertex<Wing> wings(mesh.vertex_count());
        for (const mesh::TetFace& face : boundary)
            for (const VertexId v : mesh::face_vertices(mesh, face))
                wings.count(v);
        wings.lay_out();
        for (std::size_t f = 0; f < boundary.size(); ++f) {
            const auto v = mesh::face_vertices(mesh, boundary[f]);
            for (std::size_t i = 0; i < 3; ++i)
                wings.put(v[i], { v[(i + 1) % 3], v[(i + 2) % 3], f });
        }
        Surface surface;
        Groups shells(boundary.size());
        std::vector<std::pair<VertexId, std::size_t>> spokes; // the other end of an edge; the wing
        for (std::size_t v = 0; v < wings.vertices(); ++v) {
            const std::span<Wing> own = wings.of(v);
            if (own.empty())
                continue;
            ++surface.vertices;
            spokes.clear();
            for (std::size_t i = 0; i < own.size(); ++i) {
                spokes.emplace_back(own[i].to, i);
                spokes.emplace_back(own[i].from, i);
            }
            std::sort(spokes.begin(), spokes.end());
            Groups fans(own.size());
            for (std::size_t i = 0; i < spokes.size();) {
                std::size_t j = i + 1;
                while (j < spokes.size() && spokes[j].first == spokes[i].first)
                    ++j;
                if (j - i != 2) {
                    if (surface.closed)
                        add(findings, "manifold", "edge ", v, "-", spokes[i].first, " has ", j - i,
                            " faces of the surface at ", at(mesh, static_cast<VertexId>(v)).transpose());
                    surface.closed = false;
                    return surface;
                }
                fans.join(spokes[i].second, spokes[i + 1].second);
                shells.join(own[spokes[i].second].face, own[spokes[i + 1].second].face);
                surface.edges += spokes[i].first > static_cast<VertexId>(v) ? 1 : 0;
                i = j;
            }
            if (fans.count() > 1)
                surface.pinched.emplace_back(static_cast<VertexId>(v), static_cast<int>(fans.count()));
        }
        surface.shells = shells.count();
        return surface;
    }

    double distance(const std::array<Vec3, 3>& t, const Vec3& p)
    {
        const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
        bool inside = n.squaredNorm() > 0.0;
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 a = t[i], e = t[(i + 1) % 3] - a;
            inside = inside && n.dot(e.cross(p - a)) >= 0.0;
            const double s = std::clamp(e.dot(p - a) / e.squaredNorm(), 0.0, 1.0);
            best = std::min(best, (a + s * e - p).norm());
        }
        return inside ? std::abs(n.normalized().dot(p - t[0])) : best;
    }

    /// Triangles with their boxes, asked for the distance of a point when it is at most `reach`.
    class Triangles {
    public:
        void insert(const mesh::TetMesh& mesh, const mesh::TetFace& face)
        {
            const auto v = mesh::face_vertices(mesh, face);
            corners_.push_back({ at(mesh, v[0]), at(mesh, v[1]), at(mesh, v[2]) });
            Eigen::AlignedBox3d box;
            for (const Vec3& p : corners_.back())
                box.extend(p);
            boxes_.push_back(box);
        }
        double distance_within(const Vec3& p, double reach) const
        {
            double best = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < boxes_.size(); ++i)
                if (boxes_[i].squaredExteriorDistance(p) <= reach * reach)
                    best = std::min(best, distance(corners_[i], p));
            return best;
        }

    private:
        std::vector<std::array<Vec3, 3>> corners_;
        std::vector<Eigen::AlignedBox3d> boxes_;
    };

    /// Parts of a mesh that are joined by faces, as tissue holds together.
    long pieces(const mesh::TetMesh& mesh)
    {
        struct Own {
            std::uint64_t others = 0;
            TetId tet = 0;
        };
        ByVertex<Own> faces(mesh.vertex_count());
        const auto for_all = [&](auto&& visit) {
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                for (int corner = 0; corner < 4; ++corner) {
                    FaceKey v = mesh::face_vertices(mesh, { t, corner });
                    static_cast<void>(sort_corners(v));
                    visit(v[0], Own { packed(v[1], v[2]), t });
                }
        };
        for_all([&](VertexId v, const Own&) { faces.count(v); });
        faces.lay_out();
        for_all([&](VertexId v, const Own& own) { faces.put(v, own); });
        Groups groups(mesh.tet_count());
        for (std::size_t v = 0; v < faces.vertices(); ++v) {
            const std::span<Own> own = faces.of(v);
            std::sort(own.begin(), own.end(), [](const Own& a, const Own& b) { return a.others < b.others; });
            for (std::size_t i = 1; i < own.size(); ++i)
                if (own[i].others == own[i - 1].others)
                    groups.join(static_cast<std::size_t>(own[i].tet), static_cast<std::size_t>(own[i - 1].tet));
        }
        return groups.count();
    }

    std::set<std::pair<TetId, int>> lip_faces(const State& state)
    {
        std::set<std::pair<TetId, int>> lips;
        for (const mesh::LipFace& lip : state.lips)
            lips.emplace(lip.face.tet, lip.face.corner);
        return lips;
    }

    std::vector<mesh::TetFace> outer_faces(const State& state)
    {
        const auto lips = lip_faces(state);
        std::vector<mesh::TetFace> outer;
        for (const mesh::TetFace& face : state.boundary)
            if (!lips.contains({ face.tet, face.corner }))
                outer.push_back(face);
        return outer;
    }

    double mean_edge(const mesh::TetMesh& mesh, TetId t)
    {
        double sum = 0.0;
        for (const auto& e : mesh::kTetEdges)
            sum += (at(mesh, mesh.tet(t)[static_cast<std::size_t>(e[0])])
                - at(mesh, mesh.tet(t)[static_cast<std::size_t>(e[1])]))
                       .norm();
        return sum / 6.0;
    }

    double diagonal(const mesh::TetMesh& mesh)
    {
        return (mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff()).norm();
    }

    void check_volumes(const State& before, const State& after, double snap, Findings& findings)
    {
        const auto by_label = [](const mesh::TetMesh& mesh) {
            std::map<Label, long double> volume;
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                volume[mesh.labels[static_cast<std::size_t>(t)]] += static_cast<long double>(mesh::tet_volume(mesh, t));
            return volume;
        };
        auto was = by_label(before.mesh), is = by_label(after.mesh);
        for (const auto& [label, volume] : was) {
            const auto change = static_cast<double>(std::abs(is[label] - volume) / volume);
            if (snap == 0.0 && !(change <= kVolume))
                add(findings, "volume kept", "label ", label, " changed by ", change, " of its volume");
        }
        if (was.size() != is.size())
            add(findings, "volume kept", "a label came or went");
    }

    /// The new outer surface lies on the old one: also where elements of different sizes meet without matching.
    void check_outer_surface(
        const State& before, const State& after, const mesh::TetMesh& first, double snap, Findings& findings)
    {
        std::unordered_map<VertexId, Vec3> known; // by session id: vertices of the old outer surface
        Triangles old;
        for (const mesh::TetFace& face : outer_faces(before)) {
            old.insert(before.mesh, face);
            for (const VertexId v : mesh::face_vertices(before.mesh, face))
                known.emplace(before.map.vertex_slot[static_cast<std::size_t>(v)], at(before.mesh, v));
        }
        const double round_off = kRoundOff * diagonal(first);
        double worst = 0.0;
        Vec3 where = Vec3::Zero();
        bool stray = false;
        std::unordered_map<VertexId, double> local; // largest edge length of the first mesh round a vertex
        for (const mesh::TetFace& face : outer_faces(after))
            for (const VertexId v : mesh::face_vertices(after.mesh, face)) {
                double& edge = local[v];
                edge = std::max(edge, mean_edge(first, after.origins[static_cast<std::size_t>(face.tet)]));
            }
        for (const mesh::TetFace& face : outer_faces(after)) {
            const auto v = mesh::face_vertices(after.mesh, face);
            const double unit = mean_edge(first, after.origins[static_cast<std::size_t>(face.tet)]);
            const double most = snap == 0.0 ? round_off : kSurface * unit;
            bool changed = false;
            for (const VertexId w : v) {
                const auto it = known.find(after.map.vertex_slot[static_cast<std::size_t>(w)]);
                if (it != known.end() && it->second == at(after.mesh, w))
                    continue;
                changed = true;
                const double edge = local.at(w);
                const double off
                    = old.distance_within(at(after.mesh, w), edge) / (snap == 0.0 ? diagonal(first) : edge);
                if (off > worst) {
                    worst = off;
                    where = at(after.mesh, w);
                }
            }
            if (!changed)
                continue;
            const Vec3 middle = (at(after.mesh, v[0]) + at(after.mesh, v[1]) + at(after.mesh, v[2])) / 3.0;
            stray = stray || !(old.distance_within(middle, unit) <= 2.0 * most + 0.25 * unit);
        }
        if (worst > (snap == 0.0 ? kRoundOff : kSurface))
            add(findings, "surface kept", worst, snap == 0.0 ? " of the body's size" : " local edges",
                " from the former surface at ", where.transpose());
        if (stray)
            add(findings, "no T-junctions", "a face of the surface is neither lip nor former surface");
    }

    using Corners = std::array<std::array<double, 3>, 3>;

    void check_lips(const State& before, const State& after, Findings& findings)
    {
        const int number = static_cast<int>(before.cuts);
        std::array<std::vector<Corners>, 2> mine;
        const auto area = [](const State& s) {
            std::map<std::pair<int, int>, double> sum;
            for (const mesh::LipFace& lip : s.lips) {
                const auto v = mesh::face_vertices(s.mesh, lip.face);
                sum[{ lip.cut, lip.side }]
                    += 0.5 * (at(s.mesh, v[1]) - at(s.mesh, v[0])).cross(at(s.mesh, v[2]) - at(s.mesh, v[0])).norm();
            }
            return sum;
        };
        for (const mesh::LipFace& lip : after.lips) {
            if (lip.cut != number)
                continue;
            Corners corners;
            const auto v = mesh::face_vertices(after.mesh, lip.face);
            for (std::size_t i = 0; i < 3; ++i)
                corners[i]
                    = { after.mesh.vertices(v[i], 0), after.mesh.vertices(v[i], 1), after.mesh.vertices(v[i], 2) };
            std::sort(corners.begin(), corners.end());
            mine[lip.side > 0 ? 1 : 0].push_back(corners);
        }
        for (auto& side : mine)
            std::sort(side.begin(), side.end());
        if (mine[0] != mine[1])
            add(findings, "lips mirror", mine[0].size(), " and ", mine[1].size(), " faces, not the same corners");
        auto is = area(after);
        for (const auto& [key, was] : area(before))
            if (!(std::abs(is[key] - was) <= kRoundOff * diagonal(before.mesh) * diagonal(before.mesh)))
                add(findings, "earlier lips kept", "cut ", key.first, " side ", key.second, ": ", was, " is now ",
                    is[key]);
    }

    /// Elements whose boxes meet a box.
    std::vector<TetId> tets_near(const mesh::TetMesh& mesh, const Eigen::AlignedBox3d& box)
    {
        std::vector<TetId> near;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Eigen::AlignedBox3d own;
            for (const VertexId v : mesh.tet(t))
                own.extend(at(mesh, v));
            if (own.intersects(box))
                near.push_back(t);
        }
        return near;
    }

    TetId tet_at(const mesh::TetMesh& mesh, const std::vector<TetId>& among, const Vec3& p)
    {
        for (const TetId t : among) {
            const auto n = mesh.tet(t);
            const std::array<Vec3, 4> c { at(mesh, n[0]), at(mesh, n[1]), at(mesh, n[2]), at(mesh, n[3]) };
            bool inside = true;
            for (int axis = 0; axis < 3 && inside; ++axis) {
                double low = c[0][axis], high = low;
                for (const Vec3& q : c) {
                    low = std::min(low, q[axis]);
                    high = std::max(high, q[axis]);
                }
                inside = p[axis] >= low && p[axis] <= high;
            }
            for (std::size_t i = 0; i < 4 && inside; ++i) {
                auto q = c;
                q[i] = p;
                inside = mesh::tet_volume(q[0], q[1], q[2], q[3]) > 0.0;
            }
            if (inside)
                return t;
        }
        return -1;
    }

    /// The wound is where the blade went: no further, and everywhere that the blade is in tissue. Two places are left
    /// out, as nothing is guaranteed there. Where the blade's start, end or front reaches less than 0.1 local edges
    /// into tissue (seen along the blade, there is none further back), it may end so much earlier. And a flake of less
    /// than 0.05 local edges between the blade and the surface need not be cut off: the surface may be carried so far,
    /// and the vertices on it are then on the blade. (Of 1000 strokes some 1.3, all in the plane of a face of the skin,
    /// leave such a flake where they are.) Whatever is deeper than that must be cut, however thin the tissue is.
    void check_extent(const State& before, const State& after, const mesh::TetMesh& first, const mesh::Blade& blade,
        const mesh::CutOptions& options, Findings& findings)
    {
        const mesh::SweptBlade swept(blade);
        const double size = std::max(swept.length(), swept.depth());
        // A gentle bend is spanned by chords; where they lie on a surface, their points stay there.
        const bool flat = swept.creases(0.0).empty();
        double off = 0.0, beyond = 0.0, uncut = 0.0;
        std::size_t mine = 0;
        Triangles wound, surface;
        for (const mesh::TetFace& face : outer_faces(before))
            surface.insert(before.mesh, face);
        const std::vector<TetId> near = tets_near(before.mesh, swept.box(0.0, swept.length()));
        for (const mesh::LipFace& lip : after.lips) {
            wound.insert(after.mesh, lip.face);
            if (lip.cut != static_cast<int>(before.cuts))
                continue;
            ++mine;
            const double unit = mean_edge(first, after.origins[static_cast<std::size_t>(lip.face.tet)]);
            for (const VertexId v : mesh::face_vertices(after.mesh, lip.face)) {
                const mesh::BladeCoordinates c = swept.coordinates(at(after.mesh, v));
                off = std::max(off, std::abs(c.side) / (flat ? size : unit));
                beyond = std::max(
                    beyond, std::max({ -c.along, c.along - swept.length(), c.depth - swept.depth() }) / unit);
            }
        }
        if (off > (flat ? kOnBlade : kExtent))
            add(findings, "lips on blade", "off by ", off, flat ? " of the blade's size" : " local edges");
        if (beyond > kExtent)
            add(findings, "not too far", beyond, " local edges beyond the blade's border");
        if (!options.uncut_labels.empty())
            return;
        constexpr int kSamples = 5;
        double along_worst = 0.0, depth_worst = 0.0;
        for (int i = 0; i <= kSamples; ++i)
            for (int j = 0; j <= kSamples; ++j) {
                const double along = swept.length() * i / kSamples, depth = swept.depth() * j / kSamples;
                const Vec3 sample = swept.at(along, depth);
                const TetId t = tet_at(before.mesh, near, sample);
                if (t < 0)
                    continue;
                const double unit = mean_edge(first, before.origins[static_cast<std::size_t>(t)]);
                const double gap = wound.distance_within(sample, 2.0 * unit) / unit;
                if (gap <= std::max(uncut, kExtent))
                    continue;
                const double least = kExtent * unit;
                const auto outside = [&](double x, double y) { return tet_at(before.mesh, near, swept.at(x, y)) < 0; };
                const bool touched = (i == 0 && outside(along + least, depth))
                    || (i == kSamples && outside(along - least, depth))
                    || (j == kSamples && outside(along, depth - least));
                if (!touched && surface.distance_within(sample, kSurface * unit) > kSurface * unit) {
                    uncut = gap;
                    along_worst = along / swept.length();
                    depth_worst = depth / swept.depth();
                }
            }
        if (uncut > kExtent)
            add(findings, "not too short", mine, " lip faces; ", uncut, " local edges uncut at ", along_worst,
                " of the length, ", depth_worst, " of the depth");
    }

} // namespace

bool is_named_refusal(const Error& error)
{
    constexpr std::array<const char*, 4> kBlades { "neighbouring rays of the blade cross", "the blade crosses itself",
        "the line turns back on itself", "the direction turns by 90 degrees" };
    constexpr std::array<const char*, 10> kWounds { "the cut would leave an element without volume",
        "the lips of the wound would hang together", "a face of the wound has tissue on one side only",
        "a face of the wound was lost", "the wound would reach more than", "the wound would stay more than",
        "the wound would lie more than", "the step would divide one lip", "no step of a freehand stroke",
        "the blade twists or bends so much within single elements" };
    const std::string text = error.what();
    const auto begins = [&](const char* name) { return text.starts_with(name); };
    return dynamic_cast<const InputError*>(&error) != nullptr ? std::any_of(kBlades.begin(), kBlades.end(), begins)
                                                              : std::any_of(kWounds.begin(), kWounds.end(), begins);
}

State::State(const mesh::CutSession& session)
    : mesh(session.compact_mesh(&map))
    , lips(session.lips())
    , pinched(test_support::pinched_vertices(session))
    , cuts(session.cut_count())
    , tets(session.tet_count())
    , vertices(session.vertex_count())
{
    for (const TetId t : map.tet_slot)
        origins.push_back(session.origin(t));
    for (mesh::LipFace& lip : lips)
        lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
    for (VertexId& v : pinched)
        v = map.compact_vertex[static_cast<std::size_t>(v)];
    match_faces(mesh, boundary, faces, face_findings);
}

bool same_bits(const State& a, const State& b)
{
    return a.mesh.vertices.rows() == b.mesh.vertices.rows()
        && (a.mesh.vertices.array() == b.mesh.vertices.array()).all() && a.mesh.nodes == b.mesh.nodes
        && a.mesh.labels == b.mesh.labels && a.origins == b.origins && a.pinched == b.pinched && a.cuts == b.cuts
        && a.map.vertex_slot == b.map.vertex_slot && a.map.tet_slot == b.map.tet_slot
        && a.map.compact_vertex == b.map.compact_vertex && a.map.compact_tet == b.map.compact_tet
        && std::equal(a.lips.begin(), a.lips.end(), b.lips.begin(), b.lips.end(),
            [](const mesh::LipFace& x, const mesh::LipFace& y) {
                return x.face.tet == y.face.tet && x.face.corner == y.face.corner && x.side == y.side && x.cut == y.cut;
            });
}

Topology check_sound(const State& state, Findings& findings)
{
    const mesh::TetMesh& mesh = state.mesh;
    if (mesh.tet_count() != state.tets || mesh.vertex_count() != state.vertices)
        add(findings, "counts", "the session counts ", state.tets, " elements, its mesh has ", mesh.tet_count());
    if (!mesh.vertices.allFinite())
        add(findings, "volumes positive", "a coordinate is not finite");
    std::vector<bool> used(mesh.vertex_count(), false);
    for (const VertexId v : mesh.nodes)
        used[static_cast<std::size_t>(v)] = true;
    if (std::find(used.begin(), used.end(), false) != used.end())
        add(findings, "counts", "a vertex belongs to no element");
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (!(mesh::tet_volume(mesh, t) > 0.0)) {
            add(findings, "volumes positive", "element ", t, ": ", mesh::tet_volume(mesh, t));
            break;
        }
    findings.insert(findings.end(), state.face_findings.begin(), state.face_findings.end());
    const Surface surface = look_at_surface(mesh, state.boundary, findings);
    std::set<std::pair<TetId, int>> on_surface;
    for (const mesh::TetFace& face : state.boundary)
        on_surface.emplace(face.tet, face.corner);
    for (const mesh::LipFace& lip : state.lips)
        if (!on_surface.contains({ lip.face.tet, lip.face.corner })) {
            add(findings, "lips on surface", "lip of element ", lip.face.tet, " is inside");
            break;
        }
    Topology topology;
    if (!findings.empty())
        return topology;
    std::vector<VertexId> pinched;
    for (const auto& [v, fans] : surface.pinched) {
        topology.pinches += fans - 1;
        pinched.push_back(v);
    }
    if (pinched != state.pinched)
        add(findings, "manifold", pinched.size(), " pinched vertices, ", state.pinched.size(), " said");
    // 2 chi(body) = chi(surface) + the pinches, if the link of every vertex is a sphere with one hole for each fan.
    const auto n = [](std::size_t count) { return static_cast<long>(count); };
    topology.body = n(mesh.vertex_count()) - n(count_edges(mesh)) + n(state.faces) - n(mesh.tet_count());
    topology.surface = n(surface.vertices) - n(surface.edges) + n(state.boundary.size());
    if (2 * topology.body != topology.surface + topology.pinches)
        add(findings, "Euler", "body ", topology.body, ", surface ", topology.surface, ", pinches ", topology.pinches);
    topology.pieces = pieces(mesh);
    topology.shells = surface.shells;
    // Taken apart at the pinches, the surface is closed shells, each with chi = 2 - 2 handles.
    const long taken_apart = topology.surface + topology.pinches;
    topology.handles = topology.shells - taken_apart / 2;
    if (taken_apart % 2 != 0 || topology.handles < 0 || topology.shells < topology.pieces)
        add(findings, "Euler", "surface ", topology.surface, ", pinches ", topology.pinches, ", shells ",
            topology.shells, ", pieces ", topology.pieces);
    return topology;
}

void check_account(const State& before, const State& after, const std::map<VertexId, VertexId>& copies,
    const Topology& was, const Topology& is, Findings& findings)
{
    // Bisection and moves leave the characteristic alone; parting changes it by chi(lips) - chi(lips glued again).
    const int number = static_cast<int>(before.cuts);
    std::set<VertexId> apart;
    std::set<std::pair<VertexId, VertexId>> apart_edges;
    std::set<VertexId> glued; // session ids
    std::set<std::pair<VertexId, VertexId>> glued_edges;
    std::size_t faces = 0;
    const auto first_of = [&](VertexId v) {
        VertexId id = after.map.vertex_slot[static_cast<std::size_t>(v)];
        for (auto it = copies.find(id); it != copies.end(); it = copies.find(id))
            id = it->second;
        return id;
    };
    for (const mesh::LipFace& lip : after.lips) {
        if (lip.cut != number)
            continue;
        ++faces;
        const auto v = mesh::face_vertices(after.mesh, lip.face);
        for (std::size_t i = 0; i < 3; ++i) {
            const VertexId a = v[i], b = v[(i + 1) % 3];
            apart.insert(a);
            glued.insert(first_of(a));
            apart_edges.insert(std::minmax(a, b));
            glued_edges.insert(std::minmax(first_of(a), first_of(b)));
        }
    }
    const auto n = [](std::size_t count) { return static_cast<long>(count); };
    const long change = (n(apart.size()) - n(glued.size())) - (n(apart_edges.size()) - n(glued_edges.size()))
        + (n(faces) - n(faces / 2));
    if (is.body - was.body != change)
        add(findings, "Euler", "the body's characteristic was ", was.body, " and is ", is.body,
            "; the wound accounts for ", change, " (pieces ", was.pieces, " -> ", is.pieces, ", handles ", was.handles,
            " -> ", is.handles, ", pinches ", was.pinches, " -> ", is.pinches, ")");
}

void check_cut(const State& before, const State& after, const mesh::TetMesh& first, const mesh::Blade& blade,
    const mesh::CutOptions& options, const mesh::CutReport& report, Findings& findings)
{
    check_volumes(before, after, options.snap, findings);
    check_outer_surface(before, after, first, options.snap, findings);
    check_lips(before, after, findings);
    check_extent(before, after, first, blade, options, findings);
    if (!(report.surface_deviation <= kSurface))
        add(findings, "surface as reported", report.surface_deviation);
    if (report.tets_created + before.tets != report.tets_removed + after.tets)
        add(findings, "counts", "the report counts ", report.tets_created, " created, ", report.tets_removed,
            " removed");
}

void check_ablation(const State& before, const State& after, const std::vector<TetId>& marked,
    const mesh::CutReport& report, Findings& findings)
{
    double marked_volume = 0.0, was = 0.0, is = 0.0;
    for (const TetId t : marked)
        marked_volume += mesh::tet_volume(before.mesh, before.map.compact_tet[static_cast<std::size_t>(t)]);
    for (TetId t = 0; t < static_cast<TetId>(before.mesh.tet_count()); ++t)
        was += mesh::tet_volume(before.mesh, t);
    for (TetId t = 0; t < static_cast<TetId>(after.mesh.tet_count()); ++t)
        is += mesh::tet_volume(after.mesh, t);
    if (!(std::abs(was - marked_volume - is) <= kVolume * was))
        add(findings, "volume kept", "of ", was, " mm^3 ", marked_volume, " are ablated, ", is, " are left");
    if (!(std::abs(report.removed_volume_mm3 - marked_volume) <= kVolume * was))
        add(findings, "ablation", "reports ", report.removed_volume_mm3, " mm^3, ", marked_volume, " were marked");
    for (const mesh::LipFace& lip : after.lips)
        if (lip.cut == static_cast<int>(before.cuts) && lip.side != 0) {
            add(findings, "ablation", "bares a face with side ", lip.side);
            break;
        }
}

Mirror::Mirror(const State& state)
    : vertices_(state.map.compact_vertex.size())
    , tets_(state.map.compact_tet.size())
    , vertex_count_(state.vertices)
    , tet_count_(state.tets)
{
    for (std::size_t v = 0; v < state.map.vertex_slot.size(); ++v)
        *vertex(state.map.vertex_slot[v]) = { at(state.mesh, static_cast<VertexId>(v)), true };
    for (std::size_t t = 0; t < state.map.tet_slot.size(); ++t) {
        Tet& own = *tet(state.map.tet_slot[t]);
        for (std::size_t i = 0; i < 4; ++i)
            own.nodes[i] = state.map.vertex_slot[static_cast<std::size_t>(state.mesh.tet(static_cast<TetId>(t))[i])];
        own.label = state.mesh.labels[t];
        own.alive = true;
    }
}

Mirror::Vertex* Mirror::vertex(VertexId v)
{
    const auto i = static_cast<std::size_t>(v);
    if (i >= vertices_.size())
        vertices_.resize(i + 1);
    return &vertices_[i];
}

Mirror::Tet* Mirror::tet(TetId t)
{
    const auto i = static_cast<std::size_t>(t);
    if (i >= tets_.size())
        tets_.resize(i + 1);
    return &tets_[i];
}

void Mirror::follow(const mesh::MeshDelta& delta, Findings& findings)
{
    bool good = true;
    for (const auto& born : delta.vertices_born) {
        const bool restored = born.a == born.id && born.b == born.id;
        good = good && (restored || (vertex(born.a)->alive && vertex(born.b)->alive)) && !vertex(born.id)->alive;
        good = good && restored == (born.origin == mesh::MeshDelta::Origin::restored);
        good = good && (born.origin != mesh::MeshDelta::Origin::copy || born.a == born.b);
        *vertex(born.id) = { born.position, true };
        ++vertex_count_;
    }
    for (const auto& moved : delta.vertices_moved) {
        Vertex& own = *vertex(moved.id);
        good = good && own.alive && own.position == moved.from;
        own.position = moved.to;
    }
    for (const auto& gone : delta.tets_gone) {
        Tet& own = *tet(gone.id);
        good = good && own.alive && own.nodes == gone.nodes;
        own.alive = false;
        --tet_count_;
    }
    for (const auto& born : delta.tets_born) {
        good = good && !tet(born.id)->alive;
        *tet(born.id) = { born.nodes, born.label, true };
        ++tet_count_;
    }
    for (const auto& gone : delta.vertices_gone) {
        good = good && vertex(gone.id)->alive;
        vertex(gone.id)->alive = false;
        --vertex_count_;
    }
    if (!good)
        add(findings, "deltas", "a delta does not fit the mesh before it");
}

void Mirror::compare(const State& state, Findings& findings)
{
    bool same = vertex_count_ == state.vertices && tet_count_ == state.tets;
    for (std::size_t v = 0; same && v < state.map.vertex_slot.size(); ++v) {
        const Vertex& own = *vertex(state.map.vertex_slot[v]);
        same = own.alive && own.position == at(state.mesh, static_cast<VertexId>(v));
    }
    for (std::size_t t = 0; same && t < state.map.tet_slot.size(); ++t) {
        const Tet& own = *tet(state.map.tet_slot[t]);
        same = own.alive && own.label == state.mesh.labels[t];
        const auto n = state.mesh.tet(static_cast<TetId>(t));
        for (std::size_t i = 0; same && i < 4; ++i)
            same = own.nodes[i] == state.map.vertex_slot[static_cast<std::size_t>(n[i])];
    }
    if (!same)
        add(findings, "deltas", "the mirror differs from the session");
}

} // namespace retractor::fuzz
