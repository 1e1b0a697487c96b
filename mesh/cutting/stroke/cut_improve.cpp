#include "mesh/cutting/stroke/cut_improve.h"

#include "mesh/base/disjoint_sets.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_flips.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <unordered_map>

namespace retractor::mesh {

namespace {

    constexpr int kPasses = 8;
    /// A change must lower the cosine of the worst angle by this amount, so that changes cannot go on forever.
    constexpr double kLeastGain = 1e-4;
    /// Two normals that differ by more than this sine constrain a vertex in two directions.
    constexpr double kSameDirection = 0.15;
    /// Faces constrain a vertex in a direction when the mean square of the cosines between their normals and the
    /// direction exceeds this limit.
    constexpr double kHoldsFrom = 0.05;
    /// Share of kSurfaceDrift that shifts may use while the blade grows, because the next step may have to move the
    /// same vertices onto the blade.
    constexpr double kDriftOfShifts = 0.5;
    /// Permitted distance (local edges) of a corner of the wound from its border: half of the guaranteed distance.
    constexpr double kOffBorder = 0.05;
    /// Steps tried along a direction, as shares of the mean edge.
    constexpr std::array<double, 4> kSteps { 0.3, 0.15, 0.07, 0.03 };

    class Improver {
    public:
        explicit Improver(StrokeState& stroke)
            : stroke_(stroke)
            , store_(stroke.store)
            , marks_(stroke.marks)
            , limit_(std::cos(stroke.options.improve_below_deg * std::numbers::pi / 180.0))
        {
        }

        void run()
        {
            for (int pass = 0; pass < kPasses; ++pass) {
                bool changed = false;
                for (const TetId t : bad_tets())
                    if (store_.tet(t).alive && cosine(t) > limit_ && news_since_failure(t)) {
                        if (open(t))
                            changed = true;
                        else
                            failed_[t] = clock_;
                    }
                if (!changed)
                    return;
            }
        }

    private:
        double cosine(TetId t) const { return smallest_dihedral_cosine(corners_of(store_, t)); }

        double worst(std::span<const TetId> star) const
        {
            double largest = -1.0;
            for (const TetId t : star)
                largest = std::max(largest, cosine(t));
            return largest;
        }

        /// The elements to improve, the worst first.
        std::vector<TetId> bad_tets()
        {
            std::vector<VertexId> vertices(marks_.on_blade().begin(), marks_.on_blade().end());
            vertices.insert(vertices.end(), stroke_.on_crease.begin(), stroke_.on_crease.end());
            std::vector<std::pair<double, TetId>> bad;
            for (const TetId t : store_.tets_round(vertices)) {
                const std::array<Vec3, 4> corners = corners_of(store_, t);
                if (!smallest_dihedral_is_larger(corners, limit_))
                    if (const double c = smallest_dihedral_cosine(corners); c > limit_)
                        bad.emplace_back(-c, t);
            }
            std::sort(bad.begin(), bad.end());
            std::vector<TetId> tets;
            for (const auto& [c, t] : bad)
                tets.push_back(t);
            return tets;
        }

        /// True when the element's surroundings have changed since the last failed attempt to open the element.
        bool news_since_failure(TetId t) const
        {
            const auto failed = failed_.find(t);
            if (failed == failed_.end())
                return true;
            const auto& nodes = store_.tet(t).nodes;
            return std::any_of(nodes.begin(), nodes.end(), [&](VertexId v) {
                const auto changed = changed_.find(v);
                return changed != changed_.end() && changed->second > failed->second;
            });
        }

        void note_change(VertexId v, std::span<const VertexId> around)
        {
            ++clock_;
            changed_[v] = clock_;
            for (const VertexId w : around)
                changed_[w] = clock_;
        }

        bool open(TetId t)
        {
            const auto nodes = store_.tet(t).nodes;
            for (const VertexId a : nodes)
                if (store_.is_newborn(a)) {
                    const std::vector<TetId> star = store_.star(a);
                    const double limit = worst(star) - kLeastGain;
                    for (const VertexId b : nodes)
                        if (a != b && contract(a, b, star, limit))
                            return true;
                }
            bool moved = false;
            for (const VertexId v : nodes)
                moved = shift(v, t) || moved;
            return moved || flip(t);
        }

