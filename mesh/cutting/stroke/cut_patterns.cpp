#include "mesh/cutting/stroke/cut_patterns.h"

#include <Eigen/LU>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace retractor::mesh {

namespace {

    /// The middle of an edge (or face) with its ends on the blade counts as on the blade, unless the blade bends away
    /// by more than this share of the edge's length.
    constexpr double kChordOffBlade = 0.1;

    /// A point of an element that is divided. The weights give the position for edges that are all crossed in their
    /// middles. Orientations are computed from the weights, because round-off cannot change the result.
    struct SubPoint {
        VertexId id = -1;
        Eigen::Vector4d weights = Eigen::Vector4d::Zero(); ///< weights of the element's corners

        bool on_face(int opposite) const { return weights[opposite] == 0.0; }
    };
    using SubFace = std::array<SubPoint, 3>; ///< counter-clockwise seen from outside
    using SubTet = std::array<SubPoint, 4>;

    /// Index of an edge of kTetEdges by its two local corners.
    constexpr std::array<std::array<int, 4>, 4> kEdgeOf { { { -1, 0, 2, 3 }, { 0, -1, 1, 4 }, { 2, 1, -1, 5 },
        { 3, 4, 5, -1 } } };

    std::size_t edge_of(int a, int b)
    {
        return static_cast<std::size_t>(kEdgeOf[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)]);
    }

    /// The two corners other than a and b.
    std::array<int, 2> others(int a, int b)
    {
        std::array<int, 2> rest {};
        std::size_t n = 0;
        for (int c = 0; c < 4; ++c)
            if (c != a && c != b)
                rest[n++] = c;
        return rest;
    }

    /// An element with its points at corners, on edges and on faces; -1 for a missing point.
    struct Element {
        TetSlot slot;
        std::array<VertexId, 6> edge { -1, -1, -1, -1, -1, -1 };
        std::array<VertexId, 4> face { -1, -1, -1, -1 };

        std::array<Eigen::Vector4d, 4> face_weights {};

        SubPoint corner(int c) const { return { slot.nodes[static_cast<std::size_t>(c)], Eigen::Vector4d::Unit(c) }; }
        SubPoint on_edge(int a, int b) const
        {
            return { edge[edge_of(a, b)], 0.5 * (Eigen::Vector4d::Unit(a) + Eigen::Vector4d::Unit(b)) };
        }
        SubPoint on_face(int opposite) const
        {
            const auto i = static_cast<std::size_t>(opposite);
            return { face[i], face_weights[i] };
        }
    };

    /// Order of points for pulling: points on faces, then points on edges, then corners; by id within each kind.
    std::pair<int, VertexId> pulling_order(const SubPoint& p)
    {
        return { -static_cast<int>((p.weights.array() > 0.0).count()), p.id };
    }
    bool pulled_before(const SubPoint& a, const SubPoint& b) { return pulling_order(a) < pulling_order(b); }

    /// The border of a face with the points on its edges.
    std::vector<SubPoint> border_of(const Element& element, int opposite)
    {
        const auto& corners = kTetFaces[static_cast<std::size_t>(opposite)];
        std::vector<SubPoint> border;
        for (std::size_t i = 0; i < 3; ++i) {
            const int a = corners[i], b = corners[(i + 1) % 3];
            border.push_back(element.corner(a));
            if (const SubPoint m = element.on_edge(a, b); m.id >= 0)
                border.push_back(m);
        }
        return border;
    }

    /// The triangles of a face fanned from its least point.
    std::vector<SubFace> pulled_face(const Element& element, int opposite)
    {
        const std::vector<SubPoint> border = border_of(element, opposite);
        SubPoint apex = element.on_face(opposite);
        if (apex.id < 0)
            apex = *std::min_element(border.begin(), border.end(), pulled_before);
        std::vector<SubFace> triangles;
        for (std::size_t i = 0; i < border.size(); ++i) {
            const SubPoint &p = border[i], &q = border[(i + 1) % border.size()];
            if (p.id != apex.id && q.id != apex.id)
                triangles.push_back({ apex, p, q });
        }
        return triangles;
    }

    /// The triangles of a face: three corners and the middle when all edges have points, else a fan from the least
    /// point.
    std::vector<SubFace> red_green_face(const Element& element, int opposite)
    {
        const std::vector<SubPoint> b = border_of(element, opposite);
        if (b.size() < 6)
            return pulled_face(element, opposite);
        return { { b[0], b[1], b[5] }, { b[2], b[3], b[1] }, { b[4], b[5], b[3] }, { b[1], b[3], b[5] } };
    }

    void cone(std::vector<SubTet>& tets, const SubPoint& apex, const std::vector<SubFace>& base)
    {
        for (const SubFace& face : base)
            tets.push_back({ apex, face[0], face[1], face[2] });
    }

    std::vector<SubTet> pulled(const Element& element)
    {
        SubPoint apex;
        const auto consider = [&](const SubPoint& p) {
            if (p.id >= 0 && (apex.id < 0 || pulled_before(p, apex)))
                apex = p;
        };
        for (int c = 0; c < 4; ++c) {
            consider(element.corner(c));
            consider(element.on_face(c));
        }
        for (const auto& e : kTetEdges)
            consider(element.on_edge(e[0], e[1]));
        std::vector<SubTet> tets;
        for (int opposite = 0; opposite < 4; ++opposite)
            if (!apex.on_face(opposite))
                cone(tets, apex, pulled_face(element, opposite));
        return tets;
    }

    /// The elements of the green pattern with these points; empty when the points fit no green pattern.
    std::vector<SubTet> green(const Element& element)
    {
        std::vector<std::size_t> with;
        for (std::size_t e = 0; e < 6; ++e)
            if (element.edge[e] >= 0)
                with.push_back(e);
        std::vector<SubTet> tets;
        for (int c = 0; c < 4 && tets.empty(); ++c) // are all points on the face opposite c?
            if (std::none_of(with.begin(), with.end(),
                    [&](std::size_t e) { return kTetEdges[e][0] == c || kTetEdges[e][1] == c; }))
                cone(tets, element.corner(c), red_green_face(element, c));
        if (tets.empty() && with.size() == 2) { // opposite edges
            const auto &e = kTetEdges[with[0]], &f = kTetEdges[with[1]];
            const SubPoint m = element.on_edge(e[0], e[1]), n = element.on_edge(f[0], f[1]);
            for (const int a : e)
                for (const int b : f)
                    tets.push_back({ element.corner(a), m, element.corner(b), n });
        }
        return tets;
    }

    class Divider {
    public:
        explicit Divider(StrokeState& stroke)
            : stroke_(stroke)
            , store_(stroke.store)
        {
        }

        void general(std::span<const TetId> crossed)
        {
            std::set<TetId> whole;
            for (const TetId t : crossed) {
                const TetSlot slot = store_.tet(t);
                if (corners_on_blade(slot) > 1)
                    continue;
                whole.insert(t);
                for (const auto& e : kTetEdges)
                    edge_point(slot, e[0], e[1]);
            }
            for (const TetId t : whole)
                for (int opposite = 0; opposite < 4; ++opposite)
                    face_point(store_.tet(t), opposite);
            for (const TetId t : touched()) {
                const Element element = element_at(t);
                std::vector<SubTet> parts;
                if (whole.contains(t)) {
                    parts = one_to_seventeen(element);
                    orient(parts);
                }
                if (parts.empty() || turned_over(parts)) {
                    parts = pulled(element);
                    orient(parts);
                }
                replace(t, parts);
            }
        }

        void red_green(std::span<const TetId> crossed)
        {
            std::set<TetId> red, fresh;
            for (const TetId t : crossed)
                if (corners_on_blade(store_.tet(t)) == 0)
                    fresh.insert(t);
            while (!fresh.empty()) {
                std::set<TetId> round;
                for (const TetId t : fresh) {
                    const TetSlot slot = store_.tet(t);
                    for (const auto& e : kTetEdges)
                        if (edge_point(slot, e[0], e[1]))
                            for (const TetId near : store_.star(slot.nodes[static_cast<std::size_t>(e[0])],
                                     slot.nodes[static_cast<std::size_t>(e[1])]))
                                round.insert(near);
                }
                red.merge(fresh);
                fresh.clear();
                for (const TetId t : round)
                    if (!red.contains(t) && green(element_at(t)).empty())
                        fresh.insert(t);
            }
            for (const TetId t : touched()) {
                const Element element = element_at(t);
                std::vector<SubTet> parts = red.contains(t) ? one_to_eight(element) : green(element);
                orient(parts);
                replace(t, parts);
            }
        }

    private:
        int side(VertexId v) { return stroke_.marks.at(v).side; }

        int corners_on_blade(const TetSlot& slot)
        {
            return static_cast<int>(
                std::count_if(slot.nodes.begin(), slot.nodes.end(), [&](VertexId v) { return side(v) == 0; }));
        }

        /// Marks a new vertex between two vertices on the blade as on the blade; the vertex may lie on a chord.
        void mark_on_blade(VertexId v, VertexId a, VertexId b)
        {
            stroke_.marks.put_on_blade(v);
            for (std::size_t k = 0; k < 3; ++k)
                if (stroke_.marks.at(a).beyond[k] == 0 && stroke_.marks.at(b).beyond[k] == 0)
                    stroke_.marks.put_on_border(v, k);
        }

        VertexId add_between(VertexId a, VertexId b, double t)
        {
            const Vec3 p = (1.0 - t) * store_.position(a) + t * store_.position(b);
            return store_.add_vertex(p, a, b, t);
        }

        /// Gives an edge its point; returns false when the edge has a point already.
        bool edge_point(const TetSlot& slot, int first, int second)
        {
            const EdgeKey edge = std::minmax(
                slot.nodes[static_cast<std::size_t>(first)], slot.nodes[static_cast<std::size_t>(second)]);
            const auto [it, missing] = edges_.try_emplace(edge, -1);
            if (!missing)
                return false;
            const auto [a, b] = edge;
            if (side(a) * side(b) < 0) {
                if (const Crossing c = stroke_.marks.crossing(edge); c.real) {
                    it->second = store_.add_vertex(c.point, a, b, c.t);
                    stroke_.marks.put_on_blade(it->second);
                    return true;
                }
            }
            it->second = add_between(a, b, 0.5);
            if (side(a) == 0 && side(b) == 0) {
                const Vec3 &p = store_.position(a), &q = store_.position(b);
                if (std::abs(stroke_.marks.at(it->second).height) < kChordOffBlade * (p - q).norm())
                    mark_on_blade(it->second, a, b);
            }
            return true;
        }

        /// At most two places at which the blade crosses the border of a face: edges, or a corner written as an edge to
        /// itself.
        std::vector<EdgeKey> chord_of(const FaceKey& face)
        {
            const auto [p, q, r] = face;
            std::vector<EdgeKey> chord;
            for (const auto& [a, b, c] : { std::tuple { p, q, r }, { q, r, p }, { r, p, q } }) {
                if (side(a) * side(b) >= 0)
                    continue;
                if (const EdgeKey edge = std::minmax(a, b); side(edges_.at(edge)) == 0)
                    chord.push_back(edge);
                if (side(c) == 0)
                    chord.emplace_back(c, c);
            }
            return chord;
        }

        /// Gives a face its point. @pre the face's edges have their points
        void face_point(const TetSlot& slot, int opposite)
        {
            const auto [it, missing] = faces_.try_emplace(face_key(slot, opposite), -1);
            if (!missing)
                return;
            const std::vector<EdgeKey> chord = chord_of(it->first);
            if (chord.size() == 2) {
                const auto end = [&](const EdgeKey& e) { return e.first == e.second ? e.first : edges_.at(e); };
                it->second = add_between(end(chord[0]), end(chord[1]), 0.5);
                mark_on_blade(it->second, end(chord[0]), end(chord[1]));
            } else {
                const auto [p, q, r] = it->first;
                it->second = add_between(edges_.at(std::minmax(p, q)), r, 1.0 / 3.0);
            }
        }

        /// Elements with a point on an edge, ascending. A face with a point also has points on its edges.
        std::vector<TetId> touched() const
        {
            std::vector<TetId> tets;
            for (const auto& [edge, point] : edges_) {
                const std::vector<TetId> star = store_.star(edge.first, edge.second);
                tets.insert(tets.end(), star.begin(), star.end());
            }
            std::sort(tets.begin(), tets.end());
            tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
            return tets;
        }

        Eigen::Vector4d face_weights(const TetSlot& slot, const FaceKey& face)
        {
            const auto unit = [&](VertexId v) {
                return Eigen::Vector4d::Unit(std::find(slot.nodes.begin(), slot.nodes.end(), v) - slot.nodes.begin());
            };
            Eigen::Vector4d weights = Eigen::Vector4d::Zero();
            const std::vector<EdgeKey> chord = chord_of(face);
            if (chord.size() == 2)
                for (const auto& [a, b] : chord)
                    weights += 0.25 * (unit(a) + unit(b));
            else
                for (const VertexId v : face)
                    weights += unit(v) / 3.0;
            return weights;
        }

        Element element_at(TetId t)
        {
            Element element { .slot = store_.tet(t) };
            for (std::size_t e = 0; e < 6; ++e) {
                const auto it = edges_.find(std::minmax(element.slot.nodes[static_cast<std::size_t>(kTetEdges[e][0])],
                    element.slot.nodes[static_cast<std::size_t>(kTetEdges[e][1])]));
                if (it != edges_.end())
                    element.edge[e] = it->second;
            }
            for (int c = 0; c < 4; ++c)
                if (const auto it = faces_.find(face_key(element.slot, c)); it != faces_.end()) {
                    element.face[static_cast<std::size_t>(c)] = it->second;
                    element.face_weights[static_cast<std::size_t>(c)] = face_weights(element.slot, it->first);
                }
            return element;
        }

        double distance(const SubPoint& a, const SubPoint& b) const
        {
            return (store_.position(a.id) - store_.position(b.id)).norm();
        }

        /// The other corner on corner 0's side of a quadrilateral section; 0 when the section is no quadrilateral.
        int partner_of_first(const Element& element)
        {
            int partner = 0, same = 0;
            for (int c = 1; c < 4; ++c)
                if (side(element.slot.nodes[0]) * side(element.slot.nodes[static_cast<std::size_t>(c)]) > 0) {
                    partner = c;
                    ++same;
                }
            if (same != 1 || corners_on_blade(element.slot) > 0)
                return 0;
            return partner;
        }

        static void edge_and_faces(std::vector<SubTet>& tets, const Element& element, int a, int b)
        {
            const SubPoint m = element.on_edge(a, b);
            const auto [x, y] = others(a, b);
            tets.push_back({ element.corner(a), m, element.on_face(x), element.on_face(y) });
            tets.push_back({ m, element.corner(b), element.on_face(x), element.on_face(y) });
        }

        static void corner_and_faces(std::vector<SubTet>& tets, const Element& element, int a)
        {
            SubTet tet { element.corner(a) };
            std::size_t n = 1;
            for (int c = 0; c < 4; ++c)
                if (c != a)
                    tet[n++] = element.on_face(c);
            tets.push_back(tet);
        }

        /// Adds the elements on the side of a and b of a quadrilateral section. These elements see the diagonal between
        /// the points of the faces opposite a and b.
        static void flipped_side(std::vector<SubTet>& tets, const Element& element, int a, int b)
        {
            const SubPoint m = element.on_edge(a, b), fa = element.on_face(a), fb = element.on_face(b);
            for (const int x : others(a, b)) {
                const SubPoint fx = element.on_face(x);
                tets.push_back({ m, fa, fb, fx });
                tets.push_back({ m, element.corner(a), fb, fx });
                tets.push_back({ m, element.corner(b), fa, fx });
            }
        }

        std::vector<SubTet> one_to_seventeen(const Element& element)
        {
            std::vector<SubTet> tets;
            const int partner = partner_of_first(element);
            if (partner == 0) {
                for (const auto& e : kTetEdges)
                    edge_and_faces(tets, element, e[0], e[1]);
                for (int c = 0; c < 4; ++c)
                    corner_and_faces(tets, element, c);
                tets.push_back({ element.on_face(0), element.on_face(1), element.on_face(2), element.on_face(3) });
                return tets;
            }
            const auto [c, d] = others(0, partner);
            for (const auto& e : kTetEdges)
                if (edge_of(e[0], e[1]) != edge_of(0, partner) && edge_of(e[0], e[1]) != edge_of(c, d))
                    edge_and_faces(tets, element, e[0], e[1]);
            // The side of corner 0 and its partner sees the diagonal between the face points opposite c and d; the side
            // of c and d sees the other diagonal.
            const bool keep_first = distance(element.on_face(c), element.on_face(d))
                <= distance(element.on_face(0), element.on_face(partner));
            const std::array<int, 2> first { 0, partner }, second { c, d };
            const auto &kept = keep_first ? first : second, &flipped = keep_first ? second : first;
            edge_and_faces(tets, element, kept[0], kept[1]);
            for (const int corner : kept)
                corner_and_faces(tets, element, corner);
            flipped_side(tets, element, flipped[0], flipped[1]);
            return tets;
        }

        std::vector<SubTet> one_to_eight(const Element& element)
        {
            std::vector<SubTet> tets;
            for (int a = 0; a < 4; ++a) {
                SubTet tet { element.corner(a) };
                std::size_t n = 1;
                for (int b = 0; b < 4; ++b)
                    if (b != a)
                        tet[n++] = element.on_edge(a, b);
                tets.push_back(tet);
            }
            // A diagonal joins the points of two opposite edges: 0-x and the edge of the other two corners.
            const int partner = partner_of_first(element);
            int best = -1;
            double shortest = 0.0;
            for (int x = 1; x < 4; ++x) {
                const auto [y, z] = others(0, x);
                const double length = distance(element.on_edge(0, x), element.on_edge(y, z));
                if (x != partner && (best < 0 || length < shortest)) {
                    best = x;
                    shortest = length;
                }
            }
            const auto [y, z] = others(0, best);
            const SubPoint from = element.on_edge(0, best), to = element.on_edge(y, z);
            const std::array<SubPoint, 4> ring { element.on_edge(0, y), element.on_edge(y, best),
                element.on_edge(best, z), element.on_edge(z, 0) };
            for (std::size_t i = 0; i < 4; ++i)
                tets.push_back({ from, to, ring[i], ring[(i + 1) % 4] });
            return tets;
        }

        void orient(std::vector<SubTet>& parts) const
        {
            for (SubTet& part : parts) {
                Eigen::Matrix4d weights;
                for (int i = 0; i < 4; ++i)
                    weights.row(i) = part[static_cast<std::size_t>(i)].weights.transpose();
                if (weights.determinant() < 0.0)
                    std::swap(part[2], part[3]);
            }
        }

        /// True when a part is turned over. A blade that twists within the element may place the points on faces in
        /// such a way.
        bool turned_over(const std::vector<SubTet>& parts) const
        {
            return std::any_of(parts.begin(), parts.end(), [&](const SubTet& part) {
                const auto p = [&](std::size_t i) { return store_.position(part[i].id); };
                return !(tet_volume(p(0), p(1), p(2), p(3)) > 0.0);
            });
        }

        void replace(TetId t, const std::vector<SubTet>& parts)
        {
            const TetSlot parent = store_.tet(t);
            store_.remove_tet(t);
            for (const SubTet& part : parts) {
                TetSlot child = parent;
                for (std::size_t i = 0; i < 4; ++i) {
                    child.nodes[i] = part[i].id;
                    child.lips[i] = {};
                    for (int c = 0; c < 4; ++c) { // is the face a part of the parent's face?
                        bool on = true;
                        for (std::size_t j = 0; j < 4; ++j)
                            on = on && (j == i || part[j].on_face(c));
                        if (on)
                            child.lips[i] = parent.lips[static_cast<std::size_t>(c)];
                    }
                }
                store_.add_tet(child);
            }
        }

        StrokeState& stroke_;
        CutStore& store_;
        std::map<EdgeKey, VertexId> edges_;
        std::map<FaceKey, VertexId> faces_;
    };

} // namespace

