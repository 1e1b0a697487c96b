#include "fem/statics/frame_opening.h"

#include "fem/statics/driven_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::fem {

namespace {

    constexpr double kFarthestStepMm = 10.0; // in nonlinear tissue, whose tangent predicts no farther
    constexpr double kLargestTurn = 0.35; // rad: a step is linear in the rotation
    constexpr int kMostHalvings = 4;
    constexpr double kNoForceN = 1e-3; // below, a blade bears nothing, and forces are round-off
    constexpr double kRoughestEnergy = 10.0; // energy tolerance of a rough opening, over that of the last opening
    constexpr double kTornStrain = 4.0; // Green-Lagrange strain at threefold stretch, beyond what any tissue bears

    enum class Stop { free, low, high };

    struct Bounds {
        double low = 0.0, high = 0.0; ///< of the step of a blade's turn, mm at the lever
    };

    void check(const ElasticProblem& problem, const BladeFrame& frame, const RackDrive& drive,
        const OpeningOptions& options, const FrameOptions& how)
    {
        if (problem.hooks.size() != frame.size())
            throw InputError(
                "a retractor has two blades, and there are " + std::to_string(problem.hooks.size()), "blades");
        check_frame(frame);
        if (drive.distance_mm.has_value() == drive.force_N.has_value())
            throw InputError("a retractor is driven either by its opening or by its force", "retractor");
        if (drive.distance_mm && !(*drive.distance_mm >= 0.0 && *drive.distance_mm <= 2.0 * kFarthestHookMm))
            throw InputError("the opening of the retractor is out of range", "retractor");
        if (drive.force_N && !(*drive.force_N >= 0.0 && std::isfinite(*drive.force_N)))
            throw InputError("the force of the retractor is negative or not finite", "retractor");
        if (!options.near.empty())
            throw InputError("a retractor cannot be combined with a condensed region", "nonlinear region");
        if (!(how.tolerance > 0.0 && how.tolerance < 1.0) || how.most_openings < 1)
            throw InputError("the search of a retractor needs a tolerance between 0 and 1 and at least one opening");
    }

    /// Solves for the unknowns that are not fixed, with the smallest step where nothing resists (a body that floats).
    FrameVector solve_free(
        const FrameMatrix& J, const FrameVector& missing, FrameVector step, const std::vector<int>& free)
    {
        constexpr double kNoStiffness = 1e-9; // relative to the stiffest motion
        const FrameVector rest = missing - J * step; // step is zero where it is free
        const Eigen::MatrixXd of_free = J(free, free);
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
        solver.setThreshold(kNoStiffness);
        solver.compute(of_free);
        const Eigen::VectorXd moved = solver.solve(Eigen::VectorXd(rest(free)));
        for (std::size_t i = 0; i < free.size(); ++i)
            step[free[i]] = moved[static_cast<Eigen::Index>(i)];
        return step;
    }

    class FrameSearch {
    public:
        FrameSearch(const ElasticProblem& problem, const BladeFrame& frame, const RackDrive& drive,
            const OpeningOptions& options, const FrameOptions& how, const Job& job)
            : problem_(problem)
            , frame_(frame)
            , drive_(drive)
            , options_(options)
            , how_(how)
            , job_(job)
            , balancing_(job)
            , lever_(frame_lever(problem.mesh, frame, problem.hooks))
            , opening_(problem, options)
        {
            if (job.on_progress)
                balancing_.on_progress = [this](std::string_view, double fraction) {
                    job_.report("opening, balance of the retractor", fraction);
                };
            found_.direction_is_held = how.direction_is_held;
            found_.state.distance = drive.distance_mm.value_or(0.0);
            found_.blades = blades_at(frame, found_.state, problem.hooks);
        }
        FrameSearch(const FrameSearch&) = delete;
        FrameSearch& operator=(const FrameSearch&) = delete;

        FrameOpening search(const std::optional<FrameStart>& start)
        {
            if (start) {
                found_.state = start->state;
                has_stiffness_ = start->stiffness.has_value();
                if (has_stiffness_)
                    found_.stiffness = *start->stiffness;
                if (start->displacement.size() != 0)
                    continue_from(start->displacement);
            } else if (drive_.force_N) {
                linearise();
                found_.state = moved_by(found_.state, next_step(), lever_);
            }
            const bool is_answer = start && start->stiffness; // of the same elements
            const bool at_rest = !start || start->displacement.size() == 0;
            open(found_.state, at_rest ? job_ : balancing_, is_answer ? options_.tolerance : tolerance_for(1.0));
            if (is_open())
                balance();
            return std::move(found_);
        }

