#include "mesh/cutting/stroke/cut_flips.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_moves.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace retractor::mesh {

namespace {

    /// Smallest volume of an element, as a share of the mean volume of the hole's old elements; a smaller volume is
    /// round-off.
    constexpr double kLeastShare = 1e-6;

    using Corners = std::array<Vec3, 4>;

    double volume(const Corners& p) { return tet_volume(p[0], p[1], p[2], p[3]); }

    /// Cosine of the smallest dihedral angle; 1 for an element that is turned over or smaller than `least` (mm^3).
    double cosine(const CutStore& store, const std::array<VertexId, 4>& nodes, double least)
    {
        const Corners p = corners_of(store, nodes);
        return volume(p) > least ? smallest_dihedral_cosine(p) : 1.0;
    }

    bool joined(const CutStore& store, VertexId a, VertexId b)
    {
        const auto& star = store.unsorted_star(a);
        return std::any_of(star.begin(), star.end(), [&](TetId t) { return store.corner(t, b) >= 0; });
    }

    FaceKey sorted(VertexId a, VertexId b, VertexId c)
    {
        FaceKey key { a, b, c };
        std::sort(key.begin(), key.end());
        return key;
    }

    struct Taken {
        double cosine = -1.0, volume = 0.0;
    };
    /// Volume and shape of the elements that would be removed.
    Taken taken(const CutStore& store, const std::vector<TetId>& gone)
    {
        Taken sum;
        for (const TetId t : gone) {
            sum.cosine = std::max(sum.cosine, smallest_dihedral_cosine(corners_of(store, t)));
            sum.volume += store.volume(t);
        }
        return sum;
    }

    /// The elements round an edge a-b and their closed ring of vertices, in an order such that (ring[i], ring[i + 1],
    /// a, b) is a positive element. Empty when the ring is open, too long, or of several labels.
    struct Ring {
        std::vector<TetId> tets;
        std::vector<VertexId> vertices;
    };

    Ring ring_round(const CutStore& store, const EdgeKey& edge)
    {
        Ring ring;
        ring.tets = store.star(edge.first, edge.second);
        if (ring.tets.size() < 3 || ring.tets.size() > kMostRing)
            return {};
        std::map<VertexId, VertexId> next;
        for (const TetId t : ring.tets) {
            const TetSlot& tet = store.tet(t);
            if (tet.label != store.tet(ring.tets.front()).label)
                return {};
            // The corners in kTetFaces run counter-clockwise seen from outside, also for the face opposite the edge's
            // second end.
            const std::array<VertexId, 3> v = face_corners(tet.nodes, store.corner(t, edge.second));
            const auto first = static_cast<std::size_t>(std::find(v.begin(), v.end(), edge.first) - v.begin());
            if (!next.emplace(v[(first + 1) % 3], v[(first + 2) % 3]).second)
                return {};
        }
        VertexId v = next.begin()->first;
        for (std::size_t i = 0; i < ring.tets.size(); ++i) {
            ring.vertices.push_back(v);
            const auto it = next.find(v);
            if (it == next.end())
                return {};
            v = it->second;
        }
        std::vector<VertexId> once = ring.vertices;
        std::sort(once.begin(), once.end());
        if (v != ring.vertices.front() || std::adjacent_find(once.begin(), once.end()) != once.end())
            return {};
        return ring;
    }

    /// The best triangulation of a ring (Klincsek 1980).
    class RingTriangulation {
    public:
        RingTriangulation(const CutStore& store, const Ring& ring, const EdgeKey& edge, double least)
            : store_(store)
            , ring_(ring.vertices)
            , edge_(edge)
            , least_(least)
        {
            const std::size_t n = ring_.size();
            RETRACTOR_ASSERT(n >= 3 && n <= kMostRing);
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j < n; ++j)
                    cost_[i][j] = j == i + 1 ? -1.0 : 1.0;
            for (std::size_t length = 2; length < n; ++length)
                for (std::size_t i = 0; i + length < n; ++i)
                    choose(i, i + length);
        }
        double cosine() const { return cost_[0][ring_.size() - 1]; }
        /// The triangles, with the orientation of the ring.
        std::vector<std::array<VertexId, 3>> triangles() const
        {
            std::vector<std::array<VertexId, 3>> list;
            collect(0, ring_.size() - 1, list);
            return list;
        }

