#include "fem/error_estimation/error_estimate.h"

#include "fem/error_estimation/body_estimate.h"
#include "fem/error_estimation/gradient_recovery.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {

namespace {

    constexpr int kNobody = -2, kSupport = -1; // values >= 0 are the index of a hook

    std::vector<int> holders(const ElasticProblem& problem)
    {
        std::vector<int> holder(problem.mesh.vertex_count(), kNobody);
        for (std::size_t h = 0; h < problem.hooks.size(); ++h)
            for (const VertexId v : problem.hooks[h].nodes)
                holder[static_cast<std::size_t>(v)] = static_cast<int>(h);
        for (const VertexId v : problem.supports.fixed)
            holder[static_cast<std::size_t>(v)] = kSupport;
        return holder;
    }

    /// Whether the same holder holds all of the vertices.
    template <class Vertices> int common_holder(const std::vector<int>& holder, const Vertices& vertices)
    {
        const int first = holder[static_cast<std::size_t>(vertices[0])];
        for (const VertexId v : vertices)
            if (holder[static_cast<std::size_t>(v)] != first)
                return kNobody;
        return first;
    }

    void check_answer(const ElasticProblem& problem, const Points& displacement)
    {
        if (problem.mesh.nodes_per_tet != 4)
            throw InputError("the error is estimated for four-node elements, by ten-node ones", "nodes_per_tet");
        if (displacement.rows() != problem.mesh.vertices.rows())
            throw InputError("there must be one displacement per node", "displacement");
        if (!displacement.allFinite())
            throw InputError("a displacement is not finite", "displacement");
    }

    void check_held(const Prescribed& prescribed, const Eigen::VectorXd& u)
    {
        constexpr double kRoundOff = 1e-9; // relative to the largest displacement
        const double room = kRoundOff * std::max(u.cwiseAbs().maxCoeff(), prescribed.value.cwiseAbs().maxCoeff());
        for (const VertexId v : prescribed.nodes) {
            const auto at = 3 * static_cast<Eigen::Index>(v);
            if ((u.segment<3>(at) - prescribed.value.segment<3>(at)).norm() > room)
                throw InputError("the answer is not where a support or hook holds it", "node " + std::to_string(v));
        }
    }

    ElasticBody body_of(const ElasticProblem& problem, Elasticity elasticity)
    {
        ElasticBody body = tissue_body(problem.mesh, problem.material_of_label, { elasticity });
        set_springs(body, problem.supports);
        if (ExternalLoads loads = external_loads(problem); !loads.empty())
            body.set_loads(std::move(loads));
        if (!problem.blades.empty())
            body.set_blades(BladeContact(problem.mesh, problem.blades));
        return body;
    }

} // namespace

ElasticProblem with_midpoints(const ElasticProblem& problem, std::span<const std::uint8_t> elements)
{
    ElasticProblem fine = problem;
    fine.mesh = with_midpoints(problem.mesh, elements);
    const auto corners = static_cast<VertexId>(problem.mesh.vertex_count());
    const std::vector<int> holder = holders(problem);
    std::vector<int> midpoint_holder(fine.mesh.vertex_count() - problem.mesh.vertex_count(), kNobody);
    const auto hold = [&](TetId t, int by, int but_corner) {
        const auto nodes = fine.mesh.tet(t);
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
            if (mesh::kTetEdges[e][0] != but_corner && mesh::kTetEdges[e][1] != but_corner
                && !mesh::is_straight(nodes, e))
                midpoint_holder[static_cast<std::size_t>(nodes[4 + e] - corners)] = by;
    };
    for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t)
        if (const int by = common_holder(holder, problem.mesh.tet(t)); by != kNobody)
            hold(t, by, -1);
    for (const mesh::TetFace& face : mesh::boundary_faces(problem.mesh))
        if (const int by = common_holder(holder, mesh::face_vertices(problem.mesh, face)); by != kNobody)
            hold(face.tet, by, face.corner);
    for (std::size_t e = 0; e < midpoint_holder.size(); ++e) {
        const auto v = static_cast<VertexId>(static_cast<std::size_t>(corners) + e);
        if (midpoint_holder[e] == kSupport)
            fine.supports.fixed.push_back(v);
        else if (midpoint_holder[e] >= 0)
            fine.hooks[static_cast<std::size_t>(midpoint_holder[e])].nodes.push_back(v);
    }
    return fine;
}

