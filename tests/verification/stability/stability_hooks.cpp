// Extreme hooks and states: hooks that pull too far, hooks that cross each other, an inverted start.

#include "tests/verification/stability/stability_families.h"

#include "fem/interactive/online_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/stability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace retractor::verification {

namespace {

    const fem::Material kTissue { "tissue", 0.04, 0.45, 1e-9, "verification" };

    std::string name_of(fem::Elasticity elasticity)
    {
        switch (elasticity) {
        case fem::Elasticity::linear:
            return "P1, linear";
        case fem::Elasticity::corotational:
            return "P1, corotational";
        case fem::Elasticity::hyperelastic:
            return "P1, neo-Hookean"; // the law of tissue without its own law
        case fem::Elasticity::corotational_linear:
            break; // Opening refuses this combination
        }
        return {};
    }

    /// The reason why an opening is not an answer, followed by the solver's own message.
    std::string reason_of(const fem::OpeningResult& result, std::size_t elements)
    {
        if (result.status != fem::OpeningStatus::inverted)
            return result.message;
        std::array<char, 256> text {};
        (void)std::snprintf(text.data(), text.size(),
            "%d of %zu elements would be inside out, which no tissue can be: displacements and forces are not to be "
            "used, though the equations are solved to %.1e",
            result.inverted_elements, elements, result.residual);
        return text.data();
    }

    /// An answer with inverted elements is not an answer, and the status must say so.
    void open(StabilityRow& row, const Vec3& pull, const fem::OpeningOptions& options, const Job& job)
    {
        const IncisedBlock block;
        const fem::ElasticProblem problem
            = hooked_open(block, incise(uncut_block(block), incision_blade(block)), kTissue, pull);
        fem::Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
        const fem::OpeningResult result = opening.open(problem.hooks, job);
        row.residual = result.residual;
        row.quantity = "elements inside out";
        row.error = result.inverted_elements;
        const bool finite = result.displacement.allFinite();
        set_condition(row, problem, options.elasticity, finite ? result.displacement : Points());
        if (result.status != fem::OpeningStatus::converged || !finite)
            return refuse(row, reason_of(result, problem.mesh.tet_count()));
        row.bound = 0.0;
        std::array<char, 256> text {};
        (void)std::snprintf(text.data(), text.size(),
            "an equilibrium of the law, not of tissue, which tears long before: elements have %.2g to %.2g times their "
            "volume; hook force %.3g N",
            result.min_volume_ratio, result.max_volume_ratio, result.hook_forces_N.front().norm());
        row.reason = text.data();
    }

    StabilityRow far_row(const char* name, const Vec3& pull, fem::Elasticity elasticity, const Job& job)
    {
        // A law with infinite energy for inverted elements cannot invert any. If such a solution ends early, the
        // status must say so.
        const std::string named = elasticity == fem::Elasticity::hyperelastic ? "of the hooks' displacement"
                                                                              : "elements would be inside out";
        return expect_answer_or_refusal(name, name_of(elasticity), named,
            [&](StabilityRow& r) { open(r, pull, { .elasticity = elasticity }, job); });
    }

    /// A session with a cut block and the hooks of hooked_open(), by the session's ids.
    struct OnlineIncision {
        IncisedBlock block;
        mesh::CutSession session { uncut_block(block) };
        std::vector<fem::Material> materials { kTissue, kTissue };
        fem::Supports supports;
        std::vector<fem::OnlineHook> hooks;

        OnlineIncision()
        {
            const mesh::CutResult cut = session.cut(incision_blade(block));
            if (cut.status != mesh::CutStatus::done)
                throw SolverError("the incision was not made: " + cut.message);
            mesh::SlotMap map;
            Incision incision { session.compact_mesh(&map), session.lips(), cut.report };
            for (mesh::LipFace& lip : incision.lips)
                lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
            const fem::ElasticProblem problem = hooked_open(block, incision, kTissue, Vec3::Zero());
            const auto of_session = [&](const std::vector<VertexId>& compact) {
                std::vector<VertexId> ids;
                for (const VertexId v : compact)
                    ids.push_back(map.vertex_slot[static_cast<std::size_t>(v)]);
                return ids;
            };
            supports.fixed = of_session(problem.supports.fixed);
            for (const fem::HookPatch& hook : problem.hooks)
                hooks.push_back({ .name = hook.name, .side = hook.side, .nodes = of_session(hook.nodes), .drive = {} });
        }
    };

