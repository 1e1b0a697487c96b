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
#include "mesh/blade.h"
#include "mesh/tet_mesh.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace retractor {

/// Everything that one cut changed, in the order: vertices born, vertices moved, tets gone, tets born, vertices
/// gone. A vertex may be born and then moved (onto the curve where the blade ends).
struct MeshDelta {
    /// Where a vertex comes from; to be asked instead of comparing a with b.
    enum class Origin : std::uint8_t {
        on_edge, ///< on the former edge a-b
        copy, ///< of a (== b) on another lip, in the same place
        restored, ///< a == b == id: back from an ablation that is undone; of a vertex gone: taken by an ablation
    };
    struct VertexBorn {
        VertexId id = 0;
        Vec3 position; ///< rest position, mm
        VertexId a = 0, b = 0; ///< parents: alive before the delta, or born earlier in it
        /// Of a vertex on an edge: position = (1 - t) a + t b, up to the round-off of putting it on the blade, as long
        /// as nothing moved. Vertices that moved in the same delta, and parents merged into others (neither with
        /// snap = 0), leave it true to an edge's length. When both parents were merged into one vertex, a == b and
        /// t == 0: that vertex is near, no more. Of the other kinds 0.
        double t = 0.0;
        Origin origin = Origin::on_edge;
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
    /// By undo: what was born before, last born first. By ablation: what no element uses any more.
    std::vector<VertexBorn> vertices_gone;
};

/// The same change taken back: what was born is gone. Needs no mesh.
MeshDelta inverse(const MeshDelta& delta);

/// A face of the wound: on the blade, or bared by an ablation, with tissue on one side only.
struct LipFace {
    TetFace face; ///< ids of the session
    int side = 0; ///< +1 or -1, see BladeCoordinates::side; 0: bared by an ablation
    int cut = 0; ///< number of the cut in this session, from 0
};

enum class CutStatus { done, missed_body, cancelled };

/// How crossed elements are divided. `adaptive` is the product's way; the others are the source's comparison, defined
/// in cut_patterns.h: they snap and improve nothing, whatever the other options say.
enum class Subdivision { adaptive, intermediate_11, intermediate_5, general };

struct CutOptions {
    Subdivision subdivision = Subdivision::adaptive;
    /// A vertex nearer to the blade than this share of its shortest incident edge is moved onto it, which
    /// avoids slivers and keeps elements few; 0 never moves any vertex, and then volumes are kept to round-off. Between
    /// 0 and 0.5. The default is where random strokes through Kuhn boxes give the best angles. No move takes more than
    /// 75 % of an element's volume, or carries a surface or an interface further than 5 % of the shortest edge at the
    /// vertex (5 % of the mean edge by all moves together). Vertices on earlier wounds stay where they are.
    double snap = 0.35;
    double snap_angle_deg = 12.0; ///< no move onto the blade makes a dihedral angle smaller than this (or than it was)
    /// Elements near the blade with a smaller dihedral angle are opened as far as shifting and merging vertices can,
    /// unless snap is 0.
    double improve_below_deg = 12.0;
    /// Where the blade's line bends so much that a chord as long as the edges there would lie as far off the blade as
    /// at a single bend of this angle in its middle, the bend's ray is made an edge of the mesh. Gentler bends, and the
    /// twist between neighbouring rays whose directions differ, are spanned by faces with their corners on the blade:
    /// 0.1 edges off it at most where no strip is twisted (CutReport::lip_to_blade tells how far). 0: every bend is
    /// followed, twists too, at the cost of slivers where they meet.
    double crease_deg = 20.0;
    /// Labels the blade does not sever (a scalpel does not cut bone): their elements stay tied together.
    std::vector<Label> uncut_labels {};
    /// A cut during which the session would have more elements than this is refused (SolverError): cuts that cross
    /// again and again in one place divide what they divided before. At least 1.
    std::size_t element_limit = 20'000'000;
};

/// What a cut did, for the user and the bench. Angles are dihedral angles of elements.
struct CutReport {
    std::size_t tets_crossed = 0; ///< before snapping
    std::size_t tets_before = 0, tets_after = 0;
    std::size_t tets_created = 0, tets_removed = 0; ///< born and gone
    std::size_t vertices_moved = 0, vertices_merged = 0;
    double largest_move_mm = 0.0;
    /// Largest, all moves of a vertex together, in local edges: mean edges of the session's first elements there.
    double surface_deviation = 0.0;
    double lip_area_mm2 = 0.0; ///< of one lip (of an ablation: the area bared), rest configuration
    double removed_volume_mm3 = 0.0; ///< by an ablation, rest configuration
    double lip_to_blade = 0.0; ///< largest distance of a lip face's middle from the blade, in edges of that face
    double worst_dihedral_before_deg = 180.0; ///< among the elements gone
    double worst_dihedral_deg = 180.0; ///< among the elements born
    double p01_dihedral_deg = 180.0; ///< 1st percentile of all angles of the elements born
    /// Elements born whose smallest dihedral angle is below CutOptions::improve_below_deg's default and below half the
    /// smallest of the elements gone that they are made of: where the blade grazes, geometry forbids better.
    std::size_t tets_below_half_parent = 0;
    double smallest_volume_ratio = 1.0; ///< smallest volume of an element born, in mean volumes of those gone
    int attempts
        = 1; ///< more than one: a promise was not kept at first, less was snapped, more bends followed, elements halved
    double seconds = 0.0;

    /// (created - removed) / crossed; 0 when nothing was crossed.
    double mean_increase() const;
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

} // namespace retractor