    private:
        bool is_open() const
        {
            return found_.opening.status == OpeningStatus::converged
                || found_.opening.status == OpeningStatus::inverted;
        }
        bool is_nonlinear() const
        {
            return options_.elasticity != Elasticity::linear || options_.contact.has_value()
                || !problem_.blades.empty();
        }

        /// Residual of an opening on the way from this imbalance: the forces need not be known much better.
        double tolerance_for(double imbalance) const
        {
            constexpr double kShare = 0.02, kRoughest = 0.02;
            if (!is_nonlinear())
                return options_.tolerance;
            return std::max(options_.tolerance, std::min(kRoughest, kShare * imbalance));
        }

        void balance()
        {
            best_ = found_;
            if (how_.hold_without_balance && !how_.direction_is_held)
                first_ = found_;
            if (!find_balance())
                return;
            if (options_.elasticity == Elasticity::corotational && !options_.locking_free)
                stiffen_inverted();
            found_.opening.message += formatted("; the retractor is in balance after %d opening(s)", found_.openings);
        }

        /// @returns false where there is none; status and message then say why
        bool find_balance()
        {
            while (!is_in_balance()) {
                const bool is_nearly = found_.imbalance <= how_.tolerance && !must_be_held();
                const std::string why = out_of_range();
                if (is_nearly) {
                    if (found_.imbalance < best_.imbalance)
                        best_ = found_;
                    continue_from(found_.opening.displacement);
                    open(found_.state, balancing_, options_.tolerance);
                } else if (!why.empty() || found_.openings >= how_.most_openings) {
                    if (!first_) {
                        fail(why);
                        return false;
                    }
                    hold_direction();
                } else if (!step()) {
                    if (!first_) {
                        end_with_best();
                        return false;
                    }
                    hold_direction();
                }
                if (found_.opening.status == OpeningStatus::cancelled)
                    end_cancelled();
                if (!is_open())
                    return false;
            }
            return true;
        }

        /// A frame that is to be held where it turns too far is not in balance there.
        bool must_be_held() const { return first_ && turned() > how_.most_turned; }
        bool is_in_balance() const
        {
            return found_.imbalance <= how_.tolerance && tolerance_ <= options_.tolerance && !must_be_held();
        }

        /// Moves the frame to the predicted balance, or a part of the way where the tissue has no equilibrium farther
        /// on.
        /// @returns false where it has none on the way
        bool step()
        {
            if (found_.imbalance < best_.imbalance)
                best_ = found_;
            if (!has_stiffness_ || was_cut_ || found_.imbalance > good_step() * before_)
                linearise();
            before_ = found_.imbalance;
            const FrameVector step = next_step();
            const FrameOpening last = found_;
            const FrameVector forces = forces_;
            for (double share = 1.0;; share *= 0.5) {
                continue_from(last.opening.displacement);
                open(moved_by(last.state, share * step, lever_), balancing_, tolerance_for(last.imbalance));
                if (found_.opening.status == OpeningStatus::cancelled)
                    return true;
                if (is_open()) {
                    was_cut_ = was_cut_ || share < 1.0;
                    update(share * step, forces_ - forces);
                    return true;
                }
                if (++halvings_ > kMostHalvings || found_.openings >= how_.most_openings)
                    return false;
            }
        }

        /// The elements that are turned over and may be made stiffer.
        std::vector<TetId> inverted_and_soft() const
        {
            std::vector<TetId> soft;
            for (const TetId t : found_.opening.inverted) {
                const Label label = problem_.mesh.labels[static_cast<std::size_t>(t)];
                if (label < how_.may_stiffen.size() && how_.may_stiffen[label] != 0)
                    soft.push_back(t);
            }
            return soft;
        }

