// Ratio of estimated to true error of every element. The estimate's factor of safety was chosen on these problems.

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/verification/comparison/estimates.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/vessel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    /// A quantity of an answer: a number, or a vector whose error is the length of the error vector. The length of a
    /// vector can be right while both components are wrong: in a bent bar the errors along and across the bar cancel.
    using Quantity = Eigen::VectorXd;
    Quantity number(double value) { return Quantity::Constant(1, value); }

    /// Answers on one mesh by plain, locking-free and ten-node elements.
    struct Answers {
        std::vector<Quantity> plain, locking_free, ten;
        double share = 0.0; ///< ten_node_share()
        std::array<double, 3> seconds {}, residual {}; ///< in the order plain, locking-free, ten-node
    };

    const std::string kGape = "the gape beside it, mm";
    bool is_opening(const std::string& name) { return name == kGape; }

    /// Largest elements that are judged. On larger elements the opening shows no order yet, and its rows are only
    /// shown.
    constexpr double kCoarseSheet = 2.0; // mm

    /// One row per number and element.
    /// @param right right value of each number.
    void add_rows(std::vector<VerificationRow>& rows, const VerificationRow& like, const Answers& answers,
        const std::vector<Quantity>& right, const std::vector<std::string>& names, bool too_coarse = false)
    {
        for (std::size_t i = 0; i < names.size(); ++i) {
            const Quantity& ten = answers.ten[i];
            const double share
                = is_opening(names[i]) ? std::max(answers.share, fem::kLeastOpeningShare) : answers.share;
            const double lacking = share * (answers.plain[i] - ten).norm();
            const auto add = [&](VerificationElement element, std::size_t which, const Quantity& answer,
                                 double estimate) {
                VerificationRow row = like;
                row.element = element_name(element);
                row.seconds = answers.seconds[which];
                row.residual = answers.residual[which];
                check_estimate(row, names[i], { answer.norm(), estimate, right[i].norm(), (right[i] - answer).norm() });
                if (too_coarse && is_opening(names[i])) {
                    row.bound = kNoBound;
                    show_only(row, "two elements through the sheet: its gape has no order yet to estimate by");
                }
                rows.push_back(row);
            };
            add(VerificationElement::p1, 0, answers.plain[i], (answers.plain[i] - ten).norm() / fem::kErrorShare);
            add(VerificationElement::locking_free, 1, answers.locking_free[i],
                (answers.locking_free[i] - ten).norm() + lacking);
            add(VerificationElement::p2, 2, ten, lacking);
        }
    }

    VerificationRow like(const std::string& problem, double nu, const mesh::TetMesh& mesh)
    {
        std::array<char, 16> number {};
        (void)std::snprintf(number.data(), number.size(), "%g", nu);
        VerificationRow row;
        row.problem = "error estimate, " + problem + ", nu " + number.data();
        row.law = "linear";
        row.nodes = mesh.vertex_count();
        row.tets = mesh.tet_count();
        return row;
    }

    using Quantities = std::function<std::vector<Quantity>(const fem::ElasticProblem&, const fem::OpeningResult&)>;

    fem::OpeningResult opened(
        const fem::ElasticProblem& problem, fem::Elasticity elasticity, bool locking_free, const Job& job)
    {
        const bool linear = elasticity == fem::Elasticity::linear;
        fem::Opening opening(problem.mesh, problem.material_of_label, problem.supports,
            { .elasticity = elasticity, .locking_free = locking_free, .tolerance = linear ? 1e-9 : 1e-7 });
        fem::OpeningResult result = opening.open(problem.hooks, job);
        if (result.status != fem::OpeningStatus::converged
            && !(linear && result.status == fem::OpeningStatus::inverted))
            throw SolverError("not opened: " + result.message);
        return result;
    }

    /// A body solved with three elements on one mesh.
    Answers answers_on(
        const fem::ElasticProblem& problem, fem::Elasticity elasticity, const Quantities& quantities, const Job& job)
    {
        const fem::ElasticProblem fine = with_midpoints(problem);
        Answers answers;
        std::array<fem::OpeningResult, 3> results;
        for (std::size_t i = 0; i < 3; ++i) {
            const Stopwatch watch;
            results[i] = opened(i == 2 ? fine : problem, elasticity, i == 1, job);
            answers.seconds[i] = watch.seconds();
            answers.residual[i] = results[i].residual;
        }
        answers.plain = quantities(problem, results[0]);
        answers.locking_free = quantities(problem, results[1]);
        answers.ten = quantities(fine, results[2]);
        const Points& u = results[2].displacement;
        answers.share = fem::ten_node_share(
            fine, elasticity, Eigen::Map<const Eigen::VectorXd>(u.data(), u.size()), results[0].displacement);
        return answers;
    }

    struct Family {
        std::string name;
        double poissons_ratio;
        std::function<fem::ElasticProblem(double cell)> make;
        std::vector<double> cells; ///< mm
        double fine, finest; ///< cell sizes of the two reference meshes, mm
        Quantities quantities;
        std::vector<std::string> names;
        fem::Elasticity elasticity = fem::Elasticity::linear;
        /// Power of the element size with which the error of these numbers falls. The power is twice the exponent
        /// with which the displacement grows with the distance from an edge where stress has no bound. At the ends of
        /// cuts this exponent is 1/2.
        double order = 1.0;
    };

    /// Order of the error of energy-like numbers where a clamped face meets a free face at a right angle: twice the
    /// least root of sin^2(pi x / 2) = ((k + 1)^2 / 4 - x^2) / k, k = 3 - 4 nu [Williams 1952, J. Appl. Mech. 19,
    /// 526, plane strain].
    double clamped_rim_order(double poissons_ratio)
    {
        const double k = 3.0 - 4.0 * poissons_ratio;
        const auto beyond = [k](double x) {
            const double sine = std::sin(std::numbers::pi / 2.0 * x);
            return sine * sine > ((k + 1.0) * (k + 1.0) / 4.0 - x * x) / k;
        };
        double below = 0.0, above = 1.0;
        for (int halving = 0; halving < 50; ++halving) {
            const double middle = 0.5 * (below + above);
            (beyond(middle) ? above : below) = middle;
        }
        return below + above;
    }

    /// Compares with ten-node elements on two finer meshes, extrapolated to element size zero.
    void add_family(std::vector<VerificationRow>& rows, const Family& family, const Job& job)
    {
        const auto by_ten = [&](double cell) {
            const fem::ElasticProblem problem = with_midpoints(family.make(cell));
            return family.quantities(problem, opened(problem, family.elasticity, false, job));
        };
        const std::vector<Quantity> before = by_ten(family.fine);
        std::vector<Quantity> right = by_ten(family.finest);
        const double farther = 1.0 / (std::pow(family.fine / family.finest, family.order) - 1.0);
        for (std::size_t i = 0; i < right.size(); ++i)
            right[i] -= farther * (before[i] - right[i]);
        for (const double cell : family.cells) {
            if (job.cancelled())
                return;
            const fem::ElasticProblem problem = family.make(cell);
            VerificationRow row = like(family.name, family.poissons_ratio, problem.mesh);
            if (family.elasticity == fem::Elasticity::hyperelastic)
                row.law = "neo-Hookean";
            add_rows(rows, row, answers_on(problem, family.elasticity, family.quantities, job), right, family.names,
                cell > kCoarseSheet);
        }
    }

    /// A bar of 4 x 4 mm along x, clamped at one end; the other end is moved across.
    struct Bar {
        double length = 40.0, moved = 2.0; ///< mm
        double poissons_ratio = 0.3;
    };
    fem::ElasticProblem bent_bar(const Bar& bar, double cell)
    {
        constexpr double kAcross = 4.0, kTiny = 1e-9;
        const int across = static_cast<int>(std::lround(kAcross / cell)),
                  along = static_cast<int>(std::lround(bar.length / cell));
        fem::ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(along, across, across, kAcross / across);
        problem.material_of_label.assign(2, { "tissue", 0.5, bar.poissons_ratio, 1e-9, "verification" });
        problem.hooks = { { .name = "end", .side = 1, .nodes = {}, .displacement = Vec3(0.0, bar.moved, 0.0) } };
        for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertex_count()); ++v)
            if (problem.mesh.vertices(v, 0) < kTiny)
                problem.supports.fixed.push_back(v);
            else if (problem.mesh.vertices(v, 0) > bar.length - kTiny)
                problem.hooks[0].nodes.push_back(v);
        return problem;
    }

    /// A sheet of 24 x 18 x 6 mm, cut through over most of its length and pulled open.
    constexpr double kCut = 18.0;
    IncisedBlock incised_sheet(double cell)
    {
        return { .size = { 24.0, 18.0, 6.0 },
            .cell = cell,
            .length = kCut,
            .depth = 6.0,
            .hook_width = 6.0,
            .hook_height = 3.0 };
    }
    fem::ElasticProblem opened_sheet(double cell, double nu)
    {
        const IncisedBlock block = incised_sheet(cell);
        return hooked_open(block, incise(uncut_block(block), incision_blade(block)),
            { "tissue", 0.1, nu, 1e-9, "verification" }, Vec3(0.0, 1.5, 0.5));
    }
    /// Distance by which the lips were pulled apart at the skin, half way from the hooks to the end of the cut. Every
    /// mesh has a vertex there.
    double hooked_gape(const fem::ElasticProblem& problem, const fem::OpeningResult& result)
    {
        constexpr double kTiny = 1e-6;
        const Eigen::RowVector3d place(6.0, 9.0, 6.0);
        double least = 0.0, most = 0.0;
        for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v)
            if ((problem.mesh.vertices.row(v) - place).norm() < kTiny) {
                least = std::min(least, result.displacement(v, 1));
                most = std::max(most, result.displacement(v, 1));
            }
        return most - least;
    }

    constexpr double kVessel = 0.5; // MPa

    /// Mean radial displacement of the inner wall.
    double wall_displacement(const QuarterTube& tube, const Eigen::VectorXd& u)
    {
        double sum = 0.0;
        for (const mesh::TetFace& face : tube.inner_faces) {
            const auto nodes = tube.mesh.tet(face.tet);
            const auto radial = [&](VertexId v) {
                const Vec3 p = tube.mesh.vertices.row(v);
                return (u[3 * v] * p.x() + u[3 * v + 1] * p.y()) / p.head<2>().norm();
            };
            if (nodes.size() == 4) {
                for (const VertexId v : mesh::face_vertices(tube.mesh, face))
                    sum += radial(v) / 3.0;
                continue;
            }
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) // the rule is exact for quadratics
                if (mesh::kTetEdges[e][0] != face.corner && mesh::kTetEdges[e][1] != face.corner)
                    sum += radial(nodes[4 + e]) / 3.0;
        }
        return sum / static_cast<double>(tube.inner_faces.size());
    }

    constexpr double kStretching = 2.0 * kPulse; // MPa; stretches the tube by a fifth

    VerificationLaw vessel_law(fem::Elasticity elasticity, double nu)
    {
        return elasticity == fem::Elasticity::linear
            ? linear_law(kVessel, nu)
            : hyperelastic_law("neo-Hookean", fem::hyperelastic_law({ "vessel", kVessel, nu, 1e-9, "verification" }));
    }

    VerificationSolve pressed_vessel(
        const QuarterTube& tube, VerificationElement element, fem::Elasticity elasticity, double nu, const Job& job)
    {
        const bool linear = elasticity == fem::Elasticity::linear;
        fem::ElasticBody body = make_body(tube.mesh, element, vessel_law(elasticity, nu));
        body.set_loads({ {}, { fem::FollowerPressure(tube.mesh, tube.inner_faces, linear ? kPulse : kStretching) } });
        VerificationSolve solve = solve_problem(
            body, tube.held.prescribed, {}, { .load_steps = 2, .tolerance = linear ? 1e-9 : 1e-7 }, job);
        if (solve.equilibrium.status != fem::EquilibriumStatus::converged)
            throw SolverError("the tube was not pressed: " + solve.equilibrium.message);
        return solve;
    }

    /// The right displacement: Lame's, or for the stretched tube the displacement of ten-node elements on a mesh
    /// finer than all others.
    double right_displacement(fem::Elasticity elasticity, double nu, const Job& job)
    {
        if (elasticity == fem::Elasticity::linear)
            return vessel_displacement(kVessel, nu, kPulse);
        constexpr int kThrough = 3;
        const QuarterTube tube = quarter_tube(10, kVesselInner, kVesselOuter, 12 * kThrough, kThrough, 1);
        return wall_displacement(
            tube, pressed_vessel(tube, VerificationElement::p2, elasticity, nu, job).equilibrium.displacement);
    }

    void add_tube(std::vector<VerificationRow>& rows, fem::Elasticity elasticity, double nu, double right, int through,
        const Job& job)
    {
        const QuarterTube straight = quarter_tube(4, kVesselInner, kVesselOuter, 12 * through, through, 1),
                          curved = quarter_tube(10, kVesselInner, kVesselOuter, 12 * through, through, 1);
        Answers answers;
        std::array<Eigen::VectorXd, 3> u;
        constexpr std::array kElements { VerificationElement::p1, VerificationElement::locking_free,
            VerificationElement::p2 };
        for (std::size_t i = 0; i < 3; ++i) {
            VerificationSolve solve = pressed_vessel(i == 2 ? curved : straight, kElements[i], elasticity, nu, job);
            answers.seconds[i] = solve.seconds;
            answers.residual[i] = solve.equilibrium.residual;
            u[i] = std::move(solve.equilibrium.displacement);
        }
        answers.plain = { number(wall_displacement(straight, u[0])) };
        answers.locking_free = { number(wall_displacement(straight, u[1])) };
        answers.ten = { number(wall_displacement(curved, u[2])) };
        const fem::ElasticProblem problem { curved.mesh,
            std::vector<fem::Material>(2, { "vessel", kVessel, nu, 1e-9, "verification" }), {}, {} };
        answers.share = fem::ten_node_share(
            problem, elasticity, u[2], Eigen::Map<const Points>(u[0].data(), straight.mesh.vertices.rows(), 3));
        const bool linear = elasticity == fem::Elasticity::linear;
        VerificationRow row = like(linear ? "pressed tube" : "stretched tube", nu, straight.mesh);
        row.law = vessel_law(elasticity, nu).name;
        add_rows(rows, row, answers, { number(right) }, { "the inner wall's mean displacement" });
    }

} // namespace

