#include "mesh/cutting/stroke/cut_separation.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_groups.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace retractor::mesh {

namespace {

    /// A vertex that is put on the blade near an edge leaves each half at least this share of the volume of a plain
    /// bisection.
    constexpr double kHalfKeepsVolume = 0.3;

    /// Smaller bends (degrees) are round-off of points on a straight line.
    constexpr double kLeastChordBend = 1e-3;
    /// A chord across more bends spans a curve and is sampled evenly at kManyBends - 1 places.
    constexpr std::size_t kManyBends = 8;
    constexpr double kSamePlace = 0.01; ///< largest distance of equal places, as a share of the chord

    /// Distances (mm) of a face of the wound from the blade, and the face's longest edge (mm).
    struct OffBlade {
        double between_corners = 0.0, at_corners = 0.0, longest_edge = 0.0;
    };

    /// Measures distances of faces from the blade at the faces' corners and middles, at the middles of edges, and where
    /// edges pass bends, because a chord is farthest from the blade at bends.
    class LookAtLips {
    public:
        explicit LookAtLips(StrokeState& stroke)
            : stroke_(stroke)
            , bends_(stroke.blade.creases(kLeastChordBend))
        {
            std::stable_sort(
                bends_.begin(), bends_.end(), [](const auto& a, const auto& b) { return a.along < b.along; });
        }

        double at_corners(const FaceKey& key) const
        {
            double most = 0.0;
            for (const VertexId v : key)
                most = std::max(most, std::abs(stroke_.marks.at(v).height));
            return most;
        }

        OffBlade off_blade(const FaceKey& key)
        {
            OffBlade off { .at_corners = at_corners(key) };
            Vec3 middle = Vec3::Zero();
            for (std::size_t i = 0; i < 3; ++i) {
                const VertexId a = key[i], b = key[(i + 1) % 3];
                const Vec3 p = stroke_.store.position(a), q = stroke_.store.position(b);
                off.longest_edge = std::max(off.longest_edge, (q - p).norm());
                middle += p / 3.0;
                measure(0.5 * (p + q), off);
                for (const double t : bends_passed(a, b))
                    measure((1.0 - t) * p + t * q, off);
            }
            measure(middle, off);
            return off;
        }

        /// Distance (mm) that a face reaches beyond the borders; negative within the borders.
        double beyond(const FaceKey& key) const
        {
            double most = -std::numeric_limits<double>::infinity();
            for (const VertexId v : key)
                for (const double distance : stroke_.marks.at(v).distance)
                    most = std::max(most, distance);
            return most;
        }

    private:
        void measure(const Vec3& x, OffBlade& off) const
        {
            off.between_corners = std::max(off.between_corners, (stroke_.blade.project(x) - x).norm());
        }

        /// Places (0 to 1) along the edge a-b at which the edge passes bends.
        std::vector<double> bends_passed(VertexId a, VertexId b)
        {
            const Vec3 p = stroke_.store.position(a), q = stroke_.store.position(b);
            const auto along = [&](VertexId v) { return stroke_.blade.length() + stroke_.marks.at(v).distance[kEnd]; };
            const double along_a = along(a), along_b = along(b);
            const double least = std::min(along_a, along_b), most = std::max(along_a, along_b);
            auto bend = std::lower_bound(
                bends_.begin(), bends_.end(), least, [](const auto& x, double place) { return x.along < place; });
            std::vector<double> shares;
            for (; bend != bends_.end() && bend->along <= most; ++bend) {
                const double at_p = bend->normal.dot(p - bend->origin), at_q = bend->normal.dot(q - bend->origin);
                if (!(at_p * at_q < 0.0))
                    continue;
                // The pieces of a ray are successive and lie nearly in one plane.
                if (const double t = at_p / (at_p - at_q); shares.empty() || std::abs(t - shares.back()) > kSamePlace)
                    shares.push_back(t);
                if (shares.size() > kManyBends) {
                    shares.clear();
                    for (std::size_t i = 1; i < kManyBends; ++i)
                        shares.push_back(static_cast<double>(i) / static_cast<double>(kManyBends));
                    break;
                }
            }
            return shares;
        }

        StrokeState& stroke_;
        std::vector<SweptBlade::Crease> bends_; ///< in the order of their places along the line
    };