        /// Makes elements that are turned over stiffer until they resist, and balances the frame again. Blades that
        /// bear on cut bone crush the tissue before it. Where this leads to no balance with fewer such elements, the
        /// last one stays. The search ends after this.
        void stiffen_inverted()
        {
            constexpr double kStiffer = 10.0;
            constexpr int kRounds = 3, kOpeningsOfARound = 5;
            first_.reset(); // the frame stays free or held, as it is in balance
            const double before_N = largest_force(found_), before_mm = found_.state.distance;
            std::map<TetId, double> factors;
            for (int round = 0; round < kRounds; ++round) {
                const std::vector<TetId> soft = inverted_and_soft();
                if (soft.empty())
                    return;
                FrameOpening last = found_;
                opening_.stiffen(soft, kStiffer);
                for (const TetId t : soft)
                    factors[t] = factors.contains(t) ? kStiffer * factors[t] : kStiffer;
                how_.most_openings = found_.openings + kOpeningsOfARound;
                halvings_ = 0;
                was_cut_ = false;
                before_ = std::numeric_limits<double>::infinity();
                continue_from(last.opening.displacement);
                open(last.state, balancing_, options_.tolerance);
                best_ = found_;
                if (!is_open() || !find_balance()
                    || found_.opening.inverted_elements >= last.opening.inverted_elements) {
                    last.openings = found_.openings;
                    found_ = std::move(last); // also where the time is up meanwhile: the balance is there
                    return;
                }
                for (const auto& [tet, factor] : factors)
                    found_.opening.stiffened.push_back({ tet, factor });
                found_.opening.stiffening_changed_N = std::abs(largest_force(found_) - before_N);
                found_.opening.stiffening_changed_mm = std::abs(found_.state.distance - before_mm);
            }
        }

        /// Holds the frame in the direction in which it was placed, and begins at the first opening of the search
        /// again.
        /// @pre first_ is set
        void hold_direction()
        {
            how_.direction_is_held = true;
            how_.most_openings += found_.openings;
            FrameState state = first_->state;
            state.rotation = Mat3::Identity();
            const int openings = found_.openings;
            found_ = std::move(*first_);
            first_.reset();
            found_.direction_is_held = true;
            found_.openings = openings;
            has_stiffness_ = false;
            before_ = std::numeric_limits<double>::infinity();
            halvings_ = 0;
            continue_from(found_.opening.displacement);
            open(state, balancing_, tolerance_for(1.0));
            if (is_open())
                best_ = found_;
        }

        void continue_from(const Points& displacement)
        {
            opening_.start_from(displacement);
            opening_.set_load_steps(1); // the frame moves a little; steps of more than 3 mm are still divided
        }

        void open(const FrameState& state, const Job& job, double tolerance)
        {
            tolerance_ = tolerance;
            opening_.set_tolerance(tolerance,
                options_.energy_tolerance * std::clamp(tolerance / options_.tolerance, 1.0, kRoughestEnergy));
            found_.state = state;
            found_.blades = blades_at(frame_, state, std::move(found_.blades));
            found_.opening = opening_.open(found_.blades, job);
            ++found_.openings;
            found_.loads = blade_loads(problem_.mesh, found_.blades, found_.opening.hook_nodal_forces_N);
            forces_ = generalised_forces(frame_, state, found_.loads, lever_);
            found_.residual_force_N = forces_.head<3>();
            found_.residual_moment_Nmm = lever_ * forces_.segment<3>(kFrameRotation);
            found_.rack_force_N = forces_[kFrameDistance];
            found_.imbalance = imbalance();
        }

        double imbalance() const
        {
            double scale = std::max({ kNoForceN, found_.loads[0].force_N.norm(), found_.loads[1].force_N.norm() });
            double largest = forces_.head<3>().norm();
            if (!how_.direction_is_held)
                largest = std::max(largest, forces_.segment<3>(kFrameRotation).norm());
            for (std::size_t k = 0; k < frame_.size(); ++k) {
                const double moment = forces_[kFrameTurns + static_cast<Eigen::Index>(k)];
                const Bounds bounds = bounds_of(k);
                const double at_stop = kNearStop * lever_;
                const bool held
                    = (bounds.high <= at_stop && moment <= 0.0) || (bounds.low >= -at_stop && moment >= 0.0);
                largest = std::max(largest, held ? 0.0 : std::abs(moment));
            }
            if (drive_.force_N) {
                scale = std::max(scale, *drive_.force_N);
                largest = std::max(largest, std::abs(forces_[kFrameDistance] - *drive_.force_N));
            }
            return largest / scale;
        }

