#pragma once
// Cutting as a session: a blade goes in, a MeshDelta comes out. Ids are stable, freed slots are reused,
// every change is journalled, and undo replays the journal backwards. FEM, view and haptics consume the
// same deltas. Units mm; frame patient LPS (the rest configuration).
//
// Subdivision is the general one: one pattern, the bisection of an edge that the blade crosses; every
// element round that edge becomes two. Crossed edges are bisected exactly where the swept blade crosses
// them, until the blade (and the curve where it ends inside the body) runs along faces only; then the
// elements on its two sides are given their own copies of the vertices on it. Conforming by construction.

#include "mesh/base/job.h"
#include "mesh/blade.h"
#include "mesh/tet_mesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace retractor {

/// Everything that one cut changed, in the order: vertices born, vertices moved, tets gone, tets born, vertices
/// gone. A vertex may be born and then moved (onto the curve where the blade ends).
struct MeshDelta {
    struct VertexBorn {
        VertexId id = 0;
        Vec3 position; ///< rest position, mm
        VertexId a = 0, b = 0; ///< it lies on the former edge a-b; a == b: a copy of a on the other lip
        double t = 0.0; ///< position = (1 - t) a + t b, up to the round-off of putting it on the blade
    };
    struct VertexMoved {
        VertexId id = 0;
        Vec3 from, to;
    };
    struct Tet {
        TetId id = 0;
        std::array<VertexId, 4> nodes {};
        Label label = 0;
        TetId origin = 0; ///< the element of the session's first mesh that it is a part of
    };
    std::vector<VertexBorn> vertices_born;
    std::vector<VertexMoved> vertices_moved;
    std::vector<Tet> tets_gone;
    std::vector<Tet> tets_born; ///< a split or rewired element is gone and born again under a new or freed id
    std::vector<VertexBorn> vertices_gone; ///< by undo only: what was born before, last born first
};

/// The same change taken back: what was born is gone. Needs no mesh.
MeshDelta inverse(const MeshDelta& delta);

/// A face of the wound: on the blade, with tissue on one side only.
struct LipFace {
    TetFace face; ///< ids of the session
    int side = 0; ///< +1 or -1, see BladeCoordinates::side
    int cut = 0; ///< number of the cut in this session, from 0
};

enum class CutStatus { done, missed_body, cancelled };

struct CutOptions {
    /// A vertex nearer to the blade than this share of its shortest incident edge is moved onto it, which
    /// avoids slivers; 0 never moves a vertex, and then volumes are kept to round-off. Between 0 and 0.5. No move
    /// takes more than 75 % of an element's volume, or makes a dihedral angle smaller than 8 degrees (or than it
    /// was), or changes a label's volume by more than 0.5 % of the volume of the elements round the vertex.
    /// Vertices on earlier wounds stay where they are.
    double snap = 0.15;
    /// Labels the blade does not sever (a scalpel does not cut bone): their elements stay tied together.
    std::vector<Label> uncut_labels {};
};

struct CutReport {
    std::size_t tets_crossed = 0; ///< before snapping
    std::size_t tets_before = 0, tets_after = 0;
    std::size_t vertices_moved = 0;
    double largest_move_mm = 0.0;
    double lip_area_mm2 = 0.0; ///< of one lip, rest configuration
    double worst_dihedral_deg = 180.0; ///< among the elements born
    double seconds = 0.0;
};

struct [[nodiscard]] CutResult {
    CutStatus status = CutStatus::done;
    std::string message;
    MeshDelta delta;
    CutReport report;
};

/// Maps between a session's stable ids and a compact mesh's consecutive ones; -1 where there is none.
struct SlotMap {
    std::vector<VertexId> vertex_slot; ///< per compact vertex: its session id
    std::vector<TetId> tet_slot; ///< per compact element: its session id
    std::vector<VertexId> compact_vertex; ///< per session id: the compact vertex
    std::vector<TetId> compact_tet;
};

class CutSession {
public:
    /// @throws InputError as check_mesh does; four-node elements only.
    explicit CutSession(TetMesh mesh);
    ~CutSession();
    CutSession(CutSession&&) noexcept;
    CutSession& operator=(CutSession&&) noexcept;

    /// Cuts; after a status other than `done`, or a throw, the session is as it was.
    /// @throws InputError on a malformed blade.
    CutResult cut(const Blade& blade, const CutOptions& options = {}, const Job& job = {});

    bool can_undo() const;
    bool can_redo() const;
    MeshDelta undo(); ///< @throws InputError when there is nothing to undo
    MeshDelta redo();

    std::size_t tet_count() const; ///< living elements
    std::size_t vertex_count() const; ///< living vertices
    std::size_t cut_count() const;

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

} // namespace retractor
