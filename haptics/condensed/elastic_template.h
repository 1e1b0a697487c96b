#pragma once
// Boxes and spheres that give the tissue inside them another elasticity or another role (held, under blood pressure, or
// free). Units mm, MPa.

#include "datasets/phantoms/elastic_model.h"

#include <optional>

namespace retractor::haptics {

struct ElasticTemplate {
    enum class Shape { box, sphere };
    Shape shape = Shape::box;
    Vec3 centre = Vec3::Zero();
    Vec3 half_size { 10.0, 10.0, 10.0 }; ///< half sizes of the box along its axes; the first is the radius of a sphere
    Mat3 axes = Mat3::Identity(); ///< columns: axes of the box, a rotation
    std::optional<double> youngs_modulus {}, poissons_ratio {}; ///< MPa, -; an absent value leaves the model's value
    std::optional<datasets::VertexRole> role {}; ///< new role of the vertices inside

    bool contains(const Vec3& point) const;
    bool operator==(const ElasticTemplate&) const = default;
};

/// Elements with their centroid inside take the template's values; vertices inside take its role.
/// @return the number of changed elements plus, when the template has a role, of vertices inside
/// @throws InputError on sizes that are not positive, axes that are no rotation, values out of range, neither values
/// nor role, or a role that would leave no vertex fixed; the model is unchanged then
std::size_t apply(const ElasticTemplate& edit, datasets::ElasticModel& model);

} // namespace retractor::haptics