    /// Measures lips of former steps of the stroke where the current step changed them: an edge of the rim may have a
    /// new vertex, and a lip may belong to an element with a smaller local edge.
    void look_at_former_lips(StrokeState& stroke, LookAtLips& look)
    {
        if (!stroke.goes_on)
            return;
        for (const TetId t : stroke.store.changed_tets())
            for (int corner = 0; corner < 4; ++corner)
                if (const TetSlot& tet = stroke.store.tet(t);
                    tet.lips[static_cast<std::size_t>(corner)].cut == stroke.cut_number) {
                    const FaceKey key = face_key(tet, corner);
                    stroke.former_lips_off = std::max(stroke.former_lips_off,
                        std::max(look.at_corners(key), look.beyond(key)) / stroke.store.first_edge(t));
                }
    }

    constexpr std::array<std::pair<std::size_t, std::size_t>, 3> kFaceEdges { { { 0, 1 }, { 1, 2 }, { 0, 2 } } };

    /// True when the face is within every border. Where the corners do not decide, the centroid decides.
    bool inside(StrokeState& stroke, const BladeFace& face)
    {
        Vec3 centroid = Vec3::Zero();
        for (const VertexId v : face.key)
            centroid += stroke.store.position(v) / 3.0;
        std::optional<std::array<double, 3>> at_centroid;
        for (std::size_t k = 0; k < 3; ++k) {
            int least = 1, most = -1;
            for (const VertexId v : face.key) {
                least = std::min(least, stroke.marks.at(v).beyond[k]);
                most = std::max(most, stroke.marks.at(v).beyond[k]);
            }
            if (most <= 0 && least < 0)
                continue;
            if (least >= 0 && most > 0)
                return false;
            if (!at_centroid)
                at_centroid = stroke.marks.beyond(stroke.blade.coordinates(centroid));
            if ((*at_centroid)[k] >= 0.0)
                return false;
        }
        return true;
    }

    /// True when all corners of the face are beyond or on a border, and not all on the border. No part of such a face
    /// can be cut.
    bool beyond_border(const std::array<const Mark*, 4>& marks, std::size_t opposite)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            int least = 1, most = -1;
            for (std::size_t i = 0; i < 4; ++i)
                if (i != opposite) {
                    least = std::min(least, marks[i]->beyond[k]);
                    most = std::max(most, marks[i]->beyond[k]);
                }
            if (least >= 0 && most > 0)
                return true;
        }
        return false;
    }

    /// Adds the element's faces with every corner on the blade, without faces that cannot be cut.
    void open_faces(StrokeState& stroke, TetId t, std::vector<OpenFace>& open)
    {
        const TetSlot& tet = stroke.store.tet(t);
        std::array<const Mark*, 4> marks {};
        std::array<bool, 4> on {};
        int count = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            marks[i] = &stroke.marks.at(tet.nodes[i]);
            on[i] = marks[i]->side == 0;
            count += on[i] ? 1 : 0;
        }
        if (count < 3)
            return;
        for (std::size_t corner = 0; corner < 4; ++corner)
            if (count - (on[corner] ? 1 : 0) == 3 && !beyond_border(marks, corner))
                open.emplace_back(face_key(tet, static_cast<int>(corner)), TetFace { t, static_cast<int>(corner) });
    }

    bool comes_before(const OpenFace& a, const OpenFace& b)
    {
        for (std::size_t i = 0; i < 3; ++i)
            if (a.first[i] != b.first[i])
                return a.first[i] < b.first[i];
        return a.second.tet < b.second.tet;
    }

    /// Finds the faces with elements on different sides.
    void pair_up(StrokeState& stroke, BladeFaceCache& cache)
    {
        cache.faces.clear();
        for (std::size_t f = 0; f + 1 < cache.open.size(); ++f) {
            const auto& [key, one] = cache.open[f];
            const TetFace& other = cache.open[f + 1].second;
            if (cache.open[f + 1].first != key)
                continue;
            const int here = stroke.marks.side(stroke.store.tet(one.tet)),
                      there = stroke.marks.side(stroke.store.tet(other.tet));
            if (here != there)
                cache.faces.push_back(here < 0 ? BladeFace { key, one, other } : BladeFace { key, other, one });
        }
    }

    /// True when v is a corner of a lip that former steps of the stroke have cut.
    bool on_own_lip(const StrokeState& stroke, VertexId v)
    {
        const std::vector<TetId>& star = stroke.store.unsorted_star(v);
        return std::any_of(star.begin(), star.end(), [&](TetId t) {
            const TetSlot& tet = stroke.store.tet(t);
            for (std::size_t i = 0; i < 4; ++i)
                if (tet.lips[i].cut == stroke.cut_number && tet.nodes[i] != v)
                    return true;
            return false;
        });
    }

    /// Leaves out faces with a parted edge. Such a face lies behind a lip, across a chord of the lip, and does not
    /// continue the wound.
    void leave_out_parted(const StrokeState& stroke, std::vector<BladeFace>& faces)
    {
        std::vector<VertexId> on_lip;
        for (const BladeFace& face : faces)
            on_lip.insert(on_lip.end(), face.key.begin(), face.key.end());
        std::sort(on_lip.begin(), on_lip.end());
        on_lip.erase(std::unique(on_lip.begin(), on_lip.end()), on_lip.end());
        std::erase_if(on_lip, [&](VertexId v) { return !on_own_lip(stroke, v); });
        const auto is_on_lip = [&](VertexId v) { return std::binary_search(on_lip.begin(), on_lip.end(), v); };
        std::erase_if(faces, [&](const BladeFace& face) {
            const std::array<bool, 3> on { is_on_lip(face.key[0]), is_on_lip(face.key[1]), is_on_lip(face.key[2]) };
            return std::any_of(kFaceEdges.begin(), kFaceEdges.end(), [&](const auto& e) {
                return on[e.first] && on[e.second] && is_parted(stroke, { face.key[e.first], face.key[e.second] });
            });
        });
    }

    /// Number of faces round an edge that belong to one element only.
    /// @param third working memory
    std::size_t surface_faces(const CutStore& store, const EdgeKey& edge, std::vector<VertexId>& third)
    {
        third.clear();
        for (const TetId t : store.unsorted_star(edge.first))
            if (store.corner(t, edge.second) >= 0)
                for (const VertexId v : store.tet(t).nodes)
                    if (v != edge.first && v != edge.second)
                        third.push_back(v);
        std::sort(third.begin(), third.end());
        std::size_t single = 0;
        for (auto it = third.begin(); it != third.end();) {
            const auto end = std::upper_bound(it, third.end(), *it);
            single += end - it == 1 ? 1 : 0;
            it = end;
        }
        return single;
    }

    /// Refuses a wound whose lips are still connected along an edge.
    void check_lips(const CutStore& store, std::span<const TetId> parted, int cut_number)
    {
        std::vector<EdgeKey> edges;
        for (const TetId t : parted)
            for (int corner = 0; corner < 4; ++corner)
                if (const TetSlot& tet = store.tet(t); tet.lips[static_cast<std::size_t>(corner)].cut == cut_number) {
                    const FaceKey key = face_key(tet, corner);
                    for (const auto& [i, j] : kFaceEdges)
                        edges.emplace_back(key[i], key[j]);
                }
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        std::vector<VertexId> third;
        for (const EdgeKey& edge : edges)
            if (surface_faces(store, edge, third) != 2)
                throw CutQualityError(CutQualityError::Kind::shape,
                    "the lips of the wound would hang together along an edge",
                    "edge " + std::to_string(edge.first) + " - " + std::to_string(edge.second));
    }

} // namespace