        // Flips.

        /// Makes the best flip at the faces and edges of an element. Elements that the blade still crosses and faces on
        /// the blade wait until the blade grows; a flip must neither add nor remove such an element or face.
        bool flip(TetId t)
        {
            std::optional<Flip> best;
            const auto look_at = [&](std::optional<Flip> flip) {
                if (flip
                    && flip->cosine_after < std::min(flip->cosine_before, best ? best->cosine_after : 1.0) - kLeastGain
                    && leaves_blade_alone(*flip) && keeps_lips_near(*flip))
                    best = std::move(flip);
            };
            for (int corner = 0; corner < 4; ++corner)
                look_at(face_flip(store_, t, corner));
            const auto nodes = store_.tet(t).nodes;
            for (const auto& e : kTetEdges)
                look_at(edge_flip(
                    store_, std::minmax(nodes[static_cast<std::size_t>(e[0])], nodes[static_cast<std::size_t>(e[1])])));
            if (!best)
                return false;
            std::vector<VertexId> round;
            for (const TetSlot& slot : best->born)
                round.insert(round.end(), slot.nodes.begin(), slot.nodes.end());
            for (const EdgeKey& edge : best->edges_gone)
                marks_.forget(edge);
            static_cast<void>(make_flip(store_, *best));
            note_change(round.front(), round);
            return true;
        }

        bool leaves_blade_alone(const Flip& flip)
        {
            const auto on_blade = [&](const FaceKey& key) {
                return std::all_of(key.begin(), key.end(), [&](VertexId v) { return marks_.at(v).side == 0; });
            };
            const auto crossed = [&](const TetSlot& slot) { return marks_.crossed(slot); };
            return std::none_of(flip.faces_gone.begin(), flip.faces_gone.end(), on_blade)
                && std::none_of(flip.faces_born.begin(), flip.faces_born.end(), on_blade)
                && std::none_of(flip.gone.begin(), flip.gone.end(), [&](TetId t) { return crossed(store_.tet(t)); })
                && std::none_of(flip.born.begin(), flip.born.end(), crossed);
        }

        /// True when no lip face that former steps of the stroke have cut would move to an element with a smaller local
        /// edge, which would permit less distance from the blade.
        bool keeps_lips_near(const Flip& flip) const
        {
            if (!stroke_.goes_on)
                return true;
            double least = std::numeric_limits<double>::infinity();
            for (const TetId t : flip.gone)
                least = std::min(least, store_.first_edge(t));
            return std::none_of(flip.gone.begin(), flip.gone.end(), [&](TetId t) {
                const auto& lips = store_.tet(t).lips;
                return store_.first_edge(t) > least && std::any_of(lips.begin(), lips.end(), [&](const LipTag& lip) {
                    return lip.cut == stroke_.cut_number;
                });
            });
        }

        /// True for a corner of a face that will be cut. For a vertex on the extension of the blade, surfaces are the
        /// only constraint.
        bool part_of_cut(VertexId v) const { return stroke_.cut_faces.has(v); }

        // Contraction.

        /// The link condition for the body and for every surface in the body (outer surface, interfaces, blade): the
        /// common link of a and b is the link of their edge.
        bool links_agree(VertexId a, VertexId b, std::span<const TetId> star_a, std::span<const TetId> star_b)
        {
            const auto round_a = neighbours(store_, a, star_a), round_b = neighbours(store_, b, star_b);
            std::vector<VertexId> common;
            std::set_intersection(
                round_a.begin(), round_a.end(), round_b.begin(), round_b.end(), std::back_inserter(common));
            std::set<VertexId> ring;
            std::set<EdgeKey> ring_edges;
            for (const TetId t : star_a)
                if (store_.corner(t, b) >= 0) {
                    std::vector<VertexId> other;
                    for (const VertexId v : store_.tet(t).nodes)
                        if (v != a && v != b)
                            other.push_back(v);
                    ring.insert(other.begin(), other.end());
                    ring_edges.insert(std::minmax(other[0], other[1]));
                }
            if (!std::all_of(common.begin(), common.end(), [&](VertexId v) { return ring.contains(v); }))
                return false;
            const auto link_edges = [&](VertexId v, std::span<const TetId> star) {
                std::set<EdgeKey> edges;
                for (const TetId t : star) {
                    const auto& n = store_.tet(t).nodes;
                    for (const auto& e : kTetEdges) {
                        const VertexId x = n[static_cast<std::size_t>(e[0])], y = n[static_cast<std::size_t>(e[1])];
                        if (x != v && y != v)
                            edges.insert(std::minmax(x, y));
                    }
                }
                return edges;
            };
            const std::set<EdgeKey> edges_b = link_edges(b, star_b);
            for (const EdgeKey& edge : link_edges(a, star_a))
                if (edges_b.contains(edge) && !ring_edges.contains(edge))
                    return false;
            return surface_links_agree(a, b, star_a, star_b);
        }

