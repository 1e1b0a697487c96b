#include "fem/verification/problem.h"

#include "fem/material.h"
#include "fem/verification/estimates.h"

#include <cmath>
#include <utility>

namespace retractor {

std::string element_name(VerificationElement element)
{
    switch (element) {
    case VerificationElement::p1:
        return "P1";
    case VerificationElement::p2:
        return "P2";
    case VerificationElement::locking_free:
        return "locking-free P1";
    case VerificationElement::nodal:
        return "nodal P1";
    }
    return {};
}

int nodes_per_tet(VerificationElement element) { return element == VerificationElement::p2 ? 10 : 4; }

std::vector<VerificationProblem> verification_problems()
{
    return { patch_test_problem(), null_space_problem(), pressed_tube_problem(), stretched_tube_problem(),
        tube_limit_problem(), gape_problem(), penny_problem(), indentation_problem(), homogeneous_problem(),
        manufactured_problem(), cook_problem(), cardiac_beam_problem(), estimate_problem(), calculix_problem(),
        febio_problem() };
}

std::vector<VerificationProblem> ladder_problems() { return { solver_ladder_problem(), localisation_problem() }; }

std::vector<VerificationRow> run_verification(
    const std::vector<VerificationProblem>& problems, const VerificationOptions& options, const Job& job)
{
    std::vector<VerificationRow> rows;
    for (std::size_t i = 0; i < problems.size() && !job.cancelled(); ++i) {
        job.report(problems[i].name, static_cast<double>(i) / static_cast<double>(problems.size()));
        Job quiet = job; // the stage is the problem, not what it does inside
        quiet.on_progress = nullptr;
        for (VerificationRow& row : problems[i].run(options, quiet))
            rows.push_back(std::move(row));
    }
    return rows;
}

VerificationLaw linear_law(double youngs_modulus, double poissons_ratio)
{
    return { "linear", Elasticity::linear, lame({ "solid", youngs_modulus, poissons_ratio, 1e-9, "reference" }), {},
        {} };
}

VerificationLaw hyperelastic_law(std::string name, const Hyperelastic& law)
{
    return { std::move(name), Elasticity::hyperelastic, {}, law, {} };
}

ElasticBody make_body(const TetMesh& mesh, VerificationElement element, const VerificationLaw& law)
{
    const auto build = [&] {
        if (law.model != Elasticity::hyperelastic)
            return ElasticBody(mesh, law.model, std::vector<Lame>(mesh.tet_count(), law.lame));
        HyperelasticTissue tissue = uniform_tissue(mesh, law.hyperelastic);
        tissue.fibres.assign(mesh.tet_count(), law.fibres);
        return ElasticBody(mesh, std::move(tissue));
    };
    ElasticBody body = build();
    if (element == VerificationElement::locking_free)
        body.avoid_locking(LockingFreeKind::edge_patch);
    if (element == VerificationElement::nodal)
        body.avoid_locking(LockingFreeKind::nodal);
    return body;
}

VerificationSolve solve_problem(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const EquilibriumOptions& options, const Job& job)
{
    const Stopwatch watch;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * body.mesh().vertices.rows());
    EquilibriumSolver solver;
    VerificationSolve solve { solver.solve(body, prescribed, target.size() == 0 ? rest : target, rest, options, job),
        0.0 };
    solve.seconds = watch.seconds();
    return solve;
}

VerificationRow make_row(std::string problem, VerificationElement element, const VerificationLaw& law,
    const TetMesh& mesh, const VerificationSolve& solve)
{
    VerificationRow row;
    row.problem = std::move(problem);
    row.element = element_name(element);
    row.law = law.name;
    row.nodes = mesh.vertex_count();
    row.tets = mesh.tet_count();
    row.residual = solve.equilibrium.residual;
    row.seconds = solve.seconds;
    if (solve.equilibrium.status != EquilibriumStatus::converged) {
        row.note = solve.equilibrium.message.empty() ? "not converged" : solve.equilibrium.message;
        row.error = std::numeric_limits<double>::quiet_NaN();
    }
    return row;
}

void compare(VerificationRow& row, std::string quantity, double value, double expected)
{
    row.quantity = std::move(quantity);
    row.value = value;
    row.expected = expected;
    if (!std::isnan(row.error)) // it has converged
        row.error = std::abs(value - expected) / (expected == 0.0 ? 1.0 : std::abs(expected));
}

void set_orders(std::vector<VerificationRow>& series, double expected)
{
    for (std::size_t i = 0; i < series.size(); ++i) {
        series[i].expected_order = expected;
        if (i > 0)
            series[i].order
                = std::log(series[i - 1].error / series[i].error) / std::log(series[i - 1].size / series[i].size);
    }
}

void append_series(
    std::vector<VerificationRow>& rows, std::vector<VerificationRow>& series, double expected, double bound)
{
    set_orders(series, expected);
    if (!series.empty())
        series.back().bound = bound;
    rows.insert(rows.end(), series.begin(), series.end());
}

} // namespace retractor
