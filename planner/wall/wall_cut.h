#pragma once
// The wall of an approach after the knife: the incision, what is removed after it, and the pieces this leaves. Units
// mm; frame patient LPS (rest configuration).

#include "fem/model/loads.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"
#include "planner/wall/removed_tissue.h"

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The approach's cut and ablations on a session.
struct [[nodiscard]] PlannedCut {
    mesh::CutStatus status
        = mesh::CutStatus::done; ///< with another one the session is as it was, but for what can be redone
    std::string message; ///< why not, or remarks
    mesh::CutReport report; ///< of the incision
    std::vector<mesh::MeshDelta> deltas; ///< one after the other
    std::vector<RemovedTissue> removed; ///< by the ablations
    double removed_skin_mm2 = 0.0; ///< what they took of the surface that the blade enters by, at rest
};
/// @param options usually cut_options_of(approach, table).
/// @throws InputError on a malformed blade; where() "ablations/0" when an ablation finds nothing to remove; and what
/// the session's witness throws (IoError of a journal). What was cut before an ablation failed then stays.
PlannedCut cut_as_planned(mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table,
    const mesh::CutOptions& options, const Job& job = {});

/// What holds the wall before it is cut.
fem::Supports supports_of(const mesh::TetMesh& wall, const mesh::LabelVolume& labels, const Case& planned_case,
    const mesh::MeshSizing& sizing);

/// The same after cuts: copies of a fixed vertex are fixed, and so are new vertices on an edge between two fixed ones;
/// a vertex on a bed shares it with its copies.
/// @param uncut by the ids of the session's first mesh.
/// @param deltas of all cuts in force, one after the other.
/// @param map of the session's compact mesh, whose vertices the result names.
fem::Supports carried_supports(
    const fem::Supports& uncut, std::span<const mesh::MeshDelta> deltas, const mesh::SlotMap& map);

/// A part of the wall joined by faces, and what holds it.
struct WallPiece {
    int number = 1; ///< from 1, most elements first
    std::vector<TetId> tets;
    double volume_mm3 = 0.0;
    Vec3 centroid = Vec3::Zero();
    std::vector<std::pair<std::string, double>> labels; ///< name and mm^3, the largest share first
    std::size_t fixed = 0, bedded = 0; ///< vertices
    std::vector<std::string> hooks;
    bool held = true; ///< by supports, beds, hooks or pieces that are: three places not on one line
};
std::vector<WallPiece> find_wall_pieces(const mesh::TetMesh& wall, const mesh::LabelTable& table,
    const fem::Supports& supports, std::span<const fem::HookPatch> hooks);
/// "piece 2: 3.4 cm3 of rib_left_5 at (12, -80, 1045) mm".
std::string piece_text(const WallPiece& piece);
/// A piece too small to be one by one spoken of.
bool is_crumb(const WallPiece& piece);
/// "3 crumbs below 1 mm3". @pre count > 0
std::string crumbs_text(std::size_t count);

/// All of it, as the elastic solution needs it.
struct [[nodiscard]] CutWall {
    mesh::CutStatus status = mesh::CutStatus::done;
    std::string message; ///< why not, or remarks
    mesh::CutReport report;
    mesh::TetMesh wall;
    std::vector<mesh::LipFace> lips; ///< faces of `wall` on the incision's two sides
    std::vector<mesh::TetFace> wound; ///< faces of `wall` that any cut or ablation bared, the lips among them
    std::vector<TetId> origin; ///< per element of `wall`: the element of the uncut wall that it is a part of
    std::vector<fem::FaceTraction> released {}; ///< tension set free at the wound; filled in by plan_approach()
    fem::Supports supports; ///< with what loose pieces got
    std::vector<fem::HookPatch> hooks;
    std::vector<WallPiece> pieces; ///< of `wall`, with what held them before loose ones were dealt with
    std::vector<std::vector<VertexId>> rigid; ///< vertices of pieces that are left rigid: see move_rigid_pieces()
    std::vector<RemovedTissue> removed;
    double removed_skin_mm2 = 0.0; ///< what was removed of the surface that the blade enters by, at rest
    std::vector<std::string> loose; ///< each loose piece and what became of it; crumbs together
    std::array<std::string, 2> took_lip; ///< sides +1 and -1: the removed loose pieces that bore faces of that lip
};
/// @throws InputError as cut_as_planned() and hook_patches() do.
CutWall cut_wall(mesh::TetMesh uncut, const Approach& approach, const mesh::LabelTable& table, fem::Supports supports,
    const Job& job);

/// Moves the pieces that were left out of the elastic solution as LoosePieces::rigid says.
/// @param rigid from CutWall, of `wall`.
/// @param displacement n x 3 (mm), as solved; rows of the pieces' vertices are replaced.
void move_rigid_pieces(const mesh::TetMesh& wall, std::span<const std::vector<VertexId>> rigid, Points& displacement);

} // namespace retractor::planner
