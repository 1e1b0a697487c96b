#pragma once
// The wall's surface as the knife sees it: where it was at rest, where it is shown now, and what a ray from the eye
// touches. Units mm; frame patient LPS. "Rest" is the configuration in which the knife cuts; "shown" is under tension.

#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// What changes only when something is cut. Vertices are numbered as in the cutting session; rows of vertices that no
/// triangle uses say nothing.
struct WallSurface {
    std::vector<std::array<VertexId, 3>> triangles; ///< counter-clockwise seen from outside
    std::vector<Label> labels; ///< per triangle
    std::vector<std::uint8_t> is_lip; ///< per triangle: made by the knife
    Points rest; ///< n x 3, mm
};

/// One frame. Frames between which nothing was cut share their surface.
struct WallPicture {
    std::shared_ptr<const WallSurface> surface;
    Points shown; ///< as many rows as surface->rest
};

struct Ray {
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::UnitY(); ///< unit
};

/// A place on the wall.
struct Touch {
    Vec3 rest = Vec3::Zero(), shown = Vec3::Zero(); ///< the same place of the tissue
    Vec3 inward = Vec3::UnitY(); ///< unit, into the body at rest: mean of the surface near it
    std::array<VertexId, 3> triangle { -1, -1, -1 }; ///< corners of the face it lies on
    Label label = 0;
    bool on_lip = false;
    double distance = 0.0; ///< along the ray, mm
};

/// The first place of the shown surface that the ray meets, mapped back to rest in the face it lies on.
std::optional<Touch> touch(const WallPicture& picture, const Ray& ray);

/// Distance to the first meeting of a ray with a surface.
std::optional<double> first_hit(const TriMesh& surface, const Ray& ray);

/// How thick the wall at rest is near a place on it, along the knife: the largest of some places within `radius_mm`.
/// Wounds do not count as far sides. Nothing where there is no far side within `limit_mm`.
std::optional<double> thickness_near(
    const WallSurface& surface, const Touch& at, double radius_mm = 40.0, double limit_mm = 120.0);

/// Edges between lips and the rest of the surface: the borders of the wounds.
std::vector<std::array<VertexId, 2>> wound_rims(const WallSurface& surface);

} // namespace retractor::planner
