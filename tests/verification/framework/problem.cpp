#include "tests/verification/framework/problem.h"

#include "fem/material/element_fibres.h"
#include "fem/material/material.h"
#include "mesh/base/text_format.h"
#include "tests/verification/framework/nodal_element.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::verification {

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

std::vector<VerificationRow> run_verification(
    const std::vector<VerificationProblem>& problems, const VerificationOptions& options, const Job& job)
{
    std::vector<VerificationRow> rows;
    for (std::size_t i = 0; i < problems.size() && !job.cancelled(); ++i) {
        job.report(problems[i].name, static_cast<double>(i) / static_cast<double>(problems.size()));
        Job quiet = job; // the problem is the stage, not the steps inside
        quiet.on_progress = nullptr;
        for (VerificationRow& row : problems[i].run(options, quiet))
            rows.push_back(std::move(row));
    }
    return rows;
}

VerificationLaw linear_law(double youngs_modulus, double poissons_ratio)
{
    return { "linear", fem::Elasticity::linear,
        fem::lame({ "solid", youngs_modulus, poissons_ratio, 1e-9, "reference" }), {}, {} };
}

VerificationLaw hyperelastic_law(std::string name, const fem::Hyperelastic& law)
{
    return { std::move(name), fem::Elasticity::hyperelastic, {}, law, {} };
}

fem::ElasticBody make_body(const mesh::TetMesh& mesh, VerificationElement element, const VerificationLaw& law)
{
    const auto build = [&] {
        if (law.model != fem::Elasticity::hyperelastic)
            return fem::ElasticBody(mesh, law.model, std::vector<fem::Lame>(mesh.tet_count(), law.lame));
        fem::HyperelasticTissue tissue = uniform_tissue(mesh, law.hyperelastic);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            tissue.fibres.push_back(fem::element_fibres(mesh, t, { law.hyperelastic, law.fibres, law.around }));
        return fem::ElasticBody(mesh, std::move(tissue));
    };
    fem::ElasticBody body = build();
    if (element == VerificationElement::locking_free)
        body.avoid_locking();
    if (element == VerificationElement::nodal)
        body.avoid_locking(nodal_domains);
    return body;
}

VerificationSolve solve_problem(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const fem::EquilibriumOptions& options, const Job& job)
{
    const Stopwatch watch;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * body.mesh().vertices.rows());
    fem::EquilibriumSolver solver;
    VerificationSolve solve { solver.solve(body, prescribed, target.size() == 0 ? rest : target, rest, options, job),
        0.0 };
    solve.seconds = watch.seconds();
    return solve;
}

VerificationRow make_row(std::string problem, VerificationElement element, const VerificationLaw& law,
    const mesh::TetMesh& mesh, const VerificationSolve& solve)
{
    VerificationRow row;
    row.problem = std::move(problem);
    row.element = element_name(element);
    row.law = law.name;
    row.nodes = mesh.vertex_count();
    row.tets = mesh.tet_count();
    row.residual = solve.equilibrium.residual;
    row.seconds = solve.seconds;
    if (solve.equilibrium.status != fem::EquilibriumStatus::converged) {
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
    if (!std::isnan(row.error)) // the solution has converged
        row.error = std::abs(value - expected) / (expected == 0.0 ? 1.0 : std::abs(expected));
}

namespace {

    bool mixed_signs(const std::vector<VerificationRow>& series)
    {
        const auto sign = [](const VerificationRow& row) { return row.value > row.expected; };
        return series.front().expected != 0.0 // otherwise the value is the size of the error
            && std::any_of(series.begin(), series.end(),
                [&](const VerificationRow& row) { return sign(row) != sign(series.front()); });
    }

    void add_note(VerificationRow& row, const std::string& more)
    {
        row.note += (row.note.empty() || more.empty() ? "" : "; ") + more;
    }

    void check_fall(std::vector<VerificationRow>& series, const std::string& why)
    {
        const bool falls = std::adjacent_find(series.begin(), series.end(), [](const auto& coarse, const auto& fine) {
            return !(fine.error < coarse.error); // true for NaN
        }) == series.end();
        VerificationRow& finest = series.back();
        finest.order_verdict = falls ? OrderVerdict::falling : OrderVerdict::missed;
        add_note(finest, falls ? "only judged to fall: " + why : "the error does not fall with every mesh");
    }

} // namespace

void show_only(VerificationRow& row, const std::string& why)
{
    row.only_shown = true;
    add_note(row, why);
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

std::string measured_verdict(double value, const MeasuredComparison& measured)
{
    if (value - measured.bar >= measured.least && value + measured.bar <= measured.most)
        return "inside";
    if (value + measured.bar < measured.least || value - measured.bar > measured.most)
        return "outside";
    return "undecided"; // also for NaN
}

std::string order_verdict_name(OrderVerdict verdict)
{
    switch (verdict) {
    case OrderVerdict::not_judged:
        return "";
    case OrderVerdict::reached:
        return "reached";
    case OrderVerdict::mixed_signs:
        return "mixed signs";
    case OrderVerdict::at_floor:
        return "at the floor";
    case OrderVerdict::falling:
        return "falling";
    case OrderVerdict::missed:
        return "MISSED";
    }
    return {};
}

void check_orders(std::vector<VerificationRow>& series, double expected, const OrderRule& rule)
{
    set_orders(series, expected);
    constexpr std::size_t kFewest = 3, kFewestToFall = 2;
    if (rule.asks == OrderRule::Asks::fall && series.size() >= kFewestToFall)
        check_fall(series, rule.why);
    if (rule.asks != OrderRule::Asks::order || series.size() < kFewest || std::isnan(expected))
        return;
    VerificationRow& finest = series.back();
    const double whole = std::log(series.front().error / finest.error) / std::log(series.front().size / finest.size);
    // up to twice the floor, the discretisation's own error is no larger than the floor
    constexpr double kFloors = 2.0;
    if (finest.order >= expected - rule.slack)
        finest.order_verdict = OrderVerdict::reached;
    else if (rule.floor > 0.0 && finest.error <= kFloors * rule.floor) {
        finest.order_verdict = OrderVerdict::at_floor;
        add_note(finest, "at the floor of " + formatted("%.1e", rule.floor) + ": " + rule.why);
    } else if (mixed_signs(series) && whole >= expected - rule.mixed_slack) {
        finest.order_verdict = OrderVerdict::mixed_signs;
        add_note(finest, "the error passes through zero; order over all meshes " + formatted("%.1f", whole));
    } else { // also for NaN
        finest.order_verdict = OrderVerdict::missed;
        add_note(finest,
            "converges too slowly: order " + formatted("%.2f", finest.order) + ", over all meshes "
                + formatted("%.2f", whole) + ", instead of " + formatted("%g", expected));
    }
}

void append_series(std::vector<VerificationRow>& rows, std::vector<VerificationRow>& series, double expected,
    double bound, const OrderRule& rule)
{
    check_orders(series, expected, rule);
    if (series.empty())
        return;
    VerificationRow& finest = series.back();
    finest.bound = bound;
    const bool asked = rule.asks != OrderRule::Asks::nothing;
    if (std::isfinite(bound) && !asked)
        add_note(finest, "order not judged: " + rule.why);
    for (VerificationRow& row : series)
        if (!asked && !std::isfinite(bound))
            show_only(row, rule.why);
        else
            row.in_series = &row != &finest;
    rows.insert(rows.end(), series.begin(), series.end());
}

} // namespace retractor::verification
