#include "mesh/cut_stroke.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>

namespace retractor {

namespace {

    /// A point nearer to the blade (or to its border) than this share of the blade's size is on it.
    constexpr double kOnBlade = 1e-10;
    /// Root finding stops here, same unit: above the round-off of coordinates of some hundred mm.
    constexpr double kRootTolerance = 1e-13;
    constexpr int kRootIterations = 100;
    /// A snapped vertex leaves each element round it at least this share of its volume ...
    constexpr double kSnapKeepsVolume = 0.25;
    /// ... and no dihedral angle below this one (degrees), or below the one that was there, ...
    constexpr double kSnapKeepsDihedral = 8.0;
    /// ... and the volume of each label round it changes by no more than this share of the volume round it.
    constexpr double kSnapLabelVolume = 0.005;
    /// A vertex put on the blade's border leaves each half this share of what plain bisection would.
    constexpr double kBorderKeepsVolume = 0.3;
    /// Where the blade bends by more than this (degrees), the bend's ray is made an edge of the mesh; a gentler bend is
    /// spanned by faces with their corners on the blade.
    constexpr double kCrease = 3.0;
    /// Cancellation is looked at once per this many bisections.
    constexpr std::size_t kCheckEvery = 256;

    using FaceKey = std::array<VertexId, 3>;
    using EdgeKey = std::pair<VertexId, VertexId>;

    struct Cancelled { };

    /// Where a vertex lies with respect to the blade. The signs are decided once per vertex; all combinatorics
    /// asks the signs only, never the numbers.
    struct Mark {
        int side = 0;
        std::array<int, 3> beyond {}; ///< per border (start, end, front): +1 outside the blade, -1 inside
        std::array<double, 3> distance {}; ///< the same in mm
        double height = 0.0; ///< signed distance (mm)
    };

    struct Crossing {
        bool real = false; ///< the sign changes because the edge meets the blade
        double t = 0.0;
        Vec3 point;
        std::array<double, 3> distance {}; ///< as in Mark
    };

    /// A face on the blade with elements on both its sides.
    struct BladeFace {
        FaceKey key {};
        TetFace minus, plus;
    };

    FaceKey face_key(const TetSlot& tet, int corner)
    {
        FaceKey key {};
        for (std::size_t i = 0; i < 3; ++i)
            key[i] = tet.nodes[static_cast<std::size_t>(kTetFaces[static_cast<std::size_t>(corner)][i])];
        std::sort(key.begin(), key.end());
        return key;
    }

    int sign(double x, double tolerance) { return std::abs(x) <= tolerance ? 0 : (x > 0.0 ? 1 : -1); }

    /// Root in (0, 1) of a continuous f with f(0) f(1) < 0: regula falsi (Illinois), with bisection when it stalls.
    template <class F> double find_root(F&& f, double f0, double f1, double tolerance)
    {
        double a = 0.0, b = 1.0, best = 0.5, f_best = std::min(std::abs(f0), std::abs(f1));
        int same_end = 0;
        for (int i = 0; i < kRootIterations; ++i) {
            double t = (a * f1 - b * f0) / (f1 - f0);
            if (i % 8 == 7 || !(t > a && t < b))
                t = 0.5 * (a + b);
            if (t <= a || t >= b)
                break;
            const double ft = f(t);
            if (i == 0 || std::abs(ft) < f_best) {
                best = t;
                f_best = std::abs(ft);
            }
            if (f_best <= tolerance)
                break;
            if ((ft > 0.0) == (f1 > 0.0)) {
                b = t;
                f1 = ft;
                if (same_end == 1)
                    f0 *= 0.5;
                same_end = 1;
            } else {
                a = t;
                f0 = ft;
                if (same_end == -1)
                    f1 *= 0.5;
                same_end = -1;
            }
        }
        return best;
    }

    class Stroke {
    public:
        Stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number, const Job& job)
            : store_(store)
            , blade_(blade)
            , options_(options)
            , cut_(cut_number)
            , job_(job)
            , size_(std::max(blade.length(), blade.depth()))
        {
        }
        CutResult run();

    private:
        // Where things are.
        std::array<double, 3> beyond(const BladeCoordinates& c) const
        {
            return { -c.along, c.along - blade_.length(), c.depth - blade_.depth() };
        }
        Mark& mark(VertexId v);
        Mark measure(const Vec3& p) const;
        const Crossing& crossing(EdgeKey edge);
        int side(const TetSlot& tet);
        void find_near_blade();
        std::vector<TetId> living_near_blade();
        std::vector<EdgeKey> crossed_edges(const TetSlot& tet);
        bool crossed(TetId t);

