#include "mesh/cutting/stroke/cut_moves.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_retry.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace retractor::mesh {

namespace {
    /// A move leaves each element round the vertex at least this share of its volume.
    constexpr double kKeepsVolume = 0.25;
    /// Where an angle is small already, a move leaves at least this share of the angle, so that a short move is not
    /// refused without need.
    constexpr double kKeepsAngle = 0.9;

    /// A deviation below this share of an edge is round-off.
    constexpr double kRoundOff = 1e-12;

    /// A face at a vertex, given by the face's other two corners.
    struct StarFace {
        std::uint64_t others;
        Label label; ///< label of the element
    };

    std::vector<StarFace> faces_round(const CutStore& store, VertexId v, std::span<const TetId> star)
    {
        std::vector<StarFace> faces;
        faces.reserve(3 * star.size());
        for (const TetId t : star) {
            std::array<std::uint64_t, 4> others {};
            std::size_t n = 0;
            for (const VertexId w : store.tet(t).nodes)
                if (w != v)
                    others[n++] = static_cast<std::uint32_t>(w);
            for (const auto& [i, j] : { std::pair<std::size_t, std::size_t> { 0, 1 }, { 1, 2 }, { 0, 2 } }) {
                const auto [a, b] = std::minmax(others[i], others[j]);
                faces.push_back({ a << 32U | b, store.tet(t).label });
            }
        }
        std::sort(faces.begin(), faces.end(), [](const StarFace& a, const StarFace& b) { return a.others < b.others; });
        return faces;
    }

    FaceKey key_with(VertexId v, std::uint64_t others)
    {
        FaceKey key { v, static_cast<VertexId>(others >> 32U), static_cast<VertexId>(others & 0xffffffffU) };
        std::sort(key.begin(), key.end());
        return key;
    }

    /// Normals of the faces opposite corners 0 to 3, all outward or all inward.
    inline std::array<Vec3, 4> face_normals(const std::array<Vec3, 4>& p)
    {
        const Vec3 ab = p[1] - p[0], ac = p[2] - p[0], ad = p[3] - p[0], bc = p[2] - p[1], bd = p[3] - p[1];
        return { bc.cross(bd), ad.cross(ac), ab.cross(ad), ac.cross(ab) };
    }
} // namespace

double smallest_dihedral_cosine(const std::array<Vec3, 4>& p, double enough)
{
    constexpr double kSlack = 1e-12; // share of the squares; far above their round-off
    const std::array<Vec3, 4> n = face_normals(p);
    std::array<double, 4> size;
    for (std::size_t i = 0; i < 4; ++i) {
        size[i] = n[i].squaredNorm();
        if (!(size[i] > 0.0))
            return 1.0;
    }
    const double clear = enough * enough * (1.0 + kSlack);
    std::array<double, 6> square, sizes; // squares of the products, with the products' signs
    std::size_t k = 0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j, ++k) {
            const double dot = -n[i].dot(n[j]);
            square[k] = dot * std::abs(dot);
            sizes[k] = size[i] * size[j];
            if (square[k] > clear * sizes[k])
                return 1.0;
        }
    double largest = -1.0; // a single root at the end
    for (k = 0; k < 6; ++k)
        largest = std::max(largest, square[k] / sizes[k]);
    return std::copysign(std::sqrt(std::abs(largest)), largest);
}

bool smallest_dihedral_is_larger(const std::array<Vec3, 4>& p, double cosine)
{
    constexpr double kSlack = 1e-12; // share of the squares; far above their round-off
    const std::array<Vec3, 4> n = face_normals(p);
    std::array<double, 4> size;
    for (std::size_t i = 0; i < 4; ++i)
        size[i] = n[i].squaredNorm();
    const double clear = cosine * cosine * (1.0 - kSlack);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (const double dot = -n[i].dot(n[j]); !(dot * std::abs(dot) < clear * (size[i] * size[j])))
                return false;
    return true;
}

std::array<double, 6> dihedral_cosines(const std::array<Vec3, 4>& p)
{
    std::array<Vec3, 4> n = face_normals(p);
    for (Vec3& normal : n) {
        const double size = normal.norm();
        if (!(size > 0.0))
            return { 1.0, 1.0, 1.0, 1.0, 1.0, 1.0 };
        normal /= size;
    }
    std::array<double, 6> cosines;
    std::size_t k = 0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j)
            cosines[k++] = -n[i].dot(n[j]);
    return cosines;
}

