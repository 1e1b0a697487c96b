#include "fem/driven_opening.h"

#include "fem/constrained_solver.h"
#include "mesh/base/error.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace retractor {

namespace {

    constexpr double kAtRest = 5e-4; // of the farthest way: the next step of Newton's method
    constexpr double kFarthestStepMm = 10.0; // of nonlinear tissue, whose tangent foretells no more
    constexpr int kMostOpenings = 30, kMostHalvings = 4;

    Eigen::VectorXd packed(const std::vector<Vec3>& of)
    {
        Eigen::VectorXd x(3 * static_cast<Eigen::Index>(of.size()));
        for (std::size_t h = 0; h < of.size(); ++h)
            x.segment<3>(3 * static_cast<Eigen::Index>(h)) = of[h];
        return x;
    }

    double farthest(const Eigen::VectorXd& x)
    {
        double most = 0.0;
        for (Eigen::Index h = 0; h < x.size(); h += 3)
            most = std::max(most, x.segment<3>(h).norm());
        return most;
    }

    /// Near a limit point the tangent is not definite; the hooks' rest needs one that is.
    Eigen::MatrixXd definite(const Eigen::MatrixXd& R)
    {
        constexpr double kSoftest = 1e-6; // of the stiffest
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(R);
        const double least = kSoftest * modes.eigenvalues().cwiseAbs().maxCoeff();
        if (modes.eigenvalues().minCoeff() >= least)
            return R;
        return modes.eigenvectors() * modes.eigenvalues().cwiseAbs().cwiseMax(least).asDiagonal()
            * modes.eigenvectors().transpose();
    }

    /// The true stiffness where it is positive definite, else the least lifted one.
    const BlockMatrix& factorise(ElasticBody& body, const Eigen::VectorXd& u, ConstrainedSolver& solver)
    {
        constexpr double kLeast = 1.0 / 64.0, kMore = 4.0;
        for (double lift = 0.0;; lift = std::min(1.0, std::max(kMore * lift, kLeast))) {
            const BlockMatrix& K = body.stiffness(u, lift);
            try {
                solver.factorise(K);
                return K;
            } catch (const SolverError&) {
                if (lift == 1.0)
                    throw;
            }
        }
    }

    bool was_opened(const OpeningResult& opening)
    {
        return opening.status == OpeningStatus::converged || opening.status == OpeningStatus::inverted;
    }

    class HookSearch {
    public:
        HookSearch(const ElasticProblem& problem, std::span<const HookDrive> drives, const OpeningOptions& options)
            : problem_(problem)
            , drives_(drives.begin(), drives.end())
            , options_(options)
            , opening_(problem.mesh, problem.material_of_label, problem.supports, options)
            , at_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(drives.size())))
        {
            found_.hooks = problem.hooks;
        }

        DrivenOpening search(const Job& job)
        {
            const Points rest = Points::Zero(problem_.mesh.vertices.rows(), 3);
            HookRest next = rest_at(rest, at_);
            int halvings = 0;
            double share = 1.0; // of the way that is tried
            while (found_.openings < kMostOpenings) {
                Eigen::VectorXd step = share * (next.displacement - at_);
                if (const double way = farthest(step); nonlinear() && way > kFarthestStepMm)
                    step *= kFarthestStepMm / way;
                open_at(at_ + step, job);
                if (!was_opened(found_.opening)) {
                    if (found_.opening.status == OpeningStatus::cancelled || ++halvings > kMostHalvings)
                        return std::move(found_);
                    share *= 0.5;
                    continue;
                }
                share = 1.0;
                at_ += step;
                next = rest_at(found_.opening.displacement, packed(found_.opening.hook_forces_N));
                found_.yielded = next.yielded;
                found_.last_step_mm = farthest(next.displacement - at_);
                if (next.converged && found_.last_step_mm <= kAtRest * farthest(at_))
                    return std::move(found_);
            }
            found_.opening.status = OpeningStatus::not_converged;
            char text[128];
            std::snprintf(text, sizeof text, "the hooks found no rest in %d openings: %.2g mm are left; ",
                found_.openings, found_.last_step_mm);
            found_.opening.message = text + found_.opening.message;
            return std::move(found_);
        }

    private:
        bool nonlinear() const { return options_.elasticity != Elasticity::linear || options_.contact.has_value(); }

        /// Where the hooks would rest if the tissue went on as at this state.
        HookRest rest_at(const Points& displacement, const Eigen::VectorXd& forces)
        {
            if (stiffness_.size() == 0 || options_.elasticity != Elasticity::linear)
                stiffness_
                    = definite(hook_stiffness(problem_, { options_.elasticity, options_.locking_free }, displacement));
            return rest_of_hooks(stiffness_, forces - stiffness_ * at_, drives_);
        }

        void open_at(const Eigen::VectorXd& hooks, const Job& job)
        {
            for (std::size_t h = 0; h < found_.hooks.size(); ++h)
                found_.hooks[h].displacement = hooks.segment<3>(3 * static_cast<Eigen::Index>(h));
            found_.opening = opening_.open(found_.hooks, job);
            ++found_.openings;
        }

        const ElasticProblem& problem_;
        std::vector<HookDrive> drives_;
        OpeningOptions options_;
        Opening opening_;
        Eigen::VectorXd at_; ///< the hooks, three each
        Eigen::MatrixXd stiffness_;
        DrivenOpening found_;
    };

} // namespace

Eigen::MatrixXd hook_stiffness(const ElasticProblem& problem, const TissueModel& model, const Points& displacement)
{
    ElasticBody body = tissue_body(problem.mesh, problem.material_of_label, model);
    body.set_bed(bed_stiffness(problem.mesh, problem.supports));
    std::vector<HookPatch> still = problem.hooks; // hooks that share nodes move alike only if they are told the same
    for (HookPatch& hook : still)
        hook.displacement.setZero();
    const Prescribed held = prescribe(problem.mesh, problem.supports, still);
    const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
    (void)body.stiffness(u, 0.0);
    ConstrainedSolver solver(body.last_stiffness().pattern, held.flag);
    const BlockMatrix& K = factorise(body, u, solver);
    const auto columns = 3 * static_cast<Eigen::Index>(problem.hooks.size());
    Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(u.size(), columns), forces(u.size(), columns);
    for (std::size_t v = 0; v < held.hook_of_node.size(); ++v)
        if (const int hook = held.hook_of_node[v]; hook >= 0)
            moved.block<3, 3>(3 * static_cast<Eigen::Index>(v), 3 * hook).setIdentity();
    for (Eigen::Index c = 0; c < columns; ++c)
        forces.col(c) = -K.multiply(moved.col(c));
    const Eigen::MatrixXd follow = moved + solver.solve_all(forces);
    for (Eigen::Index c = 0; c < columns; ++c)
        forces.col(c) = K.multiply(follow.col(c));
    const Eigen::MatrixXd R = follow.transpose() * forces;
    return 0.5 * (R + R.transpose());
}

DrivenOpening open_driven(
    const ElasticProblem& problem, std::span<const HookDrive> drives, const OpeningOptions& options, const Job& job)
{
    if (drives.size() != problem.hooks.size())
        throw InputError("there are " + std::to_string(problem.hooks.size()) + " hooks and "
                + std::to_string(drives.size()) + " drives",
            "hooks");
    for (std::size_t h = 0; h < drives.size(); ++h)
        check_drive(drives[h], problem.hooks[h].name);
    return HookSearch(problem, drives, options).search(job);
}

} // namespace retractor