        /// True when an element that vanishes with the edge a-b would lay a face that will be cut onto another such
        /// face, or onto a surface. That face would have no tissue on one side.
        bool folds_cut(VertexId a, VertexId b, std::span<const TetId> star_a, std::span<const TetId> star_b) const
        {
            if (!part_of_cut(a) && !part_of_cut(b))
                return false;
            const auto held = [&](VertexId v, std::span<const TetId> star) {
                std::set<FaceKey> keys;
                for (const HeldFace& face : held_faces(store_, v, star))
                    keys.insert(face.key);
                return keys;
            };
            const std::set<FaceKey> held_a = held(a, star_a), held_b = held(b, star_b);
            for (const TetId t : star_a) {
                const int at_b = store_.corner(t, b);
                if (at_b < 0)
                    continue;
                const FaceKey of_a = face_key(store_.tet(t), at_b), of_b = face_key(store_.tet(t), store_.corner(t, a));
                const bool cut_a = stroke_.cut_faces.contains(of_a), cut_b = stroke_.cut_faces.contains(of_b);
                if ((cut_a && (cut_b || held_b.contains(of_b))) || (cut_b && held_a.contains(of_a)))
                    return true;
            }
            return false;
        }

        /// Vertices that share a held face with v.
        static std::set<VertexId> surface_link(std::span<const HeldFace> faces, VertexId v)
        {
            std::set<VertexId> link;
            for (const HeldFace& face : faces)
                link.insert(face.key.begin(), face.key.end());
            link.erase(v);
            return link;
        }

        bool surface_links_agree(VertexId a, VertexId b, std::span<const TetId> star_a, std::span<const TetId> star_b)
        {
            return surface_links_agree(a, b, held_faces(store_, a, star_a), held_faces(store_, b, star_b))
                && surface_links_agree(a, b, blade_faces(a), blade_faces(b));
        }

        /// Faces at v that will be cut.
        std::vector<HeldFace> blade_faces(VertexId v) const
        {
            std::vector<HeldFace> faces;
            for (const FaceKey& key : stroke_.cut_faces.around(v))
                faces.push_back({ .key = key });
            return faces;
        }

        static bool surface_links_agree(
            VertexId a, VertexId b, const std::vector<HeldFace>& held_a, const std::vector<HeldFace>& held_b)
        {
            if (held_a.empty())
                return true;
            const std::set<VertexId> link_a = surface_link(held_a, a), link_b = surface_link(held_b, b);
            if (!link_a.contains(b))
                return false;
            std::set<VertexId> third;
            for (const HeldFace& face : held_a)
                if (std::find(face.key.begin(), face.key.end(), b) != face.key.end())
                    for (const VertexId v : face.key)
                        if (v != a && v != b)
                            third.insert(v);
            return std::all_of(link_a.begin(), link_a.end(),
                [&](VertexId v) { return v == b || !link_b.contains(v) || third.contains(v); });
        }

        /// True when v is near enough to the border for a corner of the wound that belongs on the border.
        bool near_border(VertexId v, std::size_t border)
        {
            double local = std::numeric_limits<double>::infinity();
            for (const TetId t : store_.unsorted_star(v))
                local = std::min(local, store_.first_edge(t));
            return std::abs(marks_.at(v).distance[border]) <= stroke_.border * kOffBorder * local;
        }