        // The steps.
        void check_options() const;
        bool pierced(const SweptBlade::Crease& crease, TetId t) const;
        void bisect_at_crease(const SweptBlade::Crease& crease);
        void snap_to_blade(const std::vector<TetId>& crossed_tets);
        void bisect_at_blade(const std::vector<TetId>& crossed_tets);
        void snap_to_border(std::size_t border);
        void bisect_at_border(std::size_t border);
        std::optional<Vec3> border_point(EdgeKey edge, std::size_t border, double& t);
        bool keeps_volume(EdgeKey edge, const Vec3& p, double t) const;
        bool open_pinned_edges();
        std::vector<BladeFace> faces_on_blade();
        bool reaches_in(const BladeFace& face);
        bool inside(const BladeFace& face);
        std::vector<BladeFace> faces_to_cut();
        void separate(const std::vector<BladeFace>& faces);

        // Moving vertices without doing harm.
        bool on_lip(VertexId v, const std::vector<TetId>& star) const;
        double shortest_edge(VertexId v, const std::vector<TetId>& star) const;
        std::optional<double> harm(VertexId v, const Vec3& to, const std::vector<TetId>& star) const;
        bool move(VertexId v, const std::vector<Vec3>& candidates, const std::vector<TetId>& star);
        void put_on_blade(VertexId v);

        void poll(std::size_t i) const
        {
            if (i % kCheckEvery == 0 && job_.cancelled())
                throw Cancelled {};
        }

        CutStore& store_;
        const SweptBlade& blade_;
        const CutOptions& options_;
        int cut_;
        const Job& job_;
        double size_;
        std::unordered_map<VertexId, Mark> marks_; // looked up only, never walked
        std::map<EdgeKey, Crossing> crossings_;
        std::set<VertexId> on_blade_;
        std::set<VertexId> on_crease_; // in the plane that halves a bend
        std::set<EdgeKey> closed_; // edges that could not be opened: faces on them are not cut
        std::vector<TetId> near_; // elements near the blade; may hold dead ones
        CutReport report_;
    };

    Mark Stroke::measure(const Vec3& p) const
    {
        const BladeCoordinates c = blade_.coordinates(p);
        Mark m;
        m.height = c.side;
        m.side = sign(c.side, kOnBlade * size_);
        m.distance = beyond(c);
        for (std::size_t k = 0; k < 3; ++k)
            m.beyond[k] = sign(m.distance[k], kOnBlade * size_);
        return m;
    }

    Mark& Stroke::mark(VertexId v)
    {
        const auto [it, unknown] = marks_.try_emplace(v);
        if (unknown) {
            it->second = measure(store_.position(v));
            if (it->second.side == 0)
                on_blade_.insert(v);
        }
        return it->second;
    }

    const Crossing& Stroke::crossing(EdgeKey edge)
    {
        const auto [it, unknown] = crossings_.try_emplace(edge);
        Crossing& c = it->second;
        if (!unknown)
            return c;
        const Vec3 a = store_.position(edge.first), b = store_.position(edge.second);
        const auto at = [&](double t) { return Vec3((1.0 - t) * a + t * b); };
        c.t = find_root([&](double t) { return blade_.coordinates(at(t)).side; }, mark(edge.first).height,
            mark(edge.second).height, kRootTolerance * size_);
        c.point = at(c.t);
        const BladeCoordinates where = blade_.coordinates(c.point);
        c.real = std::abs(where.side) <= kOnBlade * size_;
        c.distance = beyond(where);
        return c;
    }

    /// The side of an element: that of its vertices off the blade, or of its centroid where they do not tell
    /// (all four on the blade, at a kink; or an element beyond the border, which nothing needs to cut).
    int Stroke::side(const TetSlot& tet)
    {
        int least = 1, most = -1;
        for (const VertexId v : tet.nodes) {
            least = std::min(least, mark(v).side);
            most = std::max(most, mark(v).side);
        }
        if (least == -1 && most <= 0)
            return -1;
        if (most == 1 && least >= 0)
            return 1;
        Vec3 centroid = Vec3::Zero();
        for (const VertexId v : tet.nodes)
            centroid += 0.25 * store_.position(v);
        return blade_.coordinates(centroid).side > 0.0 ? 1 : -1;
    }

    std::vector<TetId> Stroke::living_near_blade()
    {
        std::sort(near_.begin(), near_.end());
        near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
        std::erase_if(near_, [&](TetId t) { return !store_.tet(t).alive; });
        return near_;
    }

