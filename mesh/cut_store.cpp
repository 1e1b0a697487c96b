#include "mesh/cut_store.h"

#include <algorithm>

namespace retractor {

namespace {
    template <class Slot> bool by_id(const SlotChange<Slot>& a, const SlotChange<Slot>& b) { return a.id < b.id; }

    MeshDelta::Tet as_delta(TetId id, const TetSlot& slot) { return { id, slot.nodes, slot.label, slot.origin }; }
} // namespace

CutStore::CutStore(const TetMesh& mesh)
    : tets_(mesh.tet_count())
    , vertices_(mesh.vertex_count())
    , stars_(mesh.vertex_count())
    , tet_epoch_(mesh.tet_count(), 0)
    , vertex_epoch_(mesh.vertex_count(), 0)
    , birth_epoch_(mesh.tet_count(), 0)
{
    for (std::size_t v = 0; v < vertices_.size(); ++v)
        vertices_[v] = { mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose(), true };
    for (TetId t = 0; t < static_cast<TetId>(tets_.size()); ++t) {
        TetSlot& slot = tets_[static_cast<std::size_t>(t)];
        const auto nodes = mesh.tet(t);
        std::copy(nodes.begin(), nodes.end(), slot.nodes.begin());
        slot.label = mesh.labels[static_cast<std::size_t>(t)];
        slot.origin = t;
        slot.alive = true;
        attach(t);
    }
    books_ = { vertices_.size(), tets_.size(), vertices_.size(), tets_.size(), {}, {} };
}

std::vector<TetId> CutStore::star(VertexId v) const
{
    std::vector<TetId> tets = stars_[static_cast<std::size_t>(v)];
    std::sort(tets.begin(), tets.end());
    return tets;
}

std::vector<TetId> CutStore::star(VertexId a, VertexId b) const
{
    std::vector<TetId> tets;
    for (const TetId t : stars_[static_cast<std::size_t>(a)])
        if (corner(t, b) >= 0)
            tets.push_back(t);
    std::sort(tets.begin(), tets.end());
    return tets;
}

double CutStore::volume(TetId t) const
{
    const auto& n = tet(t).nodes;
    return tet_volume(position(n[0]), position(n[1]), position(n[2]), position(n[3]));
}

int CutStore::corner(TetId t, VertexId v) const
{
    const auto& n = tet(t).nodes;
    const auto it = std::find(n.begin(), n.end(), v);
    return it == n.end() ? -1 : static_cast<int>(it - n.begin());
}

void CutStore::begin()
{
    ++epoch_;
    touched_tets_.clear();
    touched_vertices_.clear();
    born_.clear();
    moved_.clear();
    freed_tets_.clear();
    before_ = books_;
}

TetSlot& CutStore::touch_tet(TetId t)
{
    const auto i = static_cast<std::size_t>(t);
    if (tet_epoch_[i] != epoch_) {
        tet_epoch_[i] = epoch_;
        touched_tets_.push_back({ t, tets_[i], {} });
    }
    return tets_[i];
}

VertexSlot& CutStore::touch_vertex(VertexId v)
{
    const auto i = static_cast<std::size_t>(v);
    if (vertex_epoch_[i] != epoch_) {
        vertex_epoch_[i] = epoch_;
        touched_vertices_.push_back({ v, vertices_[i], {} });
    }
    return vertices_[i];
}

void CutStore::attach(TetId t)
{
    for (const VertexId v : tet(t).nodes)
        stars_[static_cast<std::size_t>(v)].push_back(t);
}

void CutStore::detach(TetId t)
{
    for (const VertexId v : tet(t).nodes) {
        auto& star = stars_[static_cast<std::size_t>(v)];
        *std::find(star.begin(), star.end(), t) = star.back();
        star.pop_back();
    }
}

void CutStore::resize(std::size_t vertex_slots, std::size_t tet_slots)
{
    vertices_.resize(vertex_slots);
    stars_.resize(vertex_slots);
    vertex_epoch_.resize(vertex_slots, 0);
    tets_.resize(tet_slots);
    tet_epoch_.resize(tet_slots, 0);
    birth_epoch_.resize(tet_slots, 0);
    books_.vertex_slots = vertex_slots;
    books_.tet_slots = tet_slots;
}

VertexId CutStore::add_vertex(const Vec3& position, VertexId a, VertexId b, double t)
{
    VertexId id = 0;
    if (books_.free_vertices.empty()) {
        id = static_cast<VertexId>(vertices_.size());
        resize(vertices_.size() + 1, tets_.size());
    } else {
        id = books_.free_vertices.back();
        books_.free_vertices.pop_back();
    }
    touch_vertex(id) = { position, true };
    ++books_.vertices;
    born_.push_back({ id, position, a, b, t });
    return id;
}

void CutStore::move_vertex(VertexId v, const Vec3& to)
{
    VertexSlot& slot = touch_vertex(v);
    moved_.push_back({ v, slot.position, to });
    slot.position = to;
}

TetId CutStore::add_tet(const TetSlot& tet)
{
    TetId id = 0;
    if (books_.free_tets.empty()) {
        id = static_cast<TetId>(tets_.size());
        resize(vertices_.size(), tets_.size() + 1);
    } else {
        id = books_.free_tets.back();
        books_.free_tets.pop_back();
    }
    touch_tet(id) = tet;
    tets_[static_cast<std::size_t>(id)].alive = true;
    birth_epoch_[static_cast<std::size_t>(id)] = epoch_;
    attach(id);
    ++books_.tets;
    return id;
}

void CutStore::remove_tet(TetId t)
{
    detach(t);
    const bool newborn = birth_epoch_[static_cast<std::size_t>(t)] == epoch_;
    touch_tet(t).alive = false;
    --books_.tets;
    (newborn ? books_.free_tets : freed_tets_).push_back(t);
}

void CutStore::set_lips(TetId t, const std::array<LipTag, 4>& lips) { touch_tet(t).lips = lips; }

VertexId CutStore::bisect(VertexId a, VertexId b, const Vec3& position, double t)
{
    const VertexId middle = add_vertex(position, a, b, t);
    for (const TetId parent : star(a, b)) {
        const TetSlot slot = tet(parent);
        const auto at_a = static_cast<std::size_t>(corner(parent, a)),
                   at_b = static_cast<std::size_t>(corner(parent, b));
        remove_tet(parent);
        TetSlot half = slot;
        half.nodes[at_b] = middle;
        half.lips[at_a] = {}; // the new face between the two halves
        add_tet(half);
        half = slot;
        half.nodes[at_a] = middle;
        half.lips[at_b] = {};
        add_tet(half);
    }
    return middle;
}

void CutStore::gather_changes(CutRecord& record) const
{
    record.before = before_;
    record.after = books_;
    record.tets = touched_tets_;
    record.vertices = touched_vertices_;
    std::sort(record.tets.begin(), record.tets.end(), by_id<TetSlot>);
    std::sort(record.vertices.begin(), record.vertices.end(), by_id<VertexSlot>);
    for (auto& change : record.tets)
        change.after = tet(change.id);
    for (auto& change : record.vertices)
        change.after = vertex(change.id);
}

MeshDelta CutStore::delta(const CutRecord& record) const
{
    MeshDelta delta;
    delta.vertices_born = born_;
    delta.vertices_moved = moved_;
    for (const auto& change : record.tets) {
        if (change.before.alive && change.after.alive && change.before.nodes == change.after.nodes)
            continue; // only its lips changed
        if (change.before.alive)
            delta.tets_gone.push_back(as_delta(change.id, change.before));
        if (change.after.alive)
            delta.tets_born.push_back(as_delta(change.id, change.after));
    }
    return delta;
}

CutRecord CutStore::finish()
{
    books_.free_tets.insert(books_.free_tets.end(), freed_tets_.begin(), freed_tets_.end());
    CutRecord record;
    gather_changes(record);
    record.delta = delta(record);
    return record;
}

void CutStore::rollback()
{
    CutRecord record;
    gather_changes(record);
    apply(record, false);
}

void CutStore::undo(const CutRecord& record) { apply(record, false); }
void CutStore::redo(const CutRecord& record) { apply(record, true); }

void CutStore::apply(const CutRecord& record, bool forward)
{
    const SlotBooks& target = forward ? record.after : record.before;
    for (const auto& change : record.tets)
        if (static_cast<std::size_t>(change.id) < tets_.size() && tet(change.id).alive)
            detach(change.id);
    resize(std::max(vertices_.size(), target.vertex_slots), std::max(tets_.size(), target.tet_slots));
    for (const auto& change : record.vertices)
        vertices_[static_cast<std::size_t>(change.id)] = forward ? change.after : change.before;
    for (const auto& change : record.tets) {
        tets_[static_cast<std::size_t>(change.id)] = forward ? change.after : change.before;
        if (tet(change.id).alive)
            attach(change.id);
    }
    resize(target.vertex_slots, target.tet_slots);
    books_ = target;
}

} // namespace retractor
