// Unusual cases: other units, extremely soft tissue, hooks that contradict each other, a hooked piece that comes off.

#include "tests/verification/stability/stability_families.h"

#include "fem/interactive/online_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/stability.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <utility>

namespace retractor::verification {

namespace {

    fem::Material strange_tissue(double youngs_modulus = 0.04)
    {
        return { "tissue", youngs_modulus, 0.45, 1e-9, "verification" };
    }

    fem::ElasticProblem opened_block(const Vec3& pull = Vec3(0.0, 2.0, 0.5))
    {
        const IncisedBlock block;
        return hooked_open(block, incise(uncut_block(block), incision_blade(block)), strange_tissue(), pull);
    }

    fem::OpeningResult open(const fem::ElasticProblem& problem, fem::Elasticity elasticity, const Job& job)
    {
        fem::Opening opening(
            problem.mesh, problem.material_of_label, problem.supports, { .elasticity = elasticity, .tolerance = 1e-6 });
        return opening.open(problem.hooks, job);
    }

    /// The same body in other units of length: positions and displacements scale equally.
    void scaled(StabilityRow& row, double scale, fem::Elasticity elasticity, const Job& job)
    {
        const fem::ElasticProblem problem = opened_block();
        fem::ElasticProblem other = problem;
        other.mesh.vertices *= scale;
        for (fem::HookPatch& hook : other.hooks)
            hook.displacement *= scale;
        const fem::OpeningResult expected = open(problem, elasticity, job), result = open(other, elasticity, job);
        row.residual = result.residual;
        set_condition(row, other, elasticity, result.displacement);
        row.quantity = "displacement against the same body in millimetres, over the largest";
        row.error = (result.displacement / scale - expected.displacement).cwiseAbs().maxCoeff()
            / expected.displacement.cwiseAbs().maxCoeff();
        row.bound = elasticity == fem::Elasticity::linear ? 1e-10 : 1e-3; // error that the tolerance leaves
        if (result.status != fem::OpeningStatus::converged)
            refuse(row, result.message);
    }

    /// One element with a label of its own and nearly no stiffness.
    void soft_element(StabilityRow& row, double youngs_modulus, const Job& job)
    {
        fem::ElasticProblem problem = opened_block();
        problem.mesh.labels.at(problem.mesh.tet_count() / 2) = 2;
        problem.material_of_label.resize(3, strange_tissue(youngs_modulus));
        problem.material_of_label[2] = strange_tissue(youngs_modulus);
        const fem::OpeningResult result = open(problem, fem::Elasticity::corotational, job);
        row.residual = result.residual;
        set_condition(row, problem, fem::Elasticity::corotational, result.displacement);
        row.quantity = "hook force against the whole block's, relative";
        row.error = std::abs(result.hook_forces_N[0].norm()
                / open(opened_block(), fem::Elasticity::corotational, job).hook_forces_N[0].norm()
            - 1.0);
        row.bound = 0.05; // effect of one of several thousand elements
        if (result.status != fem::OpeningStatus::converged)
            refuse(row, result.message);
    }

    /// Two hooks on the same vertices.
    void contradicting(StabilityRow& row, const Job& job)
    {
        fem::ElasticProblem problem = opened_block();
        problem.hooks.push_back(problem.hooks[1]);
        problem.hooks.back().name = "another";
        problem.hooks.back().displacement *= 2.0;
        row.residual = open(problem, fem::Elasticity::corotational, job).residual;
        row.error = 0.0;
    }

    struct OnlineBlock {
        IncisedBlock block;
        mesh::TetMesh mesh = uncut_block(block);
        mesh::CutSession session { mesh };
        fem::Supports supports;
        fem::OnlineHook hook;

        OnlineBlock()
        {
            for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
                const Vec3 p = mesh.vertices.row(v).transpose();
                if (p.z() < 1e-6)
                    supports.fixed.push_back(v);
                else if (p.z() > block.size.z() - 1e-6 && (p - 0.5 * block.size).head<2>().cwiseAbs().maxCoeff() < 5.1)
                    hook.nodes.push_back(v);
            }
            hook.name = "one";
        }
        fem::OnlineOpening opening()
        {
            return { session, std::vector<fem::Material>(2, strange_tissue()), supports, {} };
        }
    };

