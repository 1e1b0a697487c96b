#include "mesh/cutting/store/cut_store.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <span>

namespace retractor::mesh {

namespace {
    template <class Slot> bool by_id(const SlotChange<Slot>& a, const SlotChange<Slot>& b) { return a.id < b.id; }

    MeshDelta::Tet as_delta(TetId id, const TetSlot& slot) { return { id, slot.nodes, slot.label, slot.origin }; }

    void list_tets(MeshDelta& delta, const std::vector<SlotChange<TetSlot>>& changes)
    {
        for (const auto& change : changes) {
            if (change.before.alive && change.after.alive && change.before.nodes == change.after.nodes)
                continue; // only the lips changed
            if (change.before.alive)
                delta.tets_gone.push_back(as_delta(change.id, change.before));
            if (change.after.alive)
                delta.tets_born.push_back(as_delta(change.id, change.after));
        }
    }

    /// Joins two lists of changes by id. A slot in both lists changes from the first list's `before` to the second
    /// list's `after`.
    template <class Slot>
    std::vector<SlotChange<Slot>> merged_changes(
        const std::vector<SlotChange<Slot>>& first, const std::vector<SlotChange<Slot>>& second)
    {
        RETRACTOR_ASSERT(std::is_sorted(first.begin(), first.end(), by_id<Slot>));
        RETRACTOR_ASSERT(std::is_sorted(second.begin(), second.end(), by_id<Slot>));
        std::vector<SlotChange<Slot>> all;
        auto a = first.begin();
        auto b = second.begin();
        while (a != first.end() || b != second.end()) {
            if (b == second.end() || (a != first.end() && a->id < b->id))
                all.push_back(*a++);
            else if (a == first.end() || b->id < a->id)
                all.push_back(*b++);
            else {
                all.push_back({ a->id, a->before, b->after });
                ++a;
                ++b;
            }
        }
        return all;
    }

    /// A grid with cells of two mean edges.
    TetGrid empty_grid(const TetMesh& mesh)
    {
        Eigen::AlignedBox3d box;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            box.extend(Vec3(mesh.vertices.row(v)));
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto n = mesh.tet(t);
            sum += (mesh.vertices.row(n[0]) - mesh.vertices.row(n[1])).norm();
        }
        return mesh.tet_count() > 0 ? TetGrid(box, 2.0 * sum / static_cast<double>(mesh.tet_count())) : TetGrid();
    }
    /// Reserves an eighth more memory, so that the first cut need not wait for a copy of a large mesh.
    template <class... Vectors> void leave_room(Vectors&... vectors)
    {
        (vectors.reserve(vectors.size() + vectors.size() / 8), ...);
    }

    template <class T> std::size_t bytes_of(const std::vector<T>& v) { return v.capacity() * sizeof(T); }
} // namespace

void FreeList::begin()
{
    kept_ = ids_.size();
    popped_.clear();
}

std::int32_t FreeList::pop()
{
    RETRACTOR_ASSERT(!ids_.empty());
    const std::int32_t id = ids_.back();
    ids_.pop_back();
    if (ids_.size() < kept_) {
        kept_ = ids_.size();
        popped_.push_back(id);
    }
    return id;
}

FreeList::Change FreeList::change() const
{
    return { kept_, { popped_.rbegin(), popped_.rend() },
        { ids_.begin() + static_cast<std::ptrdiff_t>(kept_), ids_.end() } };
}

void FreeList::replace_end(std::size_t kept, const std::vector<std::int32_t>& end)
{
    RETRACTOR_ASSERT(kept <= ids_.size());
    ids_.resize(kept);
    ids_.insert(ids_.end(), end.begin(), end.end());
}

std::size_t FreeList::bytes() const { return bytes_of(ids_) + bytes_of(popped_); }

FreeList::Change FreeList::merged(const Change& first, const Change& second)
{
    Change both { std::min(first.kept, second.kept), first.before, second.after };
    const auto shared
        = [](const std::vector<std::int32_t>& ids, std::size_t count) { return std::span(ids).first(count); };
    if (second.kept > first.kept) { // some entries of the first change stay
        RETRACTOR_ASSERT(second.kept - first.kept <= first.after.size());
        const auto stays = shared(first.after, second.kept - first.kept);
        both.after.insert(both.after.begin(), stays.begin(), stays.end());
    } else { // the second change popped entries that the first had kept
        RETRACTOR_ASSERT(first.kept - second.kept <= second.before.size());
        const auto taken = shared(second.before, first.kept - second.kept);
        both.before.insert(both.before.begin(), taken.begin(), taken.end());
    }
    return both;
}

