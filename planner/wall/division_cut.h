#pragma once
// Divides intercostal muscle and pleura, or the sternum, beyond the ends of the skin incision, in a session that has
// made the skin cut. Units mm; frame patient LPS (rest configuration).

#include "mesh/base/job.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/wall/divided_tissue.h"

#include <optional>
#include <vector>

namespace retractor::planner {

/// The strokes of a division, carried out in a session.
struct [[nodiscard]] DivisionCut {
    mesh::CutStatus status = mesh::CutStatus::done; ///< done or cancelled
    std::vector<mesh::MeshDelta> deltas; ///< one per stroke, in order; strokes before a cancelled one stay
    std::optional<DividedTissue> divided; ///< empty where the approach has no strokes
};

/// The cut options of a stroke: everything but what the stroke severs stays connected, and so does what the approach's
/// blade does not sever either.
mesh::CutOptions division_options(
    const Approach& approach, const DivisionStroke& stroke, const mesh::LabelTable& table);

/// Makes the strokes of Division::strokes, which find_division() has found. A stroke that the cutter refuses is
/// tried again with a start a little inside the incision, on the blade of the skin cut.
/// @pre the session has made the approach's incision
/// @throws SolverError at "division/" and the stroke's way when a stroke cannot be made or severs nothing;
/// strokes before stay. IoError of the session's witness
DivisionCut divide_beyond_skin(
    mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table, const Job& job = {});

} // namespace retractor::planner
