#include "fem/equilibrium.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor {

namespace {

    double largest_nodal_norm(const Eigen::VectorXd& vector)
    {
        double largest = 0.0;
        for (Eigen::Index i = 0; i < vector.size(); i += 3)
            largest = std::max(largest, vector.segment<3>(i).squaredNorm());
        return std::sqrt(largest);
    }

    double largest_diagonal(const BlockMatrix& K)
    {
        double largest = 0.0;
        for (std::size_t row = 0; row < K.pattern.row_count(); ++row)
            if (K.pattern.row_start[row] < K.pattern.row_start[row + 1])
                for (const std::size_t i : { 0U, 4U, 8U })
                    largest = std::max(
                        largest, K.values[9 * static_cast<std::size_t>(K.pattern.row_start[row + 1] - 1) + i]);
        return largest;
    }

    /// One call of EquilibriumSolver::solve: the state and the clocks of the Newton iteration.
    class Newton {
    public:
        Newton(ElasticBody& body, ConstrainedSolver& solver, const EquilibriumOptions& options, const Job& job,
            Equilibrium& result, bool& assembled)
            : body_(body)
            , solver_(solver)
            , options_(options)
            , job_(job)
            , result_(result)
            , assembled_(assembled)
            , stiffest_(largest_diagonal(body.last_stiffness()))
        {
        }

        void start_from(const Eigen::VectorXd& u)
        {
            u_ = u;
            state_ = respond(u_);
        }
        const Eigen::VectorXd& displacement() const { return u_; }
        const Eigen::VectorXd& forces() const { return state_.forces; }

        /// Adds `motion` (zero on free unknowns) to the prescribed unknowns, the free ones following by a linearised
        /// solve.
        void move(const Eigen::VectorXd& motion)
        {
            const BlockMatrix& K = assemble(true);
            const Eigen::VectorXd b = -state_.forces - K.multiply(motion);
            constexpr double kGuess = 0.05; // relative; Newton goes on from here
            u_ += motion + solve(b, kGuess);
            state_ = respond(u_);
        }

        enum class Outcome { converged, failed, cancelled };

        Outcome iterate(double tolerance)
        {
            for (int i = 0;; ++i) {
                result_.residual = residual();
                if (result_.residual <= tolerance)
                    return Outcome::converged;
                if (job_.cancelled())
                    return Outcome::cancelled;
                if (i == options_.max_newton_iterations || !std::isfinite(result_.residual) || !step())
                    return Outcome::failed;
            }
        }

        /// Relative to the largest internal force, or to round-off where a rigid motion leaves no force.
        double residual() const
        {
            constexpr double kRoundOff = 1e-12;
            const double noise = kRoundOff * stiffest_ * largest_nodal_norm(u_);
            const double scale = std::max(largest_nodal_norm(state_.forces), noise);
            if (scale == 0.0)
                return 0.0;
            Eigen::VectorXd r = state_.forces;
            solver_.mask(r);
            const double largest = largest_nodal_norm(r);
            return largest <= noise ? 0.0 : largest / scale;
        }

    private:
        /// One Newton step; false when no descent is found.
        bool step()
        {
            assemble(false);
            Eigen::VectorXd r = state_.forces;
            solver_.mask(r);
            // A coarse linear solve is enough far from rest; near it, two digits per Newton step [Eisenstat, Walker
            // 1996].
            const double forcing = std::clamp(result_.residual, 1e-2, 0.1);
            const Eigen::VectorXd du = solve(-r, forcing);
            ++result_.newton_iterations;
            return search(du, r.dot(du));
        }

        bool search(const Eigen::VectorXd& du, double slope)
        {
            constexpr double kArmijo = 1e-4, kShortest = 1e-4;
            const double noise = 1e-13 * std::abs(state_.energy); // below it energies cannot be told apart
            if (!(slope < 0.0))
                return false;
            for (double length = 1.0; length > kShortest; length *= 0.5) {
                Eigen::VectorXd u = u_ + length * du;
                ElasticBody::Response there = respond(u);
                if (std::isfinite(there.energy) && there.energy <= state_.energy + kArmijo * length * slope + noise) {
                    u_ = std::move(u);
                    state_ = std::move(there);
                    return true;
                }
            }
            return false;
        }

        /// Conjugate gradients with the stiffness assembled last and the factor at hand; with a new factor, of the
        /// projected stiffness, when they take longer than that is worth.
        Eigen::VectorXd solve(const Eigen::VectorXd& b, double tolerance)
        {
            constexpr int kWorthAFactor = 20; // a factorisation takes as long as about 30 iterations
            constexpr int kFresh = 60; // with a fresh factor only the projection differs
            if (solver_.factorised()) {
                const ConstrainedSolver::Iterated iterated = iterate_linear(b, tolerance, kWorthAFactor);
                if (iterated.converged || iterated.negative_curvature)
                    return iterated.solution;
            }
            factorise(assemble(true));
            if (body_.model() == Elasticity::linear)
                return solver_.solve(b);
            assemble(false);
            return iterate_linear(b, tolerance, kFresh).solution;
        }