const std::vector<BladeFace>& faces_on_blade(StrokeState& stroke)
{
    // A search may find more vertices on the blade. If nothing else has changed, the next search visits only the
    // elements of these vertices.
    BladeFaceCache& cache = stroke.blade_face_cache;
    const std::array<std::uint64_t, 2> changes { stroke.store.changes(), stroke.marks.changes() };
    const std::vector<VertexId>& found = stroke.marks.found_on_blade();
    const bool goes_on = cache.changes == changes;
    if (goes_on && cache.found == found.size())
        return cache.faces;
    const std::vector<TetId> tets = goes_on ? stroke.store.tets_round(std::span(found).subspan(cache.found))
                                            : stroke.store.tets_round(stroke.marks.on_blade());
    cache.changes = changes;
    cache.found = found.size();
    if (!goes_on)
        cache.open.clear();
    const auto known = static_cast<std::ptrdiff_t>(cache.open.size());
    for (const TetId t : tets)
        open_faces(stroke, t, cache.open);
    std::sort(cache.open.begin() + known, cache.open.end(), comes_before);
    std::inplace_merge(cache.open.begin(), cache.open.begin() + known, cache.open.end(), comes_before);
    const auto same = [](const OpenFace& a, const OpenFace& b) { return !comes_before(a, b); }; // list is sorted
    cache.open.erase(std::unique(cache.open.begin(), cache.open.end(), same), cache.open.end());
    pair_up(stroke, cache);
    if (stroke.goes_on)
        leave_out_parted(stroke, cache.faces);
    return cache.faces;
}

bool reaches_in(StrokeState& stroke, const BladeFace& face)
{
    for (std::size_t k = 0; k < 3; ++k)
        if (std::none_of(
                face.key.begin(), face.key.end(), [&](VertexId v) { return stroke.marks.at(v).beyond[k] < 0; }))
            return false;
    return true;
}