std::array<Vec3, 4> corners_of(const CutStore& store, const std::array<VertexId, 4>& n)
{
    return { store.position(n[0]), store.position(n[1]), store.position(n[2]), store.position(n[3]) };
}

std::array<Vec3, 4> corners_of(const CutStore& store, TetId t) { return corners_of(store, store.tet(t).nodes); }

std::vector<VertexId> neighbours(const CutStore& store, VertexId v, std::span<const TetId> star)
{
    std::vector<VertexId> others;
    others.reserve(3 * star.size());
    for (const TetId t : star)
        for (const VertexId w : store.tet(t).nodes)
            if (w != v)
                others.push_back(w);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others;
}

bool on_lip(const CutStore& store, VertexId v, std::span<const TetId> star)
{
    for (const TetId t : star)
        for (std::size_t corner = 0; corner < 4; ++corner)
            if (store.tet(t).lips[corner].cut >= 0 && store.tet(t).nodes[corner] != v)
                return true;
    return false;
}

double shortest_edge(const CutStore& store, VertexId v, std::span<const TetId> star)
{
    double shortest = std::numeric_limits<double>::infinity();
    for (const TetId t : star)
        for (const VertexId w : store.tet(t).nodes)
            if (w != v)
                shortest = std::min(shortest, (store.position(w) - store.position(v)).squaredNorm());
    return std::sqrt(shortest);
}

double mean_edge(const CutStore& store, VertexId v, std::span<const TetId> star)
{
    const std::vector<VertexId> others = neighbours(store, v, star);
    RETRACTOR_ASSERT(!others.empty());
    double sum = 0.0;
    for (const VertexId w : others)
        sum += (store.position(w) - store.position(v)).norm();
    return sum / static_cast<double>(others.size());
}

std::vector<HeldFace> held_faces(const CutStore& store, VertexId v, std::span<const TetId> star)
{
    const std::vector<StarFace> faces = faces_round(store, v, star);
    std::vector<HeldFace> held;
    for (std::size_t i = 0; i < faces.size();) {
        const bool shared = i + 1 < faces.size() && faces[i + 1].others == faces[i].others;
        if (!shared || faces[i].label != faces[i + 1].label) {
            const FaceKey key = key_with(v, faces[i].others);
            held.push_back(
                { key, unit_normal(store.position(key[0]), store.position(key[1]), store.position(key[2])), !shared });
        }
        i += shared ? 2 : 1;
    }
    std::sort(held.begin(), held.end(), [](const HeldFace& a, const HeldFace& b) { return a.key < b.key; });
    return held;
}

namespace {
    double distance_from_segment(const Vec3& d, const Vec3& edge)
    {
        return (d - std::clamp(edge.dot(d) / edge.squaredNorm(), 0.0, 1.0) * edge).norm();
    }

    /// Distance (mm) of v + d from the faces round v that belong to the outer surface (or to interfaces, when `outer`
    /// is false).
    double distance_from_sheet(
        const CutStore& store, VertexId v, std::span<const HeldFace> faces, const Vec3& d, bool outer)
    {
        double nearest = std::numeric_limits<double>::infinity();
        bool any = false;
        for (const HeldFace& face : faces) {
            if (face.outer != outer)
                continue;
            any = true;
            std::array<Vec3, 2> edge;
            std::size_t n = 0;
            for (const VertexId w : face.key)
                if (w != v)
                    edge[n++] = store.position(w) - store.position(v);
            const double inner = edge[0].dot(edge[1]), a = edge[0].squaredNorm(), b = edge[1].squaredNorm();
            const double x = edge[0].dot(d) * b - edge[1].dot(d) * inner,
                         y = edge[1].dot(d) * a - edge[0].dot(d) * inner;
            // Within the corner at v, the third side is assumed to be far away.
            nearest = std::min(nearest,
                x >= 0.0 && y >= 0.0 ? std::abs(face.normal.dot(d))
                                     : std::min(distance_from_segment(d, edge[0]), distance_from_segment(d, edge[1])));
        }
        return any ? nearest : 0.0;
    }
} // namespace