std::size_t CutRecord::bytes() const
{
    return sizeof(*this) + bytes_of(delta.vertices_born) + bytes_of(delta.vertices_moved) + bytes_of(delta.tets_gone)
        + bytes_of(delta.tets_born) + bytes_of(delta.vertices_gone) + bytes_of(vertices) + bytes_of(tets)
        + bytes_of(free_vertices.before) + bytes_of(free_vertices.after) + bytes_of(free_tets.before)
        + bytes_of(free_tets.after);
}

CutStore::CutStore(const TetMesh& mesh)
    : tets_(mesh.tet_count())
    , vertices_(mesh.vertex_count())
    , stars_(mesh.vertex_count())
    , first_edge_(mesh.tet_count(), 0.0F)
    , tet_epoch_(mesh.tet_count(), 0)
    , vertex_epoch_(mesh.vertex_count(), 0)
    , birth_epoch_(mesh.tet_count(), 0)
    , vertex_birth_epoch_(mesh.vertex_count(), 0)
{
    RETRACTOR_ASSERT(mesh.nodes_per_tet == 4 && mesh.nodes.size() == 4 * mesh.tet_count());
    grid_ = empty_grid(mesh);
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
        for (const auto& [a, b] : edge_keys(slot.nodes))
            first_edge_[static_cast<std::size_t>(t)] += static_cast<float>((position(a) - position(b)).norm() / 6.0);
    }
    counts_ = { vertices_.size(), tets_.size(), vertices_.size(), tets_.size() };
    leave_room(vertices_, stars_, vertex_epoch_, vertex_birth_epoch_, tets_, tet_epoch_, birth_epoch_);
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

TetId CutStore::across(const TetFace& face) const
{
    RETRACTOR_ASSERT(has_tet(face.tet));
    const auto [a, b, c] = face_corners(tet(face.tet).nodes, face.corner);
    for (const TetId t : unsorted_star(a))
        if (t != face.tet && corner(t, b) >= 0 && corner(t, c) >= 0)
            return t;
    return -1;
}

std::size_t CutStore::bytes() const
{
    std::size_t sum = bytes_of(tets_) + bytes_of(vertices_) + bytes_of(stars_) + bytes_of(first_edge_) + grid_.bytes()
        + bytes_of(tet_epoch_) + bytes_of(vertex_epoch_) + bytes_of(birth_epoch_) + bytes_of(vertex_birth_epoch_)
        + bytes_of(touched_tets_) + bytes_of(touched_vertices_) + bytes_of(born_) + bytes_of(moved_) + bytes_of(gone_)
        + bytes_of(tet_walk_.visited) + bytes_of(vertex_walk_.visited) + bytes_of(lent_table_) + bytes_of(freed_tets_)
        + bytes_of(freed_vertices_) + free_vertices_.bytes() + free_tets_.bytes();
    for (const auto& star : stars_)
        sum += bytes_of(star);
    return sum;
}

void CutStore::begin()
{
    ++epoch_;
    touched_tets_.clear();
    touched_vertices_.clear();
    born_.clear();
    moved_.clear();
    gone_.clear();
    freed_tets_.clear();
    freed_vertices_.clear();
    free_vertices_.begin();
    free_tets_.begin();
    before_ = counts_;
}

TetSlot& CutStore::touch_tet(TetId t)
{
    ++changes_;
    const auto i = static_cast<std::size_t>(t);
    if (tet_epoch_[i] != epoch_) {
        tet_epoch_[i] = epoch_;
        touched_tets_.push_back({ t, tets_[i], {} });
    }
    return tets_[i];
}

std::vector<TetId> CutStore::changed_tets() const
{
    std::vector<TetId> tets;
    for (const auto& change : touched_tets_)
        if (tet(change.id).alive)
            tets.push_back(change.id);
    return tets;
}

VertexSlot& CutStore::touch_vertex(VertexId v)
{
    ++changes_;
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
    list(t);
}

void CutStore::list(TetId t) { grid_.insert(t, box_of(t)); }

Eigen::AlignedBox3d CutStore::box_of(TetId t) const
{
    Eigen::AlignedBox3d box;
    for (const VertexId v : tet(t).nodes)
        box.extend(position(v));
    return box;
}

void CutStore::gather_near(const Eigen::AlignedBox3d& box, std::vector<TetId>& tets) const
{
    tets.clear();
    grid_.gather(box, tets);
    std::erase_if(tets, [&](TetId t) { return !box_of(t).intersects(box); });
}

