#pragma once
// Cutting as a session: a blade goes in, a MeshDelta comes out. Ids are stable, freed slots are reused,
// every change is journalled, and undo replays the journal backwards. FEM, view and haptics consume the
// same deltas. Units mm; frame patient LPS (the rest configuration).
//
// Subdivision is adaptive, with two patterns: an element whose section is a triangle or a quadrilateral is divided
// along it, by bisecting the crossed edges where the blade crosses them (its neighbours follow, so that the mesh stays
// conforming); where the blade passes near a vertex, the vertex moves onto the blade instead, along the surface or
// interface it lies on. Then the slivers that are left are opened, and the elements on the two sides are given their
// own copies of the vertices on the blade.

#include "mesh/base/job.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace retractor::mesh {

/// Maps between a session's stable ids and a compact mesh's consecutive ones; -1 where there is none.
struct SlotMap {
    std::vector<VertexId> vertex_slot; ///< per compact vertex: its session id
    std::vector<TetId> tet_slot; ///< per compact element: its session id
    std::vector<VertexId> compact_vertex; ///< per session id: the compact vertex
    std::vector<TetId> compact_tet;
};

/// An operation on a session, as its witness is told of it.
struct CutEvent {
    enum class Kind { cut, stroke_step, stroke_end, stroke_abandoned, ablation, undo, redo };
    Kind kind = Kind::cut;
    const Blade* blade = nullptr; ///< of cut and stroke_step
    const CutOptions* options = nullptr; ///< likewise
    std::span<const TetId> tets {}; ///< of ablation
    const MeshDelta* delta = nullptr; ///< what it changes; never null
};
/// Called when an operation has succeeded and before it is kept. What it throws goes to the caller of the operation,
/// which then has not happened: the session is as it was before.
using CutWitness = std::function<void(const CutEvent&)>;

/// Memory in use.
struct SessionBytes {
    std::size_t mesh = 0; ///< and what finds its elements
    std::size_t journal = 0; ///< what undo and redo need; grows with what was cut, not with the mesh
};

class CutSession {
public:
    /// @throws InputError as check_mesh does; four-node elements only.
    explicit CutSession(TetMesh mesh);
    ~CutSession();
    CutSession(CutSession&&) noexcept;
    CutSession& operator=(CutSession&&) noexcept;

    /// Cuts; after a status other than `done`, or a throw, the session is as it was.
    /// @throws InputError on a malformed blade, SolverError when no attempt keeps the promises made here.
    CutResult cut(const Blade& blade, const CutOptions& options = {}, const Job& job = {});

    /// A freehand cut that grows while the hand moves: `so_far` is the blade drawn up to now, each time the former
    /// one with more of its line. Only what is completely crossed is cut; the element under the tip waits until
    /// finish_stroke(), which cuts up to the tip exactly. Each call gives the delta of its own step; together they are
    /// one cut to undo. While a stroke is open, nothing else may change the session. When a step is not `done`, or
    /// throws, the session and the stroke are as they were before the step: another blade may be tried, or the stroke
    /// finished or abandoned as it is.
    /// @throws InputError on a malformed blade.
    CutResult extend_stroke(const Blade& so_far, const CutOptions& options = {}, const Job& job = {});
    /// When it is cancelled or throws, the stroke is still open and as it was: it may be extended, finished again or
    /// abandoned.
    /// @throws InputError when no stroke is open.
    CutResult finish_stroke(const Job& job = {});
    /// Gives the open stroke up. The session is bit for bit as it was before the stroke, redo included.
    /// @returns what takes all its steps back.
    /// @throws InputError when no stroke is open.
    MeshDelta abandon_stroke();
    bool stroke_open() const;

    /// Removes elements (by id; each counts once). The faces this bares become lips of a cut of its own, with side 0;
    /// vertices that no element uses are gone. Where what stays would hang together in a point or along an edge only,
    /// it is parted there (an edge gets a vertex in its middle first), so that the surface stays manifold but for
    /// pinched_vertices().
    /// @throws InputError when no element or every element is named, or one that is not there.
    CutResult ablate(std::span<const TetId> tets, const Job& job = {});

    bool can_undo() const;
    bool can_redo() const;
    MeshDelta undo(); ///< @throws InputError when there is nothing to undo
    MeshDelta redo();

    std::size_t tet_count() const; ///< living elements
    std::size_t vertex_count() const; ///< living vertices
    std::size_t cut_count() const; ///< cuts, strokes and ablations in force

    /// Is there a living element (vertex) of this id?
    bool has_tet(TetId tet) const;
    bool has_vertex(VertexId vertex) const;
    /// Ids run below these bounds.
    std::size_t tet_slots() const;
    std::size_t vertex_slots() const;
    /// Of a living element or vertex. @throws InputError when it is not there.
    MeshDelta::Tet tet(TetId tet) const;
    Vec3 position(VertexId vertex) const; ///< mm, rest configuration
    std::vector<TetId> tets_at(VertexId vertex) const; ///< the elements round it, by id

    /// One witness, told of every operation from now on; an empty one for none. A journal on disk is one.
    void set_witness(CutWitness witness);
    SessionBytes bytes() const;

    /// Vertices where two parts of the surface touch in a point (the tip of a wound just reaches another wound or the
    /// skin): there alone the surface is no manifold. By id.
    std::vector<VertexId> pinched_vertices() const;
    /// The faces of all wounds made so far.
    std::vector<LipFace> lips() const;
    /// The element of the first mesh that a living element is a part of.
    TetId origin(TetId tet) const;
    /// A compact copy for FEM, view or file.
    TetMesh compact_mesh(SlotMap* map = nullptr) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One cut on a mesh of one's own, on top of CutSession.
struct [[nodiscard]] CutMesh {
    CutStatus status = CutStatus::done;
    std::string message;
    TetMesh mesh;
    std::vector<TetId> origin; ///< per element of `mesh`: the element it is a part of
    std::vector<LipFace> lips; ///< ids of `mesh`
    CutReport report;
};
CutMesh cut(const TetMesh& mesh, const Blade& blade, const CutOptions& options = {}, const Job& job = {});

} // namespace retractor::mesh