    /// Hooks on the two lips in an open session stop where the lips meet. The answer there must be an equilibrium,
    /// both by a solution and by the columns of a drag.
    void push_together(StabilityRow& row, const fem::HookDrive& right, const fem::HookDrive& left)
    {
        // residual of an answer; and largest difference, relative to the largest displacement
        constexpr double kResidual = 1e-8, kSame = 1e-6;
        constexpr double kMet = 2e-6; // mm: overlap that rest_of_hooks_apart() leaves
        OnlineIncision cut;
        fem::OnlineOpening opening(cut.session, cut.materials, cut.supports, {});
        cut.hooks[0].drive = right;
        cut.hooks[1].drive = left;
        for (const fem::OnlineHook& hook : cut.hooks)
            (void)opening.attach(hook);
        fem::OnlineAnswer answer = opening.answer();
        if (answer.status == fem::OnlineStatus::solved)
            opening.complete(answer);
        if (answer.status != fem::OnlineStatus::solved)
            return refuse(row, answer.message);
        if (answer.meeting.size() != 1)
            throw PromiseNotKept("the hooks did not meet");
        row.residual = answer.residual;
        row.quantity = "lips past each other, or apart, mm";
        row.error = std::abs(
            fem::crossing_mm(answer.meeting[0], answer.hook_displacements.at(0), answer.hook_displacements.at(1)));
        row.bound = kMet;
        (void)opening.prepare_drag();
        const double apart = (opening.drag_answer().displacement - answer.displacement).cwiseAbs().maxCoeff();
        const double largest = answer.displacement.cwiseAbs().maxCoeff();
        if (answer.residual > kResidual || apart > kSame * largest)
            throw PromiseNotKept("no equilibrium where the hooks meet, or not the one that a drag finds");
        for (std::size_t i = 0; i < 2; ++i)
            cut.hooks[i].drive = { .displacement = answer.hook_displacements[i] };
        set_condition(row, problem_now(cut.session, cut.materials, cut.supports, cut.hooks), fem::Elasticity::linear);
        std::array<char, 160> text {};
        (void)std::snprintf(text.data(), text.size(),
            "stopped where the lips meet; tissue bears %.3g and %.3g N under them; a drag differs by %.1e of the "
            "largest "
            "displacement",
            answer.hook_forces_N.at(0).norm(), answer.hook_forces_N.at(1).norm(), apart / largest);
        row.reason = text.data();
    }

    /// Start states in which one vertex was moved out through the far side of its elements.
    void start_inside_out(StabilityRow& row, const VerificationLaw& law, const Job& job)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 4, 1.0);
        const Held held = hold_boundary(mesh, [](const Vec3&) { return Vec3(Vec3::Zero()); });
        fem::ElasticBody body = make_body(mesh, VerificationElement::p1, law);
        Eigen::VectorXd start = Eigen::VectorXd::Zero(held.target.size());
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices.row(v) == Eigen::RowVector3d(2.0, 2.0, 2.0))
                start.segment<3>(3 * v) = Vec3(1.3, 0.4, -1.2);
        row.unconditioned = Unconditioned::no_matrix; // a law without energy there has no stiffness either
        fem::EquilibriumSolver solver;
        const fem::Equilibrium rest
            = solver.solve(body, held.prescribed, held.target, start, { .tolerance = 1e-9 }, job);
        row.residual = rest.residual;
        row.quantity = "distance from rest, mm";
        row.error = rest.displacement.cwiseAbs().maxCoeff();
        row.bound = 1e-6; // a tolerance of 1e-9 on forces of a body with strains of 1
        if (rest.status != fem::EquilibriumStatus::converged)
            return refuse(row, "not converged: " + rest.message);
        set_condition(row, body.stiffness(rest.displacement, 0.0), held.prescribed);
    }

    void mesh_inside_out(StabilityRow& row)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 1.0);
        std::swap(mesh.nodes[4], mesh.nodes[5]);
        const fem::Opening opening(mesh, std::vector<fem::Material>(2, kTissue), { { 0, 1, 2 }, {} });
        row.residual = row.error = 0.0;
    }

} // namespace