std::vector<VerificationRow> element_estimates(const VerificationOptions& options, const Job& job)
{
    std::vector<VerificationRow> rows;
    for (const double nu : { 0.30, 0.45, 0.49 })
        for (const int through : { 1, 2, 4 })
            if (!job.cancelled())
                add_tube(rows, fem::Elasticity::linear, nu, right_displacement(fem::Elasticity::linear, nu, job),
                    through, job);
    for (const double nu : { 0.30, 0.45 }) {
        if (job.cancelled())
            break;
        const double right = right_displacement(fem::Elasticity::hyperelastic, nu, job);
        for (const int through : { 1, 2, 4 })
            add_tube(rows, fem::Elasticity::hyperelastic, nu, right, through, job);
    }
    const Quantities force = [](const fem::ElasticProblem&, const fem::OpeningResult& result) {
        return std::vector<Quantity> { result.hook_forces_N.back() };
    };
    for (const double nu : { 0.30, 0.45 })
        if (!job.cancelled())
            add_family(rows,
                { .name = "bent bar",
                    .poissons_ratio = nu,
                    .make = [nu](double cell) { return bent_bar({ .poissons_ratio = nu }, cell); },
                    .cells = { 4.0, 2.0 },
                    .fine = 4.0 / 3.0,
                    .finest = options.fine ? 0.8 : 1.0,
                    .quantities = force,
                    .names = { "the end's force, N" },
                    .order = clamped_rim_order(nu) },
                job);
    for (const double nu : { 0.30, 0.45 })
        if (!job.cancelled()) // the bar is stretched when it is bent
            add_family(rows,
                { .name = "bar bent far",
                    .poissons_ratio = nu,
                    .make =
                        [nu](double cell) {
                            return bent_bar({ .length = 20.0, .moved = 5.0, .poissons_ratio = nu }, cell);
                        },
                    .cells = { 4.0, 2.0, 4.0 / 3.0 },
                    .fine = options.fine ? 0.8 : 1.0,
                    .finest = options.fine ? 4.0 / 7.0 : 0.8,
                    .quantities = force,
                    .names = { "the end's force, N" },
                    .elasticity = fem::Elasticity::hyperelastic,
                    .order = clamped_rim_order(nu) },
                job);
    const Quantities force_and_gape = [](const fem::ElasticProblem& problem, const fem::OpeningResult& result) {
        return std::vector<Quantity> { result.hook_forces_N.back(), number(hooked_gape(problem, result)) };
    };
    for (const double nu : { 0.30, 0.49 })
        if (!job.cancelled())
            add_family(rows,
                { .name = "incised sheet",
                    .poissons_ratio = nu,
                    .make = [nu](double cell) { return opened_sheet(cell, nu); },
                    .cells = { 3.0, 1.5 },
                    .fine = 1.5,
                    .finest = options.fine ? 0.75 : 1.0,
                    .quantities = force_and_gape,
                    .names = { "a hook's force, N", kGape } },
                job);
    return rows;
}

} // namespace retractor::verification