    private:
        void choose(std::size_t i, std::size_t j)
        {
            const bool side = j == i + 1 || (i == 0 && j + 1 == ring_.size());
            if (!side && joined(store_, ring_[i], ring_[j]))
                return; // the edge exists already
            for (std::size_t k = i + 1; k < j; ++k) {
                double worst = std::max(cost_[i][k], cost_[k][j]);
                if (worst >= cost_[i][j])
                    continue;
                for (const auto& nodes : elements({ ring_[i], ring_[k], ring_[j] }, edge_))
                    worst = std::max(worst, mesh::cosine(store_, nodes, least_));
                if (worst < cost_[i][j]) {
                    cost_[i][j] = worst;
                    third_[i][j] = k;
                }
            }
        }
        void collect(std::size_t i, std::size_t j, std::vector<std::array<VertexId, 3>>& list) const
        {
            if (j == i + 1)
                return;
            const std::size_t k = third_[i][j];
            list.push_back({ ring_[i], ring_[k], ring_[j] });
            collect(i, k, list);
            collect(k, j, list);
        }

    public:
        /// The two elements between a triangle and the ends of the edge.
        static std::array<std::array<VertexId, 4>, 2> elements(const std::array<VertexId, 3>& t, const EdgeKey& edge)
        {
            return { { { t[0], t[1], t[2], edge.first }, { t[0], t[2], t[1], edge.second } } };
        }

    private:
        const CutStore& store_;
        const std::vector<VertexId>& ring_;
        const EdgeKey& edge_;
        double least_;
        std::array<std::array<double, kMostRing>, kMostRing> cost_ {};
        std::array<std::array<std::size_t, kMostRing>, kMostRing> third_ {};
    };

    /// Volume (mm^3) of the part of an element inside all `planes` (height >= 0).
    double clipped_volume(const Corners& p, std::span<const std::pair<Vec3, double>> planes)
    {
        if (planes.empty())
            return std::abs(volume(p));
        const auto& [normal, offset] = planes.front();
        const auto rest = planes.subspan(1);
        std::vector<std::size_t> in, out;
        std::array<double, 4> height;
        for (std::size_t i = 0; i < 4; ++i) {
            height[i] = normal.dot(p[i]) - offset;
            (height[i] > 0.0 ? in : out).push_back(i);
        }
        const auto on = [&](std::size_t i, std::size_t j) {
            const double t = height[i] / (height[i] - height[j]);
            return Vec3((1.0 - t) * p[i] + t * p[j]);
        };
        // A triangle prism a b c - d e f as three elements.
        const auto prism
            = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e, const Vec3& f) {
                  return clipped_volume({ a, b, c, d }, rest) + clipped_volume({ b, c, d, e }, rest)
                      + clipped_volume({ c, d, e, f }, rest);
              };
        switch (in.size()) {
        case 0:
            return 0.0;
        case 1:
            return clipped_volume({ p[in[0]], on(in[0], out[0]), on(in[0], out[1]), on(in[0], out[2]) }, rest);
        case 2:
            return prism(
                p[in[0]], on(in[0], out[0]), on(in[0], out[1]), p[in[1]], on(in[1], out[0]), on(in[1], out[1]));
        case 3:
            return prism(p[in[0]], p[in[1]], p[in[2]], on(in[0], out[0]), on(in[1], out[0]), on(in[2], out[0]));
        default:
            return clipped_volume(p, rest);
        }
    }

    /// The origin with which an element shares the most volume, among the origins of the old elements. The first of
    /// equal origins counts.
    TetId origin_of(const CutStore& store, const std::array<VertexId, 4>& nodes, const std::vector<TetId>& gone)
    {
        TetId origin = store.tet(gone.front()).origin;
        if (std::all_of(gone.begin(), gone.end(), [&](TetId t) { return store.tet(t).origin == origin; }))
            return origin;
        std::map<TetId, double> shared; // by origin
        const Corners p = corners_of(store, nodes);
        for (const TetId t : gone)
            shared[store.tet(t).origin] += shared_volume(p, corners_of(store, t));
        double most = -1.0;
        for (const auto& [id, share] : shared)
            if (share > most * (1.0 + kLeastShare)) { // a difference within round-off does not count
                most = share;
                origin = id;
            }
        return origin;
    }

} // namespace

double shared_volume(const Corners& a, const Corners& b)
{
    std::array<std::pair<Vec3, double>, 4> planes;
    for (std::size_t f = 0; f < 4; ++f) {
        const auto [p, q, r] = face_corners(b, static_cast<int>(f));
        const Vec3 inward = unit_normal(p, r, q);
        planes[f] = { inward, inward.dot(p) };
    }
    return clipped_volume(a, planes);
}