bool keeps_volume(const CutStore& store, const EdgeKey& edge, const Vec3& p, double t)
{
    for (const TetId tet : store.star(edge.first, edge.second))
        for (const auto& [end, share] : { std::pair { edge.first, 1.0 - t }, { edge.second, t } }) {
            std::array<Vec3, 4> q = corners_of(store, tet);
            q[static_cast<std::size_t>(store.corner(tet, end))] = p;
            if (!(tet_volume(q[0], q[1], q[2], q[3]) >= kHalfKeepsVolume * share * store.volume(tet)))
                return false;
        }
    return true;
}

void decide_cut_faces(StrokeState& stroke)
{
    const auto uncut = [&](const TetFace& face) {
        const auto& labels = stroke.options.uncut_labels;
        return std::find(labels.begin(), labels.end(), stroke.store.tet(face.tet).label) != labels.end();
    };
    const auto past_end = [&](const BladeFace& face) {
        return !stroke.resolve_end && std::any_of(face.key.begin(), face.key.end(), [&](VertexId v) {
            return stroke.marks.at(v).beyond[kEnd] > 0;
        });
    };
    for (const BladeFace& face : faces_on_blade(stroke))
        if (past_end(face)) {
            if (reaches_in(stroke, face))
                for (const VertexId v : face.key)
                    stroke.waits_from
                        = std::min(stroke.waits_from, stroke.blade.length() + stroke.marks.at(v).distance[kEnd]);
        } else if (inside(stroke, face) && !(uncut(face.minus) && uncut(face.plus)))
            stroke.cut_faces.insert(stroke.store.tet(face.minus.tet), face.minus.corner);
}

bool open_pinned_edges(StrokeState& stroke)
{
    const CutStore& store = stroke.store;
    // Groups that the last round has left are still valid, and their edges need no further test.
    std::map<VertexId, Groups>& groups = stroke.groups;
    std::set<VertexId> changed;
    for (const auto& [key, turn] : stroke.cut_faces.all())
        for (const VertexId v : key)
            if (const auto [it, missing] = groups.try_emplace(v); missing) {
                it->second = groups_round(v, store, stroke.cut_faces);
                changed.insert(v);
            }
    std::set<EdgeKey> edges;
    for (const auto& [key, turn] : stroke.cut_faces.all())
        for (const auto& [i, j] : kFaceEdges)
            if (changed.contains(key[i]) || changed.contains(key[j]))
                edges.emplace(key[i], key[j]);
    std::set<EdgeKey> pinned_edges;
    for (const EdgeKey& edge : edges)
        if (pinned(groups_round(edge, store, stroke.cut_faces), groups.at(edge.first), groups.at(edge.second)))
            pinned_edges.insert(edge);
    // For a face without doubled corner, the longest edge gets a vertex; then the edge from the third corner to the new
    // vertex is pinned.
    for (const auto& [key, turn] : stroke.cut_faces.all())
        if (std::all_of(key.begin(), key.end(), [&](VertexId v) { return groups.at(v).size() == 1; })) {
            std::vector<EdgeKey> own { { key[0], key[1] }, { key[1], key[2] }, { key[0], key[2] } };
            sort_longest_first(own, store);
            // When an edge of the face is pinned already, the vertex of that edge suffices. Another vertex on the rim
            // would make a smaller face of the same kind, and so on.
            if (std::none_of(own.begin(), own.end(), [&](const EdgeKey& edge) { return pinned_edges.contains(edge); }))
                pinned_edges.insert(own.front());
        }
    for (const EdgeKey& edge : pinned_edges) {
        const Vec3 middle = 0.5 * (store.position(edge.first) + store.position(edge.second));
        Vec3 p = is_held(store, edge) ? middle : stroke.blade.project(middle);
        if (!keeps_volume(store, edge, p, 0.5))
            p = middle; // then the vertex lies on a chord of a bent blade
        for (const VertexId near : stroke.store.corners_of_all(store.star(edge.first, edge.second)))
            groups.erase(near); // the elements round these vertices change
        const VertexId v = bisect(stroke, edge, p, 0.5);
        stroke.marks.put_on_blade(v);
        for (std::size_t k = 0; k < 3; ++k)
            if (stroke.marks.at(edge.first).beyond[k] == 0 && stroke.marks.at(edge.second).beyond[k] == 0)
                stroke.marks.put_on_border(v, k);
    }
    return !pinned_edges.empty();
}

namespace {

