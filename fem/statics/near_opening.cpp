#include "fem/statics/near_opening.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace retractor::fem {

namespace {

    constexpr int kQuasiNewtonSteps = 10; // per allowed Newton step, see OpeningOptions::max_newton_iterations

    std::vector<HookDrive> targets(std::span<const HookPatch> hooks)
    {
        std::vector<HookDrive> to;
        for (const HookPatch& hook : hooks) {
            if (hook.turns())
                throw InputError("a hook that turns cannot be combined with a condensed region", "nonlinear region");
            to.push_back({ .displacement = hook.displacement });
        }
        return to;
    }

    /// Displacement of the hook that moves farthest.
    double farthest_way(NonlinearRegion& field, std::span<const HookDrive> from, std::span<const HookDrive> to)
    {
        constexpr double kNoFartherMm = 150.0; // stiffness at rest predicts large displacements badly
        std::vector<Vec3> predicted;
        if (std::any_of(to.begin(), to.end(), [](const HookDrive& drive) { return drive.force_N.has_value(); }))
            predicted = field.predict_hook_displacements(to);
        double farthest = 0.0;
        for (std::size_t h = 0; h < to.size(); ++h)
            farthest = std::max(farthest,
                to[h].force_N ? std::min(kNoFartherMm, predicted[h].norm())
                              : (to[h].displacement - from[h].displacement).norm());
        return farthest;
    }

    Points points(const Eigen::VectorXd& displacement)
    {
        return Eigen::Map<const Points>(displacement.data(), displacement.size() / 3, 3);
    }

    class NearOpening {
    public:
        NearOpening(const mesh::TetMesh& mesh, std::span<const Material> materials, const Supports& supports,
            std::span<const HookPatch> hooks, const OpeningOptions& options, const Job& job)
            : mesh_(mesh)
            , materials_(materials)
            , supports_(supports)
            , hooks_(hooks)
            , options_(options)
            , job_(job)
            , to_(targets(hooks))
            , from_ { .displacement = Eigen::VectorXd::Zero(3 * mesh.vertices.rows()),
                .hook_displacements = std::vector<Vec3>(hooks.size(), Vec3::Zero()),
                .hook_forces_N = std::vector<Vec3>(hooks.size(), Vec3::Zero()) }
        {
        }

        OpeningResult open()
        {
            open_linear_beyond();
            if (result_.far && !result_.far->kept) {
                if (job_.cancelled())
                    stop_before_whole();
                else
                    open_whole();
            }
            result_.solve_seconds = watch_.seconds() - result_.factor_seconds;
            return std::move(result_);
        }

    private:
        NonlinearRegion field(const std::vector<std::uint8_t>& near)
        {
            const Stopwatch watch;
            NonlinearRegion made(mesh_, materials_, supports_, { hooks_.begin(), hooks_.end() }, near,
                { .elasticity = options_.elasticity,
                    .tolerance = options_.tolerance,
                    .max_iterations = kQuasiNewtonSteps * options_.max_newton_iterations,
                    .load = options_.load });
            (void)made.prepare();
            result_.factor_seconds += watch.seconds();
            record_part(job_, "nonlinear region", watch, made.bytes());
            return made;
        }

        void open_linear_beyond()
        {
            NonlinearRegion near = field(options_.near);
            const std::vector<Vec3> rest = from_.hook_displacements;
            DragInSteps how { .least_steps = options_.load_steps };
            bool good = true;
            if (near.rim_vertices() > 0)
                how.keep_going = [&](const NearFrame& frame, double share) {
                    return good = worth_going_on(near.far_change(), frame, share);
                };
            const NearFrame dragged = drag_in_steps(near, prescribed_drives(rest), to_, how, job_);
            if (!good)
                return;
            settle(near, dragged);
            if (near.rim_vertices() > 0 && result_.status == OpeningStatus::converged) {
                near.refresh(); // the present factor may belong to rest and underestimate stretched tissue
                judge(near.far_change());
            }
            job_.report("opening", 1.0);
        }

        /// Result when the job is cancelled at the moment the linear region is given up: the last state of a linear
        /// region that is not good enough.
        void stop_before_whole()
        {
            result_.far.reset();
            result_.status = OpeningStatus::cancelled;
            result_.message = "cancelled where the linear condensed region was given up";
            result_.displacement = points(from_.displacement);
            result_.hook_forces_N = from_.hook_forces_N;
            result_.residual = from_.residual;
        }

