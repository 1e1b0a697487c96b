#pragma once
// Cuts the wall of an approach: makes the incision, divides the intercostal space beyond it, removes the ablated
// tissue, and finds the resulting pieces. Units mm; frame patient LPS (rest configuration).

#include "fem/model/loads.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"
#include "planner/wall/divided_tissue.h"
#include "planner/wall/removed_tissue.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The approach's incision, division and ablations, carried out in a session.
struct [[nodiscard]] PlannedCut {
    /// When not done, the session is unchanged except for the operations that can be redone.
    mesh::CutStatus status = mesh::CutStatus::done;
    std::string message; ///< reason of a failure, or remarks
    mesh::CutReport report; ///< report of the incision
    std::vector<mesh::MeshDelta> deltas; ///< one per operation, in order
    std::optional<DividedTissue> divided; ///< beyond the incision's ends; empty without strokes of a division
    std::vector<RemovedTissue> removed; ///< tissue removed by the ablations
    /// Area, at rest, that the ablations took from the surface through which the blade enters.
    double removed_skin_mm2 = 0.0;
};
/// @param options usually cut_options_of(approach, table)
/// @throws InputError on a malformed blade; with where() "ablations/0" when an ablation finds nothing to remove; also
/// the errors of the session's witness (IoError of a journal); SolverError as divide_beyond_skin() does. Cuts made
/// before a failing stroke or ablation stay.
PlannedCut cut_as_planned(mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table,
    const mesh::CutOptions& options, const Job& job = {});

/// The supports of the wall before the cut.
/// @param message not null: receives a remark on ribs whose joint has one place only (rib_joints.h)
fem::Supports supports_of(const mesh::TetMesh& wall, const mesh::LabelVolume& labels, const Case& planned_case,
    const mesh::MeshSizing& sizing, std::string* message = nullptr);

/// Carries supports over cuts. A copy of a fixed vertex is fixed, and so is a new vertex on an edge between two fixed
/// ones. A vertex on a bed shares the bed's stiffness with its copies. A hinge keeps the edges whose vertices live;
/// fem::joined_hinges() then drops the edges that the cuts have parted.
/// @param uncut supports by the ids of the session's first mesh
/// @param deltas deltas of all cuts in force, in order
/// @param map map of the session's compact mesh; the result names vertices of this mesh
fem::Supports carried_supports(
    const fem::Supports& uncut, std::span<const mesh::MeshDelta> deltas, const mesh::SlotMap& map);

/// A part of the wall that is connected by faces, with its supports.
struct WallPiece {
    int number = 1; ///< from 1; the piece with most elements is first
    std::vector<TetId> tets;
    double volume_mm3 = 0.0;
    Vec3 centroid = Vec3::Zero();
    std::vector<std::pair<std::string, double>> labels; ///< name and mm^3, the largest share first
    std::size_t fixed = 0, bedded = 0; ///< numbers of vertices
    std::vector<std::string> hooks;
    bool held = true; ///< by supports, beds, hooks or held pieces, at three places not on one line
};
std::vector<WallPiece> find_wall_pieces(const mesh::TetMesh& wall, const mesh::LabelTable& table,
    const fem::Supports& supports, std::span<const fem::HookPatch> hooks);
/// Text for people: "piece 2: 3.4 cm3 of rib_left_5 at (12, -80, 1045) mm".
std::string piece_text(const WallPiece& piece);
/// Whether the piece is too small for a message of its own.
bool is_crumb(const WallPiece& piece);
/// Text for people: "3 crumbs below 1 mm3". @pre count > 0
std::string crumbs_text(std::size_t count);

/// The cut wall with everything that the elastic solution needs.
struct [[nodiscard]] CutWall {
    mesh::CutStatus status = mesh::CutStatus::done;
    std::string message; ///< reason of a failure, or remarks
    mesh::TetMesh wall;
    std::vector<mesh::LipFace> lips; ///< faces of `wall` on the incision's two sides
    std::vector<mesh::TetFace> wound; ///< faces of `wall` that any cut or ablation bared, with the lips
    std::vector<TetId> origin; ///< element of the uncut wall to which each element of `wall` belongs
    std::vector<fem::FaceTraction> released {}; ///< tension released at the wound; filled in by plan_approach()
    fem::Supports supports; ///< with the supports given to loose pieces
    std::vector<fem::HookPatch> hooks;
    std::vector<WallPiece> pieces; ///< pieces of `wall`, with their supports before loose pieces were treated
    std::vector<std::vector<VertexId>> rigid; ///< vertices of each rigid piece: see move_rigid_pieces()
    std::optional<DividedTissue> divided;
    std::vector<RemovedTissue> removed;
    double removed_skin_mm2 = 0.0; ///< removed area, at rest, of the surface through which the blade enters
    std::vector<std::string> loose; ///< each loose piece and its treatment; crumbs together
    std::array<std::string, 2> took_lip; ///< removed loose pieces that bore faces of the lips of sides +1 and -1
};
/// @throws InputError as cut_as_planned() and hook_patches() do; SolverError as divide_beyond_skin() does
CutWall cut_wall(mesh::TetMesh uncut, const Approach& approach, const mesh::LabelTable& table, fem::Supports supports,
    const Job& job);

/// Moves the pieces that were left out of the elastic solution (LoosePieces::rigid).
/// @param rigid from CutWall, of `wall`
/// @param displacement n x 3 (mm), the elastic solution; the rows of the pieces' vertices are replaced
void move_rigid_pieces(const mesh::TetMesh& wall, std::span<const std::vector<VertexId>> rigid, Points& displacement);

} // namespace retractor::planner