std::vector<TetId> CutStore::tets_near(const Eigen::AlignedBox3d& box) const
{
    std::vector<TetId> tets;
    gather_near(box, tets);
    std::sort(tets.begin(), tets.end());
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    return tets;
}

void CutStore::begin_walk(Walk& walk, std::size_t slots)
{
    if (++walk.number == 0) { // the counter has wrapped around
        walk.visited.clear();
        walk.number = 1;
    }
    if (walk.visited.size() < slots)
        walk.visited.resize(slots + slots / 8, 0);
}

std::vector<VertexId> CutStore::corners_of_all(std::span<const TetId> tets)
{
    std::vector<VertexId> corners;
    begin_walk(vertex_walk_, vertices_.size());
    for (const TetId t : tets)
        for (const VertexId v : tet(t).nodes)
            if (first_visit(vertex_walk_, v))
                corners.push_back(v);
    return corners;
}

void CutStore::detach(TetId t)
{
    for (const VertexId v : tet(t).nodes) {
        auto& star = stars_[static_cast<std::size_t>(v)];
        RETRACTOR_ASSERT(std::find(star.begin(), star.end(), t) != star.end());
        *std::find(star.begin(), star.end(), t) = star.back();
        star.pop_back();
    }
    grid_.remove(t);
}

void CutStore::resize(std::size_t vertex_slots, std::size_t tet_slots)
{
    vertices_.resize(vertex_slots);
    stars_.resize(vertex_slots);
    vertex_epoch_.resize(vertex_slots, 0);
    vertex_birth_epoch_.resize(vertex_slots, 0);
    tets_.resize(tet_slots);
    tet_epoch_.resize(tet_slots, 0);
    birth_epoch_.resize(tet_slots, 0);
    counts_.vertex_slots = vertex_slots;
    counts_.tet_slots = tet_slots;
}

VertexId CutStore::add_vertex(const Vec3& position, VertexId a, VertexId b, double t)
{
    RETRACTOR_ASSERT(has_vertex(a) && has_vertex(b));
    return add_vertex({ .position = position, .a = a, .b = b, .t = t, .origin = MeshDelta::Origin::on_edge });
}

VertexId CutStore::copy_vertex(VertexId v)
{
    RETRACTOR_ASSERT(has_vertex(v));
    return add_vertex({ .position = position(v), .a = v, .b = v, .origin = MeshDelta::Origin::copy });
}

VertexId CutStore::add_vertex(const MeshDelta::VertexBorn& born)
{
    VertexId id = 0;
    if (free_vertices_.empty()) {
        id = static_cast<VertexId>(vertices_.size());
        resize(vertices_.size() + 1, tets_.size());
    } else {
        id = free_vertices_.pop();
    }
    RETRACTOR_ASSERT(!has_vertex(id) && unsorted_star(id).empty());
    touch_vertex(id) = { born.position, true };
    vertex_birth_epoch_[static_cast<std::size_t>(id)] = epoch_;
    ++counts_.vertices;
    born_.push_back(born);
    born_.back().id = id;
    return id;
}

void CutStore::move_vertex(VertexId v, const Vec3& to)
{
    RETRACTOR_ASSERT(has_vertex(v));
    VertexSlot& slot = touch_vertex(v);
    moved_.push_back({ v, slot.position, to });
    slot.position = to;
    for (const TetId t : unsorted_star(v))
        list(t);
}

void CutStore::remove_vertex(VertexId v)
{
    RETRACTOR_ASSERT(has_vertex(v) && !is_added(v) && unsorted_star(v).empty());
    gone_.push_back({ v, position(v), v, v, 0.0, MeshDelta::Origin::restored });
    touch_vertex(v).alive = false;
    freed_vertices_.push_back(v);
    --counts_.vertices;
}

void CutStore::replace_parent(VertexId v, VertexId w)
{
    const auto record = [&](VertexId id) {
        return std::find_if(born_.begin(), born_.end(), [&](const auto& born) { return born.id == id; });
    };
    const auto at_v = record(v), at_w = record(w);
    RETRACTOR_ASSERT(at_v != born_.end() && has_vertex(w) && v != w);
    if (at_w != born_.end() && at_v < at_w) {
        MeshDelta::VertexBorn born = *at_v;
        born.id = w;
        born.position = at_w->position;
        std::rotate(at_v, at_w, at_w + 1);
        *at_v = born;
    }
    for (auto& born : born_)
        if (born.id != v && born.id != w) {
            born.a = born.a == v ? w : born.a;
            born.b = born.b == v ? w : born.b;
            if (born.a == born.b)
                born.t = 0.0;
        }
}