        /// Decides after a step whether the linear region can stay. Its error grows with the displacement of the hooks.
        /// Where the final error would be far above the limit, the present state is kept and the rest is computed
        /// nonlinearly everywhere.
        bool worth_going_on(const FarChange& change, const NearFrame& frame, double share)
        {
            constexpr double kHopeless = 15.0;
            const double off = relative_change(change, frame);
            if (change.finite) {
                from_ = frame;
                share_ = share;
            }
            if (off > kHopeless * share * options_.far_tolerance)
                result_.far = { .kept = false, .change = off, .share = share_ };
            return !result_.far;
        }

        void judge(FarChange change)
        {
            LinearCondensedRegion& far = result_.far.emplace();
            far.change = relative_change(change, settled_);
            far.kept = change.finite && far.change <= options_.far_tolerance;
            if (far.kept) {
                far.displacement_change = points(change.displacement);
                far.hook_force_changes_N = std::move(change.hook_forces_N);
            } else if (change.finite) {
                from_ = settled_;
                share_ = 1.0;
            }
            far.share = share_;
        }

        void open_whole()
        {
            NonlinearRegion whole = field(std::vector<std::uint8_t>(mesh_.tet_count(), 1));
            whole.start_from(from_);
            DragInSteps how { .least_steps
                = std::max(1, static_cast<int>(std::ceil((1.0 - share_) * options_.load_steps))) };
            NearFrame dragged = from_;
            if (share_ < 1.0)
                dragged = drag_in_steps(whole, prescribed_drives(from_.hook_displacements), to_, how, job_);
            settle(whole, dragged);
        }

        /// Brings the body to equilibrium. After a cancelled drag the hooks are not at their targets, even in
        /// equilibrium.
        void settle(NonlinearRegion& field, const NearFrame& dragged)
        {
            const bool on_the_way = job_.cancelled();
            NearFrame settled = field.settle(job_);
            result_.hook_forces_N = settled.hook_forces_N;
            result_.residual = settled.residual;
            result_.newton_iterations += settled.iterations;
            result_.message = settled.message;
            result_.status = settled.status == NearStatus::settled ? OpeningStatus::converged
                : settled.status == NearStatus::cancelled          ? OpeningStatus::cancelled
                                                                   : OpeningStatus::not_converged;
            if (on_the_way) {
                result_.status = OpeningStatus::cancelled;
                result_.message = "cancelled while the hooks moved; there " + result_.message;
            } else if (!dragged.reached) {
                if (result_.status == OpeningStatus::converged)
                    result_.status = OpeningStatus::not_converged;
                result_.message = dragged.message + "; there " + result_.message;
            }
            result_.displacement = points(settled.displacement);
            settled_ = std::move(settled);
        }

        const mesh::TetMesh& mesh_;
        std::span<const Material> materials_;
        const Supports& supports_;
        std::span<const HookPatch> hooks_;
        const OpeningOptions& options_;
        const Job& job_;
        std::vector<HookDrive> to_;
        NearFrame from_; ///< the last state with valid far elements
        double share_ = 0.0; ///< share of the hooks' motion at this state
        NearFrame settled_;
        OpeningResult result_;
        Stopwatch watch_;
    };

} // namespace

NearFrame drag_in_steps(NonlinearRegion& field, std::span<const HookDrive> from, std::span<const HookDrive> to,
    const DragInSteps& how, const Job& job)
{
    RETRACTOR_ASSERT(from.size() == to.size());
    constexpr int kRefreshes = 3;
    const int steps
        = std::max(how.least_steps, static_cast<int>(std::ceil(farthest_way(field, from, to) / how.step_mm)));
    NearFrame frame;
    std::vector<HookDrive> target(to.size());
    for (int step = 1; step <= steps; ++step) {
        const double share = static_cast<double>(step) / steps;
        for (std::size_t h = 0; h < to.size(); ++h)
            target[h] = between(from[h], to[h], share);
        frame = field.drag(target);
        for (int again = 0; again < kRefreshes && (!frame.reached || frame.residual > how.refresh_above); ++again) {
            if (job.cancelled())
                break;
            field.refresh();
            frame = field.drag(target);
        }
        const bool done = job.cancelled() || !frame.reached || (how.keep_going && !how.keep_going(frame, share));
        job.report("opening", static_cast<double>(step) / (steps + 1));
        if (done || job.cancelled())
            return frame;
    }
    return frame;
}

OpeningResult open_near(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
    const Supports& supports, std::span<const HookPatch> hooks, const OpeningOptions& options, const Job& job)
{
    return NearOpening(mesh, material_of_label, supports, hooks, options, job).open();
}

} // namespace retractor::fem
