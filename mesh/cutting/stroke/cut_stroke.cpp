#include "mesh/cutting/stroke/cut_stroke.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_extent.h"
#include "mesh/cutting/stroke/cut_improve.h"
#include "mesh/cutting/stroke/cut_moves.h"
#include "mesh/cutting/stroke/cut_retry.h"
#include "mesh/cutting/stroke/cut_separation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::mesh {

namespace {

    /// Tolerance of root finding, as a share of the blade's size.
    constexpr double kBorderRootTolerance = 1e-13;
    /// Permitted motion of fixed parts, as a share of the blade's size.
    constexpr double kUnmoved = 1e-10;
    /// A vertex that cannot be moved onto a border (or a bend) counts as on it within this share of the vertex's
    /// shortest edge. Depth, ends and bends of the wound have this tolerance, which avoids slivers.
    constexpr double kBorderTolerance = 0.08;
    /// Smaller bends (degrees) are round-off and jitter.
    constexpr double kLeastBorderBend = 0.1;
    /// Largest number of further rounds over the borders.
    constexpr int kBorderRounds = 3;
    /// Where there is a choice, an edge is bisected at least this share of its length from its ends.
    constexpr double kLeastShare = 0.2;
    /// Length of blade (mm) per search in the mesh; short boxes fit an oblique blade closely.
    constexpr double kLookUp = 8.0;
    /// Number of bisections between two tests for cancellation.
    constexpr std::size_t kCheckEvery = 256;

    /// Largest number of halvings of an element in which the blade bends; the edges shrink to an eighth.
    constexpr int kHalvings = 9;
    /// Places at which a chord is tested, as shares of its length.
    constexpr std::array<double, 3> kChordLooks { 0.25, 0.5, 0.75 };
    /// Opening a pinned face takes two rounds. Edges that are pinned after the last round make separate() refuse the
    /// stroke.
    constexpr int kPinnedRounds = 6;

    struct Cancelled { };

    class Stroke {
    public:
        Stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number, const Job& job,
            const StrokeStep& step)
            : state_ { .store = store,
                .blade = blade,
                .options = options,
                .marks = BladeMarks(store, blade, step.settings.on_blade),
                .border = step.settings.border,
                .cut_number = cut_number,
                .goes_on = step.goes_on,
                .resolve_end = step.resolve_end }
            , store_(store)
            , blade_(blade)
            , options_(options)
            , marks_(state_.marks)
            , job_(job)
            , step_(step)
        {
            if (step.drift != nullptr)
                state_.drift = *step.drift;
        }
        CutResult run();
        StrokeRest rest() { return { resume_, std::move(state_.drift) }; }

    private:
        /// Finds the elements that the blade still crosses within its borders (erring on the safe side), and the start
        /// of the next step of a growing blade: the place where elements begin that the blade has not crossed
        /// completely.
        /// @pre the lips are not separated yet
        void check_cut_marks();
        void find_near_blade();
        void restore_cut_marks();
        const std::vector<TetId>& living_near_blade();
        void find_crossed();
        std::vector<SweptBlade::Crease> bends_to_follow();
        bool spans_bend(TetId t);
        void halve_where_bent();
        bool pierced(const SweptBlade::Crease& crease, TetId t) const;
        bool straddled(const SweptBlade::Crease& crease, TetId t);
        void bisect_at_crease(const SweptBlade::Crease& crease);
        void snap_to_blade();
        void bisect_at_blade();
        void snap_to_border(std::size_t border);
        bool bisect_at_border(std::size_t border, const std::vector<BladeFace>& faces);
        Vec3 border_point(EdgeKey edge, std::size_t border, double& t, double& deviation, bool& on_border);
        double surface_room(const EdgeKey& edge) const;
        void resolve_borders();
        void check_guarantees();

        double border_tolerance() const { return step_.settings.border * kBorderTolerance; }

        void poll(std::size_t i) const
        {
            if (i % kCheckEvery == 0 && job_.cancelled())
                throw Cancelled {};
        }

