#pragma once
// The wall's surface as the knife sees it: its positions at rest and as shown, and the place that a ray from the eye
// touches. Units mm; frame patient LPS. "Rest" is the configuration in which the knife cuts; "shown" is the
// configuration under tension and hooks.

#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace retractor::planner {

/// The data that change only with a cut. Vertices are numbered as in the cutting session; rows of vertices that no
/// triangle uses have no meaning.
struct WallSurface {
    std::vector<std::array<VertexId, 3>> triangles; ///< counter-clockwise seen from outside
    std::vector<Label> labels; ///< per triangle
    std::vector<std::uint8_t> is_lip; ///< per triangle: 1 = made by the knife
    Points rest; ///< n x 3, mm
};

/// One frame. Frames share their surface when no cut lies between them.
struct WallPicture {
    std::shared_ptr<const WallSurface> surface;
    Points shown; ///< shown positions, as many rows as surface->rest, mm
};

struct Ray {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitY(); ///< unit
};

/// A place on the wall.
struct Touch {
    Vec3 rest = Vec3::Zero(), shown = Vec3::Zero(); ///< the same tissue point at rest and as shown
    Vec3 inward = Vec3::UnitY(); ///< unit vector into the body at rest: mean over the nearby surface
    std::array<VertexId, 3> triangle { -1, -1, -1 }; ///< corners of the touched face
    Label label = 0;
    bool on_lip = false;
    double distance = 0.0; ///< along the ray, mm
};

/// The first place of the shown surface that the ray meets, mapped to rest within its face.
std::optional<Touch> touch(const WallPicture& picture, const Ray& ray);

/// Distance along a ray to its first intersection with a surface.
std::optional<double> first_hit(const TriMesh& surface, const Ray& ray);

/// Thickness of the wall at rest near a place, along the knife: the largest of several samples within `radius_mm`. Lips
/// of wounds do not count as far sides. Empty when no far side is within `limit_mm`.
std::optional<double> thickness_near(
    const WallSurface& surface, const Touch& at, double radius_mm = 40.0, double limit_mm = 120.0);

/// Edges between lips and the rest of the surface: the margins of the wounds.
std::vector<std::array<VertexId, 2>> wound_rims(const WallSurface& surface);

} // namespace retractor::planner
