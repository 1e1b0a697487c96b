#include "fem/statics/driven_opening.h"

#include "fem/statics/opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

namespace retractor::fem {

namespace {

    constexpr double kAtRest = 5e-4; // limit of the next Newton step, relative to the farthest hook displacement
    constexpr double kFarthestStepMm = 10.0; // limit in nonlinear tissue, whose tangent predicts no farther
    constexpr int kMostOpenings = 30, kMostHalvings = 4;
    // Green-Lagrange strain at threefold stretch; skin, the toughest tissue, fails below twofold stretch.
    constexpr double kTornStrain = 4.0;

    double farthest(const Eigen::VectorXd& x)
    {
        double most = 0.0;
        for (Eigen::Index h = 0; h < x.size(); h += 3)
            most = std::max(most, x.segment<3>(h).norm());
        return most;
    }

    bool was_opened(const OpeningResult& opening)
    {
        return opening.status == OpeningStatus::converged || opening.status == OpeningStatus::inverted;
    }

    /// Joins the progress of all openings of a search into one stage that only rises.
    class SearchProgress {
    public:
        explicit SearchProgress(const Job& job)
            : job_(job)
            , of_opening_(job)
        {
            if (job.on_progress)
                of_opening_.on_progress = [this](std::string_view stage, double fraction) {
                    if (stage == kStage)
                        show(from_ + fraction * (to_ - from_));
                    else
                        job_.report(stage, fraction);
                };
        }
        SearchProgress(const SearchProgress&) = delete;
        SearchProgress& operator=(const SearchProgress&) = delete;

        /// @param openings expected number of openings, this one included
        const Job& next_opening(double openings)
        {
            from_ = shown_;
            to_ = from_ + (1.0 - from_) / openings;
            return of_opening_;
        }

        void done() { show(1.0); }

    private:
        static constexpr std::string_view kStage = "opening";

        void show(double fraction)
        {
            if (fraction > shown_)
                job_.report(kStage, shown_ = fraction);
        }

        const Job& job_;
        Job of_opening_;
        double shown_ = 0.0, from_ = 0.0, to_ = 1.0;
    };

    class HookSearch {
    public:
        HookSearch(const ElasticProblem& problem, std::span<const HookDrive> drives, const OpeningOptions& options)
            : problem_(problem)
            , drives_(drives.begin(), drives.end())
            , options_(options)
            , far_tolerance_(options.far_tolerance)
            , at_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(drives.size())))
        {
            found_.hooks = problem.hooks;
            make_opening();
        }

        DrivenOpening search(const Job& job)
        {
            const Points rest = Points::Zero(problem_.mesh.vertices.rows(), 3);
            HookRest next = rest_at(rest, at_);
            int halvings = 0;
            double share = 1.0; // share of the Newton step that is tried
            SearchProgress progress(job);
            while (found_.openings < kMostOpenings) {
                Eigen::VectorXd step = share * (next.displacement - at_);
                double steps = 1.0; // number of steps of this length that the way needs
                if (const double way = farthest(step); nonlinear() && way > kFarthestStepMm) {
                    steps = way / kFarthestStepMm;
                    step /= steps;
                }
                open_at(at_ + step, progress.next_opening(std::ceil(steps / share) + (nonlinear() ? 1.0 : 0.0)));
                if (!was_opened(found_.opening)) {
                    if (found_.opening.status == OpeningStatus::cancelled || ++halvings > kMostHalvings)
                        return finished();
                    share *= 0.5;
                    continue;
                }
                share = 1.0;
                halvings = 0;
                at_ += step;
                decide_on_condensed_region();
                next = rest_at(found_.opening.displacement, packed(found_.opening.hook_forces_N));
                found_.yielded = next.yielded;
                found_.last_step_mm = farthest(next.displacement - at_);
                if (next.converged && found_.last_step_mm <= kAtRest * farthest(at_) && is_condensed_region_good()) {
                    progress.done();
                    return finished();
                }
                if (farthest(next.displacement) > farthest(at_))
                    if (std::string why = beyond_tissue(); !why.empty())
                        return without_equilibrium(next, why);
            }
            return without_equilibrium(next, "");
        }

