#include "fem/statics/parameter_sensitivity.h"

#include "fem/statics/tissue_linearisation.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/QR>

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

namespace retractor::fem {

namespace {

    /// Springs or hinges of a parameter: each exists, and belongs to one parameter only.
    void check_members(const std::string& kind, const std::vector<std::size_t>& members, std::size_t count,
        const std::string& name, std::map<std::size_t, std::string>& owner)
    {
        const std::string where = "parameter '" + name + "'";
        for (const std::size_t member : members) {
            if (member >= count)
                throw InputError("there is no " + kind + " " + std::to_string(member), where);
            if (const auto [other, added] = owner.emplace(member, name); !added)
                throw InputError(
                    "the parameter '" + other->second + "' has the " + kind + " " + std::to_string(member) + " too",
                    where);
        }
    }

    void check(const ElasticProblem& problem, const Points& displacement,
        std::span<const StiffnessParameter> parameters, const Eigen::MatrixXd& motions)
    {
        if (displacement.rows() != problem.mesh.vertices.rows())
            throw InputError("there are " + std::to_string(displacement.rows()) + " displacements for "
                    + std::to_string(problem.mesh.vertices.rows()) + " nodes",
                "displacement");
        if (!displacement.allFinite())
            throw InputError("a displacement is not finite", "displacement");
        if (motions.rows() != 3 * displacement.rows())
            throw InputError("the motions need three rows for each node", "motions");
        const std::vector<Label> met = labels_met(problem.mesh);
        std::map<Label, std::string> of_label;
        std::map<std::size_t, std::string> of_spring, of_hinge;
        for (const StiffnessParameter& parameter : parameters) {
            const std::string where = "parameter '" + parameter.name + "'";
            if (parameter.labels.empty() && parameter.springs.empty() && parameter.hinges.empty())
                throw InputError("the parameter has neither a label nor a spring", where);
            for (const Label label : parameter.labels) {
                if (!std::binary_search(met.begin(), met.end(), label))
                    throw InputError("no element has the label " + std::to_string(label), where);
                if (const auto [other, added] = of_label.emplace(label, parameter.name); !added)
                    throw InputError(
                        "the parameter '" + other->second + "' has the label " + std::to_string(label) + " too", where);
            }
            check_members("spring", parameter.springs, problem.supports.bedded.size(), parameter.name, of_spring);
            check_members("hinge", parameter.hinges, problem.supports.hinges.size(), parameter.name, of_hinge);
        }
    }

    /// The part of the mesh with some labels; the nodes keep their numbers.
    mesh::TetMesh part_of(const mesh::TetMesh& mesh, const std::vector<Label>& labels)
    {
        mesh::TetMesh part {
            .vertices = mesh.vertices, .nodes_per_tet = mesh.nodes_per_tet, .nodes = {}, .labels = {}
        };
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Label label = mesh.labels[static_cast<std::size_t>(t)];
            if (std::find(labels.begin(), labels.end(), label) == labels.end())
                continue;
            const auto nodes = mesh.tet(t);
            part.nodes.insert(part.nodes.end(), nodes.begin(), nodes.end());
            part.labels.push_back(label);
        }
        return part;
    }

    /// The forces that are in proportion to a parameter, N, three per node: of its tissue, springs and hinges, less the
    /// loads of its tissue's tension.
    Eigen::VectorXd forces_of(const ElasticProblem& problem, const TissueModel& model,
        const StiffnessParameter& parameter, const Eigen::VectorXd& u)
    {
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(u.size());
        if (!parameter.labels.empty())
            forces = tissue_body(part_of(problem.mesh, parameter.labels), problem.material_of_label, model)
                         .response(u)
                         .forces;
        for (const std::size_t spring : parameter.springs) {
            const BeddedVertex& bedded = problem.supports.bedded[spring];
            const Eigen::Index row = 3 * static_cast<Eigen::Index>(bedded.vertex);
            forces.segment<3>(row) += bedded.stiffness * u.segment<3>(row);
        }
        const HingeAngle angle = model.elasticity == Elasticity::linear ? HingeAngle::linear : HingeAngle::swept;
        for (const std::size_t hinge : parameter.hinges)
            (void)add_hinge_response(problem.mesh, problem.supports.hinges[hinge], angle, u, forces);
        std::vector<FaceTraction> released;
        for (const FaceTraction& load : problem.loads) {
            const Label label = problem.mesh.labels[static_cast<std::size_t>(load.face.tet)];
            if (std::find(parameter.labels.begin(), parameter.labels.end(), label) != parameter.labels.end())
                released.push_back(load);
        }
        if (!released.empty())
            forces -= traction_loads(problem.mesh, released);
        return forces;
    }

    /// Sums nodal forces over the nodes of each hook, for each column.
    Eigen::MatrixXd of_hooks(const ElasticProblem& problem, const Eigen::MatrixXd& nodal)
    {
        Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(problem.hooks.size()), nodal.cols());
        std::vector<std::uint8_t> taken(problem.mesh.vertex_count(), 0); // the first hook of a node has its force
        for (std::size_t h = 0; h < problem.hooks.size(); ++h)
            for (const VertexId v : problem.hooks[h].nodes)
                if (std::exchange(taken[static_cast<std::size_t>(v)], std::uint8_t { 1 }) == 0)
                    sums.middleRows<3>(3 * static_cast<Eigen::Index>(h))
                        += nodal.middleRows<3>(3 * static_cast<Eigen::Index>(v));
        return sums;
    }

} // namespace