    void Stroke::find_near_blade()
    {
        Eigen::AlignedBox3d reach;
        const TriMesh& surface = blade_.surface();
        for (Eigen::Index i = 0; i < surface.vertices.rows(); ++i)
            reach.extend(Vec3(surface.vertices.row(i)));
        for (TetId t = 0; t < static_cast<TetId>(store_.books().tet_slots); ++t) {
            const TetSlot& tet = store_.tet(t);
            if (!tet.alive)
                continue;
            Eigen::AlignedBox3d box(store_.position(tet.nodes[0]));
            for (std::size_t i = 1; i < 4; ++i)
                box.extend(store_.position(tet.nodes[i]));
            if (box.intersects(reach))
                near_.push_back(t);
        }
    }

    std::vector<EdgeKey> Stroke::crossed_edges(const TetSlot& tet)
    {
        std::vector<EdgeKey> edges;
        for (const auto& e : kTetEdges) {
            const VertexId a = tet.nodes[static_cast<std::size_t>(e[0])], b = tet.nodes[static_cast<std::size_t>(e[1])];
            if (mark(a).side * mark(b).side < 0)
                edges.push_back(std::minmax(a, b));
        }
        return edges;
    }

    /// Does the blade, within its borders, run through the element? The corners of the section (where the blade
    /// meets edges and vertices) must reach inside each border. At a corner of the blade this is on the safe side.
    bool Stroke::crossed(TetId t)
    {
        const TetSlot& tet = store_.tet(t);
        const std::vector<EdgeKey> edges = crossed_edges(tet);
        if (edges.empty())
            return false;
        std::array<bool, 3> in { false, false, false };
        for (const EdgeKey& edge : edges) {
            const Crossing& c = crossing(edge);
            if (!c.real)
                return false;
            for (std::size_t k = 0; k < 3; ++k)
                in[k] = in[k] || c.distance[k] < -kOnBlade * size_;
        }
        for (const VertexId v : tet.nodes)
            if (const Mark& m = mark(v); m.side == 0)
                for (std::size_t k = 0; k < 3; ++k)
                    in[k] = in[k] || m.beyond[k] < 0;
        return in[0] && in[1] && in[2];
    }

    bool Stroke::on_lip(VertexId v, const std::vector<TetId>& star) const
    {
        for (const TetId t : star)
            for (int corner = 0; corner < 4; ++corner)
                if (store_.tet(t).lips[static_cast<std::size_t>(corner)].cut >= 0
                    && store_.tet(t).nodes[static_cast<std::size_t>(corner)] != v)
                    return true;
        return false;
    }

    double Stroke::shortest_edge(VertexId v, const std::vector<TetId>& star) const
    {
        double shortest = std::numeric_limits<double>::infinity();
        for (const TetId t : star)
            for (const VertexId w : store_.tet(t).nodes)
                if (w != v)
                    shortest = std::min(shortest, (store_.position(w) - store_.position(v)).norm());
        return shortest;
    }

    double worst_dihedral(const std::array<Vec3, 4>& p)
    {
        const auto angles = dihedral_angles_deg(p[0], p[1], p[2], p[3]);
        return *std::min_element(angles.begin(), angles.end());
    }

    /// Share by which moving v would change the volume of labels round it; nothing when the move is not allowed.
    std::optional<double> Stroke::harm(VertexId v, const Vec3& to, const std::vector<TetId>& star) const
    {
        std::map<Label, double> change;
        double total = 0.0;
        for (const TetId t : star) {
            std::array<Vec3, 4> p;
            for (std::size_t i = 0; i < 4; ++i)
                p[i] = store_.position(store_.tet(t).nodes[i]);
            const double before = tet_volume(p[0], p[1], p[2], p[3]), angle_before = worst_dihedral(p);
            p[static_cast<std::size_t>(store_.corner(t, v))] = to;
            const double after = tet_volume(p[0], p[1], p[2], p[3]);
            if (!(after >= kSnapKeepsVolume * before))
                return std::nullopt;
            if (worst_dihedral(p) < std::min(angle_before, kSnapKeepsDihedral))
                return std::nullopt;
            change[store_.tet(t).label] += after - before;
            total += before;
        }
        double worst = 0.0;
        for (const auto& [label, volume] : change)
            worst = std::max(worst, std::abs(volume) / total);
        return worst <= kSnapLabelVolume ? std::optional(worst) : std::nullopt;
    }

