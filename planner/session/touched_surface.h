#pragma once
// Where fingers meet a surface, for the eye: what a ray from the eye touches at rest, and where a fingertip is drawn so
// that it lies on the tissue and not inside it. Units mm.

#include "haptics/condensed/elastic_template.h"
#include "planner/session/wall_picture.h"

#include <array>
#include <optional>
#include <vector>

namespace retractor::planner {

struct SurfacePlace {
    Vec3 point = Vec3::Zero();
    Vec3 outward = Vec3::UnitZ(); ///< unit, of the smooth surface
};

/// The first place that a ray meets on a side that faces it. @param normals vertex_normals().
std::optional<SurfacePlace> place_under(const TriMesh& surface, const Points& normals, const Ray& ray);

/// `centre` moved outward until no triangle cuts the ball: meshes are coarser than fingertips. At most by two radii.
Vec3 seated_on(const Points& shown, const std::vector<std::array<VertexId, 3>>& triangles, const Vec3& centre,
    double radius, const Vec3& outward);

/// The template's outline, as pieces of line.
std::vector<std::array<Vec3, 2>> outline_of(const haptics::ElasticTemplate& shape);

} // namespace retractor::planner