ParameterSensitivity parameter_sensitivity(const ElasticProblem& problem, const TissueModel& model,
    const Points& displacement, std::span<const StiffnessParameter> parameters, const Eigen::MatrixXd& motions,
    const std::optional<ContactOptions>& contact)
{
    check(problem, displacement, parameters, motions);
    TissueLinearisation tissue(problem, model, displacement, contact);
    const auto columns = static_cast<Eigen::Index>(parameters.size());
    Eigen::MatrixXd forces(tissue.state().size(), columns);
    for (Eigen::Index p = 0; p < columns; ++p)
        forces.col(p) = forces_of(problem, model, parameters[static_cast<std::size_t>(p)], tissue.state());
    ParameterSensitivity made { tissue.response(motions), tissue.solve(-forces), {} };
    made.nodal_forces_N = forces + tissue.forces_of(made.displacement);
    const std::vector<int>& hook_of_node = tissue.held().hook_of_node;
    for (std::size_t v = 0; v < hook_of_node.size(); ++v)
        if (hook_of_node[v] < 0) // a support, or a free node, where round-off is left
            made.nodal_forces_N.middleRows<3>(3 * static_cast<Eigen::Index>(v)).setZero();
    return made;
}

EquilibriumSensitivity with_held_hooks(const ElasticProblem& problem, const ParameterSensitivity& sensitivity)
{
    return { sensitivity.displacement, of_hooks(problem, sensitivity.nodal_forces_N) };
}

std::optional<EquilibriumSensitivity> with_driven_hooks(const ElasticProblem& problem,
    const ParameterSensitivity& sensitivity, const Eigen::VectorXd& at, const Eigen::VectorXd& forces,
    const std::vector<HookDrive>& drives)
{
    RETRACTOR_ASSERT(at.size() == 3 * static_cast<Eigen::Index>(drives.size()) && forces.size() == at.size());
    // The drives are no smooth equations, so that the derivative is a difference. Its step is far above the error of
    // rest_of_hooks() and small enough for hooks not to begin or end to yield.
    constexpr double kStep = 1e-3;
    const Eigen::MatrixXd R = definite(sensitivity.response.stiffness);
    const auto rest_under = [&](const Eigen::VectorXd& there) { return rest_of_hooks(R, there - R * at, drives); };
    const HookRest here = rest_under(forces);
    if (!here.converged)
        return std::nullopt;
    EquilibriumSensitivity made = with_held_hooks(problem, sensitivity);
    for (Eigen::Index p = 0; p < made.hook_forces_N.cols(); ++p) {
        const Eigen::VectorXd change = resisted(sensitivity.response.stiffness, made.hook_forces_N.col(p));
        const HookRest there = rest_under(forces + kStep * change);
        if (!there.converged)
            return std::nullopt;
        const Eigen::VectorXd way = (there.displacement - here.displacement) / kStep;
        made.displacement.col(p) += sensitivity.response.displacement * way;
        made.hook_forces_N.col(p) = change + R * way;
    }
    return made;
}

EquilibriumSensitivity with_balanced_frame(
    const ElasticProblem& problem, const ParameterSensitivity& sensitivity, const BalancedFrame& retractor)
{
    constexpr double kAtStop = 1e-6; // rad: the balance is solved to less
    constexpr double kNoStiffness = 1e-9; // relative to the stiffest motion, as the search of the balance takes it
    RETRACTOR_ASSERT(problem.hooks.size() == retractor.frame.size() && sensitivity.response.stiffness.rows() == 12);
    const double lever = frame_lever(problem.mesh, retractor.frame, problem.hooks);
    const FrameMatrix J
        = frame_stiffness(retractor.frame, retractor.state, retractor.loads, sensitivity.response.stiffness, lever);
    const auto B = blades_by_state(retractor.frame, retractor.state, lever);
    std::vector<int> free { 0, 1, 2 };
    if (!retractor.direction_is_held)
        free.insert(free.end(), { kFrameRotation, kFrameRotation + 1, kFrameRotation + 2 });
    for (std::size_t k = 0; k < retractor.frame.size(); ++k)
        if (std::abs(retractor.state.turn[k]) < retractor.frame[k].play - kAtStop)
            free.push_back(kFrameTurns + static_cast<int>(k));
    if (retractor.driven_by_force)
        free.push_back(kFrameDistance);
    const Eigen::MatrixXd of_free = J(free, free);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(kNoStiffness);
    solver.compute(of_free);
    EquilibriumSensitivity made = with_held_hooks(problem, sensitivity);
    for (Eigen::Index p = 0; p < made.displacement.cols(); ++p) {
        const FrameVector change = generalised_forces(retractor.frame, retractor.state,
            blade_loads(problem.mesh, problem.hooks, sensitivity.nodal_forces_N.col(p)), lever);
        FrameVector step = FrameVector::Zero();
        const Eigen::VectorXd moved = solver.solve(Eigen::VectorXd(-change(free)));
        step(free) = moved;
        const Eigen::VectorXd motion = B * step;
        made.displacement.col(p) += sensitivity.response.displacement * motion;
        const Eigen::VectorXd by_motion = sensitivity.response.stiffness * motion;
        for (Eigen::Index k = 0; k < 2; ++k)
            made.hook_forces_N.col(p).segment<3>(3 * k) += by_motion.segment<3>(6 * k);
    }
    return made;
}

} // namespace retractor::fem
