#include "fem/statics/elastic_problem.h"

#include "fem/material/element_fibres.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    /// @throws InputError naming the first element whose label has no material.
    void check_labels(const mesh::TetMesh& mesh, std::span<const Material> material_of_label)
    {
        for (std::size_t t = 0; t < mesh.tet_count(); ++t)
            if (mesh.labels[t] >= material_of_label.size())
                throw InputError(
                    "label " + std::to_string(mesh.labels[t]) + " has no material", "element " + std::to_string(t));
    }

    void check_node(const mesh::TetMesh& mesh, VertexId node, const std::string& where)
    {
        if (node < 0 || static_cast<std::size_t>(node) >= mesh.vertex_count())
            throw InputError("node " + std::to_string(node) + " is out of range", where);
    }

    void check_hook(const mesh::TetMesh& mesh, const HookPatch& hook)
    {
        const std::string where = "hook '" + hook.name + "'";
        if (hook.nodes.empty())
            throw InputError("the hook's patch has no nodes", where);
        if (!hook.displacement.allFinite())
            throw InputError("the hook's displacement is not finite", where);
        constexpr double kProper = 1e-9; // round-off of a product of rotations
        if (!hook.rotation.allFinite() || !hook.pivot.allFinite()
            || !((hook.rotation.transpose() * hook.rotation - Mat3::Identity()).norm() < kProper)
            || !(hook.rotation.determinant() > 0.0))
            throw InputError("the hook's turn is not a rotation about a finite pivot", where);
        for (const VertexId v : hook.nodes)
            check_node(mesh, v, where);
    }

} // namespace

Prescribed prescribe(const mesh::TetMesh& mesh, const Supports& supports, std::span<const HookPatch> hooks)
{
    const std::size_t n = mesh.vertex_count();
    Prescribed all { std::vector<std::uint8_t>(3 * n, 0), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * n)), {},
        std::vector<int>(n, -1) };
    const auto hold = [&](VertexId v, const Vec3& value) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            all.flag[3 * static_cast<std::size_t>(v) + axis] = 1;
        all.value.segment<3>(3 * static_cast<Eigen::Index>(v)) = value;
        all.nodes.push_back(v);
    };
    for (const VertexId v : supports.fixed) {
        check_node(mesh, v, "supports");
        hold(v, Vec3::Zero());
    }
    for (std::size_t h = 0; h < hooks.size(); ++h) {
        check_hook(mesh, hooks[h]);
        for (const VertexId v : hooks[h].nodes) {
            const auto i = static_cast<std::size_t>(v);
            const int owner = all.hook_of_node[i];
            const Vec3 moved = hooks[h].displacement_of(mesh.vertices.row(v).transpose());
            if (all.flag[3 * i] != 0 && all.value.segment<3>(3 * static_cast<Eigen::Index>(v)) != moved)
                throw InputError("node " + std::to_string(v) + " is already held by "
                        + (owner < 0 ? std::string("a support")
                                     : "hook '" + hooks[static_cast<std::size_t>(owner)].name + "'")
                        + ", which moves it otherwise",
                    "hook '" + hooks[h].name + "'");
            hold(v, moved);
            if (owner < 0)
                all.hook_of_node[i] = static_cast<int>(h);
        }
    }
    return all;
}

void add_blade(ElasticProblem& problem, std::size_t hook, std::span<const mesh::TetFace> lip,
    std::span<const mesh::TetFace> bone, const BladePlace& place)
{
    RETRACTOR_ASSERT(hook < problem.hooks.size() && problem.mesh.nodes_per_tet == 4);
    mesh::TetMesh& mesh = problem.mesh;
    const std::array<Vec3, 3> at = blade_nodes(place);
    const auto first = static_cast<VertexId>(mesh.vertices.rows());
    const std::array<VertexId, 3> nodes { first, first + 1, first + 2 };
    BladeSurface blade
        = make_blade_surface(mesh, element_parameters(mesh, problem.material_of_label), lip, bone, place, nodes);
    mesh.vertices.conservativeResize(first + 3, 3);
    for (std::size_t i = 0; i < at.size(); ++i)
        mesh.vertices.row(nodes[i]) = at[i].transpose();
    problem.hooks[hook].nodes.assign(nodes.begin(), nodes.end());
    problem.blades.push_back(std::move(blade));
}

Points with_blade_nodes(const ElasticProblem& problem, const Points& displacement)
{
    Eigen::Index count = displacement.rows();
    for (const BladeSurface& blade : problem.blades)
        for (const VertexId v : blade.nodes)
            count = std::max<Eigen::Index>(count, v + 1);
    Points all = displacement;
    all.conservativeResize(count, 3);
    for (const BladeSurface& blade : problem.blades)
        for (const HookPatch& hook : problem.hooks)
            if (std::ranges::equal(hook.nodes, blade.nodes))
                for (const VertexId v : blade.nodes)
                    all.row(v) = hook.displacement_of(problem.mesh.vertices.row(v).transpose()).transpose();
    return all;
}

std::vector<Label> labels_met(const mesh::TetMesh& mesh)
{
    const std::set<Label> met(mesh.labels.begin(), mesh.labels.end());
    return { met.begin(), met.end() };
}

