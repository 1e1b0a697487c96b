#include "fem/body_estimate.h"

#include "fem/constrained_solver.h"
#include "mesh/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
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

    /// Contact by the coarse body's pairs. A point of theirs feels the displacement there and the mean of what the
    /// finer elements add on the edges round it, weighted by the area of the faces in contact on both sides of an edge.
    class ContactByAverages {
    public:
        ContactByAverages(const ElasticBody& coarse, const TetMesh& fine, const Eigen::VectorXd& answer)
            : contact_(coarse.contact())
            , coarse_size_(answer.size())
        {
            if (contact_ == nullptr)
                return;
            forces_ = Eigen::VectorXd::Zero(answer.size());
            (void)contact_->add_response(answer, forces_);
            BlockPattern none;
            none.row_start.assign(coarse.mesh().vertex_count() + 1, 0);
            stiffness_.pattern = contact_->pattern(none);
            weigh_edges(coarse.mesh(), fine);
        }

        /// For add_product(); what is indefinite in it is left out by the share `lifted`.
        void linearise(const Eigen::VectorXd& answer, double lifted)
        {
            if (contact_ == nullptr)
                return;
            stiffness_.values.assign(9 * stiffness_.pattern.block_count(), 0.0);
            contact_->add_stiffness(answer, lifted, stiffness_);
        }

        void add_forces(Eigen::VectorXd& to) const
        {
            if (contact_ != nullptr)
                spread(forces_, to);
        }
        void add_product(const Eigen::VectorXd& u, Eigen::VectorXd& to) const
        {
            if (contact_ != nullptr)
                spread(stiffness_.multiply(average(u)), to);
        }

    private:
        struct Share { ///< of what an edge's function adds to one of its ends
            VertexId end, other, middle;
            double weight;
        };

        void weigh_edges(const TetMesh& coarse, const TetMesh& fine)
        {
            std::vector<double> area(coarse.vertex_count(), 0.0);
            std::map<std::array<VertexId, 2>, double> of_edge; // end and midpoint
            std::map<VertexId, std::array<VertexId, 2>> ends;
            for (const TetFace& face : boundary_faces(coarse)) {
                const auto corners = face_vertices(coarse, face);
                if (!std::all_of(corners.begin(), corners.end(),
                        [&](VertexId v) { return !forces_.segment<3>(3 * v).isZero(0.0); }))
                    continue;
                const Vec3 a = coarse.vertices.row(corners[0]), b = coarse.vertices.row(corners[1]),
                           c = coarse.vertices.row(corners[2]);
                const double size = (b - a).cross(c - a).norm();
                for (const VertexId v : corners)
                    area[static_cast<std::size_t>(v)] += size;
                const auto nodes = fine.tet(face.tet);
                for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
                    const auto [i, j] = kTetEdges[e];
                    if (i == face.corner || j == face.corner)
                        continue;
                    const VertexId middle = nodes[4 + e];
                    ends[middle] = { nodes[static_cast<std::size_t>(i)], nodes[static_cast<std::size_t>(j)] };
                    for (const VertexId end : ends[middle])
                        of_edge[{ end, middle }] += 0.5 * size; // two of a face's edges end there
                }
            }
            for (const auto& [edge, size] : of_edge) {
                const auto [end, middle] = edge;
                const auto [a, b] = ends[middle];
                shares_.push_back({ end, end == a ? b : a, middle, size / area[static_cast<std::size_t>(end)] });
            }
        }

        Eigen::VectorXd average(const Eigen::VectorXd& u) const
        {
            Eigen::VectorXd mean = u.head(coarse_size_);
            for (const Share& s : shares_)
                mean.segment<3>(3 * s.end) += s.weight
                    * (u.segment<3>(3 * s.middle) - 0.5 * u.segment<3>(3 * s.end) - 0.5 * u.segment<3>(3 * s.other));
            return mean;
        }
        /// The transpose of average().
        void spread(const Eigen::VectorXd& forces, Eigen::VectorXd& to) const
        {
            to.head(coarse_size_) += forces;
            for (const Share& s : shares_) {
                const Vec3 part = s.weight * forces.segment<3>(3 * s.end);
                to.segment<3>(3 * s.middle) += part;
                to.segment<3>(3 * s.end) -= 0.5 * part;
                to.segment<3>(3 * s.other) -= 0.5 * part;
            }
        }

        const Contact* contact_;
        Eigen::Index coarse_size_;
        Eigen::VectorXd forces_;
        BlockMatrix stiffness_;
        std::vector<Share> shares_;
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
    Step solve(const BlockMatrix& K, const ContactByAverages& contact, const Eigen::VectorXd& b, TwoLevels& levels,
        double noise, const Job& job)
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

    /// @param must_be false: where K is not positive definite, false is the answer.
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
    job.report("error estimate", 0.0);
    if (!std::isfinite(coarse_body.response(answer).energy))
        return { .status = EstimateStatus::not_converged,
            .message = "no estimate: elements of the answer are turned over",
            .displacement = {},
            .forces = {},
            .coarse_displacement = {},
            .coarse_forces = {} };
    ConstrainedSolver coarse(coarse_body.stiffness(answer, 1.0).pattern, coarse_held);
    job.report("error estimate", 0.3);

    const auto corners = static_cast<VertexId>(coarse_body.mesh().vertex_count());
    const Nesting nesting(coarse_body.mesh().vertex_count(), midpoint_ends(fine_body.mesh(), corners));
    const Eigen::VectorXd start = nesting.prolong(answer);
    ElasticBody::Response there = fine_body.response(start);
    ContactByAverages contact(coarse_body, fine_body.mesh(), answer);
    contact.add_forces(there.forces);
    TwoLevels levels(coarse, nesting, fine_held);

    constexpr double kRoundOff = 1e-24; // of the energy: the square of round-off in forces, with room
    BodyEstimate estimate;
    Step step;
    // The true stiffness, or one whose negative eigenvalues are lifted as far as it takes to be positive definite: the
    // same of both bodies, so that the coarse one's is the finer one's among linear functions.
    for (const double lifted : { 0.0, 0.25, 1.0 }) {
        const BlockMatrix& coarse_K = coarse_body.stiffness(answer, lifted);
        if (!is_factorised(coarse, coarse_K, lifted == 1.0)) // among more functions it is no more positive
            continue;
        const BlockMatrix& K = fine_body.stiffness(start, lifted);
        contact.linearise(answer, lifted);
        levels.take_blocks(K);
        job.report("error estimate", 0.6);
        step = solve(K, contact, -there.forces, levels, kRoundOff * std::abs(there.energy), job);
        estimate.iterations += step.iterations;
        if (!step.negative_curvature)
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
    contact.add_product(step.du, estimate.forces);
    const double scale = 2.0 * std::abs(there.energy); // of loads alone: minus the work of half of them
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

} // namespace retractor