        Bounds bounds_of(std::size_t blade) const
        {
            const double play = frame_[blade].play, turn = found_.state.turn[blade];
            return { lever_ * std::min(0.0, -play - turn), lever_ * std::max(0.0, play - turn) };
        }

        /// Takes the stiffness of the frame at rest, or where the last opening is.
        void linearise()
        {
            // The blades of the problem name the nodes; the motions are those of the blades as they stand.
            const Eigen::MatrixXd motions = blade_motions(problem_.mesh, found_.blades);
            const TissueModel model { options_.elasticity, options_.locking_free };
            const Eigen::MatrixXd stiffness = found_.openings > 0
                ? opening_.stiffness(found_.opening.displacement, motions)
                : motion_response(
                    problem_, model, Points::Zero(problem_.mesh.vertices.rows(), 3), motions, options_.contact)
                      .stiffness;
            found_.stiffness = frame_stiffness(frame_, found_.state, found_.loads, stiffness, lever_);
            has_stiffness_ = true;
            was_cut_ = false;
        }

        /// Broyden's update: the stiffness that explains the last step and changes least.
        void update(const FrameVector& step, const FrameVector& change)
        {
            if (const double length = step.squaredNorm(); length > 0.0)
                found_.stiffness += (change - found_.stiffness * step) * step.transpose() / length;
        }

        /// The step to the predicted balance, cut to a length that the prediction bears.
        FrameVector next_step()
        {
            FrameVector missing = -forces_;
            missing[kFrameDistance] += drive_.force_N.value_or(0.0);
            FrameVector step = step_with_stops(missing);
            const double turned = std::max({ step.segment<3>(kFrameRotation).norm(), std::abs(step[kFrameTurns]),
                std::abs(step[kFrameTurns + 1]) });
            const double moved = step.head<3>().norm() + turned + 0.5 * std::abs(step[kFrameDistance]);
            double share = turned > kLargestTurn * lever_ ? kLargestTurn * lever_ / turned : 1.0;
            if (is_nonlinear() && moved > kFarthestStepMm)
                share = std::min(share, kFarthestStepMm / moved);
            was_cut_ = was_cut_ || share < 1.0;
            return share * step;
        }

        FrameVector step_with_stops(const FrameVector& missing) const
        {
            constexpr std::array kStops { Stop::free, Stop::low, Stop::high };
            for (const Stop first : kStops)
                for (const Stop second : kStops)
                    if (const auto step = step_with({ first, second }, missing))
                        return *step;
            // Where the stiffness is not definite no combination may fit. Then the blades turn freely to their stops.
            FrameVector step = solve_free(found_.stiffness, missing, FrameVector::Zero(), free_unknowns({}));
            for (std::size_t k = 0; k < frame_.size(); ++k) {
                const Bounds bounds = bounds_of(k);
                double& turn = step[kFrameTurns + static_cast<Eigen::Index>(k)];
                turn = std::clamp(turn, bounds.low, bounds.high);
            }
            return step;
        }

        std::vector<int> free_unknowns(const std::array<Stop, 2>& stops) const
        {
            std::vector<int> free { 0, 1, 2 };
            if (!how_.direction_is_held)
                free.insert(free.end(), { kFrameRotation, kFrameRotation + 1, kFrameRotation + 2 });
            for (std::size_t k = 0; k < stops.size(); ++k)
                if (stops[k] == Stop::free)
                    free.push_back(kFrameTurns + static_cast<int>(k));
            if (drive_.force_N)
                free.push_back(kFrameDistance);
            return free;
        }

        /// The step with these stops; nothing when a free blade would pass a stop, or a stop would have to pull.
        std::optional<FrameVector> step_with(const std::array<Stop, 2>& stops, const FrameVector& missing) const
        {
            FrameVector step = FrameVector::Zero();
            for (std::size_t k = 0; k < stops.size(); ++k) {
                const Bounds bounds = bounds_of(k);
                if (frame_[k].play == 0.0 && stops[k] != Stop::low)
                    return std::nullopt; // without play both stops are one, which pushes and pulls
                if (stops[k] != Stop::free)
                    step[kFrameTurns + static_cast<Eigen::Index>(k)] = stops[k] == Stop::low ? bounds.low : bounds.high;
            }
            step = solve_free(found_.stiffness, missing, step, free_unknowns(stops));
            const FrameVector left = found_.stiffness * step - missing; // forces after the step
            for (std::size_t k = 0; k < stops.size(); ++k) {
                const Eigen::Index row = kFrameTurns + static_cast<Eigen::Index>(k);
                const Bounds bounds = bounds_of(k);
                const bool fits = stops[k] == Stop::free ? step[row] >= bounds.low && step[row] <= bounds.high
                    : stops[k] == Stop::low              ? frame_[k].play == 0.0 || left[row] >= 0.0
                                                         : left[row] <= 0.0;
                if (!fits)
                    return std::nullopt;
            }
            return step;
        }