double surface_deviation(
    const CutStore& store, VertexId v, std::span<const HeldFace> faces, const Vec3& to, double most)
{
    const Vec3 d = to - store.position(v);
    double worst = 0.0;
    for (const HeldFace& face : faces) {
        worst = std::max(worst, std::abs(face.normal.dot(d)));
        std::array<Vec3, 3> p;
        for (std::size_t i = 0; i < 3; ++i)
            p[i] = face.key[i] == v ? to : store.position(face.key[i]);
        const Vec3 after = (p[1] - p[0]).cross(p[2] - p[0]);
        if (const double size = after.norm(); size > 0.0)
            worst = std::max(worst, std::abs(after.dot(d)) / size);
    }
    // Where a surface bends back sharply, the planes of its faces continue beyond the bend; there the distance from the
    // faces decides.
    for (const bool outer : { true, false })
        if (worst <= most)
            worst = std::max(worst, distance_from_sheet(store, v, faces, d, outer));
    return worst;
}

std::vector<HeldFace> held_faces(const CutStore& store, const EdgeKey& edge)
{
    const std::vector<TetId> star = store.star(edge.first);
    std::vector<HeldFace> held = held_faces(store, edge.first, star);
    std::erase_if(held, [&](const HeldFace& face) {
        return std::find(face.key.begin(), face.key.end(), edge.second) == face.key.end();
    });
    return held;
}

void check_element_limit(const StrokeState& stroke)
{
    const std::size_t limit = stroke.options.element_limit;
    if (stroke.store.counts().tets > limit)
        throw SolverError("the cut would make more than " + std::to_string(limit)
                + " elements (element_limit); undo cuts that cross in one place, or allow more",
            "element_limit");
}

void check_growth(const StrokeState& stroke)
{
    const CutReport& report = stroke.report;
    const std::size_t most = kMostGrowth * std::max(report.tets_crossed, kLeastCrossed);
    if (stroke.store.counts().tets > report.tets_before + most)
        throw CutQualityError(CutQualityError::Kind::growth,
            "the blade twists or bends so much within single elements that each it crosses would become more than "
                + std::to_string(kMostGrowth) + "; turn it less over a few millimetres, or mesh finer there",
            std::to_string(report.tets_crossed) + " elements crossed");
}

VertexId bisect(StrokeState& stroke, const EdgeKey& edge, const Vec3& p, double t)
{
    if (is_parted(stroke, edge))
        throw CutQualityError(CutQualityError::Kind::shape,
            "the step would divide one lip of the stroke and not the other",
            "edge " + std::to_string(edge.first) + " - " + std::to_string(edge.second));
    const VertexId v = stroke.store.bisect(edge.first, edge.second, p, t);
    check_element_limit(stroke);
    check_growth(stroke);
    stroke.cut_faces.bisect(edge, v);
    for (const VertexId end : { edge.first, edge.second })
        if (const auto it = stroke.drift.find(end); it != stroke.drift.end()) {
            const double drift = it->second;
            stroke.drift[v] = std::max(stroke.drift[v], drift);
        }
    return v;
}

bool is_parted(const StrokeState& stroke, const EdgeKey& edge)
{
    if (!stroke.goes_on)
        return false;
    using Place = std::array<double, 3>;
    std::vector<Place> minus, plus; // third corners of the lips at the edge; copies have bit-equal positions
    for (const TetId t : stroke.store.unsorted_star(edge.first)) {
        const TetSlot& tet = stroke.store.tet(t);
        if (std::none_of(
                tet.lips.begin(), tet.lips.end(), [&](const LipTag& lip) { return lip.cut == stroke.cut_number; })
            || stroke.store.corner(t, edge.second) < 0)
            continue;
        for (std::size_t i = 0; i < 4; ++i)
            if (tet.lips[i].cut == stroke.cut_number && tet.nodes[i] != edge.first && tet.nodes[i] != edge.second)
                for (std::size_t j = 0; j < 4; ++j)
                    if (j != i && tet.nodes[j] != edge.first && tet.nodes[j] != edge.second) {
                        const Vec3& p = stroke.store.position(tet.nodes[j]);
                        (tet.lips[i].side > 0 ? plus : minus).push_back({ p.x(), p.y(), p.z() });
                    }
    }
    std::sort(minus.begin(), minus.end());
    std::sort(plus.begin(), plus.end());
    return minus != plus;
}

