// Validation problem 7: a half-space under a flat punch, a ball, a disc of pressure and a point load, without
// friction.

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/loads.h"
#include "mesh/base/job.h"
#include "tests/verification/framework/half_space.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kTissueYoung = 0.020, kTissuePoisson = 0.49; // MPa
    constexpr double kStar = kTissueYoung / (1.0 - kTissuePoisson * kTissuePoisson);
    constexpr double kCircle = 5.0; // radius of the circle of the meshes, mm

    constexpr const char* kRough
        = "under loads, not displacements, a surface of strains averaged round nodes goes up and "
          "down from node to node; the element is kept because published results rest on it";

    struct Indentation {
        std::string name;
        double a; ///< radius of contact, mm
        std::function<double(double)> depth; ///< depth of the indenter at a radius, mm
        double force; ///< N
        double order;
        std::string note {};
    };

    Indentation flat_punch()
    {
        constexpr double punch = 5.0, pushed = 2.0;
        return { "flat punch", punch, [=](double) { return pushed; }, 2.0 * punch * kStar * pushed, 1.0 };
    }

    constexpr double kPressedBall = 8.0; // mm, radius

    /// Depth of a ball whose contact circle has radius a [Sneddon 1965].
    double ball_depth(double a) { return 0.5 * a * std::log((kPressedBall + a) / (kPressedBall - a)); }
    double ball_force(double a)
    {
        return 0.5 * kStar
            * ((kPressedBall * kPressedBall + a * a) * std::log((kPressedBall + a) / (kPressedBall - a))
                - 2.0 * a * kPressedBall);
    }
    double ball_contact(double depth)
    {
        double low = 0.0, high = kPressedBall;
        for (int i = 0; i < 200; ++i) {
            const double a = 0.5 * (low + high);
            (ball_depth(a) < depth ? low : high) = a;
        }
        return 0.5 * (low + high);
    }

    Indentation pressed_ball()
    {
        constexpr double d = 5.0;
        const double a = ball_contact(d);
        return { "pressed by a ball", a,
            [=](double r) {
                return d - (kPressedBall - std::sqrt(std::max(0.0, kPressedBall * kPressedBall - r * r)));
            },
            ball_force(a), 2.0 };
    }

    /// Hertz replaces the ball by a paraboloid.
    Indentation shallow_ball()
    {
        constexpr double d = 0.5, kRange = 0.06; // relative to the radius: the range in which Hertz's theory holds
        static_assert(
            d > kRange * kPressedBall && d < 1.1 * kRange * kPressedBall, "at the end of the range, the note says");
        const double hertz = 4.0 / 3.0 * kStar * std::sqrt(kPressedBall) * std::pow(d, 1.5);
        char note[160];
        (void)std::snprintf(note, sizeof note,
            "Hertz, d at the end of his range (0.06 R): a ball itself bears %.2g %% less [Sneddon]",
            100.0 * (1.0 - ball_force(ball_contact(d)) / hertz));
        return { "pressed by a ball, shallow", std::sqrt(kPressedBall * d),
            [=](double r) { return d - r * r / (2.0 * kPressedBall); }, hertz, 2.0, note };
    }

    /// Force on the whole indenter: four times the force on the quarter.
    double indenter_force(const QuarterCylinder& body, const Eigen::VectorXd& forces)
    {
        double sum = 0.0;
        for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v)
            if (body.in_circle(body.mesh.vertices.row(v).transpose()))
                sum += forces[3 * v + 2];
        return 4.0 * sum;
    }

    /// A linear body that is assembled and factorised once, for several targets and loads on the same held unknowns.
    class LinearSolves {
    public:
        LinearSolves(const QuarterCylinder& body, VerificationElement element, double poissons_ratio,
            std::vector<std::uint8_t> prescribed)
            : elastic_(make_body(body.mesh, element, linear_law(kTissueYoung, poissons_ratio)))
            , K_(elastic_.stiffness(Eigen::VectorXd::Zero(3 * body.mesh.vertices.rows()), 0.0))
            , solver_(K_.pattern, std::move(prescribed))
        {
            solver_.factorise(K_);
            factor_seconds_ = watch_.seconds();
        }

        /// The time of this solution and of the factorisation.
        VerificationSolve solve(const Eigen::VectorXd& target, const Eigen::VectorXd& loads)
        {
            const Stopwatch watch;
            VerificationSolve solve;
            fem::Equilibrium& e = solve.equilibrium;
            const Eigen::VectorXd right = loads - K_.multiply(target);
            e.displacement = target + solver_.solve(right);
            e.forces = K_.multiply(e.displacement) - loads;
            Eigen::VectorXd left = e.forces;
            solver_.mask(left);
            e.residual
                = left.cwiseAbs().maxCoeff() / std::max(right.cwiseAbs().maxCoeff(), e.forces.cwiseAbs().maxCoeff());
            solve.seconds = factor_seconds_ + watch.seconds();
            return solve;
        }

    private:
        Stopwatch watch_;
        fem::ElasticBody elastic_;
        const fem::BlockMatrix& K_;
        fem::ConstrainedSolver solver_;
        double factor_seconds_ = 0.0;
    };

    /// All indenters on one mesh: lengths, and the force of a given depth, scale with the contact radius.
    std::vector<VerificationRow> indent(
        const std::vector<Indentation>& indentations, const QuarterCylinder& body, VerificationElement element, int n)
    {
        const auto pushed = [&](const std::function<double(double)>& depth) {
            Held held = symmetric(body);
            for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v)
                if (const Vec3 p = body.mesh.vertices.row(v).transpose(); body.in_circle(p))
                    hold(held, v, 2, depth(std::hypot(p.x(), p.y())));
            return held;
        };
        // The far side moves with the unknown force. So the problem is solved twice: the force with the far side at
        // rest, and the reduction of the force when the far side moves as under a unit force.
        const Held moved = with_far_side(pushed([](double) { return 0.0; }), body, kTissueYoung, kTissuePoisson, 1.0);
        LinearSolves solves(body, element, kTissuePoisson, moved.prescribed);
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(moved.target.size());
        const double taken_off = indenter_force(body, solves.solve(moved.target, none).equilibrium.forces);
        std::vector<VerificationRow> rows;
        for (const Indentation& problem : indentations) {
            const double scale = problem.a / kCircle;
            const Held still = with_far_side(
                pushed([&](double r) { return problem.depth(scale * r); }), body, kTissueYoung, kTissuePoisson, 0.0);
            const VerificationSolve solve = solves.solve(still.target, none);
            VerificationRow row
                = make_row(problem.name, element, linear_law(kTissueYoung, kTissuePoisson), body.mesh, solve);
            compare(row, "force, N", scale * indenter_force(body, solve.equilibrium.forces) / (1.0 - taken_off),
                problem.force);
            row.size = 1.0 / n;
            rows.push_back(row);
        }
        return rows;
    }

    /// Mean depth of the nodes on the circle. Nodes in the planes of symmetry have half the weight.
    double mean_on_circle(const QuarterCylinder& body, const VerificationSolve& solve)
    {
        constexpr double kTiny = 1e-6; // relative to the radius
        double sum = 0.0, weights = 0.0;
        for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v) {
            const Vec3 p = body.mesh.vertices.row(v).transpose();
            if (!body.in_circle(p) || std::abs(std::hypot(p.x(), p.y()) / body.a - 1.0) > kTiny)
                continue;
            const double weight = std::min(p.x(), p.y()) < kTiny * body.a ? 0.5 : 1.0;
            sum += weight * solve.equilibrium.displacement[3 * v + 2];
            weights += weight;
        }
        return sum / weights;
    }

    VerificationRow pressed_row(const char* name, const QuarterCylinder& body, VerificationElement element, int n,
        const VerificationSolve& solve)
    {
        VerificationRow row = make_row(name, element, linear_law(kTissueYoung, kTissuePoisson), body.mesh, solve);
        row.size = 1.0 / n;
        return row;
    }

    /// A disc of pressure: the depth of the middle, of the edge, and the mean depth of the disc.
    std::vector<VerificationRow> press_disc(const QuarterCylinder& body, VerificationElement element, int n)
    {
        constexpr double pressure = 0.001; // MPa
        // given, so no unknown force must be found first
        const double force = pressure * std::numbers::pi * kCircle * kCircle;
        const Held held = with_far_side(symmetric(body), body, kTissueYoung, kTissuePoisson, force);
        const Eigen::VectorXd loads = fem::traction_loads(body.mesh, body.circle(), Vec3(0.0, 0.0, pressure));
        const VerificationSolve solve
            = LinearSolves(body, element, kTissuePoisson, held.prescribed).solve(held.target, loads);
        const auto sunk = [&](const Vec3& at) { return solve.equilibrium.displacement[3 * body.nearest(at) + 2]; };
        std::vector<VerificationRow> rows(3, pressed_row("disc of pressure", body, element, n, solve));
        const double middle = 2.0 * pressure * kCircle / kStar;
        compare(rows[0], "sinking of the middle, mm", sunk(Vec3::Zero()), middle);
        compare(rows[1], "sinking of the edge, mm", sunk(Vec3(kCircle, 0.0, 0.0)), 2.0 / std::numbers::pi * middle);
        compare(rows[2], "mean sinking, mm", loads.dot(solve.equilibrium.displacement) / loads.sum(),
            8.0 / (3.0 * std::numbers::pi) * middle);
        return rows;
    }

    /// A point load: the depth of a circle round the load, because the depth at the load is infinite. The tissue is
    /// compressible: in incompressible tissue the infinite strain under the load has an influence much farther away.
    VerificationRow press_point(const QuarterCylinder& body, VerificationElement element, int n)
    {
        constexpr double force = 0.1, nu = 0.3; // N
        const Held held = with_far_side(symmetric(body), body, kTissueYoung, nu, force);
        Eigen::VectorXd load = Eigen::VectorXd::Zero(held.target.size());
        load[3 * body.nearest(Vec3::Zero()) + 2] = 0.25 * force; // load on a quarter
        const VerificationSolve solve = LinearSolves(body, element, nu, held.prescribed).solve(held.target, load);
        VerificationRow row = pressed_row("point load, nu 0.3", body, element, n, solve);
        compare(row, "mean sinking of the circle of 5 mm round it, mm", mean_on_circle(body, solve),
            force * (1.0 - nu * nu) / (std::numbers::pi * kTissueYoung * kCircle));
        return row;
    }

} // namespace

