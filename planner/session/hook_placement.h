#pragma once
// Finds the place where a hook holds a wound that was cut by hand. The place is the point of the wound's edge nearest
// to the touched point, on the same side of the wound. Units mm; frame patient LPS, at rest.

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

/// A face of a wound by the session's vertices, counter-clockwise seen from the gap.
struct LipTriangle {
    std::array<VertexId, 3> vertices {};
    int cut = 0, side = 0;
};
std::vector<LipTriangle> lip_triangles(const mesh::CutSession& session);

/// The patch of a lip that a hook holds.
struct HookPlacement {
    int cut = 0, side = 0; ///< number of the cut, and side of the lip
    Vec3 centre = Vec3::Zero(); ///< centre of the patch
    Vec3 along = Vec3::UnitX(), inward = Vec3::UnitY(); ///< unit vectors along the wound's edge and into the body
    Vec3 pull = Vec3::UnitX(); ///< unit vector away from the other lip
    double width_mm = 10.0, height_mm = 15.0;
    std::vector<VertexId> nodes {}; ///< vertices of the lip under the patch, in rising order
    Vec3 arm = Vec3::Zero(); ///< where a retractor's blade hangs on its arm, over the patch's middle, at the skin
    double lever_mm = 0.0; ///< of a retractor's blade: depth below the arm at which it bears
    double reach_mm = 0.0; ///< of a retractor's blade: depth of its end below the arm
};

/// Finds the patch for a hook near a touched place.
/// @param held per vertex: 1 = does not move, so that no hook can hold the vertex
/// @param outward out of the body; edges on the inner side of the wall do not count
/// @param why_not receives the reason when no lip is near; the result then has no nodes
HookPlacement find_hook_placement(const WallSurface& surface, std::span<const LipTriangle> lips,
    std::span<const char> held, const Vec3& outward, const Touch& at, std::string& why_not);

/// Finds the patches of a retractor's two blades: one near a touched place, one on the lip opposite. Both pull along
/// one line, the rack's.
/// @param width_mm along the wound
/// @param depth_mm into the wound; a blade deeper than the wound holds the whole lip
/// @param held, outward, why_not as find_hook_placement(); where a blade finds no lip, neither has nodes
std::array<HookPlacement, 2> find_blade_placements(const WallSurface& surface, std::span<const LipTriangle> lips,
    std::span<const char> held, const Vec3& outward, const Touch& at, double width_mm, double depth_mm,
    std::string& why_not);

/// The planned hooks that find a lip in a wound that was drawn by hand.
struct PlannedPlacements {
    std::vector<HookPlacement> placements;
    std::vector<std::string> names; ///< one per placement
    std::vector<fem::HookDrive> drives; ///< planned drive of each placement
    std::string omitted; ///< message that names the hooks without a lip, with the reasons
};
PlannedPlacements planned_placements(const mesh::CutSession& session, const Approach& approach,
    const mesh::LabelTable& table, std::span<const char> held);

} // namespace retractor::planner