        bool may_merge(VertexId a, VertexId b)
        {
            const Mark from = marks_.at(a), to = marks_.at(b);
            if (part_of_cut(a)) {
                if (!part_of_cut(b))
                    return false;
                for (std::size_t k = 0; k < 3; ++k)
                    if (from.beyond[k] == 0 && to.beyond[k] != 0 && !near_border(b, k))
                        return false;
            }
            return same_part(a, store_.position(b), stroke_.on_crease.contains(b));
        }

        /// Number of groups of elements at v that are connected by faces at v.
        static std::size_t groups_at(VertexId v, std::span<const std::array<VertexId, 4>> tets)
        {
            DisjointSets sets(tets.size());
            std::vector<std::pair<EdgeKey, std::size_t>> faces;
            for (std::size_t i = 0; i < tets.size(); ++i)
                for (const auto& e : kTetEdges) {
                    const VertexId x = tets[i][static_cast<std::size_t>(e[0])],
                                   y = tets[i][static_cast<std::size_t>(e[1])];
                    if (x != v && y != v)
                        faces.emplace_back(std::minmax(x, y), i);
                }
            std::sort(faces.begin(), faces.end());
            std::size_t groups = tets.size();
            for (std::size_t f = 0; f + 1 < faces.size(); ++f)
                if (faces[f].first == faces[f + 1].first && sets.join(faces[f].second, faces[f + 1].second))
                    --groups;
            return groups;
        }

        /// True when contracting a-b would leave elements connected in a vertex only. Between two wounds a single
        /// element may connect the elements round a vertex, and that element may vanish.
        bool loosens(VertexId a, VertexId b, std::span<const TetId> star_a) const
        {
            std::vector<VertexId> round;
            for (const TetId t : star_a)
                if (store_.corner(t, b) >= 0)
                    round.insert(round.end(), store_.tet(t).nodes.begin(), store_.tet(t).nodes.end());
            std::sort(round.begin(), round.end());
            round.erase(std::unique(round.begin(), round.end()), round.end());
            for (const VertexId v : round) {
                if (v == a)
                    continue;
                std::vector<std::array<VertexId, 4>> before, after;
                for (const TetId t : store_.star(v))
                    before.push_back(store_.tet(t).nodes);
                const auto keep = [&](TetId t) {
                    auto nodes = store_.tet(t).nodes;
                    std::replace(nodes.begin(), nodes.end(), a, b);
                    after.push_back(nodes);
                };
                for (const TetId t : store_.star(v))
                    if (store_.corner(t, a) < 0 || store_.corner(t, b) < 0)
                        keep(t);
                if (v == b)
                    for (const TetId t : star_a)
                        if (store_.corner(t, b) < 0)
                            keep(t);
                if (groups_at(v, after) > groups_at(v, before))
                    return true;
            }
            return false;
        }

        /// Passes on lips of elements that vanish with the edge a-b. When such an element has a lip opposite a, the
        /// neighbour across the face opposite b takes its place and its lip.
        void hand_on_lips(VertexId a, VertexId b, std::span<const TetId> star_a)
        {
            for (const TetId t : star_a) {
                if (store_.corner(t, b) < 0)
                    continue;
                const LipTag lip = store_.tet(t).lips[static_cast<std::size_t>(store_.corner(t, a))];
                if (lip.cut < 0)
                    continue;
                const FaceKey shared = face_key(store_.tet(t), store_.corner(t, b));
                for (const TetId other : star_a)
                    for (int corner = 0; corner < 4; ++corner)
                        if (other != t && face_key(store_.tet(other), corner) == shared) {
                            auto lips = store_.tet(other).lips;
                            lips[static_cast<std::size_t>(corner)] = lip;
                            store_.set_lips(other, lips);
                        }
            }
        }