    /// Moves v to the candidate that changes the labels' volumes least (on the skin: along the skin).
    bool Stroke::move(VertexId v, const std::vector<Vec3>& candidates, const std::vector<TetId>& star)
    {
        const Vec3 from = store_.position(v);
        const double unit = shortest_edge(v, star);
        double least = std::numeric_limits<double>::infinity();
        const Vec3* best = nullptr;
        for (const Vec3& candidate : candidates) {
            const std::optional<double> cost = harm(v, candidate, star);
            if (!cost)
                continue;
            const double weight = *cost / kSnapLabelVolume + (candidate - from).norm() / unit;
            if (weight < least) {
                least = weight;
                best = &candidate;
            }
        }
        if (best == nullptr)
            return false;
        report_.largest_move_mm = std::max(report_.largest_move_mm, (*best - from).norm());
        ++report_.vertices_moved;
        store_.move_vertex(v, *best);
        marks_.erase(v);
        on_blade_.erase(v);
        for (const TetId t : star)
            for (const VertexId w : store_.tet(t).nodes)
                crossings_.erase(std::minmax(v, w));
        return true;
    }

    void Stroke::put_on_blade(VertexId v)
    {
        Mark& m = mark(v);
        m = measure(store_.position(v));
        m.side = 0;
        on_blade_.insert(v);
    }

    /// Longest edges first: their halves make the better elements.
    void sort_longest_first(std::vector<EdgeKey>& edges, const CutStore& store)
    {
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        std::stable_sort(edges.begin(), edges.end(), [&](const EdgeKey& a, const EdgeKey& b) {
            const auto length
                = [&](const EdgeKey& e) { return (store.position(e.first) - store.position(e.second)).squaredNorm(); };
            return length(a) > length(b);
        });
    }

    /// Does the bend run through the element (or touch it)?
    bool Stroke::pierced(const SweptBlade::Crease& crease, TetId t) const
    {
        const TetSlot& tet = store_.tet(t);
        double first = 0.0, last = crease.length;
        for (const auto& face : kTetFaces) {
            const auto corner
                = [&](std::size_t i) { return store_.position(tet.nodes[static_cast<std::size_t>(face[i])]); };
            const Vec3 out = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
            const double height = out.dot(crease.origin - corner(0)) - kOnBlade * size_,
                         slope = out.dot(crease.direction);
            if (std::abs(slope) < std::numeric_limits<double>::epsilon()) {
                if (height > 0.0)
                    return false;
            } else if (slope > 0.0) {
                last = std::min(last, -height / slope);
            } else {
                first = std::max(first, -height / slope);
            }
        }
        return first <= last;
    }

    /// Bisects the elements that a bend runs through by the plane that halves it: what is left on each side meets
    /// one flat part of the blade only, and the bend itself is where edges in the plane cross
    /// the blade.
    void Stroke::bisect_at_crease(const SweptBlade::Crease& crease)
    {
        const auto height = [&](VertexId v) { return crease.normal.dot(store_.position(v) - crease.origin); };
        const auto side_of = [&](VertexId v) { return sign(height(v), kOnBlade * size_); };
        std::vector<TetId> tets;
        for (const TetId t : living_near_blade())
            if (pierced(crease, t))
                tets.push_back(t);
        std::set<VertexId> vertices;
        for (const TetId t : tets)
            vertices.insert(store_.tet(t).nodes.begin(), store_.tet(t).nodes.end());
        for (const VertexId v : vertices) {
            const std::vector<TetId> star = store_.star(v);
            const double h = height(v);
            if (side_of(v) == 0 || std::abs(h) >= options_.snap * shortest_edge(v, star) || on_lip(v, star)
                || on_crease_.contains(v))
                continue;
            std::vector<Vec3> candidates { store_.position(v) - h * crease.normal };
            for (const TetId t : star)
                for (const VertexId w : store_.tet(t).nodes)
                    if (side_of(w) * side_of(v) < 0)
                        candidates.push_back(
                            store_.position(v) + h / (h - height(w)) * (store_.position(w) - store_.position(v)));
            std::erase_if(
                candidates, [&](const Vec3& c) { return (c - store_.position(v)).norm() > 2.0 * std::abs(h); });
            move(v, candidates, star);
        }
        std::vector<EdgeKey> edges;
        for (const TetId t : tets)
            for (const auto& e : kTetEdges) {
                const auto& n = store_.tet(t).nodes;
                const VertexId a = n[static_cast<std::size_t>(e[0])], b = n[static_cast<std::size_t>(e[1])];
                if (side_of(a) * side_of(b) < 0)
                    edges.push_back(std::minmax(a, b));
            }
        for (const VertexId v : vertices)
            if (side_of(v) == 0)
                on_crease_.insert(v);
        sort_longest_first(edges, store_);
        for (const auto& [a, b] : edges) {
            const double t = height(a) / (height(a) - height(b));
            const VertexId v = store_.bisect(a, b, Vec3((1.0 - t) * store_.position(a) + t * store_.position(b)), t);
            on_crease_.insert(v);
            const std::vector<TetId> children = store_.star(v);
            near_.insert(near_.end(), children.begin(), children.end());
        }
    }

