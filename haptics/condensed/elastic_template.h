#pragma once
// Boxes and spheres placed in a body to give what is inside them another elasticity, or another role: held, pressed by
// blood, or free. Units mm, MPa.

#include "datasets/phantoms/elastic_model.h"

#include <optional>

namespace retractor::haptics {

struct ElasticTemplate {
    enum class Shape { box, sphere };
    Shape shape = Shape::box;
    Vec3 centre = Vec3::Zero();
    Vec3 half_size { 10.0, 10.0, 10.0 }; ///< of the box along its axes; of the sphere the first is the radius
    Mat3 axes = Mat3::Identity(); ///< columns: the box's axes, a rotation
    std::optional<double> youngs_modulus {}, poissons_ratio {}; ///< MPa, -; what is not given stays
    std::optional<datasets::VertexRole> role {}; ///< of the vertices inside

    bool contains(const Vec3& point) const;
    bool operator==(const ElasticTemplate&) const = default;
};

/// Elements whose centroid lies inside take the template's values, vertices inside its role. @return how many elements
/// and, where there is a role, vertices that is.
/// @throws InputError on sizes that are not positive, axes that are no rotation, values out of their range, neither
/// values nor role, or a role that would leave no vertex fixed; the model is as it was then.
std::size_t apply(const ElasticTemplate& edit, datasets::ElasticModel& model);

} // namespace retractor::haptics