ElasticProblem without_midpoints(const ElasticProblem& problem)
{
    constexpr std::size_t kCorners = 4;
    ElasticProblem coarse = problem;
    coarse.mesh.nodes_per_tet = kCorners;
    coarse.mesh.nodes.clear();
    for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t) {
        const auto corners = problem.mesh.tet(t).first(kCorners);
        coarse.mesh.nodes.insert(coarse.mesh.nodes.end(), corners.begin(), corners.end());
    }
    VertexId count = 1 + *std::max_element(coarse.mesh.nodes.begin(), coarse.mesh.nodes.end());
    for (const BladeSurface& blade : coarse.blades)
        count = std::max(count, 1 + *std::max_element(blade.nodes.begin(), blade.nodes.end()));
    coarse.mesh.vertices.conservativeResize(count, 3);
    const auto beyond = [count](VertexId v) { return v >= count; };
    std::erase_if(coarse.supports.fixed, beyond);
    for (HookPatch& hook : coarse.hooks)
        std::erase_if(hook.nodes, beyond);
    return coarse;
}

double ten_node_share(
    const ElasticProblem& problem, Elasticity elasticity, const Eigen::VectorXd& ten_node, const Points& plain)
{
    const Eigen::VectorXd corners = Eigen::Map<const Eigen::VectorXd>(plain.data(), plain.size());
    return kRecoverySafety
        * share_left(
            problem.mesh, elasticity, element_parameters(problem.mesh, problem.material_of_label), ten_node, corners);
}

ErrorEstimate estimate_error(const ElasticProblem& problem, Elasticity elasticity, const Points& displacement,
    const Job& job, const std::optional<ContactOptions>& contact)
{
    const Stopwatch watch;
    check_problem(problem);
    check_answer(problem, displacement);
    const Prescribed coarse_held = prescribe(problem.mesh, problem.supports, problem.hooks);
    const Eigen::VectorXd answer = Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
    check_held(coarse_held, answer);

    ElasticBody coarse_body = body_of(problem, elasticity);
    if (contact) {
        constexpr double kStiffer = 10.0;
        ContactOptions stiffer = *contact;
        stiffer.stiffness *= kStiffer;
        coarse_body.set_contact(
            Contact(problem.mesh, element_parameters(problem.mesh, problem.material_of_label), std::move(stiffer)));
        (void)coarse_body.find_contact(answer);
    }
    const ElasticProblem fine = with_midpoints(problem);
    const Prescribed held = prescribe(fine.mesh, fine.supports, fine.hooks);
    ElasticBody fine_body = body_of(fine, elasticity);
    BodyEstimate step = estimate_error(coarse_body, coarse_held.flag, fine_body, held.flag, answer, job);
    ErrorEstimate estimate { .status = step.status,
        .message = step.message,
        .displacement = {},
        .hook_forces_N = {},
        .ten_node = {},
        .plain = {},
        .plain_forces_N = {},
        .energy_error = step.energy_error,
        .algebraic_error = step.algebraic_error,
        .iterations = step.iterations };
    if (step.status == EstimateStatus::done) {
        estimate.displacement = Eigen::Map<const Points>(step.displacement.data(), problem.mesh.vertices.rows(), 3);
        estimate.hook_forces_N = hook_forces(step.forces, held, problem.hooks.size());
        estimate.plain = Eigen::Map<const Points>(step.coarse_displacement.data(), problem.mesh.vertices.rows(), 3);
        estimate.plain_forces_N = hook_forces(step.coarse_forces, coarse_held, problem.hooks.size());
        estimate.ten_node = std::move(step.displacement);
    }
    record_part(job, "error estimate", watch, step.bytes);
    job.report("error estimate", 1.0);
    return estimate;
}

} // namespace retractor::fem