std::optional<Flip> face_flip(const CutStore& store, TetId t, int corner)
{
    const TetId other = store.across({ t, corner });
    if (other < 0 || store.tet(other).label != store.tet(t).label)
        return std::nullopt;
    const TetSlot& tet = store.tet(t);
    const std::array<VertexId, 3> face = face_corners(tet.nodes, corner);
    const VertexId below = tet.nodes[static_cast<std::size_t>(corner)];
    VertexId above = -1;
    for (const VertexId v : store.tet(other).nodes)
        if (std::find(face.begin(), face.end(), v) == face.end())
            above = v;
    if (joined(store, below, above))
        return std::nullopt;
    Flip flip;
    flip.gone = { std::min(t, other), std::max(t, other) };
    const Taken before = taken(store, flip.gone);
    flip.cosine_before = before.cosine;
    flip.cosine_after = -1.0;
    flip.faces_gone = { sorted(face[0], face[1], face[2]) };
    for (std::size_t i = 0; i < 3; ++i) {
        const VertexId a = face[i], b = face[(i + 1) % 3]; // counter-clockwise seen from above
        const std::array<VertexId, 4> nodes { below, a, b, above };
        flip.cosine_after = std::max(flip.cosine_after, cosine(store, nodes, kLeastShare * before.volume / 3.0));
        if (flip.cosine_after >= 1.0)
            return std::nullopt;
        flip.born.push_back({ .nodes = nodes, .label = tet.label });
        flip.faces_born.push_back(sorted(below, above, a));
    }
    return flip;
}

std::optional<Flip> edge_flip(const CutStore& store, const EdgeKey& edge)
{
    const Ring ring = ring_round(store, edge);
    const std::size_t n = ring.vertices.size();
    if (n < 3)
        return std::nullopt;
    const auto is_face = [&](const std::array<VertexId, 3>& v) {
        const auto& star = store.unsorted_star(v[0]);
        return std::any_of(star.begin(), star.end(),
            [&](TetId t) { return store.corner(t, v[1]) >= 0 && store.corner(t, v[2]) >= 0; });
    };
    if (n == 3 && is_face({ ring.vertices[0], ring.vertices[1], ring.vertices[2] }))
        return std::nullopt;
    const Taken before = taken(store, ring.tets);
    const RingTriangulation best(store, ring, edge, kLeastShare * before.volume / static_cast<double>(2 * n - 4));
    if (best.cosine() >= 1.0)
        return std::nullopt;
    Flip flip;
    flip.gone = ring.tets;
    flip.cosine_before = before.cosine;
    flip.cosine_after = best.cosine();
    flip.edges_gone = { edge };
    for (const VertexId v : ring.vertices)
        flip.faces_gone.push_back(sorted(edge.first, edge.second, v));
    for (const auto& triangle : best.triangles()) {
        flip.faces_born.push_back(sorted(triangle[0], triangle[1], triangle[2]));
        for (const auto& nodes : RingTriangulation::elements(triangle, edge))
            flip.born.push_back({ .nodes = nodes, .label = store.tet(ring.tets.front()).label });
    }
    for (const auto& slot : flip.born) // faces between a diagonal and an end of the edge
        for (int corner = 0; corner < 4; ++corner)
            if (const FaceKey key = face_key(slot, corner);
                std::find(flip.faces_born.begin(), flip.faces_born.end(), key) == flip.faces_born.end()
                && !is_face(key))
                flip.faces_born.push_back(key);
    return flip;
}

std::vector<TetId> make_flip(CutStore& store, const Flip& flip)
{
    RETRACTOR_ASSERT(!flip.gone.empty() && !flip.born.empty());
    std::map<FaceKey, LipTag> lips;
    for (const TetId t : flip.gone)
        for (int corner = 0; corner < 4; ++corner)
            if (const LipTag tag = store.tet(t).lips[static_cast<std::size_t>(corner)]; tag.cut >= 0)
                lips.emplace(face_key(store.tet(t), corner), tag);
    std::vector<TetSlot> born = flip.born;
    for (TetSlot& slot : born) {
        slot.origin = origin_of(store, slot.nodes, flip.gone);
        for (int corner = 0; corner < 4; ++corner)
            if (const auto it = lips.find(face_key(slot, corner)); it != lips.end())
                slot.lips[static_cast<std::size_t>(corner)] = it->second;
    }
    for (const TetId t : flip.gone)
        store.remove_tet(t);
    std::vector<TetId> tets;
    for (const TetSlot& slot : born)
        tets.push_back(store.add_tet(slot));
    return tets;
}

} // namespace retractor::mesh