        StrokeState state_;
        CutStore& store_;
        const SweptBlade& blade_;
        const CutOptions& options_;
        BladeMarks& marks_;
        const Job& job_;
        StrokeStep step_;
        double resume_ = 0.0;
        std::vector<UncutElement> left_;
        std::vector<TetId> near_; ///< elements near the blade; may contain removed elements
        std::size_t near_sorted_ = 0; ///< number of leading entries of near_ that are sorted
        std::vector<TetId> crossed_;
    };

    const std::vector<TetId>& Stroke::living_near_blade()
    {
        const auto tail = near_.begin() + static_cast<std::ptrdiff_t>(near_sorted_);
        std::sort(tail, near_.end());
        std::inplace_merge(near_.begin(), tail, near_.end());
        near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
        std::erase_if(near_, [&](TetId t) { return !store_.tet(t).alive; });
        near_sorted_ = near_.size();
        return near_;
    }

    void Stroke::find_near_blade()
    {
        const double length = blade_.length();
        const int pieces = std::max(1, static_cast<int>(std::ceil((length - step_.from_along) / kLookUp)));
        for (int i = 0; i < pieces; ++i) {
            const auto along = [&](int k) {
                return step_.from_along + (length - step_.from_along) * k / static_cast<double>(pieces);
            };
            Eigen::AlignedBox3d reach = blade_.box(along(i), along(i + 1));
            const std::vector<TetId> tets = store_.tets_near(reach);
            near_.insert(near_.end(), tets.begin(), tets.end());
        }
    }

    /// Marks the lips of former steps of this stroke as on the blade, also where their corners are slightly off the
    /// blade or its borders, so that these lips are not cut again. Edges of these lips are bisected only on the rim,
    /// because otherwise the lips would not mirror each other.
    void Stroke::restore_cut_marks()
    {
        if (!step_.goes_on)
            return;
        std::vector<VertexId> cut;
        // The lips may belong to elements that only touch the elements near the blade.
        for (const TetId t : store_.tets_round(store_.corners_of_all(living_near_blade())))
            for (int corner = 0; corner < 4; ++corner)
                if (const TetSlot& tet = store_.tet(t);
                    tet.lips[static_cast<std::size_t>(corner)].cut == state_.cut_number) {
                    const FaceKey key = face_key(tet, corner);
                    cut.insert(cut.end(), key.begin(), key.end());
                }
        std::sort(cut.begin(), cut.end());
        cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
        for (const VertexId v : cut) {
            marks_.put_on_blade(v);
            const Mark& mark = marks_.at(v);
            const double near = border_tolerance() * shortest_edge(store_, v, store_.unsorted_star(v));
            for (const std::size_t border : { kStart, kFront })
                if (std::abs(mark.distance[border]) < near)
                    marks_.put_on_border(v, border);
        }
    }

    void Stroke::find_crossed()
    {
        crossed_.clear();
        for (const TetId t : living_near_blade())
            if (marks_.crossed(store_.tet(t), !step_.resolve_end))
                crossed_.push_back(t);
    }

    /// Joins the successive pieces of each ray; the plane of the lowest piece halves the bend of all pieces. Where
    /// directions turn, each piece has its own, slightly turned plane, and the planes would leave slivers where they
    /// meet.
    std::vector<SweptBlade::Crease> whole_rays(std::vector<SweptBlade::Crease> bends)
    {
        std::erase_if(bends, [](const auto& bend) { return !bend.ray; });
        std::stable_sort(bends.begin(), bends.end(), [](const auto& a, const auto& b) { return a.along < b.along; });
        std::vector<SweptBlade::Crease> rays;
        for (const SweptBlade::Crease& piece : bends)
            if (rays.empty() || rays.back().along != piece.along) {
                rays.push_back(piece);
            } else {
                SweptBlade::Crease& ray = rays.back();
                ray.length = (piece.origin + piece.length * piece.direction - ray.origin).norm();
                ray.normal = piece.normal;
            }
        return rays;
    }

    /// Angle (degrees) of a single bend in the middle of a chord that lies as far off the chord as the blade at `along`
    /// does. The chord spans `along`, is `edge` long (mm), and begins at `from` at the earliest.
    /// @param past_ends the chord may pass the ends of the blade, where the blade is extended straight
    double bend_under_chord(const SweptBlade& blade, double along, double edge, double from, bool past_ends)
    {
        RETRACTOR_ASSERT(edge > 0.0);
        const double first = past_ends && from == 0.0 ? along - 0.5 * edge : std::max(along - 0.5 * edge, from),
                     last = past_ends ? along + 0.5 * edge : std::min(along + 0.5 * edge, blade.length());
        double off = 0.0;
        for (const double share : { 0.0, 0.5, 1.0 }) {
            const double depth = share * blade.depth();
            const Vec3 a = blade.at(first, depth), b = blade.at(last, depth), p = blade.at(along, depth);
            if ((b - a).norm() > 0.0)
                off = std::max(off, (p - a).cross((b - a).normalized()).norm());
        }
        return 4.0 * off / edge * 180.0 / std::numbers::pi;
    }

    /// The rays that become edges of the mesh: rays that chords of the local elements would miss by more than
    /// CutOptions::crease_deg allows. Faces span the other rays and stay near the blade, so that successive bends do
    /// not each cut a slice of their own. Bends within a twisted strip come from dividing the strip into triangles and
    /// are oblique to the rays; elements would be cut to slivers where they meet. The function includes such bends only
    /// when every bend is to be followed.
    std::vector<SweptBlade::Crease> Stroke::bends_to_follow()
    {
        if (options_.crease_deg == 0.0) {
            std::vector<SweptBlade::Crease> all = blade_.creases(0.0);
            std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.along < b.along; });
            return all;
        }
        std::vector<std::pair<double, double>> edges; // place along the blade and mean edge of each crossed element
        for (const TetId t : crossed_) {
            const std::array<Vec3, 4> p = corners_of(store_, t);
            double edge = 0.0;
            for (const auto& e : kTetEdges)
                edge += (p[static_cast<std::size_t>(e[0])] - p[static_cast<std::size_t>(e[1])]).norm() / 6.0;
            edges.emplace_back(blade_.coordinates(0.25 * (p[0] + p[1] + p[2] + p[3])).along, edge);
        }
        const auto longest_edge = [&](double along) { // chords of long edges lie farthest off
            double longest = 0.0;
            for (const auto& [at, edge] : edges)
                if (std::abs(at - along) <= edge)
                    longest = std::max(longest, edge);
            return longest;
        };
        std::vector<SweptBlade::Crease> chosen;
        double last = 0.0;
        for (const SweptBlade::Crease& ray :
            whole_rays(blade_.creases(std::min(kLeastBorderBend, options_.crease_deg)))) {
            const double edge
                = ray.along < step_.from_along ? 0.0 : longest_edge(ray.along); // 0: cut before, or no tissue
            if (edge > 0.0
                && bend_under_chord(blade_, ray.along, edge, last, step_.settings.past_ends) > options_.crease_deg) {
                chosen.push_back(ray);
                last = ray.along;
            }
        }
        return chosen;
    }

    /// True when the blade bends so much within a crossed element that chords of the section lie too far off the blade.
    bool Stroke::spans_bend(TetId t)
    {
        std::vector<std::pair<Vec3, std::array<double, 3>>>
            section; // corners of the section, with their distances beyond the borders
        for (const EdgeKey& edge : marks_.crossed_edges(store_.tet(t)))
            if (const Crossing& c = marks_.crossing(edge); c.real)
                section.emplace_back(c.point, c.distance);
        for (const VertexId v : store_.tet(t).nodes)
            if (const Mark& mark = marks_.at(v); mark.side == 0)
                section.emplace_back(store_.position(v), mark.distance);
        const double most = step_.settings.chord * store_.first_edge(t);
        for (std::size_t i = 0; i < section.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const auto& [p, beyond_p] = section[i];
                const auto& [q, beyond_q] = section[j];
                bool outside = false;
                for (std::size_t k = 0; k < 3; ++k)
                    outside = outside || (beyond_p[k] > 0.0 && beyond_q[k] > 0.0);
                if (outside)
                    continue;
                for (const double share : kChordLooks) {
                    const Vec3 on_chord = (1.0 - share) * p + share * q;
                    if ((blade_.project(on_chord) - on_chord).norm() > most)
                        return true;
                }
            }
        return false;
    }

    /// Halves elements in which the blade twists or bends, because the section of such an element does not follow the
    /// blade. A plane through every bend would leave slivers where bends meet; halves of the element are well shaped,
    /// and their sections are four times nearer to the blade.
    void Stroke::halve_where_bent()
    {
        for (int round = 0; round < kHalvings; ++round) {
            std::vector<EdgeKey> edges;
            for (const TetId t : crossed_) {
                if (!spans_bend(t))
                    continue;
                const auto keys = edge_keys(store_.tet(t).nodes);
                std::vector<EdgeKey> own(keys.begin(), keys.end());
                sort_longest_first(own, store_);
                if (!is_parted(state_, own.front()))
                    edges.push_back(own.front());
            }
            if (edges.empty())
                return;
            sort_longest_first(edges, store_);
            for (std::size_t i = 0; i < edges.size(); ++i) {
                poll(i);
                const auto [a, b] = edges[i];
                const VertexId v = bisect(state_, edges[i], 0.5 * (store_.position(a) + store_.position(b)), 0.5);
                const std::vector<TetId> children = store_.star(v);
                near_.insert(near_.end(), children.begin(), children.end());
            }
            find_crossed();
        }
    }

    void Stroke::check_cut_marks()
    {
        std::vector<TetId> near = living_near_blade();
        const std::vector<TetId> parts = store_.tets_round(marks_.on_blade()); // elements round the new vertices
        near.insert(near.end(), parts.begin(), parts.end());
        std::erase_if(near, [&](TetId t) { return !marks_.crossed(store_.tet(t)); });
        std::sort(near.begin(), near.end());
        near.erase(std::unique(near.begin(), near.end()), near.end());
        resume_ = std::min(blade_.length(), state_.waits_from);
        for (const TetId t : near) {
            left_.push_back({ corners_of(store_, t), store_.first_edge(t) });
            for (const VertexId v : store_.tet(t).nodes)
                resume_ = std::min(resume_, blade_.length() + marks_.at(v).distance[kEnd]);
        }
        resume_ = step_.resolve_end ? blade_.length() : std::max(0.0, resume_);
    }

    /// True when the bend runs through the element or touches it.
    bool Stroke::pierced(const SweptBlade::Crease& crease, TetId t) const
    {
        const std::array<Vec3, 4> corners = corners_of(store_, t);
        double first = 0.0, last = crease.length;
        for (int f = 0; f < 4; ++f) {
            const std::array<Vec3, 3> face = face_corners(corners, f);
            const Vec3 out = unit_normal(face);
            const double height = out.dot(crease.origin - face[0]) - marks_.tolerance(),
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

    /// True when the blade crosses the element on both sides of a bend. The bend may pass outside the element, on the
    /// convex side.
    bool Stroke::straddled(const SweptBlade::Crease& crease, TetId t)
    {
        bool before = false, after = false;
        const auto look_at = [&](double beyond_end) {
            const double along = blade_.length() + beyond_end;
            before = before || along < crease.along - marks_.tolerance();
            after = after || along > crease.along + marks_.tolerance();
        };
        for (const EdgeKey& edge : marks_.crossed_edges(store_.tet(t)))
            look_at(marks_.crossing(edge).distance[kEnd]);
        for (const VertexId v : store_.tet(t).nodes)
            if (marks_.at(v).side == 0)
                look_at(marks_.at(v).distance[kEnd]);
        return before && after;
    }

    /// Bisects the elements that a bend runs through by the plane that halves the bend. The parts on each side meet a
    /// single flat part of the blade, and edges in the plane cross the blade at the bend.
    void Stroke::bisect_at_crease(const SweptBlade::Crease& crease)
    {
        const auto height = [&](VertexId v) { return crease.normal.dot(store_.position(v) - crease.origin); };
        std::set<VertexId> taken; // vertices that cannot be moved but are near enough
        const auto side_of = [&](VertexId v) { return taken.contains(v) ? 0 : sign(height(v), marks_.tolerance()); };
        std::vector<TetId> tets;
        for (const TetId t : living_near_blade())
            if (pierced(crease, t) || (step_.settings.attempt > 1 && straddled(crease, t)))
                tets.push_back(t);
        std::set<VertexId> vertices;
        for (const TetId t : tets)
            vertices.insert(store_.tet(t).nodes.begin(), store_.tet(t).nodes.end());
        for (const VertexId v : vertices) {
            const std::vector<TetId> star = store_.star(v);
            const double h = height(v);
            if (side_of(v) == 0 || std::abs(h) >= options_.snap * shortest_edge(store_, v, star)
                || on_lip(store_, v, star) || state_.on_crease.contains(v))
                continue;
            std::vector<Vec3> candidates { store_.position(v) - h * crease.normal };
            for (const TetId t : star)
                for (const VertexId w : store_.tet(t).nodes)
                    if (side_of(w) * side_of(v) < 0)
                        candidates.push_back(
                            store_.position(v) + h / (h - height(w)) * (store_.position(w) - store_.position(v)));
            std::erase_if(
                candidates, [&](const Vec3& c) { return (c - store_.position(v)).norm() > 2.0 * std::abs(h); });
            if (move_to_best(state_, v, candidates, star))
                near_.insert(near_.end(), star.begin(), star.end());
            else if (std::abs(h) < border_tolerance() * shortest_edge(store_, v, star))
                taken.insert(v);
        }
        std::vector<EdgeKey> edges;
        for (const TetId t : tets)
            for (const EdgeKey& edge : edge_keys(store_.tet(t).nodes))
                if (side_of(edge.first) * side_of(edge.second) < 0 && !is_parted(state_, edge))
                    edges.push_back(edge);
        for (const VertexId v : vertices)
            if (side_of(v) == 0)
                state_.on_crease.insert(v);
        sort_longest_first(edges, store_);
        for (const auto& [a, b] : edges) {
            const double t = height(a) / (height(a) - height(b));
            const VertexId v
                = bisect(state_, { a, b }, Vec3((1.0 - t) * store_.position(a) + t * store_.position(b)), t);
            state_.on_crease.insert(v);
            const std::vector<TetId> children = store_.star(v);
            near_.insert(near_.end(), children.begin(), children.end());
        }
    }

    void Stroke::snap_to_blade()
    {
        std::set<VertexId> near;
        for (const TetId t : crossed_)
            near.insert(store_.tet(t).nodes.begin(), store_.tet(t).nodes.end());
        for (const VertexId v : near) {
            const Mark m = marks_.at(v);
            const std::vector<TetId> star = store_.star(v);
            const double reach = options_.snap * shortest_edge(store_, v, star);
            if (m.side == 0 || std::abs(m.height) >= reach || on_lip(store_, v, star))
                continue;
            // A vertex in the plane of a bend moves along edges in that plane only.
            const bool bend = state_.on_crease.contains(v);
            const auto stays_in_bend = [&](const Vec3& p) {
                return std::any_of(state_.creases.begin(), state_.creases.end(), [&](const auto& crease) {
                    const double now = std::abs(crease.normal.dot(store_.position(v) - crease.origin));
                    return now < kBorderTolerance * reach / options_.snap
                        && std::abs(crease.normal.dot(p - crease.origin)) <= now + marks_.tolerance();
                });
            };
            std::vector<Vec3> candidates;
            if (!bend)
                candidates.push_back(blade_.project(store_.position(v)));
            for (const TetId t : star)
                for (const EdgeKey& edge : marks_.crossed_edges(store_.tet(t))) {
                    if (edge.first != v && edge.second != v)
                        continue;
                    const Crossing& c = marks_.crossing(edge);
                    if (c.real && (c.point - store_.position(v)).norm() < 2.0 * reach
                        && (!bend
                            || (state_.on_crease.contains(edge.first == v ? edge.second : edge.first)
                                && stays_in_bend(c.point))))
                        candidates.push_back(c.point);
                }
            if (move_to_best(state_, v, candidates, star)) {
                marks_.put_on_blade(v);
                near_.insert(near_.end(), star.begin(), star.end()); // the blade may run through further elements now
            }
        }
    }

    void Stroke::bisect_at_blade()
    {
        std::vector<EdgeKey> edges;
        for (const TetId t : crossed_) {
            const BladeMarks::Edges of_tet = marks_.crossed_edges(store_.tet(t));
            edges.insert(edges.end(), of_tet.begin(), of_tet.end());
        }
        sort_longest_first(edges, store_);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            poll(i);
            const Crossing& c = marks_.crossing(edges[i]);
            marks_.put_on_blade(bisect(state_, edges[i], c.point, c.t));
        }
    }

    void Stroke::snap_to_border(std::size_t border)
    {
        std::set<VertexId> near;
        for (const BladeFace& face : faces_on_blade(state_))
            if (reaches_in(state_, face))
                near.insert(face.key.begin(), face.key.end());
        for (const VertexId v : near) {
            const Mark m = marks_.at(v);
            const std::vector<TetId> star = store_.star(v);
            const double unit = shortest_edge(store_, v, star);
            if (m.beyond[border] == 0 || std::abs(m.distance[border]) >= options_.snap * unit)
                continue;
            // A blade much shorter than the elements must keep its length, so that no vertex is on both ends.
            if ((border == kStart && m.beyond[kEnd] == 0) || (border == kEnd && m.beyond[kStart] == 0))
                continue;
            // A vertex on another border stays on that border: `along` and `depth` are kept separately.
            const BladeCoordinates c = blade_.coordinates(store_.position(v));
            const Vec3 target = border == kStart ? blade_.at(0.0, c.depth)
                : border == kEnd                 ? blade_.at(blade_.length(), c.depth)
                                                 : blade_.at(c.along, blade_.depth());
            if (on_lip(store_, v, star) || !move_to_best(state_, v, std::span(&target, 1), star)) {
                if (std::abs(m.distance[border]) < border_tolerance() * unit)
                    marks_.put_on_border(v, border);
                continue;
            }
            marks_.put_on_blade(v);
            marks_.put_on_border(v, border);
            for (std::size_t k = 0; k < 3; ++k)
                if (m.beyond[k] == 0)
                    marks_.put_on_border(v, k);
        }
    }

    /// The point at which an edge on the blade meets a border. The point is on the blade and on the border, also when
    /// the edge is a chord. Where the edge's surface would be carried too far, the point is on the edge instead.
    Vec3 Stroke::border_point(EdgeKey edge, std::size_t border, double& t, double& deviation, bool& on_border)
    {
        RETRACTOR_ASSERT(marks_.at(edge.first).beyond[border] * marks_.at(edge.second).beyond[border] < 0);
        const Vec3 a = store_.position(edge.first), b = store_.position(edge.second);
        const auto on_edge = [&](double s) { return Vec3((1.0 - s) * a + s * b); };
        t = find_root([&](double s) { return marks_.beyond(blade_.coordinates(on_edge(s)))[border]; },
            marks_.at(edge.first).distance[border], marks_.at(edge.second).distance[border],
            kBorderRootTolerance * std::max(blade_.length(), blade_.depth()));
        Vec3 p = on_edge(t);
        const BladeCoordinates c = blade_.coordinates(p);
        // A chord of a strongly bent blade may jump over the border; then only a point off the chord is on the border.
        const bool jumps = std::abs(marks_.beyond(c)[border]) > border_tolerance() * (b - a).norm();
        deviation = 0.0;
        if (jumps || std::abs(c.side) > marks_.tolerance()) {
            const Vec3 on_chord = p;
            p = border == kFront ? blade_.at(c.along, blade_.depth())
                                 : blade_.at(border == kStart ? 0.0 : blade_.length(), c.depth);
            for (const HeldFace& face : held_faces(store_, edge))
                deviation = std::max(deviation, std::abs(face.normal.dot(p - on_chord)));
            if (deviation > surface_room(edge) || !keeps_volume(store_, edge, p, t)) {
                deviation = 0.0;
                p = on_chord;
                if (jumps) { // a point in between; the halves are tested again
                    t = std::clamp(t, kLeastShare, 1.0 - kLeastShare);
                    p = on_edge(t);
                    on_border = false;
                }
            }
        }
        return p;
    }

    /// Permitted deviation (mm) of a vertex between the two ends from a surface. The edges round the vertex will be
    /// half as long.
    double Stroke::surface_room(const EdgeKey& edge) const
    {
        if (options_.snap == 0.0
            || (on_lip(store_, edge.first, store_.unsorted_star(edge.first))
                && on_lip(store_, edge.second, store_.unsorted_star(edge.second))))
            return kUnmoved * std::max(blade_.length(), blade_.depth()); // earlier wounds do not move
        double room = std::numeric_limits<double>::infinity(), drift = 0.0;
        for (const VertexId end : { edge.first, edge.second }) {
            room = std::min(room, 0.5 * kSurfaceDeviation * mean_edge(store_, end, store_.unsorted_star(end)));
            if (const auto it = state_.drift.find(end); it != state_.drift.end())
                drift = std::max(drift, it->second);
        }
        return room - drift;
    }

    bool Stroke::bisect_at_border(std::size_t border, const std::vector<BladeFace>& faces)
    {
        std::vector<EdgeKey> edges;
        for (const BladeFace& face : faces) {
            if (!reaches_in(state_, face))
                continue;
            for (const auto& [i, j] : { std::pair<std::size_t, std::size_t> { 0, 1 }, { 1, 2 }, { 0, 2 } })
                if (marks_.at(face.key[i]).beyond[border] * marks_.at(face.key[j]).beyond[border] < 0)
                    edges.emplace_back(face.key[i], face.key[j]);
        }
        sort_longest_first(edges, store_);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            poll(i);
            const auto [a, b] = edges[i];
            double t = 0.0, deviation = 0.0;
            bool on_border = true;
            const Vec3 p = border_point(edges[i], border, t, deviation, on_border);
            const VertexId v = bisect(state_, edges[i], p, t);
            if (deviation > 0.0)
                carry_surface(state_, v, deviation);
            marks_.put_on_blade(v);
            if (on_border)
                marks_.put_on_border(v, border);
            for (std::size_t k = 0; k < 3; ++k)
                if (marks_.at(a).beyond[k] == 0 && marks_.at(b).beyond[k] == 0)
                    marks_.put_on_border(v, k);
        }
        return !edges.empty();
    }

    void Stroke::resolve_borders()
    {
        for (const std::size_t border : { kStart, kEnd, kFront }) {
            if (border == kEnd && !step_.resolve_end)
                continue;
            if (options_.snap > 0.0)
                snap_to_border(border);
            bisect_at_border(border, faces_on_blade(state_));
        }
        // At a bend, a bisection may miss the border, or may make a new face between the two sides.
        for (int round = 0; round < kBorderRounds; ++round) {
            bool changed = false;
            std::vector<BladeFace> faces = faces_on_blade(state_);
            for (const std::size_t border : { kStart, kEnd, kFront })
                if ((border != kEnd || step_.resolve_end) && bisect_at_border(border, faces)) {
                    faces = faces_on_blade(state_);
                    changed = true;
                }
            if (!changed)
                break;
        }
    }

    /// Tests the guarantees of the stroke. With labels that the blade does not sever, only the lips are tested, because
    /// parts of the blade stay uncut.
    void Stroke::check_guarantees()
    {
        const double most = largest_blade_deviation(step_.settings);
        const auto check = [](double share, double limit, const char* would, const char* how) {
            if (share > limit)
                throw CutQualityError(CutQualityError::Kind::extent, quality_message(would, limit, how),
                    std::to_string(share) + " local edges " + how);
        };
        check(state_.lips_off, most, "lie", "off");
        check(state_.lips_beyond, most, "reach", "beyond");
        check(state_.former_lips_off, kLargestBladeDeviation, "lie", "off");
        if (options_.uncut_labels.empty())
            check_extent(state_, left_, step_.settings, step_.from_along, resume_, [&] { poll(0); });
    }

    void check_options(const CutOptions& options)
    {
        const auto check = [](double value, double most, const char* name) {
            if (!(value >= 0.0 && value <= most))
                throw InputError(std::string(name) + " must lie between 0 and " + std::to_string(most), name);
        };
        check(options.snap, 0.5, "snap");
        check(options.snap_angle_deg, 60.0, "snap_angle_deg");
        check(options.crease_deg, 180.0, "crease_deg");
        check(options.improve_below_deg, 60.0, "improve_below_deg");
        if (options.element_limit == 0)
            throw InputError("element_limit must be at least 1", "element_limit");
    }

    CutResult Stroke::run()
    {
        CutResult result;
        poll(0);
        state_.report.tets_before = store_.counts().tets;
        job_.report("cut", 0.0);
        find_near_blade();
        restore_cut_marks();
        find_crossed();
        state_.report.tets_crossed = crossed_.size();
        poll(0);
        if (step_.settings.chord > 0.0)
            halve_where_bent();
        state_.creases = bends_to_follow();
        for (const SweptBlade::Crease& crease : state_.creases)
            bisect_at_crease(crease);
        if (!state_.creases.empty())
            find_crossed();
        if (options_.snap > 0.0) {
            snap_to_blade();
            find_crossed();
        }
        job_.report("cut", 0.3);
        bisect_at_blade();
        job_.report("cut", 0.5);
        resolve_borders();
        decide_cut_faces(state_);
        if (options_.snap > 0.0)
            improve_near_blade(state_);
        for (int round = 0; round < kPinnedRounds && open_pinned_edges(state_); ++round)
            poll(0);
        poll(0);
        if (state_.report.tets_crossed == 0 && state_.cut_faces.empty()) {
            result.status = CutStatus::missed_body;
            result.message = "the blade cuts no tissue: it misses the body, or runs where it is cut already";
            return result;
        }
        if (state_.cut_faces.empty()) {
            result.status = CutStatus::missed_body;
            result.message = "the cut is too small for the elements here: it opens none of their faces";
            return result;
        }
        check_cut_marks();
        separate(state_);
        check_guarantees();
        job_.report("cut", 1.0);
        poll(0);
        state_.report.tets_after = store_.counts().tets;
        result.report = state_.report;
        return result;
    }

} // namespace

CutResult cut_stroke(CutStore& store, const SweptBlade& blade, const CutOptions& options, int cut_number,
    const Job& job, const StrokeStep& step, StrokeRest* rest)
{
    check_options(options);
    CutOptions effective = options;
    effective.snap *= step.settings.snap;
    effective.crease_deg = std::min(effective.crease_deg, step.settings.crease_deg);
    try {
        Stroke stroke(store, blade, effective, cut_number, job, step);
        CutResult result = stroke.run();
        if (rest != nullptr)
            *rest = stroke.rest();
        return result;
    } catch (const Cancelled&) {
        CutResult result;
        result.status = CutStatus::cancelled;
        result.message = "the cut was cancelled";
        return result;
    }
}

} // namespace retractor::mesh
