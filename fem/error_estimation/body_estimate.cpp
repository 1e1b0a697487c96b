#include "fem/error_estimation/body_estimate.h"

#include "fem/error_estimation/averaged_contact.h"
#include "fem/error_estimation/two_level_preconditioner.h"
#include "fem/linear_algebra/constrained_solver.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace retractor::fem {

namespace {

    struct Step {
        EstimateStatus status = EstimateStatus::done;
        bool negative_curvature = false;
        Eigen::VectorXd du;
        double energy = 0.0; ///< du K du, N mm
        int iterations = 0;
    };

    /// Conjugate gradients, until the energy gained in the last few steps [Hestenes, Stiefel 1952] is small relative
    /// to the energy of the solution.
    Step solve(const BlockMatrix& K, const AveragedContact& contact, const Eigen::VectorXd& b,
        TwoLevelPreconditioner& levels, double noise, const Job& job)
    {
        // A thousandth in energy norm. Forces are quadratic in this norm; they then have two digits of the error.
        constexpr double kTolerance = 1e-3;
        constexpr std::size_t kLookBack = 4;
        // flat elements take several hundred iterations, others less than a hundred
        constexpr int kMostIterations = 1000;
        Step step;
        step.du = Eigen::VectorXd::Zero(b.size());
        Eigen::VectorXd r = b;
        levels.mask(r);
        Eigen::VectorXd z = levels.apply(r), p = z;
        double rz = r.dot(z);
        std::deque<double> gained;
        for (; rz > noise; ++step.iterations) {
            if (job.cancelled()) {
                step.status = EstimateStatus::cancelled;
                return step;
            }
            Eigen::VectorXd Kp = K.multiply(p);
            contact.add_product(p, Kp);
            levels.mask(Kp);
            const double curvature = p.dot(Kp);
            step.negative_curvature = !(curvature > 0.0);
            if (step.negative_curvature || step.iterations == kMostIterations) {
                step.status = EstimateStatus::not_converged;
                return step;
            }
            const double length = rz / curvature;
            step.du += length * p;
            r -= length * Kp;
            gained.push_back(length * rz);
            step.energy += gained.back();
            if (gained.size() > kLookBack)
                gained.pop_front();
            double lately = 0.0;
            for (const double gain : gained)
                lately += gain;
            if (gained.size() == kLookBack && lately <= kTolerance * kTolerance * step.energy)
                break;
            z = levels.apply(r);
            const double next = r.dot(z);
            p = z + (next / rz) * p;
            rz = next;
        }
        return step;
    }

    /// @param must_be whether an indefinite K is an error.
    /// @return false when K is not positive definite and `must_be` is false.
    bool is_factorised(ConstrainedSolver& solver, const BlockMatrix& K, bool must_be)
    {
        try {
            solver.factorise(K);
            return true;
        } catch (const SolverError&) {
            if (must_be)
                throw;
            return false;
        }
    }

} // namespace

BodyEstimate estimate_error(ElasticBody& coarse_body, const std::vector<std::uint8_t>& coarse_held,
    ElasticBody& fine_body, const std::vector<std::uint8_t>& fine_held, const Eigen::VectorXd& answer, const Job& job)
{
    RETRACTOR_ASSERT(static_cast<std::size_t>(answer.size()) == coarse_held.size());
    job.report("error estimate", 0.0);
    (void)coarse_body.renew_follower_loads(answer);
    coarse_body.renew_blades(answer);
    if (!std::isfinite(coarse_body.response(answer).energy))
        return { .status = EstimateStatus::not_converged,
            .message = "no estimate: elements of the answer are turned over",
            .displacement = {},
            .forces = {},
            .coarse_displacement = {},
            .coarse_forces = {} };
    ConstrainedSolver coarse(coarse_body.stiffness(answer, 1.0).pattern, coarse_held);
    job.report("error estimate", 0.3);

    const Nesting nesting(fine_body.mesh(), coarse_body.mesh().vertex_count());
    const Eigen::VectorXd start = nesting.prolong(answer);
    (void)fine_body.renew_follower_loads(start);
    fine_body.renew_blades(start);
    ElasticBody::Response there = fine_body.response(start);
    AveragedContact contact(coarse_body, fine_body.mesh(), answer);
    contact.add_forces(there.forces);
    TwoLevelPreconditioner levels(coarse, nesting, contact, fine_held);

    constexpr double kRoundOff = 1e-24; // relative to the energy: the square of round-off in forces, with a margin
    BodyEstimate estimate;
    Step step;
    // The true stiffness, or a stiffness whose negative eigenvalues are raised until it is positive definite. Both
    // bodies use the same share, so that the coarse stiffness is the finer one restricted to linear functions.
    for (const double lifted : { 0.0, 0.25, 1.0 }) {
        const BlockMatrix& coarse_K = coarse_body.stiffness(answer, lifted);
        if (!is_factorised(coarse, coarse_K, lifted == 1.0)) // more functions do not make the stiffness more positive
            continue;
        const BlockMatrix& K = fine_body.stiffness(start, lifted);
        contact.linearise(answer, lifted);
        levels.take_blocks(coarse_K, K);
        job.report("error estimate", 0.6);
        step = solve(K, contact, -there.forces, levels, kRoundOff * std::abs(there.energy), job);
        estimate.iterations += step.iterations;
        if (!step.negative_curvature)
            break;
    }
    estimate.status = step.status;
    estimate.bytes = coarse_body.bytes() + coarse.bytes() + fine_body.bytes() + levels.bytes();
    if (step.status == EstimateStatus::not_converged)
        estimate.message
            = "no estimate: the finer problem was not solved in " + std::to_string(step.iterations) + " iterations";
    else if (step.status == EstimateStatus::cancelled)
        estimate.message = "cancelled after " + std::to_string(step.iterations) + " iterations";
    if (step.status != EstimateStatus::done)
        return estimate;
    estimate.displacement = start + step.du;
    estimate.forces = there.forces + fine_body.last_stiffness().multiply(step.du);
    contact.add_product(step.du, estimate.forces);
    const double scale = 2.0 * std::abs(there.energy); // with loads alone the energy is minus half of their work
    estimate.coarse_forces = nesting.restrict_to_corners(there.forces);
    Eigen::VectorXd unsolved = estimate.coarse_forces;
    coarse.mask(unsolved);
    const Eigen::VectorXd left = coarse.solve(unsolved);
    estimate.coarse_displacement = answer - left;
    estimate.coarse_forces -= coarse_body.last_stiffness().multiply(left);
    const double algebraic = unsolved.dot(left);
    estimate.energy_error = scale > 0.0 ? std::sqrt(step.energy / scale) : 0.0;
    estimate.algebraic_error = scale > 0.0 ? std::sqrt(std::max(algebraic, 0.0) / scale) : 0.0;
    return estimate;
}

} // namespace retractor::fem
