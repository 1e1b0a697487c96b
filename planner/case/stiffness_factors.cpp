#include "planner/case/stiffness_factors.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/bones/bone_limits.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    double factor_of(const StiffnessFactors& factors, std::string_view name)
    {
        const auto found = factors.find(name);
        return found == factors.end() ? 1.0 : found->second;
    }

} // namespace

std::vector<std::string> stiffness_names(const Case& planned_case)
{
    std::vector<std::string> names;
    for (const mesh::LabelInfo& info : planned_case.label_table)
        if (mesh::is_wall(info) && std::ranges::find(names, info.material) == names.end())
            names.push_back(info.material);
    names.emplace_back(kJointSprings);
    names.emplace_back(kGirdleSprings);
    return names;
}

void check_stiffness_factors(const Case& planned_case, const StiffnessFactors& factors)
{
    if (factors.empty())
        return;
    if (planned_case.solution.elasticity == fem::Elasticity::hyperelastic)
        throw InputError("the laws of hyperelastic materials have more than one modulus", stiffness_text(factors));
    const std::vector<std::string> names = stiffness_names(planned_case);
    for (const auto& [name, factor] : factors) {
        const std::string where = stiffness_text({ { name, factor } });
        if (std::ranges::find(names, name) == names.end())
            throw InputError("nothing of the wall has this stiffness; there are " + joined(names), where);
        if (!(factor >= kLeastStiffnessFactor && factor <= kMostStiffnessFactor))
            throw InputError(
                formatted("a factor lies between %g and %g", kLeastStiffnessFactor, kMostStiffnessFactor), where);
    }
}

void scale_materials(const StiffnessFactors& factors, std::vector<fem::Material>& materials)
{
    for (fem::Material& material : materials)
        material.youngs_modulus_MPa *= factor_of(factors, material.name);
}

void scale_springs(const StiffnessFactors& factors, const mesh::LabelTable& table, fem::ElasticProblem& problem)
{
    const double joint = factor_of(factors, kJointSprings), girdle = factor_of(factors, kGirdleSprings);
    if (joint == 1.0 && girdle == 1.0)
        return;
    const std::vector<std::uint8_t> on_rib = vertices_on_ribs(problem.mesh, table);
    for (fem::BeddedVertex& bedded : problem.supports.bedded)
        bedded.stiffness *= on_rib[static_cast<std::size_t>(bedded.vertex)] != 0 ? joint : girdle;
    for (fem::Hinge& hinge : problem.supports.hinges) {
        hinge.stiffness *= joint;
        hinge.stop_stiffness *= joint;
    }
}

std::string stiffness_text(const StiffnessFactors& factors)
{
    std::string text;
    for (const auto& [name, factor] : factors)
        text += (text.empty() ? "" : ",") + name + "=" + formatted("%.6g", factor);
    return text;
}

std::vector<std::uint8_t> vertices_on_ribs(const mesh::TetMesh& mesh, const mesh::LabelTable& table)
{
    const mesh::LabelFlags is_rib_label
        = mesh::flagged_labels(table, [](const mesh::LabelInfo& info) { return is_rib(info.name); });
    std::vector<std::uint8_t> on_rib(mesh.vertex_count(), 0);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (is_rib_label[mesh.labels[static_cast<std::size_t>(t)]] != 0)
            for (const VertexId v : mesh.tet(t))
                on_rib[static_cast<std::size_t>(v)] = 1;
    return on_rib;
}

} // namespace retractor::planner