    /// Every cut face with the elements on both sides, in the order of keys.
    std::vector<BladeFace> sides_of_cut(const StrokeState& stroke)
    {
        const BladeFace none { {}, { -1, 0 }, { -1, 0 } };
        std::map<FaceKey, BladeFace> faces;
        std::vector<VertexId> least;
        for (const auto& [key, turn] : stroke.cut_faces.all())
            least.push_back(key[0]);
        std::vector<TetId> tets = stroke.store.tets_round(least);
        std::sort(tets.begin(), tets.end());
        for (const TetId t : tets)
            for (int corner = 0; corner < 4; ++corner)
                if (const int side = stroke.cut_faces.side(stroke.store.tet(t), corner); side != 0) {
                    BladeFace& face = faces.try_emplace(face_key(stroke.store.tet(t), corner), none).first->second;
                    face.key = face_key(stroke.store.tet(t), corner);
                    (side < 0 ? face.minus : face.plus) = { t, corner };
                }
        std::vector<BladeFace> list;
        for (const auto& [key, face] : faces) {
            if (face.minus.tet < 0 || face.plus.tet < 0)
                throw CutQualityError(CutQualityError::Kind::shape, "a face of the wound has tissue on one side only",
                    "vertex " + std::to_string(key[0]));
            list.push_back(face);
        }
        if (list.size() != stroke.cut_faces.all().size())
            throw CutQualityError(CutQualityError::Kind::shape, "a face of the wound was lost", {});
        return list;
    }

} // namespace

void separate(StrokeState& stroke)
{
    RETRACTOR_ASSERT(!stroke.cut_faces.empty());
    const std::vector<BladeFace> faces = sides_of_cut(stroke);
    LookAtLips look(stroke);
    look_at_former_lips(stroke, look);
    std::set<VertexId> vertices;
    std::set<TetId> on_minus;
    for (const BladeFace& face : faces) {
        vertices.insert(face.key.begin(), face.key.end());
        on_minus.insert(face.minus.tet);
    }
    // All groups are found before vertices are copied, because rewiring a vertex changes the face keys round its
    // neighbours.
    std::map<TetId, TetSlot> rewired;
    const auto slot_of = [&](TetId t) -> TetSlot& { return rewired.try_emplace(t, stroke.store.tet(t)).first->second; };
    for (const VertexId v : vertices) {
        const auto known = stroke.groups.find(v);
        auto groups
            = known != stroke.groups.end() ? std::move(known->second) : groups_round(v, stroke.store, stroke.cut_faces);
        RETRACTOR_ASSERT(!groups.empty());
        const auto keeps = std::find_if(groups.begin(), groups.end(), [&](const std::vector<TetId>& group) {
            return std::any_of(group.begin(), group.end(), [&](TetId t) { return on_minus.contains(t); });
        });
        if (keeps != groups.end())
            std::rotate(groups.begin(), keeps, keeps + 1);
        for (std::size_t g = 1; g < groups.size(); ++g) {
            const VertexId copy = stroke.store.copy_vertex(v);
            for (const TetId t : groups[g])
                slot_of(t).nodes[static_cast<std::size_t>(stroke.store.corner(t, v))] = copy;
        }
    }
    for (const BladeFace& face : faces) {
        TetSlot& minus = slot_of(face.minus.tet);
        TetSlot& plus = slot_of(face.plus.tet);
        if (face_key(minus, face.minus.corner) == face_key(plus, face.plus.corner))
            continue; // every corner lies on the border, and the face stays undivided
        minus.lips[static_cast<std::size_t>(face.minus.corner)] = { stroke.cut_number, -1 };
        plus.lips[static_cast<std::size_t>(face.plus.corner)] = { stroke.cut_number, 1 };
        stroke.report.lip_area_mm2 += triangle_area(
            stroke.store.position(face.key[0]), stroke.store.position(face.key[1]), stroke.store.position(face.key[2]));
        const double local_edge
            = std::min(stroke.store.first_edge(face.minus.tet), stroke.store.first_edge(face.plus.tet));
        const OffBlade off = look.off_blade(face.key);
        stroke.lips_off = std::max(stroke.lips_off, std::max(off.between_corners, off.at_corners) / local_edge);
        stroke.lips_beyond = std::max(stroke.lips_beyond, look.beyond(face.key) / local_edge);
        stroke.report.lip_to_blade = std::max(stroke.report.lip_to_blade, off.between_corners / off.longest_edge);
    }
    std::vector<TetId> parted;
    for (const auto& [t, slot] : rewired) {
        if (slot.nodes == stroke.store.tet(t).nodes) {
            stroke.store.set_lips(t, slot.lips);
            parted.push_back(t);
        } else {
            stroke.store.remove_tet(t);
            parted.push_back(stroke.store.add_tet(slot));
        }
    }
    check_lips(stroke.store, parted, stroke.cut_number);
}

} // namespace retractor::mesh
