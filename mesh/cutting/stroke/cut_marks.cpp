#include "mesh/cutting/stroke/cut_marks.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::mesh {

namespace {
    /// Tolerance of root finding, as a share of the blade's size: above the round-off of coordinates of a few hundred
    /// mm.
    constexpr double kRootTolerance = 1e-13;

    std::uint64_t key_of(VertexId v) { return static_cast<std::uint32_t>(v); }
    std::uint64_t key_of(const EdgeKey& edge) { return key_of(edge.first) << 32U | key_of(edge.second); }
} // namespace

FaceKey face_key(const TetSlot& tet, int corner)
{
    FaceKey key = face_corners(tet.nodes, corner);
    std::sort(key.begin(), key.end());
    return key;
}

void sort_longest_first(std::vector<EdgeKey>& edges, const CutStore& store)
{
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    std::vector<std::pair<double, EdgeKey>> by_length;
    by_length.reserve(edges.size());
    for (const EdgeKey& e : edges)
        by_length.emplace_back((store.position(e.first) - store.position(e.second)).squaredNorm(), e);
    std::stable_sort(
        by_length.begin(), by_length.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t i = 0; i < edges.size(); ++i)
        edges[i] = by_length[i].second;
}

int sign(double x, double tolerance) { return std::abs(x) <= tolerance ? 0 : (x > 0.0 ? 1 : -1); }

BladeMarks::BladeMarks(CutStore& store, const SweptBlade& blade, double on_blade)
    : store_(store)
    , blade_(blade)
    , size_(std::max(blade.length(), blade.depth()))
    , share_(on_blade)
    , table_(store.lend_table())
{
}

BladeMarks::~BladeMarks() { store_.give_back(std::move(table_)); }

std::array<double, 3> BladeMarks::beyond(const BladeCoordinates& c) const
{
    return { -c.along, c.along - blade_.length(), c.depth - blade_.depth() };
}

Mark BladeMarks::measure(const Vec3& p) const
{
    const BladeCoordinates c = blade_.coordinates(p);
    Mark m;
    m.height = c.side;
    m.side = sign(c.side, tolerance());
    m.distance = beyond(c);
    for (std::size_t k = 0; k < 3; ++k)
        m.beyond[k] = sign(m.distance[k], tolerance());
    return m;
}

Mark& BladeMarks::add(VertexId v)
{
    if (count_ == chunks_.size() * kChunk)
        chunks_.push_back(std::make_unique<Chunk>());
    if (static_cast<std::size_t>(v) >= table_.size())
        table_.resize(store_.counts().vertex_slots, 0);
    RETRACTOR_ASSERT(store_.has_vertex(v) && static_cast<std::size_t>(v) < table_.size());
    table_[static_cast<std::size_t>(v)] = count_;
    Entry& entry = (*chunks_[count_ / kChunk])[count_ % kChunk];
    ++count_;
    entry.vertex = v;
    return entry.mark;
}

const Mark& BladeMarks::look_at(VertexId v)
{
    Mark& mark = add(v);
    mark = measure(store_.position(v));
    if (mark.side == 0) {
        on_blade_.insert(v);
        found_.push_back(v);
    }
    return mark;
}

const Crossing& BladeMarks::crossing(const EdgeKey& edge)
{
    bool unknown = false;
    Crossing& c = crossings_.at(key_of(edge), unknown);
    if (!unknown)
        return c;
    RETRACTOR_ASSERT(at(edge.first).side * at(edge.second).side < 0);
    const Vec3 a = store_.position(edge.first), b = store_.position(edge.second);
    const auto point = [&](double t) { return Vec3((1.0 - t) * a + t * b); };
    c.t = find_root([&](double t) { return blade_.coordinates(point(t)).side; }, at(edge.first).height,
        at(edge.second).height, kRootTolerance * size_);
    c.point = point(c.t);
    const BladeCoordinates where = blade_.coordinates(c.point);
    c.real = std::abs(where.side) <= tolerance();
    c.distance = beyond(where);
    return c;
}

int BladeMarks::side(const TetSlot& tet)
{
    int least = 1, most = -1;
    for (const VertexId v : tet.nodes) {
        least = std::min(least, at(v).side);
        most = std::max(most, at(v).side);
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

BladeMarks::Edges BladeMarks::crossed_edges(const TetSlot& tet)
{
    std::array<int, 4> sides {};
    for (std::size_t i = 0; i < 4; ++i)
        sides[i] = at(tet.nodes[i]).side;
    Edges edges;
    for (const auto& e : kTetEdges) {
        const auto a = static_cast<std::size_t>(e[0]), b = static_cast<std::size_t>(e[1]);
        if (sides[a] * sides[b] < 0)
            edges.keys[edges.count++] = std::minmax(tet.nodes[a], tet.nodes[b]);
    }
    return edges;
}

bool BladeMarks::crossed(const TetSlot& tet, bool completely)
{
    const Edges edges = crossed_edges(tet);
    if (edges.count == 0)
        return false;
    std::array<bool, 3> in { false, false, false };
    bool past_end = false;
    for (const EdgeKey& edge : edges) {
        const Crossing& c = crossing(edge);
        if (!c.real)
            return false;
        for (std::size_t k = 0; k < 3; ++k)
            in[k] = in[k] || c.distance[k] < -tolerance();
        past_end = past_end || c.distance[kEnd] > tolerance();
    }
    for (const VertexId v : tet.nodes)
        if (const Mark& m = at(v); m.side == 0) {
            for (std::size_t k = 0; k < 3; ++k)
                in[k] = in[k] || m.beyond[k] < 0;
            past_end = past_end || m.beyond[kEnd] > 0;
        }
    return in[0] && in[1] && in[2] && !(completely && past_end);
}

void BladeMarks::put_on_blade(VertexId v)
{
    Entry* entry = find(v);
    Mark& m = entry != nullptr ? entry->mark : add(v);
    m = measure(store_.position(v));
    m.side = 0;
    on_blade_.insert(v);
    ++changes_;
}

void BladeMarks::put_on_border(VertexId v, std::size_t border)
{
    RETRACTOR_ASSERT(border < 3);
    (void)at(v);
    find(v)->mark.beyond[border] = 0;
    ++changes_;
}

void BladeMarks::forget(VertexId v, std::span<const VertexId> neighbours)
{
    if (Entry* entry = find(v))
        entry->vertex = -1;
    on_blade_.erase(v);
    ++changes_;
    for (const VertexId w : neighbours)
        crossings_.erase(key_of(std::minmax(v, w)));
}

void BladeMarks::forget(const EdgeKey& edge) { crossings_.erase(key_of(edge)); }

} // namespace retractor::mesh