std::vector<Lame> element_parameters(const mesh::TetMesh& mesh, std::span<const Material> material_of_label)
{
    check_labels(mesh, material_of_label);
    std::vector<Lame> of_label(material_of_label.size());
    for (const Label label : labels_met(mesh))
        of_label[label] = lame(material_of_label[label]);
    std::vector<Lame> of_element;
    of_element.reserve(mesh.tet_count());
    for (const Label label : mesh.labels)
        of_element.push_back(of_label[label]);
    return of_element;
}

HyperelasticTissue hyperelastic_tissue(const mesh::TetMesh& mesh, std::span<const Material> material_of_label)
{
    check_labels(mesh, material_of_label);
    HyperelasticTissue tissue;
    std::vector<std::int32_t> law_of_label(material_of_label.size(), -1);
    for (const Label label : labels_met(mesh)) {
        law_of_label[label] = static_cast<std::int32_t>(tissue.laws.size());
        tissue.laws.push_back(hyperelastic_law(material_of_label[label]));
    }
    tissue.law_of_element.reserve(mesh.tet_count());
    tissue.fibres.reserve(mesh.tet_count());
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const Label label = mesh.labels[static_cast<std::size_t>(t)];
        tissue.law_of_element.push_back(law_of_label[label]);
        const Material& material = material_of_label[label];
        if (!material.law || !has_fibres(material.law->law)) {
            tissue.fibres.emplace_back();
            continue;
        }
        try {
            tissue.fibres.push_back(element_fibres(mesh, t, *material.law));
        } catch (const InputError& error) {
            throw InputError(error.what(), "material '" + material.name + "', " + error.where());
        }
    }
    return tissue;
}

ElasticBody tissue_body(
    const mesh::TetMesh& mesh, std::span<const Material> material_of_label, const TissueModel& model)
{
    ElasticBody body = model.elasticity == Elasticity::hyperelastic
        ? ElasticBody(mesh, hyperelastic_tissue(mesh, material_of_label))
        : ElasticBody(mesh, model.elasticity, element_parameters(mesh, material_of_label));
    if (model.locking_free)
        body.avoid_locking();
    return body;
}

std::vector<double> bed_stiffness(const mesh::TetMesh& mesh, const Supports& supports)
{
    if (supports.bedded.empty())
        return {};
    std::vector<double> bed(mesh.vertex_count(), 0.0);
    for (const BeddedVertex& bedded : supports.bedded) {
        check_node(mesh, bedded.vertex, "supports");
        const std::string where = "bed of node " + std::to_string(bedded.vertex);
        if (!(bedded.stiffness > 0.0 && std::isfinite(bedded.stiffness)))
            throw InputError("a bed's stiffness must be positive", where);
        double& here = bed[static_cast<std::size_t>(bedded.vertex)];
        if (here != 0.0)
            throw InputError("a node is bedded at most once", where);
        here = bedded.stiffness;
    }
    return bed;
}

void set_springs(ElasticBody& body, const Supports& supports)
{
    body.set_bed(bed_stiffness(body.mesh(), supports));
    body.set_hinges(supports.hinges);
}

ExternalLoads external_loads(const ElasticProblem& problem)
{
    ExternalLoads loads;
    if (!problem.loads.empty())
        loads.nodal = traction_loads(problem.mesh, problem.loads);
    for (const SurfacePressure& pressure : problem.pressures)
        loads.pressures.emplace_back(problem.mesh, pressure.faces, pressure.pressure);
    return loads;
}

Eigen::VectorXd nodal_loads(const ElasticProblem& problem)
{
    ExternalLoads loads = external_loads(problem);
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
    for (const FollowerPressure& pressure : loads.pressures)
        loads.nodal = (loads.nodal.size() == 0 ? rest : loads.nodal) + pressure.force(rest);
    return std::move(loads.nodal);
}

void check_problem(const ElasticProblem& problem)
{
    mesh::check_mesh(problem.mesh);
    if (problem.mesh.tet_count() == 0)
        throw InputError("the mesh has no elements");
    (void)element_parameters(problem.mesh, problem.material_of_label);
    (void)bed_stiffness(problem.mesh, problem.supports);
    check_hinges(problem.mesh, problem.supports.hinges);
    (void)prescribe(problem.mesh, problem.supports, problem.hooks);
    (void)external_loads(problem);
}

std::vector<Vec3> hook_forces(const Eigen::VectorXd& nodal_forces, const Prescribed& prescribed, std::size_t hooks)
{
    RETRACTOR_ASSERT(nodal_forces.size() == 3 * static_cast<Eigen::Index>(prescribed.hook_of_node.size()));
    std::vector<Vec3> forces(hooks, Vec3::Zero());
    for (std::size_t v = 0; v < prescribed.hook_of_node.size(); ++v)
        if (const int hook = prescribed.hook_of_node[v]; hook >= 0)
            forces[static_cast<std::size_t>(hook)] += nodal_forces.segment<3>(3 * static_cast<Eigen::Index>(v));
    return forces;
}

Eigen::MatrixXd hook_motions(const Prescribed& prescribed, std::size_t hooks)
{
    const std::vector<int>& hook_of_node = prescribed.hook_of_node;
    Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(
        3 * static_cast<Eigen::Index>(hook_of_node.size()), 3 * static_cast<Eigen::Index>(hooks));
    for (std::size_t v = 0; v < hook_of_node.size(); ++v)
        if (const int hook = hook_of_node[v]; hook >= 0)
            motions.block<3, 3>(3 * static_cast<Eigen::Index>(v), 3 * hook).setIdentity();
    return motions;
}

} // namespace retractor::fem