        ConstrainedSolver::Iterated iterate_linear(const Eigen::VectorXd& b, double tolerance, int max_iterations)
        {
            const Stopwatch watch;
            ConstrainedSolver::Iterated iterated
                = solver_.iterate(body_.last_stiffness(), b, tolerance, max_iterations);
            result_.solver_iterations += iterated.iterations;
            result_.solve_seconds += watch.seconds();
            return iterated;
        }

        void factorise(const BlockMatrix& K)
        {
            const Stopwatch watch;
            const bool first = !solver_.factorised();
            solver_.factorise(K);
            result_.factor_seconds += watch.seconds();
            ++result_.factorisations;
            if (first)
                record_part(job_, "factorisation", watch, solver_.bytes());
        }

        const BlockMatrix& assemble(bool projected)
        {
            const Stopwatch watch;
            const BlockMatrix& K = body_.stiffness(u_, projected);
            result_.assemble_seconds += watch.seconds();
            if (!std::exchange(assembled_, true))
                record_part(job_, "assembly", watch, body_.bytes());
            return K;
        }

        ElasticBody::Response respond(const Eigen::VectorXd& u)
        {
            const Stopwatch watch;
            ElasticBody::Response response = body_.response(u);
            result_.assemble_seconds += watch.seconds();
            return response;
        }

        ElasticBody& body_;
        ConstrainedSolver& solver_;
        const EquilibriumOptions& options_;
        const Job& job_;
        Equilibrium& result_;
        bool& assembled_;
        double stiffest_; ///< N/mm
        Eigen::VectorXd u_;
        ElasticBody::Response state_;
    };

    Eigen::VectorXd prescribed_part(const std::vector<std::uint8_t>& prescribed, const Eigen::VectorXd& vector)
    {
        Eigen::VectorXd part = Eigen::VectorXd::Zero(vector.size());
        for (std::size_t i = 0; i < prescribed.size(); ++i)
            if (prescribed[i] != 0)
                part[static_cast<Eigen::Index>(i)] = vector[static_cast<Eigen::Index>(i)];
        return part;
    }

    /// Load steps: full ones of 1/load_steps, halved where Newton fails, doubled again after success.
    void load_in_steps(Newton& newton, const Eigen::VectorXd& motion, const EquilibriumOptions& options, const Job& job,
        Equilibrium& result)
    {
        const double full_step = 1.0 / options.load_steps;
        const double smallest = full_step / 16.0;
        constexpr double kOnTheWay = 0.05; // a state on the way only has to be a good place to go on from
        constexpr double kWhole = 1.0 - 1e-12;
        double step = full_step;
        while (true) {
            const double next = result.load + step > kWhole ? 1.0 : result.load + step;
            const Eigen::VectorXd saved = newton.displacement();
            newton.move((next - result.load) * motion);
            const auto outcome
                = newton.iterate(next == 1.0 ? options.tolerance : std::max(kOnTheWay, options.tolerance));
            if (outcome == Newton::Outcome::cancelled) {
                result.status = EquilibriumStatus::cancelled;
                return;
            }
            if (outcome == Newton::Outcome::converged) {
                result.load = next;
                job.report("opening", next);
                if (next == 1.0)
                    return;
                step = std::min(full_step, 2.0 * step);
                continue;
            }
            step = 0.5 * (next - result.load);
            const bool give_up = step < smallest;
            if (!give_up || !newton.displacement().allFinite() || !newton.forces().allFinite())
                newton.start_from(saved);
            else
                result.load = next; // the best there is: at the load asked for, at rest only in part
            if (give_up) {
                result.status = EquilibriumStatus::not_converged;
                return;
            }
        }
    }

} // namespace

Equilibrium EquilibriumSolver::solve(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const Eigen::VectorXd& start, const EquilibriumOptions& options, const Job& job)
{
    Equilibrium result;
    if (!solver_ || solver_->prescribed() != prescribed) {
        const Stopwatch watch;
        if (!assembled_) {
            (void)body.stiffness(start, true);
            assembled_ = true;
            result.assemble_seconds += watch.seconds();
            record_part(job, "assembly", watch, body.bytes());
        }
        const Stopwatch analysis;
        solver_.emplace(body.last_stiffness().pattern, prescribed);
        result.factor_seconds += analysis.seconds();
    }
    Newton newton(body, *solver_, options, job, result, assembled_);
    newton.start_from(start);
    const Eigen::VectorXd motion = prescribed_part(prescribed, target - start);
    if (body.model() == Elasticity::linear) {
        newton.move(motion);
        result.load = 1.0;
        if (newton.iterate(options.tolerance) != Newton::Outcome::converged)
            result.status = job.cancelled() ? EquilibriumStatus::cancelled : EquilibriumStatus::not_converged;
    } else {
        load_in_steps(newton, motion, options, job, result);
    }
    result.residual = newton.residual();
    result.displacement = newton.displacement();
    result.forces = newton.forces();
    return result;
}

} // namespace retractor
