#include "datasets/phantoms/elastic_model.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets {

void check_elastic_model(const ElasticModel& model)
{
    mesh::check_mesh(model.mesh);
    if (model.mesh.tet_count() == 0)
        throw InputError("the body has no elements", "mesh");
    if (model.roles.size() != model.mesh.vertex_count())
        throw InputError("there must be one role per vertex", "roles");
    if (model.youngs_modulus.size() != model.mesh.tet_count() || model.poissons_ratio.size() != model.mesh.tet_count())
        throw InputError("there must be one Young's modulus and one Poisson's ratio per element", "elasticity");
    for (std::size_t t = 0; t < model.mesh.tet_count(); ++t) {
        const double E = model.youngs_modulus[t], nu = model.poissons_ratio[t];
        if (!(std::isfinite(E) && E > 0.0))
            throw InputError("Young's modulus must be positive and finite, not " + std::to_string(E) + " MPa",
                "element " + std::to_string(t));
        if (!(nu > -1.0 && nu < 0.5))
            throw InputError("Poisson's ratio must lie between -1 and 0.5, not at " + std::to_string(nu),
                "element " + std::to_string(t));
    }
    if (std::find(model.roles.begin(), model.roles.end(), VertexRole::fixed) == model.roles.end())
        throw InputError("no vertex is fixed: the body would float", "roles");
}

bool has_inner_wall(const ElasticModel& model)
{
    return std::find(model.roles.begin(), model.roles.end(), VertexRole::inner_wall) != model.roles.end();
}

const TouchSite& PalpationScene::site(const std::string& wanted) const
{
    std::string names;
    for (const TouchSite& s : sites) {
        if (s.name == wanted)
            return s;
        names += (names.empty() ? "" : ", ") + s.name;
    }
    throw InputError("has no site \"" + wanted + "\"; there is " + (names.empty() ? "none" : names), name);
}

} // namespace retractor::datasets
