#include "haptics/condensed/elastic_template.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

    void check(const ElasticTemplate& t)
    {
        constexpr const char* kWhere = "elasticity template";
        constexpr double kRotation = 1e-9; // round-off of three products
        const bool sphere = t.shape == ElasticTemplate::Shape::sphere;
        if (!t.centre.allFinite() || !t.half_size.allFinite() || !(t.half_size.x() > 0.0)
            || (!sphere && !(t.half_size.minCoeff() > 0.0)))
            throw InputError("its size must be positive and finite", kWhere);
        if (!((t.axes.transpose() * t.axes - Mat3::Identity()).cwiseAbs().maxCoeff() < kRotation))
            throw InputError("its axes must be a rotation", kWhere);
        if (t.youngs_modulus && !(std::isfinite(*t.youngs_modulus) && *t.youngs_modulus > 0.0))
            throw InputError("Young's modulus must be positive and finite", kWhere);
        if (t.poissons_ratio && !(*t.poissons_ratio > -1.0 && *t.poissons_ratio < 0.5))
            throw InputError("Poisson's ratio must lie between -1 and 0.5", kWhere);
        if (!t.youngs_modulus && !t.poissons_ratio && !t.role)
            throw InputError("it changes nothing: give it Young's modulus, Poisson's ratio or a role", kWhere);
    }

    std::size_t give_role(const ElasticTemplate& edit, datasets::ElasticModel& model)
    {
        std::vector<datasets::VertexRole> roles = model.roles;
        std::size_t inside = 0;
        for (std::size_t v = 0; v < roles.size(); ++v)
            if (edit.contains(model.mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose())) {
                roles[v] = *edit.role;
                ++inside;
            }
        if (std::find(roles.begin(), roles.end(), datasets::VertexRole::fixed) == roles.end())
            throw InputError("no vertex would be fixed any more: the body would float", "elasticity template");
        model.roles = std::move(roles);
        return inside;
    }

} // namespace

bool ElasticTemplate::contains(const Vec3& point) const
{
    const Vec3 from = point - centre;
    if (shape == Shape::sphere)
        return from.norm() <= half_size.x();
    return ((axes.transpose() * from).cwiseAbs().array() <= half_size.array()).all();
}

std::size_t apply(const ElasticTemplate& edit, datasets::ElasticModel& model)
{
    check(edit);
    std::size_t changed = edit.role ? give_role(edit, model) : 0;
    for (std::size_t t = 0; t < model.mesh.tet_count(); ++t) {
        Vec3 centroid = Vec3::Zero();
        const auto nodes = model.mesh.tet(static_cast<TetId>(t));
        for (std::size_t c = 0; c < 4; ++c)
            centroid += 0.25 * model.mesh.vertices.row(nodes[c]).transpose();
        if (!edit.contains(centroid))
            continue;
        ++changed;
        model.youngs_modulus[t] = edit.youngs_modulus.value_or(model.youngs_modulus[t]);
        model.poissons_ratio[t] = edit.poissons_ratio.value_or(model.poissons_ratio[t]);
    }
    return changed;
}

} // namespace retractor::haptics
