#pragma once
// The places of a body that a blade can touch: samples on faces of the wound's lip, and on the surface of bone behind
// soft tissue. Geometry alone decides: the side to which a face looks, and its distance from the blade at rest; no
// vertex is chosen. Units mm, N, MPa; frame patient LPS.
//
// Lip. A lip that reaches over the plane of the blade at rest, where an incision bends, keeps this overlap without a
// force, as if the blade had the shape of the lip: rest is an equilibrium. Where the lip is hollow the gap closes
// first.
//
// Bone behind soft tissue. Elements of several millimetres cannot be squeezed flat between blade and bone, and soft
// tissue can. So bone bears on the blade as soon as the layer between is squeezed to kSqueezedTo of its thickness at
// rest; until then, and beside it, the layer itself bears. Bone that the blade passes through at rest keeps the
// overlap.

#include "fem/material/elasticity.h"
#include "fem/model/blade_contact.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// Thickness of the layer of soft tissue between blade and bone at which the bone bears, relative to rest. Ours.
inline constexpr double kSqueezedTo = 0.5;
/// Bone farther behind a blade than this (mm) is out of reach.
inline constexpr double kBoneReachMm = 8.0;
/// Friction over pressure of a blade with a serrated or lipped end on wet tissue. Ours.
inline constexpr double kBladeFriction = 0.5;

/// A blade at rest.
struct BladePlace {
    std::string name;
    Vec3 middle = Vec3::Zero(); ///< of its rectangle, mm
    Vec3 along = Vec3::UnitX(); ///< along its width
    Vec3 deep = Vec3::UnitY(); ///< along its height; need not be at a right angle to `along`
    Vec3 outward = Vec3::UnitZ(); ///< into the tissue that the blade pushes; decides the side of the blade
    double width_mm = 0.0, height_mm = 0.0;
    double friction = kBladeFriction;
};

/// The nodes of a blade: its middle, the end of its half width and the end of its half height, so that they are
/// counter-clockwise seen from the tissue.
/// @throws InputError naming the blade on sizes that are not positive, and on axes that are zero or parallel
std::array<Vec3, 3> blade_nodes(const BladePlace& place);

/// Finds the samples of a blade.
/// @param lame one per element
/// @param lip faces of the lip that the blade holds
/// @param bone faces of the surface of bones, each of an element of bone; faces that are also in `lip`, and those that
/// no elements near the blade connect with the lip (they lie on the other lip of the cut), are passed over
/// @param nodes numbers of the blade's nodes in the mesh
/// @throws InputError as blade_nodes(), and naming the blade when no face of the lip looks at it
BladeSurface make_blade_surface(const mesh::TetMesh& mesh, std::span<const Lame> lame,
    std::span<const mesh::TetFace> lip, std::span<const mesh::TetFace> bone, const BladePlace& place,
    const std::array<VertexId, 3>& nodes);

/// The surface of the elements with these labels: faces that only one of them has.
std::vector<mesh::TetFace> surface_of_labels(const mesh::TetMesh& mesh, std::span<const Label> labels);

} // namespace retractor::fem