bool is_held(const CutStore& store, const EdgeKey& edge)
{
    std::map<VertexId, std::pair<int, Label>>
        faces; // per third corner: number of elements, and the label of the first element
    for (const TetId t : store.unsorted_star(edge.first)) {
        if (store.corner(t, edge.second) < 0)
            continue;
        for (const VertexId v : store.tet(t).nodes)
            if (v != edge.first && v != edge.second) {
                auto& [count, label] = faces.try_emplace(v, 0, store.tet(t).label).first->second;
                if (++count == 2 && label != store.tet(t).label)
                    return true;
            }
    }
    return std::any_of(faces.begin(), faces.end(), [](const auto& face) { return face.second.first == 1; });
}

bool SurfaceRoom::keeps(double deviation)
{
    if (deviation <= kRoundOff * unit_)
        return true; // earlier moves were within their limit, also when the edges have become short
    const auto it = stroke_.drift.find(v_);
    const double after = deviation + (it == stroke_.drift.end() ? 0.0 : it->second);
    if (deviation > kSurfaceDeviation * unit_)
        return false;
    if (!local_) {
        local_ = mean_edge(stroke_.store, v_, star_);
        for (const TetId t : star_)
            local_ = std::min(*local_, stroke_.store.first_edge(t));
    }
    return after <= share_ * kSurfaceDrift * *local_;
}

void report_surface(StrokeState& stroke, VertexId v, double deviation)
{
    double local = 0.0;
    for (const TetId t : stroke.store.unsorted_star(v))
        local = std::max(local, stroke.store.first_edge(t));
    stroke.report.surface_deviation = std::max(stroke.report.surface_deviation, deviation / local);
}

void carry_surface(StrokeState& stroke, VertexId v, double deviation)
{
    RETRACTOR_ASSERT(deviation >= 0.0);
    report_surface(stroke, v, stroke.drift[v] += deviation);
}

void move_checked(StrokeState& stroke, VertexId v, const Vec3& to, std::span<const TetId> star, double deviation)
{
    RETRACTOR_ASSERT(stroke.store.has_vertex(v) && !star.empty());
    CutReport& report = stroke.report;
    report.largest_move_mm = std::max(report.largest_move_mm, (to - stroke.store.position(v)).norm());
    carry_surface(stroke, v, deviation);
    ++report.vertices_moved;
    stroke.store.move_vertex(v, to);
    stroke.marks.forget(v, neighbours(stroke.store, v, star));
}

bool move_to_best(StrokeState& stroke, VertexId v, std::span<const Vec3> candidates, std::span<const TetId> star)
{
    const CutStore& store = stroke.store;
    const Vec3 from = store.position(v);
    const double unit = shortest_edge(store, v, star);
    const std::vector<HeldFace> held = held_faces(store, v, star);
    SurfaceRoom room(stroke, v, unit, star);
    struct Choice {
        double cost;
        double deviation;
        const Vec3* to;
    };
    std::vector<Choice> choices;
    for (const Vec3& candidate : candidates) {
        const Vec3 d = candidate - from;
        const double deviation = surface_deviation(store, v, held, candidate, kSurfaceDeviation * unit);
        if (room.keeps(deviation))
            choices.push_back({ deviation / (kSurfaceDeviation * unit) + d.norm() / unit, deviation, &candidate });
    }
    std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) { return a.cost < b.cost; });
    const double limit = std::cos(stroke.options.snap_angle_deg * std::numbers::pi / 180.0);
    const auto harmless = [&](const Vec3& to) {
        for (const TetId t : star) {
            std::array<Vec3, 4> p = corners_of(store, t);
            const double before = tet_volume(p[0], p[1], p[2], p[3]);
            const std::array<Vec3, 4> old = p;
            p[static_cast<std::size_t>(store.corner(t, v))] = to;
            if (!(tet_volume(p[0], p[1], p[2], p[3]) >= kKeepsVolume * before))
                return false;
            const double cosine = smallest_dihedral_cosine(p);
            if (cosine > limit && 1.0 - cosine < kKeepsAngle * kKeepsAngle * (1.0 - smallest_dihedral_cosine(old)))
                return false; // 1 - cosine is proportional to the square of a small angle
        }
        return true;
    };
    for (const Choice& choice : choices)
        if (harmless(*choice.to)) {
            move_checked(stroke, v, Vec3(*choice.to), star, choice.deviation);
            return true;
        }
    return false;
}

} // namespace retractor::mesh