VerificationProblem indentation_problem()
{
    return { "indentation",
        "half-space, nu 0.49: flat punch, 0.5264 N, order 1 for its edge; ball of 8 mm pressed in by 5 mm [Sneddon], "
        "1.0401 N, and by 0.5 mm [Hertz], 0.03509 N; disc of pressure, in points and in the mean; point load, P (1 - "
        "nu^2) / (pi E r) beside it. The far side is moved as a point load of the same force would move it "
        "[Boussinesq], which takes a finite block's 1.3 a / H away",
        [](const VerificationOptions& options, const Job& job) {
            const std::vector<Indentation> indentations { flat_punch(), pressed_ball(), shallow_ball() };
            struct Pressed {
                double order, bound;
            };
            // bound for an indenter; its force over its depth is a mean, as for the disc
            constexpr double kForce = 0.05;
            constexpr Pressed kPressed[] = { { 2.0, 0.03 }, { 1.0, 0.05 }, { 2.0, kForce }, { 2.0, 0.03 } };
            constexpr std::size_t kMean = 2; // index of the mean depth in kPressed
            std::vector<std::vector<VerificationRow>> by_problem(indentations.size() + std::size(kPressed));
            for (const HalfSpaceRun& run : half_space_runs(options.fine)) {
                std::vector<std::vector<VerificationRow>> series(by_problem.size());
                for (const int n : coarsest(run.cells, options))
                    if (!job.cancelled()) {
                        const QuarterCylinder body = quarter_cylinder(nodes_per_tet(run.element), kCircle, n);
                        std::vector<VerificationRow> all = indent(indentations, body, run.element, n);
                        for (VerificationRow& row : press_disc(body, run.element, n))
                            all.push_back(std::move(row));
                        all.push_back(press_point(body, run.element, n));
                        for (std::size_t i = 0; i < all.size(); ++i)
                            series[i].push_back(all[i]);
                    }
                for (std::size_t i = 0; i < series.size(); ++i) {
                    const bool pushed = i < indentations.size();
                    const double order = pushed ? indentations[i].order : kPressed[i - indentations.size()].order,
                                 bound = pushed ? kForce : kPressed[i - indentations.size()].bound;
                    if (pushed && !series[i].empty())
                        series[i].back().note = indentations[i].note;
                    const bool locks = run.element == VerificationElement::p1 && i + 1 < series.size(),
                               rough
                        = run.element == VerificationElement::nodal && !pushed && i != indentations.size() + kMean;
                    OrderRule rule;
                    if (rough)
                        rule = { .asks = OrderRule::Asks::nothing, .why = kRough };
                    else if (locks && i == indentations.size() + kMean)
                        rule = { .asks = OrderRule::Asks::fall, .why = "plain P1 is too stiff at nu 0.49" };
                    append_series(by_problem[i], series[i], order, locks || rough ? kNoBound : bound, rule);
                }
            }
            std::vector<VerificationRow> rows;
            for (const std::vector<VerificationRow>& problem : by_problem)
                rows.insert(rows.end(), problem.begin(), problem.end());
            return rows;
        },
        "laws but linear: the closed forms are of small strain. The point load at nu 0.49: its strain has no limit, "
        "and tissue that keeps its volume feels that far away" };
}

} // namespace retractor::verification
