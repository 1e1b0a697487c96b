#include "mesh/cut_session.h"

#include "mesh/base/error.h"
#include "mesh/cut_store.h"
#include "mesh/cut_stroke.h"

#include <algorithm>
#include <utility>

namespace retractor {

namespace {

    TetMesh checked(TetMesh mesh)
    {
        check_mesh(mesh);
        if (mesh.nodes_per_tet != 4)
            throw InputError("only four-node elements can be cut; add midpoints after cutting", "nodes_per_tet");
        return mesh;
    }

    /// Refuses what no later stage could work with, and finds the worst angle.
    double check_born(const CutStore& store, const MeshDelta& delta)
    {
        double worst = 180.0;
        for (const MeshDelta::Tet& tet : delta.tets_born) {
            std::array<Vec3, 4> p;
            for (std::size_t i = 0; i < 4; ++i)
                p[i] = store.position(tet.nodes[i]);
            if (!(tet_volume(p[0], p[1], p[2], p[3]) > 0.0))
                throw SolverError("the cut would leave an element without volume; try another value of snap",
                    "element " + std::to_string(tet.id));
            const auto angles = dihedral_angles_deg(p[0], p[1], p[2], p[3]);
            worst = std::min(worst, *std::min_element(angles.begin(), angles.end()));
        }
        return worst;
    }

} // namespace

MeshDelta inverse(const MeshDelta& delta)
{
    MeshDelta back;
    back.vertices_born.assign(delta.vertices_gone.rbegin(), delta.vertices_gone.rend());
    back.vertices_gone.assign(delta.vertices_born.rbegin(), delta.vertices_born.rend());
    for (auto it = delta.vertices_moved.rbegin(); it != delta.vertices_moved.rend(); ++it)
        back.vertices_moved.push_back({ it->id, it->to, it->from });
    back.tets_gone = delta.tets_born;
    back.tets_born = delta.tets_gone;
    return back;
}

struct CutSession::State {
    explicit State(const TetMesh& mesh)
        : store(mesh)
    {
    }
    CutStore store;
    std::vector<CutRecord> journal;
    std::size_t done = 0; ///< records of the journal that are in force; the rest can be redone
};

CutSession::CutSession(TetMesh mesh)
    : state_(std::make_unique<State>(checked(std::move(mesh))))
{
}
CutSession::~CutSession() = default;
CutSession::CutSession(CutSession&&) noexcept = default;
CutSession& CutSession::operator=(CutSession&&) noexcept = default;

CutResult CutSession::cut(const Blade& blade, const CutOptions& options, const Job& job)
{
    const Stopwatch watch;
    const SweptBlade swept(blade);
    CutStore& store = state_->store;
    store.begin();
    CutResult result;
    CutRecord record;
    try {
        result = cut_stroke(store, swept, options, static_cast<int>(state_->done), job);
        if (result.status == CutStatus::done) {
            record = store.finish();
            result.report.worst_dihedral_deg = check_born(store, record.delta);
        }
    } catch (...) {
        store.rollback();
        throw;
    }
    if (result.status != CutStatus::done) {
        store.rollback();
        return result;
    }
    result.delta = record.delta;
    state_->journal.resize(state_->done);
    state_->journal.push_back(std::move(record));
    ++state_->done;
    result.report.seconds = watch.seconds();
    return result;
}

bool CutSession::can_undo() const { return state_->done > 0; }
bool CutSession::can_redo() const { return state_->done < state_->journal.size(); }

MeshDelta CutSession::undo()
{
    if (!can_undo())
        throw InputError("there is no cut to undo");
    const CutRecord& record = state_->journal[--state_->done];
    state_->store.undo(record);
    return inverse(record.delta);
}

MeshDelta CutSession::redo()
{
    if (!can_redo())
        throw InputError("there is no cut to redo");
    const CutRecord& record = state_->journal[state_->done++];
    state_->store.redo(record);
    return record.delta;
}

std::size_t CutSession::tet_count() const { return state_->store.books().tets; }
std::size_t CutSession::vertex_count() const { return state_->store.books().vertices; }
std::size_t CutSession::cut_count() const { return state_->done; }

std::vector<LipFace> CutSession::lips() const
{
    std::vector<LipFace> faces;
    for (TetId t = 0; t < static_cast<TetId>(state_->store.books().tet_slots); ++t) {
        const TetSlot& tet = state_->store.tet(t);
        if (!tet.alive)
            continue;
        for (int corner = 0; corner < 4; ++corner)
            if (const LipTag tag = tet.lips[static_cast<std::size_t>(corner)]; tag.cut >= 0)
                faces.push_back({ { t, corner }, tag.side, tag.cut });
    }
    return faces;
}

TetId CutSession::origin(TetId tet) const
{
    const CutStore& store = state_->store;
    if (tet < 0 || static_cast<std::size_t>(tet) >= store.books().tet_slots || !store.tet(tet).alive)
        throw InputError("there is no such element", "element " + std::to_string(tet));
    return store.tet(tet).origin;
}

TetMesh CutSession::compact_mesh(SlotMap* map) const
{
    const CutStore& store = state_->store;
    SlotMap slots;
    slots.compact_vertex.assign(store.books().vertex_slots, -1);
    slots.compact_tet.assign(store.books().tet_slots, -1);
    TetMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(vertex_count()), 3);
    for (VertexId v = 0; v < static_cast<VertexId>(store.books().vertex_slots); ++v) {
        if (!store.vertex(v).alive)
            continue;
        const auto compact = static_cast<VertexId>(slots.vertex_slot.size());
        slots.compact_vertex[static_cast<std::size_t>(v)] = compact;
        slots.vertex_slot.push_back(v);
        mesh.vertices.row(compact) = store.position(v).transpose();
    }
    for (TetId t = 0; t < static_cast<TetId>(store.books().tet_slots); ++t) {
        const TetSlot& tet = store.tet(t);
        if (!tet.alive)
            continue;
        slots.compact_tet[static_cast<std::size_t>(t)] = static_cast<TetId>(slots.tet_slot.size());
        slots.tet_slot.push_back(t);
        for (const VertexId v : tet.nodes)
            mesh.nodes.push_back(slots.compact_vertex[static_cast<std::size_t>(v)]);
        mesh.labels.push_back(tet.label);
    }
    if (map != nullptr)
        *map = std::move(slots);
    return mesh;
}

CutMesh cut(const TetMesh& mesh, const Blade& blade, const CutOptions& options, const Job& job)
{
    CutSession session(mesh);
    CutResult result = session.cut(blade, options, job);
    CutMesh out;
    out.status = result.status;
    out.message = std::move(result.message);
    out.report = result.report;
    SlotMap map;
    out.mesh = session.compact_mesh(&map);
    for (const TetId slot : map.tet_slot)
        out.origin.push_back(session.origin(slot));
    out.lips = session.lips();
    for (LipFace& lip : out.lips)
        lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
    return out;
}

} // namespace retractor