void CutStore::drop_added(VertexId v)
{
    RETRACTOR_ASSERT(has_vertex(v) && is_added(v) && unsorted_star(v).empty());
    std::erase_if(born_, [&](const MeshDelta::VertexBorn& born) { return born.id == v; });
    std::erase_if(moved_, [&](const MeshDelta::VertexMoved& moved) { return moved.id == v; });
    touch_vertex(v) = {};
    vertex_birth_epoch_[static_cast<std::size_t>(v)] = 0;
    free_vertices_.push(v);
    --counts_.vertices;
}

TetId CutStore::add_tet(const TetSlot& tet)
{
    RETRACTOR_ASSERT(std::all_of(tet.nodes.begin(), tet.nodes.end(), [&](VertexId v) { return has_vertex(v); }));
    TetId id = 0;
    if (free_tets_.empty()) {
        id = static_cast<TetId>(tets_.size());
        resize(vertices_.size(), tets_.size() + 1);
    } else {
        id = free_tets_.pop();
    }
    touch_tet(id) = tet;
    tets_[static_cast<std::size_t>(id)].alive = true;
    birth_epoch_[static_cast<std::size_t>(id)] = epoch_;
    attach(id);
    ++counts_.tets;
    return id;
}

void CutStore::remove_tet(TetId t)
{
    RETRACTOR_ASSERT(has_tet(t));
    detach(t);
    const bool added = birth_epoch_[static_cast<std::size_t>(t)] == epoch_;
    touch_tet(t).alive = false;
    --counts_.tets;
    if (added)
        free_tets_.push(t);
    else
        freed_tets_.push_back(t);
}

void CutStore::set_lips(TetId t, const std::array<LipTag, 4>& lips)
{
    RETRACTOR_ASSERT(has_tet(t));
    touch_tet(t).lips = lips;
}

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
    record.after = counts_;
    record.free_vertices = free_vertices_.change();
    record.free_tets = free_tets_.change();
    record.tets = touched_tets_;
    record.vertices = touched_vertices_;
    std::sort(record.tets.begin(), record.tets.end(), by_id<TetSlot>);
    std::sort(record.vertices.begin(), record.vertices.end(), by_id<VertexSlot>);
    for (auto& change : record.tets)
        change.after = tet(change.id);
    for (auto& change : record.vertices)
        change.after = vertex(change.id);
}

CutRecord CutStore::finish()
{
    RETRACTOR_ASSERT(counts_.tet_slots == tets_.size() && counts_.vertex_slots == vertices_.size());
    for (const TetId t : freed_tets_)
        free_tets_.push(t);
    for (const VertexId v : freed_vertices_)
        free_vertices_.push(v);
    CutRecord record;
    gather_changes(record);
    record.delta.vertices_born = born_;
    record.delta.vertices_moved = moved_;
    record.delta.vertices_gone = gone_;
    list_tets(record.delta, record.tets);
    return record;
}

CutRecord CutStore::merged(const CutRecord& first, const CutRecord& second) const
{
    CutRecord record;
    record.before = first.before;
    record.after = second.after;
    record.free_vertices = FreeList::merged(first.free_vertices, second.free_vertices);
    record.free_tets = FreeList::merged(first.free_tets, second.free_tets);
    record.vertices = merged_changes(first.vertices, second.vertices);
    record.tets = merged_changes(first.tets, second.tets);
    record.delta = first.delta;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(record.delta.vertices_born, second.delta.vertices_born);
    append(record.delta.vertices_moved, second.delta.vertices_moved);
    record.delta.tets_gone.clear();
    record.delta.tets_born.clear();
    list_tets(record.delta, record.tets);
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
    const SlotCounts& target = forward ? record.after : record.before;
    RETRACTOR_ASSERT(counts_.tets == (forward ? record.before : record.after).tets);
    RETRACTOR_ASSERT(counts_.vertices == (forward ? record.before : record.after).vertices);
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
    for (const auto& change : record.vertices) // elements whose shape alone changed
        if (change.before.alive && change.after.alive)
            for (const TetId t : unsorted_star(change.id))
                list(t);
    resize(target.vertex_slots, target.tet_slots);
    counts_ = target;
    const auto put = [&](FreeList& list, const FreeList::Change& change) {
        list.replace_end(change.kept, forward ? change.after : change.before);
    };
    put(free_vertices_, record.free_vertices);
    put(free_tets_, record.free_tets);
}

} // namespace retractor::mesh