void divide_by_pattern(StrokeState& stroke, std::span<const TetId> crossed)
{
    Divider divider(stroke);
    if (stroke.options.subdivision == Subdivision::general)
        divider.general(crossed);
    else
        divider.red_green(crossed);
}

std::vector<TetId> crossed_elements(const TetMesh& mesh, const SweptBlade& blade)
{
    const Eigen::AlignedBox3d reach = blade.box(0.0, blade.length());
    TetMesh near;
    near.vertices = mesh.vertices;
    std::vector<TetId> id;
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        Eigen::AlignedBox3d box;
        for (const VertexId v : mesh.tet(t).first(4))
            box.extend(Vec3(mesh.vertices.row(v).transpose()));
        if (!box.intersects(reach))
            continue;
        const auto nodes = mesh.tet(t).first(4);
        near.nodes.insert(near.nodes.end(), nodes.begin(), nodes.end());
        near.labels.push_back(mesh.labels[static_cast<std::size_t>(t)]);
        id.push_back(t);
    }
    if (id.empty())
        return {};
    CutStore store(near);
    BladeMarks marks(store, blade);
    std::vector<TetId> crossed;
    for (TetId t = 0; t < static_cast<TetId>(id.size()); ++t)
        if (marks.crossed(store.tet(t)))
            crossed.push_back(id[static_cast<std::size_t>(t)]);
    return crossed;
}

} // namespace retractor::mesh