    void Stroke::snap_to_blade(const std::vector<TetId>& crossed_tets)
    {
        std::set<VertexId> near;
        for (const TetId t : crossed_tets)
            near.insert(store_.tet(t).nodes.begin(), store_.tet(t).nodes.end());
        for (const VertexId v : near) {
            const Mark m = mark(v);
            const std::vector<TetId> star = store_.star(v);
            const double reach = options_.snap * shortest_edge(v, star);
            if (m.side == 0 || std::abs(m.height) >= reach || on_lip(v, star))
                continue;
            // A vertex in the plane of a bend must stay in it: it moves along edges in that plane only.
            const bool bend = on_crease_.contains(v);
            std::vector<Vec3> candidates;
            if (!bend)
                candidates.push_back(blade_.project(store_.position(v)));
            for (const TetId t : star)
                for (const EdgeKey& edge : crossed_edges(store_.tet(t))) {
                    if (edge.first != v && edge.second != v)
                        continue;
                    const Crossing& c = crossing(edge);
                    if (c.real && (c.point - store_.position(v)).norm() < 2.0 * reach
                        && (!bend || on_crease_.contains(edge.first == v ? edge.second : edge.first)))
                        candidates.push_back(c.point);
                }
            if (!move(v, candidates, star))
                continue;
            put_on_blade(v);
        }
    }