    void contradicting_online(StabilityRow& row)
    {
        OnlineBlock scene;
        fem::OnlineOpening opening = scene.opening();
        scene.hook.drive.displacement = Vec3(0.0, 0.0, 1.0);
        (void)opening.attach(scene.hook);
        scene.hook.name = "another";
        scene.hook.drive.displacement = Vec3(0.0, 0.0, -1.0);
        (void)opening.attach(scene.hook);
        const fem::OnlineAnswer answer = opening.answer();
        row.residual = answer.residual;
        row.error = 0.0;
        if (answer.status != fem::OnlineStatus::solved)
            refuse(row, answer.message);
    }

    /// The piece that a hook pulls with a force comes off: nothing carries the force any more.
    void freed_by_force(StabilityRow& row)
    {
        OnlineBlock scene;
        fem::OnlineOpening opening = scene.opening();
        scene.hook.drive.force_N = Vec3(0.0, 0.2, 0.5);
        (void)opening.attach(scene.hook);
        const double z = 0.62 * scene.block.size.z();
        const mesh::CutResult cut
            = scene.session.cut({ .line = { Vec3(-5.0, -2.0, z), Vec3(scene.block.size.x() + 5.0, -2.0, z) },
                .directions = { Vec3::UnitY() },
                .depth_mm = scene.block.size.y() + 10.0 });
        opening.follow(cut.delta);
        set_condition(row,
            problem_now(scene.session, std::vector<fem::Material>(2, strange_tissue()), scene.supports, {}),
            fem::Elasticity::linear);
        fem::OnlineAnswer answer = opening.answer();
        if (answer.status != fem::OnlineStatus::solved)
            return refuse(row, answer.message);
        opening.complete(answer);
        row.residual = answer.residual;
        row.quantity = "largest displacement, mm: nothing bears the force";
        row.error = answer.displacement.cwiseAbs().maxCoeff();
        row.bound = 0.0;
    }

    std::string scale_name(double scale)
    {
        std::array<char, 64> text {};
        (void)std::snprintf(text.data(), text.size(), "the same body %g times as large", scale);
        return text.data();
    }

} // namespace

StabilityCase strange_case()
{
    return { "nobody's list", "other units, hardly any stiffness, contradictions, a hooked piece that comes off",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            // Hook displacements are divided into steps of at most 3 mm; a displacement 1e3 times as large would need
            // 800 steps.
            for (const auto& [scale, elasticity, name] : { std::tuple { 1e-3, fem::Elasticity::linear, "P1, linear" },
                     std::tuple { 1e-6, fem::Elasticity::linear, "P1, linear" },
                     std::tuple { 1e3, fem::Elasticity::linear, "P1, linear" },
                     std::tuple { 1e-3, fem::Elasticity::corotational, "P1, corotational" },
                     std::tuple { 1e-6, fem::Elasticity::corotational, "P1, corotational" },
                     std::tuple { 1e2, fem::Elasticity::corotational, "P1, corotational" } })
                rows.push_back(attempt(scale_name(scale), name,
                    [&, s = scale, e = elasticity](StabilityRow& row) { scaled(row, s, e, job); }));
            rows.push_back(attempt("one element with E = 1e-12 MPa", "P1, corotational",
                [&](StabilityRow& row) { soft_element(row, 1e-12, job); }));
            rows.push_back(expect_refusal("two hooks on one patch, elsewhere", "opening", "another",
                [&](StabilityRow& row) { contradicting(row, job); }));
            rows.push_back(expect_refusal("two hooks on one patch, elsewhere", "online opening", "another",
                [](StabilityRow& row) { contradicting_online(row); }));
            rows.push_back(expect_refusal("drawn by a force, and cut off", "online opening",
                "no equilibrium of the hooks", [](StabilityRow& row) { freed_by_force(row); }));
            return rows;
        } };
}

} // namespace retractor::verification
