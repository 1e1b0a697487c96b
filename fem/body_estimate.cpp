#include "fem/body_estimate.h"

#include "fem/constrained_solver.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <utility>

namespace retractor {

namespace {

    /// The ends of the edge that each midpoint lies on; `first` is the number of corners.
    std::vector<std::array<VertexId, 2>> midpoint_ends(const TetMesh& fine, VertexId first)
    {
        std::vector<std::array<VertexId, 2>> ends(fine.vertex_count() - static_cast<std::size_t>(first));
        for (std::size_t t = 0; t < fine.tet_count(); ++t) {
            const auto nodes = fine.tet(static_cast<TetId>(t));
            for (std::size_t e = 0; e < kTetEdges.size(); ++e)
                ends[static_cast<std::size_t>(nodes[4 + e] - first)]
                    = { nodes[static_cast<std::size_t>(kTetEdges[e][0])],
                          nodes[static_cast<std::size_t>(kTetEdges[e][1])] };
        }
        return ends;
    }

    /// Linear functions among the quadratic ones.
    class Nesting {
    public:
        Nesting(std::size_t corners, std::vector<std::array<VertexId, 2>> ends)
            : corners_(static_cast<Eigen::Index>(corners))
            , ends_(std::move(ends))
        {
        }

        Eigen::VectorXd prolong(const Eigen::VectorXd& coarse) const
        {
            Eigen::VectorXd fine(3 * (corners_ + static_cast<Eigen::Index>(ends_.size())));
            fine.head(3 * corners_) = coarse;
            for (std::size_t e = 0; e < ends_.size(); ++e)
                fine.segment<3>(3 * (corners_ + static_cast<Eigen::Index>(e)))
                    = 0.5 * (coarse.segment<3>(3 * ends_[e][0]) + coarse.segment<3>(3 * ends_[e][1]));
            return fine;
        }

        Eigen::VectorXd restrict_to_corners(const Eigen::VectorXd& fine) const
        {
            Eigen::VectorXd coarse = fine.head(3 * corners_);
            for (std::size_t e = 0; e < ends_.size(); ++e) {
                const Vec3 half = 0.5 * fine.segment<3>(3 * (corners_ + static_cast<Eigen::Index>(e)));
                coarse.segment<3>(3 * ends_[e][0]) += half;
                coarse.segment<3>(3 * ends_[e][1]) += half;
            }
            return coarse;
        }

        Eigen::Index corners() const { return corners_; }
        std::size_t midpoints() const { return ends_.size(); }

    private:
        Eigen::Index corners_;
        std::vector<std::array<VertexId, 2>> ends_;
    };

    /// The linear part by its factor, the edge functions by their diagonal blocks.
    class TwoLevels {
    public:
        TwoLevels(ConstrainedSolver& coarse, const Nesting& nesting, const std::vector<std::uint8_t>& held)
            : coarse_(coarse)
            , nesting_(nesting)
            , held_(held)
        {
        }

        void take_blocks(const BlockMatrix& K)
        {
            inverse_.resize(nesting_.midpoints());
            for (std::size_t e = 0; e < inverse_.size(); ++e) {
                const std::size_t node = static_cast<std::size_t>(nesting_.corners()) + e;
                const auto last = static_cast<std::size_t>(K.pattern.row_start[node + 1] - 1);
                const Mat3 block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&K.values[9 * last]);
                const Eigen::LLT<Mat3> factor(block);
                // Where the true stiffness is not positive definite at an edge, any positive scale will do.
                inverse_[e] = factor.info() == Eigen::Success
                    ? Mat3(factor.solve(Mat3::Identity()))
                    : Mat3(Mat3::Identity() / block.diagonal().cwiseAbs().maxCoeff());
            }
        }

        Eigen::VectorXd coarse_part(const Eigen::VectorXd& r)
        {
            return nesting_.prolong(coarse_.solve(nesting_.restrict_to_corners(r)));
        }

        Eigen::VectorXd apply(const Eigen::VectorXd& r)
        {
            Eigen::VectorXd z = coarse_part(r);
            for (std::size_t e = 0; e < inverse_.size(); ++e) {
                const auto at = 3 * (nesting_.corners() + static_cast<Eigen::Index>(e));
                if (held_[static_cast<std::size_t>(at)] == 0)
                    z.segment<3>(at) += inverse_[e] * r.segment<3>(at);
            }
            mask(z);
            return z;
        }