        double turned() const { return std::abs(Eigen::AngleAxisd(found_.state.rotation).angle()); } ///< rad

        /// Why the frame cannot be where it is; empty: it can.
        std::string out_of_range() const
        {
            if (turned() > how_.most_turned)
                return formatted(", and it turns by %.0f degrees", turned() * 180.0 / std::numbers::pi);
            if (found_.opening.strain_p99 > kTornStrain)
                return formatted(
                    ", but tissue is strained by %.0f %%: tissue tears before", 100.0 * found_.opening.strain_p99);
            for (const HookPatch& blade : found_.blades)
                if (blade.displacement.norm() > kFarthestHookMm)
                    return formatted(", but a blade moves at most %.0f mm", kFarthestHookMm);
            return {};
        }

        void fail(const std::string& why)
        {
            found_.opening.status = OpeningStatus::not_converged;
            found_.opening.message = no_balance(found_, found_.openings) + why;
            end_with_best();
        }

        void end_cancelled()
        {
            found_.opening.message = no_balance(best_, found_.openings);
            end_with_best();
        }

        static double largest_force(const FrameOpening& at)
        {
            return std::max(at.loads[0].force_N.norm(), at.loads[1].force_N.norm());
        }

        std::string no_balance(const FrameOpening& at, int openings) const
        {
            const double force = largest_force(at);
            return formatted("the retractor found no balance in %d opening(s): at %.1f mm between its "
                             "blades they bear up to %.3g N, and %.3g N of it are not balanced",
                openings, at.state.distance, force, at.imbalance * std::max(force, drive_.force_N.value_or(0.0)));
        }

        /// Ends a search without balance: the state is that of the best balance on the way, status and message stay.
        void end_with_best()
        {
            best_.opening.status = found_.opening.status;
            best_.opening.message = std::move(found_.opening.message);
            best_.openings = found_.openings;
            found_ = std::move(best_);
        }

        /// A step that leaves more of the imbalance than this share was predicted badly. Blades in contact slip, which
        /// the linearised tissue does not: Broyden's update predicts their further steps better.
        double good_step() const { return problem_.blades.empty() ? 0.3 : 0.7; }

        static constexpr double kNearStop = 1e-9; ///< rad, round-off of a turn

        const ElasticProblem& problem_;
        const BladeFrame& frame_;
        RackDrive drive_;
        OpeningOptions options_;
        FrameOptions how_; ///< changes where the frame must be held
        const Job& job_;
        Job balancing_; ///< the job of all openings after the first: its progress begins again under another name
        double lever_;
        Opening opening_;
        FrameOpening found_;
        FrameOpening best_; ///< of the openings so far, the one nearest to balance
        std::optional<FrameOpening> first_; ///< where the search begins again when the frame must be held
        FrameVector forces_ = FrameVector::Zero(); ///< generalised forces at the present state
        double tolerance_ = 0.0; ///< residual of the present state, as OpeningOptions::tolerance
        double before_ = std::numeric_limits<double>::infinity(); ///< imbalance before the last step
        int halvings_ = 0; ///< of all steps
        bool has_stiffness_ = false;
        bool was_cut_ = false; ///< the last step ended before the predicted balance
    };

} // namespace

FrameOpening open_with_frame(const ElasticProblem& problem, const BladeFrame& frame, const RackDrive& drive,
    const OpeningOptions& options, const FrameOptions& how, const Job& job, const std::optional<FrameStart>& start)
{
    check(problem, frame, drive, options, how);
    for (const HookPatch& blade : problem.hooks)
        for (const VertexId v : blade.nodes)
            if (v < 0 || v >= problem.mesh.vertices.rows())
                throw InputError("node " + std::to_string(v) + " is out of range", "hook '" + blade.name + "'");
    return FrameSearch(problem, frame, drive, options, how, job).search(start);
}

} // namespace retractor::fem
