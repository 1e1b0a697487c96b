#pragma once
// Where a hook takes hold of a wound that was cut by hand: the edge of the wound nearest to the place that was
// touched, on the side of the wound that it lies on. Units mm; frame patient LPS, at rest.

#include "fem/statics/hook_drive.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/session/wall_picture.h"

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// A face of a wound by the vertices of the session; counter-clockwise seen from the gap.
struct LipTriangle {
    std::array<VertexId, 3> vertices {};
    int cut = 0, side = 0;
};
std::vector<LipTriangle> lip_triangles(const mesh::CutSession& session);

/// A patch of one lip.
struct HookPlacement {
    int cut = 0, side = 0; ///< the lip
    Vec3 centre = Vec3::Zero(); ///< of the patch
    Vec3 along = Vec3::UnitX(), inward = Vec3::UnitY(); ///< unit: along the wound's edge, and into the body
    Vec3 pull = Vec3::UnitX(); ///< unit: away from the other lip
    double width_mm = 10.0, height_mm = 15.0;
    std::vector<VertexId> nodes {}; ///< of the lip under the patch, rising
};

/// @param held per vertex: 1 where it does not move and no hook can hold it.
/// @param why_not is set when there is nothing to hold near by; the seat then has no nodes.
HookPlacement find_hook_seat(const WallSurface& surface, std::span<const LipTriangle> lips, std::span<const char> held,
    const Touch& at, std::string& why_not);

/// The hooks of a plan in a wound that was drawn by hand, wherever a lip lies under them.
struct PlannedSeats {
    std::vector<HookPlacement> seats;
    std::vector<std::string> names; ///< per seat
    std::vector<fem::HookDrive> drives; ///< per seat: as planned
    std::string reduction_error; ///< the hooks that find no hold, and why
};
PlannedSeats planned_seats(const mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table,
    std::span<const char> held);

} // namespace retractor::planner