StabilityCase far_hook_case()
{
    return { "hook pulled by 200 mm", "an incision of 30 mm: an answer without elements inside out, or a refusal",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            for (const fem::Elasticity elasticity :
                { fem::Elasticity::linear, fem::Elasticity::corotational, fem::Elasticity::hyperelastic }) {
                rows.push_back(far_row("hooks pulled aside by 200 mm", Vec3(0.0, 200.0, 0.0), elasticity, job));
                rows.push_back(far_row("hooks pulled out by 200 mm", Vec3(0.0, 20.0, 200.0), elasticity, job));
            }
            return rows;
        } };
}

StabilityCase crossing_hooks_case()
{
    return { "hooks pulled through each other", "lips do not pass through each other: refused, by name and distance",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            for (const fem::Elasticity elasticity : { fem::Elasticity::linear, fem::Elasticity::corotational })
                rows.push_back(expect_refusal("hooks pulled through each other", name_of(elasticity),
                    "would pass through each other",
                    [&](StabilityRow& r) { open(r, Vec3(0.0, -8.0, 0.0), { .elasticity = elasticity }, job); }));
            rows.push_back(expect_refusal("hooks pulled through each other", "P1, corotational, contact",
                "of the hooks' displacement", [&](StabilityRow& r) {
                    open(r, Vec3(0.0, -8.0, 0.0),
                        { .elasticity = fem::Elasticity::corotational, .contact = fem::ContactOptions {} }, job);
                }));
            return rows;
        } };
}

StabilityCase meeting_hooks_case()
{
    return { "hooks pushed together online",
        "while a session is open, hooks of every kind stop where their lips meet, in equilibrium (residual 1e-8)",
        [](const Job&) {
            const auto along = [](double mm) -> Vec3 { return { 0.0, mm, 0.0 }; };
            struct Pair {
                const char* kind;
                fem::HookDrive right, left; ///< the right lip lies at smaller y
            };
            const Pair pairs[] = {
                { "drawn", { .displacement = along(3.0) }, { .displacement = along(-1.0) } },
                { "by forces", { .force_N = along(0.6) }, { .force_N = along(-0.2) } },
                { "at a limit", { .displacement = along(3.0), .force_limit_N = 0.3 }, { .displacement = along(-1.0) } },
                { "softly gripped", { .displacement = along(3.0), .grip_N_per_mm = 0.3 },
                    { .displacement = along(-1.0) } },
            };
            std::vector<StabilityRow> rows;
            for (const Pair& pair : pairs)
                rows.push_back(attempt("hooks pushed together online", std::string("P1, linear, ") + pair.kind,
                    [&](StabilityRow& row) { push_together(row, pair.right, pair.left); }));
            return rows;
        } };
}

StabilityCase inverted_start_case()
{
    return { "start inside out", "laws that have an energy there come back to rest; the others say so",
        [](const Job& job) {
            const fem::Lame l = linear_law(1.0, 0.3).lame;
            const auto start = [&](const VerificationLaw& law) {
                return [&job, law](StabilityRow& row) { start_inside_out(row, law, job); };
            };
            return std::vector<StabilityRow> {
                attempt("start inside out", "P1, linear", start(linear_law(1.0, 0.3))),
                attempt("start inside out", "P1, corotational",
                    start({ "corotational", fem::Elasticity::corotational, l, {}, {} })),
                expect_refusal("start inside out", "P1, neo-Hookean", "turned over",
                    start(hyperelastic_law("neo-Hookean", fem::NeoHookean { l.mu, l.lambda }))),
                expect_refusal("mesh with an element inside out", "opening", "is not positive", mesh_inside_out),
            };
        } };
}

} // namespace retractor::verification