    void Stroke::bisect_at_blade(const std::vector<TetId>& crossed_tets)
    {
        std::vector<EdgeKey> edges;
        for (const TetId t : crossed_tets) {
            const auto of_tet = crossed_edges(store_.tet(t));
            edges.insert(edges.end(), of_tet.begin(), of_tet.end());
        }
        sort_longest_first(edges, store_);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            poll(i);
            const Crossing& c = crossing(edges[i]);
            put_on_blade(store_.bisect(edges[i].first, edges[i].second, c.point, c.t));
        }
    }

    std::vector<BladeFace> Stroke::faces_on_blade()
    {
        std::vector<TetId> tets;
        for (const VertexId v : on_blade_)
            for (const TetId t : store_.star(v))
                tets.push_back(t);
        std::sort(tets.begin(), tets.end());
        tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
        std::map<FaceKey, TetFace> open;
        std::vector<BladeFace> faces;
        for (const TetId t : tets) {
            const TetSlot& tet = store_.tet(t);
            for (int corner = 0; corner < 4; ++corner) {
                const FaceKey key = face_key(tet, corner);
                if (!std::all_of(key.begin(), key.end(), [&](VertexId v) { return mark(v).side == 0; }))
                    continue;
                const auto [it, first] = open.try_emplace(key, TetFace { t, corner });
                if (first)
                    continue;
                const int here = side(tet), there = side(store_.tet(it->second.tet));
                if (here != there)
                    faces.push_back(here < 0 ? BladeFace { key, { t, corner }, it->second }
                                             : BladeFace { key, it->second, { t, corner } });
            }
        }
        std::sort(faces.begin(), faces.end(), [](const BladeFace& a, const BladeFace& b) { return a.key < b.key; });
        return faces;
    }

    /// Is some of the face within every border?
    bool Stroke::reaches_in(const BladeFace& face)
    {
        for (std::size_t k = 0; k < 3; ++k)
            if (std::none_of(face.key.begin(), face.key.end(), [&](VertexId v) { return mark(v).beyond[k] < 0; }))
                return false;
        return true;
    }

    /// Is the face within every border? Where its corners do not tell, its centroid does.
    bool Stroke::inside(const BladeFace& face)
    {
        Vec3 centroid = Vec3::Zero();
        for (const VertexId v : face.key)
            centroid += store_.position(v) / 3.0;
        std::optional<std::array<double, 3>> at_centroid;
        for (std::size_t k = 0; k < 3; ++k) {
            int least = 1, most = -1;
            for (const VertexId v : face.key) {
                least = std::min(least, mark(v).beyond[k]);
                most = std::max(most, mark(v).beyond[k]);
            }
            if (most <= 0 && least < 0)
                continue;
            if (least >= 0 && most > 0)
                return false;
            if (!at_centroid)
                at_centroid = beyond(blade_.coordinates(centroid));
            if ((*at_centroid)[k] >= 0.0)
                return false;
        }
        return true;
    }

    void Stroke::snap_to_border(std::size_t border)
    {
        std::set<VertexId> near;
        for (const BladeFace& face : faces_on_blade())
            if (reaches_in(face))
                near.insert(face.key.begin(), face.key.end());
        for (const VertexId v : near) {
            const Mark m = mark(v);
            const std::vector<TetId> star = store_.star(v);
            if (m.beyond[border] == 0 || std::abs(m.distance[border]) >= options_.snap * shortest_edge(v, star)
                || on_lip(v, star))
                continue;
            // A vertex already on another border stays on it: along and depth are kept one by one.
            const BladeCoordinates c = blade_.coordinates(store_.position(v));
            const Vec3 target = border == 0 ? blade_.at(0.0, c.depth)
                : border == 1               ? blade_.at(blade_.length(), c.depth)
                                            : blade_.at(c.along, blade_.depth());
            if (!move(v, { target }, star))
                continue;
            put_on_blade(v);
            mark(v).beyond[border] = 0;
        }
    }

    /// May the edge be bisected at p, which is near to its own point at t?
    bool Stroke::keeps_volume(EdgeKey edge, const Vec3& p, double t) const
    {
        for (const TetId tet : store_.star(edge.first, edge.second))
            for (const auto& [end, share] : { std::pair { edge.first, 1.0 - t }, { edge.second, t } }) {
                std::array<Vec3, 4> q;
                for (std::size_t i = 0; i < 4; ++i)
                    q[i] = store_.position(store_.tet(tet).nodes[i]);
                q[static_cast<std::size_t>(store_.corner(tet, end))] = p;
                if (!(tet_volume(q[0], q[1], q[2], q[3]) >= kBorderKeepsVolume * share * store_.volume(tet)))
                    return false;
            }
        return true;
    }

    /// Where an edge on the blade meets a border: on the blade and on the border, also where the edge is a chord.
    std::optional<Vec3> Stroke::border_point(EdgeKey edge, std::size_t border, double& t)
    {
        const Vec3 a = store_.position(edge.first), b = store_.position(edge.second);
        const auto on_edge = [&](double s) { return Vec3((1.0 - s) * a + s * b); };
        t = find_root([&](double s) { return beyond(blade_.coordinates(on_edge(s)))[border]; },
            mark(edge.first).distance[border], mark(edge.second).distance[border], kRootTolerance * size_);
        Vec3 p = on_edge(t);
        const BladeCoordinates c = blade_.coordinates(p);
        if (std::abs(c.side) > kOnBlade * size_)
            p = border == 2 ? blade_.at(c.along, blade_.depth())
                            : blade_.at(border == 0 ? 0.0 : blade_.length(), c.depth);
        else if (std::abs(beyond(c)[border]) > kOnBlade * size_)
            return std::nullopt;
        if (!keeps_volume(edge, p, t))
            return std::nullopt;
        return p;
    }

    void Stroke::bisect_at_border(std::size_t border)
    {
        std::vector<EdgeKey> edges;
        for (const BladeFace& face : faces_on_blade()) {
            if (!reaches_in(face))
                continue;
            for (const auto& [i, j] : { std::pair<std::size_t, std::size_t> { 0, 1 }, { 1, 2 }, { 0, 2 } })
                if (mark(face.key[i]).beyond[border] * mark(face.key[j]).beyond[border] < 0)
                    edges.emplace_back(face.key[i], face.key[j]);
        }
        sort_longest_first(edges, store_);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            poll(i);
            const auto [a, b] = edges[i];
            double t = 0.0;
            const std::optional<Vec3> p = border_point(edges[i], border, t);
            if (!p)
                continue; // the face's centroid will decide
            const VertexId v = store_.bisect(a, b, *p, t);
            put_on_blade(v);
            Mark& m = mark(v);
            m.beyond[border] = 0;
            for (std::size_t k = 0; k < 3; ++k)
                if (mark(a).beyond[k] == 0 && mark(b).beyond[k] == 0)
                    mark(v).beyond[k] = 0;
        }
    }

    std::vector<BladeFace> Stroke::faces_to_cut()
    {
        const auto uncut = [&](const TetFace& face) {
            const auto& labels = options_.uncut_labels;
            return std::find(labels.begin(), labels.end(), store_.tet(face.tet).label) != labels.end();
        };
        const auto closed = [&](const BladeFace& face) {
            return closed_.contains({ face.key[0], face.key[1] }) || closed_.contains({ face.key[1], face.key[2] })
                || closed_.contains({ face.key[0], face.key[2] });
        };
        std::vector<BladeFace> faces;
        for (const BladeFace& face : faces_on_blade())
            if (inside(face) && !(uncut(face.minus) && uncut(face.plus)) && !closed(face))
                faces.push_back(face);
        return faces;
    }

    /// Elements in groups joined by faces that are not cut, each by id; groups by their first element. Only faces
    /// with all of `core` (a vertex or an edge that all the elements have in common) count.
    std::vector<std::vector<TetId>> groups_round(std::span<const VertexId> core, const std::vector<TetId>& star,
        const CutStore& store, const std::set<FaceKey>& cut)
    {
        std::vector<std::size_t> parent(star.size());
        std::iota(parent.begin(), parent.end(), std::size_t { 0 });
        const auto root = [&](std::size_t i) {
            while (parent[i] != i)
                i = parent[i] = parent[parent[i]];
            return i;
        };
        std::map<FaceKey, std::size_t> open;
        for (std::size_t i = 0; i < star.size(); ++i)
            for (int corner = 0; corner < 4; ++corner) {
                const TetSlot& tet = store.tet(star[i]);
                if (std::find(core.begin(), core.end(), tet.nodes[static_cast<std::size_t>(corner)]) != core.end())
                    continue;
                const FaceKey key = face_key(tet, corner);
                const auto [it, first] = open.try_emplace(key, i);
                if (!first && !cut.contains(key))
                    parent[std::max(root(i), root(it->second))] = std::min(root(i), root(it->second));
            }
        std::map<std::size_t, std::vector<TetId>> by_root;
        for (std::size_t i = 0; i < star.size(); ++i)
            by_root[root(i)].push_back(star[i]);
        std::vector<std::vector<TetId>> groups;
        for (auto& [first, group] : by_root)
            groups.push_back(std::move(group));
        return groups;
    }

    using Groups = std::vector<std::vector<TetId>>;

    Groups groups_round(VertexId v, const CutStore& store, const std::set<FaceKey>& cut)
    {
        return groups_round(std::span(&v, 1), store.star(v), store, cut);
    }

    Groups groups_round(const EdgeKey& edge, const CutStore& store, const std::set<FaceKey>& cut)
    {
        const std::array<VertexId, 2> core { edge.first, edge.second };
        return groups_round(core, store.star(edge.first, edge.second), store, cut);
    }

    std::size_t group_of(TetId t, const Groups& groups)
    {
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (std::binary_search(groups[g].begin(), groups[g].end(), t))
                return g;
        return groups.size();
    }

    /// Would two fans of elements round the edge still share both its ends after the cut?
    bool pinned(const Groups& fans, const Groups& at_a, const Groups& at_b)
    {
        for (std::size_t i = 0; i < fans.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (group_of(fans[i].front(), at_a) == group_of(fans[j].front(), at_a)
                    && group_of(fans[i].front(), at_b) == group_of(fans[j].front(), at_b))
                    return true;
        return false;
    }

    /// An edge of the wound with both ends on its rim (at a corner of the blade, say) would stay closed, as neither
    /// end is doubled: it gets a vertex of its own.
    /// False when there was none.
    bool Stroke::open_pinned_edges()
    {
        std::set<FaceKey> cut;
        std::set<EdgeKey> edges;
        std::map<VertexId, Groups> groups;
        for (const BladeFace& face : faces_to_cut()) {
            cut.insert(face.key);
            for (const auto& [i, j] : { std::pair<std::size_t, std::size_t> { 0, 1 }, { 1, 2 }, { 0, 2 } })
                edges.emplace(face.key[i], face.key[j]);
            for (const VertexId v : face.key)
                groups.try_emplace(v);
        }
        for (auto& [v, at_v] : groups)
            at_v = groups_round(v, store_, cut);
        std::vector<EdgeKey> pinned_edges;
        for (const EdgeKey& edge : edges)
            if (pinned(groups_round(edge, store_, cut), groups.at(edge.first), groups.at(edge.second)))
                pinned_edges.push_back(edge);
        for (const EdgeKey& edge : pinned_edges) {
            const Vec3 p = blade_.project(0.5 * (store_.position(edge.first) + store_.position(edge.second)));
            if (!keeps_volume(edge, p, 0.5)) {
                closed_.insert(edge);
                continue;
            }
            const VertexId v = store_.bisect(edge.first, edge.second, p, 0.5);
            put_on_blade(v);
            for (std::size_t k = 0; k < 3; ++k)
                if (mark(edge.first).beyond[k] == 0 && mark(edge.second).beyond[k] == 0)
                    mark(v).beyond[k] = 0;
        }
        return !pinned_edges.empty();
    }

    double triangle_area(const CutStore& store, const FaceKey& key)
    {
        const Vec3 a = store.position(key[0]);
        return 0.5 * (store.position(key[1]) - a).cross(store.position(key[2]) - a).norm();
    }

    void Stroke::separate(const std::vector<BladeFace>& faces)
    {
        std::set<FaceKey> cut;
        std::set<VertexId> vertices;
        for (const BladeFace& face : faces) {
            cut.insert(face.key);
            vertices.insert(face.key.begin(), face.key.end());
        }
        // Groups first, copies after: rewiring one vertex changes the face keys round its neighbours.
        std::map<TetId, TetSlot> rewired;
        const auto slot_of = [&](TetId t) -> TetSlot& { return rewired.try_emplace(t, store_.tet(t)).first->second; };
        for (const VertexId v : vertices) {
            auto groups = groups_round(v, store_, cut);
            const auto keeps = std::find_if(groups.begin(), groups.end(), [&](const std::vector<TetId>& group) {
                return std::any_of(group.begin(), group.end(), [&](TetId t) { return side(store_.tet(t)) < 0; });
            });
            if (keeps != groups.end())
                std::rotate(groups.begin(), keeps, keeps + 1);
            for (std::size_t g = 1; g < groups.size(); ++g) {
                const VertexId copy = store_.add_vertex(Vec3(store_.position(v)), v, v, 0.0);
                for (const TetId t : groups[g])
                    slot_of(t).nodes[static_cast<std::size_t>(store_.corner(t, v))] = copy;
            }
        }
        const auto corner_face = [](const TetSlot& slot, int corner) { return face_key(slot, corner); };
        for (const BladeFace& face : faces) {
            TetSlot& minus = slot_of(face.minus.tet);
            TetSlot& plus = slot_of(face.plus.tet);
            if (corner_face(minus, face.minus.corner) == corner_face(plus, face.plus.corner))
                continue; // every corner lies on the border: still one face
            minus.lips[static_cast<std::size_t>(face.minus.corner)] = { cut_, -1 };
            plus.lips[static_cast<std::size_t>(face.plus.corner)] = { cut_, 1 };
            report_.lip_area_mm2 += triangle_area(store_, face.key);
        }
        for (const auto& [t, slot] : rewired) {
            if (slot.nodes == store_.tet(t).nodes) {
                store_.set_lips(t, slot.lips);
            } else {
                store_.remove_tet(t);
                store_.add_tet(slot);
            }
        }
    }

    void Stroke::check_options() const
    {
        if (!(options_.snap >= 0.0 && options_.snap <= 0.5))
            throw InputError("snap must lie between 0 and 0.5", "snap");
    }

    CutResult Stroke::run()
    {
        CutResult result;
        check_options();
        poll(0);
        report_.tets_before = store_.books().tets;
        find_near_blade();
        std::vector<TetId> crossed_tets;
        const auto find_crossed = [&] {
            crossed_tets.clear();
            for (const TetId t : living_near_blade())
                if (crossed(t))
                    crossed_tets.push_back(t);
        };
        job_.report("cut", 0.0);
        find_crossed();
        report_.tets_crossed = crossed_tets.size();
        poll(0);
        if (const auto creases = blade_.creases(kCrease); !creases.empty()) {
            for (const SweptBlade::Crease& crease : creases)
                bisect_at_crease(crease);
            find_crossed();
        }
        if (options_.snap > 0.0) {
            snap_to_blade(crossed_tets);
            find_crossed();
        }
        job_.report("cut", 0.3);
        bisect_at_blade(crossed_tets);
        job_.report("cut", 0.6);
        for (std::size_t border = 0; border < 3; ++border) {
            if (options_.snap > 0.0)
                snap_to_border(border);
            bisect_at_border(border);
        }
        while (open_pinned_edges())
            poll(0);
        const std::vector<BladeFace> faces = faces_to_cut();
        poll(0);
        if (report_.tets_crossed == 0 && faces.empty()) {
            result.status = CutStatus::missed_body;
            result.message = "the blade cuts no tissue: it misses the body, or runs where it is cut already";
            return result;
        }
        separate(faces);
        job_.report("cut", 1.0);
        poll(0);
        report_.tets_after = store_.books().tets;
        result.report = report_;
        return result;
    }

} // namespace

CutResult cut_stroke(
    CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number, const Job& job)
{
    try {
        return Stroke(store, blade, options, cut_number, job).run();
    } catch (const Cancelled&) {
        CutResult result;
        result.status = CutStatus::cancelled;
        result.message = "the cut was cancelled";
        return result;
    }
}

} // namespace retractor