        /// Merges vertex a, which this stroke has added, into b. Returns false when the merge is refused.
        /// @param star_a the elements round a, ascending
        /// @param limit largest permitted cosine of a smallest angle among the remaining elements
        bool contract(VertexId a, VertexId b, std::span<const TetId> star_a, double limit)
        {
            // Cheap tests come first: most pairs fail because of the shape of the remaining elements.
            std::vector<TetId> kept;
            for (const TetId t : star_a) {
                if (store_.corner(t, b) >= 0)
                    continue;
                std::array<Vec3, 4> p = corners_of(store_, t);
                const double volume = tet_volume(p[0], p[1], p[2], p[3]);
                p[static_cast<std::size_t>(store_.corner(t, a))] = store_.position(b);
                if (!(tet_volume(p[0], p[1], p[2], p[3]) > 0.1 * volume) || smallest_dihedral_cosine(p) > limit)
                    return false;
                kept.push_back(t);
            }
            if (!may_merge(a, b) || on_lip(store_, a, star_a))
                return false;
            const std::vector<TetId> star_b = store_.star(b);
            const double deviation = surface_deviation(store_, a, held_faces(store_, a, star_a), store_.position(b));
            // The unit is the mean edge round a, because the length of a short edge a-b says nothing about the surface.
            if (!SurfaceRoom(stroke_, a, mean_edge(store_, a, star_a), star_a).keeps(deviation))
                return false;
            if (!links_agree(a, b, star_a, star_b) || folds_cut(a, b, star_a, star_b) || loosens(a, b, star_a))
                return false;
            std::array<bool, 3> on_border {};
            for (std::size_t k = 0; k < 3; ++k)
                on_border[k] = part_of_cut(a) && marks_.at(a).beyond[k] == 0;
            stroke_.cut_faces.merge(a, b);
            store_.replace_parent(a, b);
            if (deviation > 0.0 || stroke_.drift.contains(a)) { // b lies on the surfaces of a from now on
                const double carried = stroke_.drift[a] + deviation;
                report_surface(stroke_, a, carried);
                stroke_.drift[b] = std::max(stroke_.drift[b], carried);
            }
            const std::vector<VertexId> around = neighbours(store_, a, star_a);
            hand_on_lips(a, b, star_a);
            for (const TetId t : star_a) {
                TetSlot slot = store_.tet(t);
                const bool keep = std::find(kept.begin(), kept.end(), t) != kept.end();
                const auto corner = static_cast<std::size_t>(store_.corner(t, a));
                store_.remove_tet(t);
                if (!keep)
                    continue;
                slot.nodes[corner] = b;
                store_.add_tet(slot);
            }
            if (part_of_cut(b))
                for (std::size_t k = 0; k < 3; ++k)
                    if (on_border[k])
                        marks_.put_on_border(b, k);
            store_.remove_added_vertex(a);
            marks_.forget(a, around);
            stroke_.on_crease.erase(a);
            stroke_.drift.erase(a);
            ++stroke_.report.vertices_merged;
            note_change(b, around);
            return true;
        }

        // Shifting.

        /// The constraints of a vertex: directions at right angles to which the vertex may move.
        struct Hold {
            std::vector<Vec3> surfaces; ///< orthonormal normals of bends, outer surfaces and interfaces
            std::vector<Vec3> all; ///< `surfaces` and the blade's normal
            bool on_blade = false;
            bool on_start = false, on_end = false, on_front = false;
        };

        /// The constraints of v; nothing when v cannot move.
        std::optional<Hold> hold_of(VertexId v, std::span<const HeldFace> held)
        {
            Hold hold;
            const auto add = [](std::vector<Vec3>& basis, Vec3 normal) {
                for (const Vec3& b : basis)
                    normal -= b.dot(normal) * b;
                if (normal.norm() > kSameDirection)
                    basis.push_back(normal.normalized());
            };
            if (stroke_.on_crease.contains(v))
                for (const SweptBlade::Crease& crease : stroke_.creases)
                    if (sign(height(crease, store_.position(v)), marks_.tolerance()) == 0)
                        add(hold.surfaces, crease.normal);
            for (const Vec3& normal : main_normals(held))
                add(hold.surfaces, normal);
            hold.all = hold.surfaces;
            if (const Mark& mark = marks_.at(v); part_of_cut(v)) {
                hold.on_blade = true;
                hold.on_start = mark.beyond[kStart] == 0;
                hold.on_end = mark.beyond[kEnd] == 0;
                hold.on_front = mark.beyond[kFront] == 0;
                add(hold.all, stroke_.blade.normal(store_.position(v)));
            }
            if (hold.surfaces.size() > 2 || hold.all.size() > 2)
                return std::nullopt;
            return hold;
        }

