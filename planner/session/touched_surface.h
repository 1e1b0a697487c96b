#pragma once
// Places of fingers on a surface for display: the place that a ray from the eye meets, and the position of a drawn
// fingertip that lies on the tissue and not inside. Units mm.

#include "haptics/condensed/elastic_template.h"
#include "planner/session/wall_picture.h"

#include <array>
#include <optional>
#include <vector>

namespace retractor::planner {

struct SurfacePlace {
    Vec3 point = Vec3::Zero();
    Vec3 outward = Vec3::UnitZ(); ///< unit normal of the smooth surface
};

/// The first place where a ray meets a front face of the surface. @param normals vertex_normals()
std::optional<SurfacePlace> place_under(const TriMesh& surface, const Points& normals, const Ray& ray);

/// `centre` moved outward until no triangle cuts the ball, because meshes are coarser than fingertips. Moves at most
/// two radii.
Vec3 seated_on(const Points& shown, const std::vector<std::array<VertexId, 3>>& triangles, const Vec3& centre,
    double radius, const Vec3& outward);

/// The outline of a template as line segments.
std::vector<std::array<Vec3, 2>> outline_of(const haptics::ElasticTemplate& shape);

} // namespace retractor::planner
