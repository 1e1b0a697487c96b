#pragma once
// A site on an organ, such as an anastomosis: the part of the organ's surface that the surgeon works on.
// Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"

namespace retractor::planner {

/// The triangles of an organ's surface whose middle lies within the site's radius of its centre.
/// @throws InputError with the distance of the nearest surface when there are none
TriMesh site_surface(const TriMesh& organ, const TargetSpec& site);

/// The organ at a place, with a site there that reaches its surface all round: in a vessel's middle the site is a ring.
/// A target or a structure at risk within kSiteMm comes first: fat and cavities fill what lies beside vessels. The site
/// has no words yet.
/// @throws InputError when there is no organ
TargetSpec site_at(const mesh::LabelVolume& labels, const Vec3& place);

/// @throws InputError when no voxel on the surface of the site's label lies within its radius
void check_site(const mesh::LabelVolume& labels, const TargetSpec& site);

/// The smallest radius that site_at() proposes, and the farthest organ that it takes, mm: a coronary anastomosis with
/// the vessel on both sides of it (ours).
inline constexpr double kSiteMm = 8.0;

/// The other triangles.
TriMesh surface_beside_site(const TriMesh& organ, const TargetSpec& site);

} // namespace retractor::planner
