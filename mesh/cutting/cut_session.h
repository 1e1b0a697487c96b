#pragma once
// A cutting session: a blade goes in, a MeshDelta comes out. Ids are stable, and freed ids are reused. The session
// journals every change; undo replays the journal backwards. Finite elements, view and haptics follow the same deltas.
// Units mm; frame patient LPS (the rest configuration).
//
// Subdivision is adaptive, with two patterns (Nakao et al. 2006, doi 10.1007/s10916-006-9021-4). An element whose
// section is a triangle or a quadrilateral is divided along the section: the crossed edges are bisected where the blade
// crosses them, and the neighbours are divided likewise, so that the mesh stays conforming. A vertex near the blade
// moves onto the blade instead, along the surface or interface that it lies on. Then the remaining slivers are opened,
// and the elements on the two sides get their own copies of the vertices on the blade.

#include "mesh/base/job.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace retractor::mesh {

/// Maps between the stable ids of a session and the consecutive ids of a compact mesh; -1 for an id without partner.
struct SlotMap {
    std::vector<VertexId> vertex_slot; ///< session id of each compact vertex
    std::vector<TetId> tet_slot; ///< session id of each compact element
    std::vector<VertexId> compact_vertex; ///< compact vertex of each session id
    std::vector<TetId> compact_tet; ///< compact element of each session id
};

/// An operation on a session, as the session reports it to its witness.
struct CutEvent {
    /// The journal names the kinds in this order.
    enum class Kind { cut, stroke_step, stroke_end, stroke_abandoned, ablation, undo, redo };
    Kind kind = Kind::cut;
    const Blade* blade = nullptr; ///< for cut and stroke_step, else null
    const CutOptions* options = nullptr; ///< for cut and stroke_step, else null
    std::span<const TetId> tets {}; ///< for ablation: the removed elements
    const MeshDelta* delta = nullptr; ///< change of the mesh; never null
};
/// Called after an operation has succeeded and before the session keeps the change. When the witness throws, the
/// operation is taken back, and the exception goes to the caller of the operation.
using CutWitness = std::function<void(const CutEvent&)>;

/// Memory in use (bytes).
struct SessionBytes {
    std::size_t mesh = 0; ///< mesh with its search structures
    std::size_t journal = 0; ///< records for undo and redo; grows with the cuts, not with the mesh
};

/// A mesh with its history of cuts, strokes and ablations.
class CutSession {
public:
    /// @param mesh four-node elements
    /// @throws InputError as check_mesh()
    explicit CutSession(TetMesh mesh);
    ~CutSession();
    CutSession(CutSession&&) noexcept;
    CutSession& operator=(CutSession&&) noexcept;

    /// Cuts. After a status other than `done`, or an exception, the session is unchanged.
    /// @throws InputError on a malformed blade, an option out of range, or an open stroke; CutQualityError when no
    /// attempt keeps the guarantees of cut_retry.h; SolverError when the element limit is exceeded
    CutResult cut(const Blade& blade, const CutOptions& options = {}, const Job& job = {});

    /// Extends a freehand cut while the hand moves. `so_far` is the blade drawn up to now: the blade of the previous
    /// call with a longer line. Only elements that the blade crosses completely are cut; the element under the tip
    /// waits until finish_stroke(), which cuts exactly up to the tip. Each call returns the delta of its own step; all
    /// steps together are one cut for undo. While a stroke is open, no other operation may change the session. After a
    /// step with a status other than `done`, or with an exception, the session and the stroke are unchanged: the caller
    /// may try another blade, finish the stroke or abandon it.
    /// @throws InputError on a malformed blade.
    CutResult extend_stroke(const Blade& so_far, const CutOptions& options = {}, const Job& job = {});
    /// Cuts up to the tip and ends the stroke. After cancellation or an exception the stroke is still open and
    /// unchanged.
    /// @throws InputError when no stroke is open.
    CutResult finish_stroke(const Job& job = {});
    /// Gives up the open stroke and restores the session bit for bit, redo included.
    /// @return the delta that takes back all steps of the stroke
    /// @throws InputError when no stroke is open
    MeshDelta abandon_stroke();
    bool stroke_open() const;

    /// Removes elements, given by id; duplicates count once. The bared faces become lips of a cut of its own, with side
    /// 0; vertices without elements are removed. Where remaining elements would be connected in a point or along an
    /// edge only, they are separated (an edge first gets a vertex in its middle). The surface stays manifold except at
    /// vertices where two parts of the surface touch: for example, the tip of a wound reaches another wound or the
    /// skin.
    /// @throws InputError when `tets` names no element, every element, or a missing element
    CutResult ablate(std::span<const TetId> tets, const Job& job = {});

    bool can_undo() const;
    bool can_redo() const;
    /// Takes back the last operation (undo) or repeats the operation that was taken back last (redo), and returns the
    /// changes.
    /// @throws InputError when there is no such operation, or when a stroke is open
    MeshDelta undo();
    MeshDelta redo();

    std::size_t tet_count() const; ///< living elements
    std::size_t vertex_count() const; ///< living vertices
    std::size_t cut_count() const; ///< cuts, strokes and ablations that are not undone

    /// True for the id of a living element or vertex.
    bool has_tet(TetId tet) const;
    bool has_vertex(VertexId vertex) const;
    /// Upper bounds of ids: every id is smaller.
    std::size_t tet_slots() const;
    std::size_t vertex_slots() const;
    /// Data of a living element or vertex. @throws InputError when the id has no living element or vertex
    MeshDelta::Tet tet(TetId tet) const;
    Vec3 position(VertexId vertex) const; ///< mm, rest configuration
    std::vector<TetId> tets_at(VertexId vertex) const; ///< elements round a vertex, ascending

    /// Sets the witness, which is called for every further operation, such as the journal on disk. An empty function
    /// removes the witness.
    void set_witness(CutWitness witness);
    SessionBytes bytes() const;

    /// The faces of all wounds.
    std::vector<LipFace> lips() const;
    /// The element of the first mesh that contains a living element.
    TetId origin(TetId tet) const;
    /// A compact copy for finite elements, view or file.
    TetMesh compact_mesh(SlotMap* map = nullptr) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::mesh