        /// The directions in which faces constrain a vertex, the strongest first. A slightly bent surface constrains
        /// the vertex in one direction; surface_deviation() measures the deviation of a shift along such a surface.
        static std::vector<Vec3> main_normals(std::span<const HeldFace> held)
        {
            if (held.empty())
                return {};
            Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
            for (const HeldFace& face : held)
                spread += face.normal * face.normal.transpose() / static_cast<double>(held.size());
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
            std::vector<Vec3> normals;
            for (int i = 2; i >= 0; --i)
                if (axes.eigenvalues()[i] > kHoldsFrom)
                    normals.push_back(axes.eigenvectors().col(i));
            return normals;
        }

        /// The permitted position of v nearest `wanted`.
        Vec3 allowed(VertexId v, const Vec3& wanted, const Hold& hold) const
        {
            const Vec3 from = store_.position(v);
            const auto along = [&](const std::vector<Vec3>& basis, const Vec3& p) {
                Vec3 d = p - from;
                for (const Vec3& b : basis)
                    d -= b.dot(d) * b;
                return Vec3(from + d);
            };
            Vec3 p = along(hold.all, wanted);
            if (!hold.on_blade)
                return p;
            // Projections on surface and blade in turn, because surface and blade may be oblique to each other.
            constexpr int kAlternations = 6;
            for (int i = 0; i < kAlternations; ++i) {
                const BladeCoordinates c = stroke_.blade.coordinates(p);
                const double at = hold.on_start ? 0.0 : hold.on_end ? stroke_.blade.length() : c.along;
                const Vec3 on_blade = stroke_.blade.at(at, hold.on_front ? stroke_.blade.depth() : c.depth);
                if (hold.surfaces.empty())
                    return on_blade;
                p = along(hold.surfaces, on_blade);
                if (i + 1 == kAlternations || (p - on_blade).norm() <= 0.1 * marks_.tolerance())
                    return on_blade;
            }
            return p;
        }

        /// True when `to` is on the same flat part of the blade as v, or on the bend at its end when
        /// `may_end_on_crease`.
        bool same_part(VertexId v, const Vec3& to, bool may_end_on_crease) const
        {
            return std::all_of(stroke_.creases.begin(), stroke_.creases.end(), [&](const auto& crease) {
                const auto side = [&](const Vec3& p) { return sign(height(crease, p), marks_.tolerance()); };
                const int from = side(store_.position(v)), there = side(to);
                return from == there || (may_end_on_crease && there == 0);
            });
        }

        static double height(const SweptBlade::Crease& crease, const Vec3& p)
        {
            return crease.normal.dot(p - crease.origin);
        }

        /// True when a shift to `to` keeps the sides of v with respect to the blade and its borders.
        bool same_place(VertexId v, const Mark& before, const Vec3& to) const
        {
            if (before.side == 0 && !part_of_cut(v))
                return true;
            const BladeCoordinates c = stroke_.blade.coordinates(to);
            const std::array<double, 3> beyond = marks_.beyond(c);
            for (std::size_t k = 0; k < 3; ++k)
                if (before.side == 0 && before.beyond[k] != 0
                    && sign(beyond[k], marks_.tolerance()) != before.beyond[k])
                    return false;
            return before.side == 0 ? std::abs(c.side) <= marks_.tolerance()
                                    : sign(c.side, marks_.tolerance()) == before.side;
        }

        std::vector<Vec3> wanted_positions(VertexId v, TetId bad, std::span<const TetId> star) const
        {
            const Vec3 from = store_.position(v);
            std::vector<Vec3> wanted;
            Vec3 mean = Vec3::Zero();
            double unit = 0.0; // the mean edge, because the shortest edge may be the fault
            const std::vector<VertexId> round = neighbours(store_, v, star);
            for (const VertexId w : round) {
                mean += store_.position(w) / static_cast<double>(round.size());
                unit += (store_.position(w) - from).norm() / static_cast<double>(round.size());
            }
            for (const double share : { 1.0, 0.5, 0.25 })
                wanted.push_back(from + share * (mean - from));
            const auto corner = static_cast<std::size_t>(store_.corner(bad, v));
            const auto& face = kTetFaces[corner];
            const auto p = corners_of(store_, bad);
            const auto at = [&](std::size_t i) { return p[static_cast<std::size_t>(face[i])]; };
            const Vec3 normal = unit_normal(at(0), at(1), at(2));
            std::vector<Vec3> directions { normal, -normal };
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 edge = at((i + 1) % 3) - at(i);
                const Vec3 off = (from - at(i)) - edge * (edge.dot(from - at(i)) / edge.squaredNorm());
                if (off.norm() > 0.0) {
                    directions.push_back(off.normalized());
                    directions.push_back(-off.normalized());
                }
                directions.push_back((at(i) - from).normalized());
            }
            for (const Vec3& direction : directions)
                for (const double step : kSteps)
                    wanted.push_back(from + step * unit * direction);
            return wanted;
        }