        void mask(Eigen::VectorXd& vector) const
        {
            for (std::size_t i = 0; i < held_.size(); ++i)
                if (held_[i] != 0)
                    vector[static_cast<Eigen::Index>(i)] = 0.0;
        }

    private:
        ConstrainedSolver& coarse_;
        const Nesting& nesting_;
        const std::vector<std::uint8_t>& held_;
        std::vector<Mat3> inverse_;
    };

    struct Step {
        EstimateStatus status = EstimateStatus::done;
        bool negative_curvature = false;
        Eigen::VectorXd du;
        double energy = 0.0; ///< du K du
        int iterations = 0;
    };

    /// Conjugate gradients until what is left, seen over the last few steps [Hestenes, Stiefel 1952], is small beside
    /// what was found.
    Step solve(const BlockMatrix& K, const Eigen::VectorXd& b, TwoLevels& levels, double noise, const Job& job)
    {
        // A thousandth in energy norm: forces, which are quadratic in it, then have two digits of the error.
        constexpr double kTolerance = 1e-3;
        constexpr std::size_t kLookBack = 4;
        constexpr int kMostIterations = 400;
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

} // namespace

BodyEstimate estimate_error(ElasticBody& coarse_body, const std::vector<std::uint8_t>& coarse_held,
    ElasticBody& fine_body, const std::vector<std::uint8_t>& fine_held, const Eigen::VectorXd& answer, const Job& job)
{
    job.report("error estimate", 0.0);
    if (!std::isfinite(coarse_body.response(answer).energy))
        return { .status = EstimateStatus::not_converged,
            .message = "no estimate: elements of the answer are turned over",
            .displacement = {},
            .forces = {} };
    const BlockMatrix& coarse_K = coarse_body.stiffness(answer, 1.0);
    ConstrainedSolver coarse(coarse_K.pattern, coarse_held);
    coarse.factorise(coarse_K);
    job.report("error estimate", 0.3);

    const auto corners = static_cast<VertexId>(coarse_body.mesh().vertex_count());
    const Nesting nesting(coarse_body.mesh().vertex_count(), midpoint_ends(fine_body.mesh(), corners));
    const Eigen::VectorXd start = nesting.prolong(answer);
    const ElasticBody::Response there = fine_body.response(start);
    TwoLevels levels(coarse, nesting, fine_held);

    constexpr double kRoundOff = 1e-24; // of the energy: the square of round-off in forces, with room
    BodyEstimate estimate;
    Step step;
    // The true stiffness, or one whose negative eigenvalues are lifted as far as it takes to be positive definite.
    for (const double lifted : { 0.0, 0.25, 1.0 }) {
        const BlockMatrix& K = fine_body.stiffness(start, lifted);
        levels.take_blocks(K);
        job.report("error estimate", 0.6);
        step = solve(K, -there.forces, levels, kRoundOff * std::abs(there.energy), job);
        estimate.iterations += step.iterations;
        if (!step.negative_curvature || fine_body.model() == Elasticity::linear)
            break;
    }
    estimate.status = step.status;
    estimate.bytes = coarse_body.bytes() + coarse.bytes() + fine_body.bytes();
    if (step.status == EstimateStatus::not_converged)
        estimate.message
            = "no estimate: the finer problem was not solved in " + std::to_string(step.iterations) + " iterations";
    else if (step.status == EstimateStatus::cancelled)
        estimate.message = "cancelled after " + std::to_string(step.iterations) + " iterations";
    if (step.status != EstimateStatus::done)
        return estimate;
    estimate.displacement = start + step.du;
    estimate.forces = there.forces + fine_body.last_stiffness().multiply(step.du);
    const double scale = 2.0 * std::abs(there.energy); // of loads alone: minus the work of half of them
    Eigen::VectorXd unsolved = nesting.restrict_to_corners(there.forces);
    coarse.mask(unsolved);
    const double algebraic = unsolved.dot(coarse.solve(unsolved));
    estimate.energy_error = scale > 0.0 ? std::sqrt(step.energy / scale) : 0.0;
    estimate.algebraic_error = scale > 0.0 ? std::sqrt(std::max(algebraic, 0.0) / scale) : 0.0;
    return estimate;
}

} // namespace retractor