    private:
        /// Why the tissue cannot follow the hooks from their present place; empty: it can.
        std::string beyond_tissue() const
        {
            std::ostringstream text;
            text << std::setprecision(3);
            if (found_.opening.strain_p99 > kTornStrain)
                text << "tissue is strained by " << 100.0 * found_.opening.strain_p99 << " %: tissue tears before";
            else if (farthest(at_) > kFarthestHookMm)
                text << "a hook moves at most " << kFarthestHookMm << " mm";
            return text.str();
        }

        DrivenOpening without_equilibrium(const HookRest& next, const std::string& why)
        {
            std::size_t hook = 0; // the hook that moved farthest
            for (std::size_t h = 1; h < found_.hooks.size(); ++h)
                if (found_.hooks[h].displacement.norm() > found_.hooks[hook].displacement.norm())
                    hook = h;
            const HookPatch& moved = found_.hooks[hook];
            const Vec3 there = next.displacement.segment<3>(3 * static_cast<Eigen::Index>(hook));
            std::ostringstream text;
            text << "the hooks found no equilibrium in " << found_.openings << " opening(s): " << std::setprecision(3)
                 << "at " << found_.opening.hook_forces_N[hook].norm() << " N hook '" << moved.name << "' has moved "
                 << moved.displacement.norm() << " mm and would move " << (there - moved.displacement).norm()
                 << " mm farther" << (why.empty() ? "" : ", but " + why);
            found_.opening.message = text.str();
            found_.opening.status = OpeningStatus::not_converged;
            return finished();
        }

        void make_opening() { opening_.emplace(problem_, options_); }

        /// Fixes the choice for the openings that follow: a linear region that was kept stays, with any error, until
        /// the hooks are in equilibrium; a linear region that was given up stays nonlinear.
        void decide_on_condensed_region()
        {
            const std::optional<LinearCondensedRegion>& far = found_.opening.far;
            if (!far)
                return;
            if (!far->kept)
                give_condensed_region_up(*far);
            else if (!std::isinf(options_.far_tolerance)) {
                options_.far_tolerance = std::numeric_limits<double>::infinity();
                make_opening();
            }
        }

        /// Compares the error of the linear region at equilibrium with the requested limit.
        /// @return false when the region is given up now
        bool is_condensed_region_good()
        {
            const std::optional<LinearCondensedRegion>& far = found_.opening.far;
            if (!far || !far->kept || far->change <= far_tolerance_)
                return true;
            give_condensed_region_up({ .kept = false, .change = far->change });
            return false;
        }

        void give_condensed_region_up(LinearCondensedRegion far)
        {
            given_up_ = std::move(far);
            std::fill(options_.near.begin(), options_.near.end(), std::uint8_t { 1 });
            make_opening();
        }

        DrivenOpening finished()
        {
            if (given_up_ && found_.opening.status != OpeningStatus::cancelled)
                found_.opening.far = std::move(given_up_);
            return std::move(found_);
        }

        bool nonlinear() const
        {
            return options_.elasticity != Elasticity::linear || options_.contact.has_value()
                || !problem_.blades.empty();
        }

        /// Predicts the equilibrium of the hooks from the forces and the tangent at this state.
        HookRest rest_at(const Points& displacement, const Eigen::VectorXd& forces)
        {
            if (stiffness_.size() == 0 || nonlinear())
                stiffness_ = definite(hook_response(
                    problem_, { options_.elasticity, options_.locking_free }, displacement, options_.contact)
                                          .stiffness);
            return rest_of_hooks(stiffness_, forces - stiffness_ * at_, drives_);
        }

        void open_at(const Eigen::VectorXd& hooks, const Job& job)
        {
            for (std::size_t h = 0; h < found_.hooks.size(); ++h)
                found_.hooks[h].displacement = hooks.segment<3>(3 * static_cast<Eigen::Index>(h));
            found_.opening = opening_->open(found_.hooks, job);
            ++found_.openings;
        }