        /// An element round a vertex that is shifted: the local index `moving` of the vertex, and the smallest angle's
        /// cosine.
        struct StarTet {
            std::array<Vec3, 4> corners;
            std::size_t moving = 0;
            double cosine = 0.0;
        };

        /// The elements round v, the worst first, so that a position without gain is rejected early.
        std::vector<StarTet> star_of(VertexId v, std::span<const TetId> star) const
        {
            std::vector<StarTet> round;
            round.reserve(star.size());
            for (const TetId t : star) {
                const auto corners = corners_of(store_, t);
                round.push_back(
                    { corners, static_cast<std::size_t>(store_.corner(t, v)), smallest_dihedral_cosine(corners) });
            }
            std::stable_sort(
                round.begin(), round.end(), [](const StarTet& a, const StarTet& b) { return a.cosine > b.cosine; });
            return round;
        }

        /// Largest cosine of the smallest angles round v with v at p. When that cosine is at least `enough`, the result
        /// is any value of at least `enough`.
        static double cosine_at(std::vector<StarTet>& star, const Vec3& p, double enough)
        {
            double largest = -1.0;
            for (StarTet& tet : star) {
                auto& q = tet.corners;
                q[tet.moving] = p;
                largest = std::max(
                    largest, tet_volume(q[0], q[1], q[2], q[3]) > 0.0 ? smallest_dihedral_cosine(q, enough) : 1.0);
                if (largest >= enough)
                    break;
            }
            return largest;
        }

        bool shift(VertexId v, TetId bad)
        {
            const std::vector<TetId> star = store_.star(v);
            if (on_lip(store_, v, star))
                return false;
            const std::vector<HeldFace> held = held_faces(store_, v, star);
            const std::optional<Hold> hold = hold_of(v, held);
            if (!hold)
                return false;
            const double unit = shortest_edge(store_, v, star);
            SurfaceRoom room(stroke_, v, unit, star, stroke_.resolve_end || part_of_cut(v) ? 1.0 : kDriftOfShifts);
            std::vector<StarTet> round = star_of(v, star);
            const Mark mark = marks_.at(v);
            double best = round.front().cosine - kLeastGain, deviation = 0.0;
            std::optional<Vec3> to;
            for (const Vec3& wanted : wanted_positions(v, bad, star)) {
                const Vec3 p = allowed(v, wanted, *hold);
                const double largest = cosine_at(round, p, best);
                if (largest >= best)
                    continue;
                const double off = surface_deviation(store_, v, held, p, kSurfaceDeviation * unit);
                if (off <= kSurfaceDeviation * unit && room.keeps(off) && same_place(v, mark, p)
                    && same_part(v, p, false)) {
                    best = largest;
                    deviation = off;
                    to = p;
                }
            }
            if (!to)
                return false;
            move_checked(stroke_, v, *to, star, deviation);
            note_change(v, neighbours(store_, v, star));
            if (part_of_cut(v)) {
                marks_.put_on_blade(v);
                for (std::size_t k = 0; k < 3; ++k)
                    if (mark.beyond[k] == 0)
                        marks_.put_on_border(v, k);
            }
            return true;
        }

        StrokeState& stroke_;
        CutStore& store_;
        BladeMarks& marks_;
        double limit_;
        std::uint64_t clock_ = 0; ///< counts changes
        /// Time of the last change of a vertex or its neighbours; never iterated.
        std::unordered_map<VertexId, std::uint64_t> changed_;
        std::unordered_map<TetId, std::uint64_t> failed_; ///< time of the last failure per element; never iterated
    };

} // namespace

void improve_near_blade(StrokeState& stroke) { Improver(stroke).run(); }

} // namespace retractor::mesh
