#pragma once
// The steel of a retractor's hook or blade as a surface: what pictures draw, and what blocks the line of sight.
// Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <string>

namespace retractor::planner {

/// A blade of steel whose patch lies against a lip, with its shaft over the skin.
struct HookShape {
    std::string name {};
    Vec3 position = Vec3::Zero(); ///< centre of the patch, on the lip
    Vec3 pull = Vec3::UnitX(); ///< direction of the pull; need not be unit
    /// Out of the body; need not be unit or normal to `pull`, but must not be parallel to it.
    Vec3 outward = -Vec3::UnitY();
    double width_mm = 15.0; ///< width of the patch, along the incision
    double depth_mm = 10.0; ///< height of the patch, into the body
    double height_mm = 0.0; ///< from the patch centre to the skin, over which the blade bends; 0: depth_mm / 2
    double shaft_mm = 60.0;
};

/// Of a hand-held retractor's blade, mm.
inline constexpr double kBladeThicknessMm = 1.6;

/// A closed ribbon of steel: the patch against the lip, the bend over the wound's edge, and the shaft away from the
/// wound. Triangles face outwards.
/// @throws InputError on values that are not finite, sizes that are not positive, or a pull along `outward`
TriMesh hook_mesh(const HookShape& hook);

/// The arms and the rack that join two blades of a retractor, above the skin, at one end of the wound: three closed
/// bars, whose triangles face outwards.
/// @throws InputError as hook_mesh()
TriMesh rack_mesh(const HookShape& blade, const HookShape& opposite);

} // namespace retractor::planner