        const ElasticProblem& problem_;
        std::vector<HookDrive> drives_;
        OpeningOptions options_;
        double far_tolerance_; ///< the requested limit
        std::optional<LinearCondensedRegion> given_up_;
        std::optional<Opening> opening_;
        Eigen::VectorXd at_; ///< displacement of the hooks, three per hook
        Eigen::MatrixXd stiffness_;
        DrivenOpening found_;
    };

} // namespace

HookResponse hook_response(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
    const std::optional<ContactOptions>& contact)
{
    TissueLinearisation tissue(problem, model, displacement, contact);
    return tissue.response(hook_motions(tissue.held(), problem.hooks.size()));
}

HookResponse motion_response(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
    const Eigen::MatrixXd& motions, const std::optional<ContactOptions>& contact)
{
    return TissueLinearisation(problem, model, displacement, contact).response(motions);
}

std::optional<ReleasedHooks> release_hooks(const HookResponse& response, const Eigen::VectorXd& at,
    const Eigen::VectorXd& forces, const Eigen::VectorXd& other_forces, const std::vector<HookDrive>& drives)
{
    RETRACTOR_ASSERT(at.size() == 3 * static_cast<Eigen::Index>(drives.size()) && forces.size() == at.size());
    constexpr double kMostRatio = 10.0;
    Eigen::VectorXd by_way = forces, other_by_way = other_forces;
    if (response.of_loads.size() != 0) {
        by_way -= response.of_loads;
        other_by_way -= response.of_loads;
    }
    const double own = by_way.norm(), other = other_by_way.norm();
    const double ratio = own > 0.0 ? other / own : 1.0;
    const bool alike = other_by_way.dot(by_way) > 0.0 || own == 0.0;
    if (!(alike && ratio <= kMostRatio && ratio * kMostRatio >= 1.0)) // also true for NaN
        return std::nullopt;
    const Eigen::MatrixXd R = ratio * definite(response.stiffness);
    const Eigen::VectorXd there = forces + resisted(response.stiffness, other_forces - forces);
    const HookRest rest = rest_of_hooks(R, there - R * at, drives);
    if (!rest.converged)
        return std::nullopt;
    const Eigen::VectorXd way = rest.displacement - at;
    return ReleasedHooks { way, there + R * way };
}

namespace {

    /// Hooks that share a node stay together only when all of them prescribe the same displacement.
    void check_shared_nodes(const ElasticProblem& problem, std::span<const HookDrive> drives)
    {
        std::vector<int> hook_of_node(problem.mesh.vertex_count(), -1);
        for (std::size_t h = 0; h < drives.size(); ++h)
            for (const VertexId v : problem.hooks[h].nodes) {
                if (v < 0 || static_cast<std::size_t>(v) >= hook_of_node.size())
                    continue; // prescribe() reports the bad node
                int& first = hook_of_node[static_cast<std::size_t>(v)];
                if (first < 0) {
                    first = static_cast<int>(h);
                    continue;
                }
                const auto other = static_cast<std::size_t>(first);
                if (other == h
                    || (drives[h].prescribes() && drives[other].prescribes()
                        && drives[h].displacement == drives[other].displacement))
                    continue;
                throw InputError("hooks '" + problem.hooks[other].name + "' and '" + problem.hooks[h].name
                        + "' share node " + std::to_string(v)
                        + ": they would be driven apart. Only hooks that are moved alike may share nodes",
                    "hook '" + problem.hooks[h].name + "'");
            }
    }

} // namespace

DrivenOpening open_driven(
    const ElasticProblem& problem, std::span<const HookDrive> drives, const OpeningOptions& options, const Job& job)
{
    if (drives.size() != problem.hooks.size())
        throw InputError("there are " + std::to_string(problem.hooks.size()) + " hooks and "
                + std::to_string(drives.size()) + " drives",
            "hooks");
    for (std::size_t h = 0; h < drives.size(); ++h)
        check_drive(drives[h], problem.hooks[h].name);
    check_shared_nodes(problem, drives);
    return HookSearch(problem, drives, options).search(job);
}

} // namespace retractor::fem
