#include "fem/statics/equilibrium.h"

#include "fem/linear_algebra/norm.h"
#include "fem/statics/lifted_factor.h"
#include "fem/statics/local_relaxation.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace retractor::fem {

namespace {

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

    /// State and clocks of the Newton iteration during one call of EquilibriumSolver::solve.
    class Newton {
    public:
        /// @param is_first whether the body has not been solved before
        Newton(ElasticBody& body, ConstrainedSolver& solver, const EquilibriumOptions& options, const Job& job,
            Equilibrium& result, std::size_t& pattern, bool& assembled, bool is_first)
            : body_(body)
            , solver_(solver)
            , options_(options)
            , job_(job)
            , result_(result)
            , pattern_(pattern)
            , assembled_(assembled)
            , stiffest_(largest_diagonal(body.last_stiffness()))
            , guesses_friction_(is_first)
        {
        }

        void start_from(const Eigen::VectorXd& u)
        {
            RETRACTOR_ASSERT(u.size() == 3 * body_.mesh().vertices.rows());
            u_ = u;
            reach_ = std::max(reach_, largest_length(u_));
            // the body may hold the follower loads of a state that was given up
            (void)body_.renew_follower_loads(u_);
            state_ = respond(u_);
        }
        /// Stores the largest nodal force of the body's whole loads at u. Loads that balance each other leave no other
        /// force as a scale of the residual.
        void take_loads(const Eigen::VectorXd& u)
        {
            body_.set_load_share(0.0);
            const Eigen::VectorXd without = respond(u).forces;
            body_.set_load_share(1.0);
            largest_load_ = largest_length(respond(u).forces - without);
        }
        ElasticBody& body() const { return body_; }
        const EquilibriumOptions& options() const { return options_; }
        const Job& job() const { return job_; }
        Equilibrium& result() const { return result_; }
        const std::vector<std::uint8_t>& prescribed() const { return solver_.prescribed(); }
        const Eigen::VectorXd& displacement() const { return u_; }
        double energy() const { return state_.energy; }
        const Eigen::VectorXd& forces() const { return state_.forces; }

        /// Adds `motion` (zero on free unknowns) to the prescribed unknowns; the free unknowns follow by a linearised
        /// solve. Where the linearisation fails (stretched bone that turns, inverted elements), the energy is many
        /// times the predicted energy, and the motion is halved.
        /// @return the share of the motion that was made: 1, 1/2, 1/4 .. or 0 when no share was accepted and nothing
        /// moved
        double move(const Eigen::VectorXd& motion)
        {
            constexpr double kTrusted = 3.0, kSmallest = 1.0 / 32.0;
            // What touches a blade changes with the step, which the prediction does not know.
            constexpr double kOfBlades = 0.01; // share of the energy
            const double slack = body_.blades() != nullptr ? kOfBlades * std::abs(state_.energy) : 0.0;
            // Blades move before the tissue follows: the step is linearised with the places that they will touch.
            const Eigen::VectorXd ahead = u_ + motion;
            body_.expect_blades(&ahead);
            const Eigen::VectorXd unbalanced = body_.blades() != nullptr ? -respond(u_).forces : -state_.forces;
            const auto [rest, follow] = predict(unbalanced, motion);
            const BlockMatrix& K = body_.last_stiffness();
            body_.expect_blades(nullptr);
            for (double share = 1.0; share >= kSmallest; share *= 0.5)
                // A body that was not at rest settles too, unless this fails.
                for (const double settled : { 1.0, 0.0 }) {
                    const Eigen::VectorXd du = settled * rest + share * follow;
                    const double predicted = state_.forces.dot(du) + 0.5 * du.dot(K.multiply(du));
                    Eigen::VectorXd u = u_ + du;
                    ElasticBody::Response there = respond(u);
                    const double limit = kTrusted * std::max(predicted, 0.0) + energy_noise(u) + slack;
                    const double risen = there.energy - state_.energy - (contact_energy(u) - contact_energy(u_));
                    if (std::isfinite(there.energy) && risen <= limit) {
                        u_ = std::move(u);
                        state_ = std::move(there);
                        return share;
                    }
                }
            return 0.0;
        }

        enum class Outcome { converged, out_of_iterations, failed, cancelled };

        /// Pairs the surfaces in contact anew. @return whether the pairs changed
        bool renew_contact(Contact::Pairing pairing = Contact::Pairing::all_anew)
        {
            if (body_.contact() == nullptr || !body_.find_contact(u_, pairing))
                return false;
            if (pattern_ != body_.patterns_made()) {
                solver_.change_pattern();
                pattern_ = body_.patterns_made();
            }
            state_ = respond(u_);
            return true;
        }

        /// Iterates as iterate(), until the pairs in contact are the pairs of the state that is reached.
        Outcome settle(double tolerance, int max_iterations)
        {
            // A point that slides over some faces needs one round per face. Where two sets of pairs lead to each
            // other's equilibrium, further rounds do not end.
            constexpr int kRoundsAnew = 6, kRounds = 12;
            Outcome outcome = settle_blades(begin_friction(tolerance, max_iterations), tolerance, max_iterations);
            Energies before = energies();
            for (int round = 0; outcome == Outcome::converged
                 && renew_contact(round < kRoundsAnew ? Contact::Pairing::all_anew : Contact::Pairing::new_only);
                 ++round) {
                if (round == kRounds)
                    return Outcome::out_of_iterations;
                outcome = settle_blades(iterate(tolerance, max_iterations), tolerance, max_iterations);
                const Energies after = energies();
                if (is_rough() && is_unchanged(after.all - before.all, after.contact - before.contact))
                    return outcome; // other pairs do not matter
                before = after;
            }
            return outcome;
        }

        Outcome iterate(double tolerance, int max_iterations)
        {
            last_ = {};
            for (int i = 0;; ++i) {
                if (body_.renew_follower_loads(u_) > 0.0)
                    state_ = respond(u_);
                result_.residual = residual();
                if (job_.cancelled())
                    return Outcome::cancelled;
                if (result_.residual <= std::max(tolerance, kNoForce) || has_settled())
                    return Outcome::converged;
                if (!std::isfinite(result_.residual))
                    return Outcome::failed;
                if (i == max_iterations)
                    return Outcome::out_of_iterations;
                relax_locally(tolerance);
                if (result_.residual <= std::max(tolerance, kNoForce))
                    return Outcome::converged;
                if (!step())
                    return Outcome::failed;
            }
        }

        /// Brings nodes with large forces to rest, as long as these forces are local and the energy falls.
        void relax_locally(double tolerance)
        {
            constexpr double kLargeResidual = 0.05; // below, Newton's steps are whole
            constexpr double kWorthARound = 1e-5; // fall of the energy, as a share of it
            constexpr int kRounds = 4; // the large forces move to neighbours a few times
            if (body_.has_loads() || !body_.has_parts() || body_.mesh().vertex_count() < options_.relax_locally_from)
                return;
            const double enough = std::max(tolerance, kLargeResidual);
            bool goes_on = true;
            for (int round = 0; goes_on && round < kRounds && result_.residual > enough && !job_.cancelled(); ++round) {
                if (!locally_)
                    locally_.emplace(body_, solver_.prescribed());
                Eigen::VectorXd r = state_.forces;
                solver_.mask(r);
                const Stopwatch watch;
                std::optional<Eigen::VectorXd> u = locally_->relax(u_, r);
                result_.solve_seconds += watch.seconds();
                if (!u)
                    return;
                ElasticBody::Response there = respond(*u);
                if (!std::isfinite(there.energy) || there.energy >= state_.energy)
                    return;
                goes_on = state_.energy - there.energy >= kWorthARound * std::abs(state_.energy);
                u_ = std::move(*u);
                state_ = std::move(there);
                result_.residual = residual();
            }
        }

        /// Iterates as iterate(), and renews the friction of the blades on the way: the state before needs no rest.
        Outcome begin_friction(double tolerance, int max_iterations)
        {
            constexpr double kRoughly = 0.2; // residual of a state whose friction is not known yet
            if (body_.blades() != nullptr && tolerance < kRoughly) {
                const bool is_guessed = std::exchange(guesses_friction_, false) && guess_friction();
                if (const Outcome outcome = iterate(kRoughly, max_iterations); outcome != Outcome::converged)
                    return outcome;
                body_.renew_blades(u_, is_guessed ? 1.0 : kFrictionShare);
                state_ = respond(u_);
            }
            return iterate(tolerance, max_iterations);
        }

        /// Takes the friction of a first opening from the blades' forces at the present state: from a start near the
        /// answer this saves the steps of tissue that sticks. @return whether a blade bears anything
        bool guess_friction()
        {
            if (std::ranges::none_of(
                    body_.blades()->bearing(u_), [](const BladeBearing& blade) { return blade.force_N > 0.0; }))
                return false;
            body_.renew_blades(u_);
            state_ = respond(u_);
            return true;
        }

        /// Renews the friction of the blades until it belongs to the state. A part of a change is made at a time:
        /// friction changes the forces that it comes from.
        Outcome settle_blades(Outcome outcome, double tolerance, int max_iterations)
        {
            const double known = std::max(kFrictionError, kFrictionPerResidual * tolerance);
            for (int round = 0; outcome == Outcome::converged && body_.blades() != nullptr; ++round) {
                if (body_.blades()->friction_error(u_) <= known)
                    return outcome;
                if (round == kFrictionRounds)
                    return Outcome::out_of_iterations;
                body_.renew_blades(u_, kFrictionShare);
                state_ = respond(u_);
                outcome = iterate(tolerance, max_iterations);
            }
            return outcome;
        }

        /// Largest residual force relative to the largest support force or nodal load. The load is part of the scale
        /// because a load that balances itself leaves almost no force on far supports. Where a rigid motion, or the way
        /// back to rest, leaves only round-off, the result is at most kNoForce.
        double residual() const
        {
            const double noise = kNoForce * stiffest_ * std::max(reach_, largest_length(u_));
            const double scale = std::max({ largest_reaction(), largest_load_, noise });
            if (scale == 0.0)
                return 0.0;
            Eigen::VectorXd r = state_.forces;
            solver_.mask(r);
            const double largest = largest_length(r);
            return largest <= noise ? std::min(kNoForce, largest / scale) : largest / scale;
        }

    private:
        /// Friction force that may be missing, relative to the force of a blade. The balance of a retractor is known no
        /// better.
        static constexpr double kFrictionError = 0.005;
        /// The same for a residual of 1: a rough state has a rough friction.
        static constexpr double kFrictionPerResidual = 4.0;
        static constexpr double kStartTolerance = 1e-3; ///< of a linear solve that a step begins with
        static constexpr double kShortest = 1e-4; ///< share of a step below which no length is tried
        static constexpr int kFrictionRounds = 12;
        static constexpr double kFrictionShare = 0.5; ///< of a change of the friction that is made at a time
        static constexpr double kNoForce = 1e-12; ///< relative round-off; no smaller residual is requested

        /// Contact energy is excluded from the prediction; Newton's method reduces it.
        double contact_energy(const Eigen::VectorXd& u) const
        {
            return (body_.contact() != nullptr ? body_.contact()->energy(u) : 0.0)
                + (body_.blades() != nullptr ? body_.blades()->energy(u) : 0.0);
        }

        /// Largest force at a node. The three nodes of a blade bear what the nodes under it share, so the forces at
        /// these nodes are taken.
        double largest_reaction() const
        {
            if (body_.blades() == nullptr)
                return largest_length(state_.forces);
            Eigen::VectorXd forces = state_.forces;
            for (const BladeSurface& blade : body_.blades()->blades())
                for (const VertexId v : blade.nodes)
                    forces.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
            return std::max(largest_length(forces), body_.blades()->largest_nodal_force(u_));
        }

        struct Energies {
            double all = 0.0, contact = 0.0; ///< N mm
        };
        Energies energies() const { return { state_.energy, contact_energy(u_) }; }

        /// Whether changes of the energies, N mm, are within EquilibriumOptions::energy_tolerance.
        bool is_unchanged(double all, double contact) const
        {
            const double limit = options_.energy_tolerance;
            return std::abs(all) <= limit * std::abs(state_.energy)
                && std::abs(contact) <= std::sqrt(limit) * contact_energy(u_);
        }

        /// Whether the energy tolerance may end an iteration here.
        bool is_rough() const
        {
            constexpr double kRough = 0.05, kOfTolerance = 50.0; // residual
            return options_.energy_tolerance > 0.0 && body_.blades() != nullptr
                && result_.residual <= std::max(kRough, kOfTolerance * options_.tolerance);
        }

        /// Whether the last step ended the iteration by EquilibriumOptions::energy_tolerance.
        bool has_settled() const { return is_rough() && is_unchanged(last_.fall, last_.contact_change); }

        double energy_noise(const Eigen::VectorXd& u) const
        {
            constexpr double kRoundOff = 1e-10;
            const double size = largest_length(u);
            return kRoundOff * (stiffest_ * size * size + std::abs(state_.energy));
        }

        /// Number of iterations that take about as long as a factorisation. On n unknowns a factorisation takes n^2
        /// operations, an iteration n^(4/3) (nested dissection in space); on some 430,000 they take 16 and 0.14 s.
        int worth_a_factor() const
        {
            constexpr double kPerUnknown = 0.018;
            constexpr int kFewest = 25;
            return std::max(kFewest,
                static_cast<int>(kPerUnknown * std::pow(static_cast<double>(solver_.free_count()), 2.0 / 3.0)));
        }

        /// Whether the factor at hand may precondition the step of a motion: a single step from a start near its end.
        /// Load steps take fresh factors; on flat elements an old factor leaves an error that the next steps keep.
        bool is_single_step() const { return options_.load_steps == 1 && solver_.factorised(); }

        struct Prediction {
            Eigen::VectorXd rest; ///< displacement to the equilibrium of the present state
            Eigen::VectorXd follow; ///< displacement with the motion of the prescribed unknowns
        };

        /// Solves with the linearised stiffness, which is left in ElasticBody::last_stiffness(). A single step takes
        /// the true stiffness where that is positive definite: the projected one is much stiffer where tissue is
        /// stretched, and its steps turn elements over.
        Prediction predict(const Eigen::VectorXd& unbalanced, const Eigen::VectorXd& motion)
        {
            if (body_.model() == Elasticity::hyperelastic) {
                const BlockMatrix& K = factorise_least_lifted();
                return { solver_.solve(unbalanced), motion - solver_.solve(K.multiply(motion)) };
            }
            bool fresh = false;
            if (is_single_step()) {
                const BlockMatrix& K = assemble(lift_);
                if (auto rest = iterate_linearised(unbalanced))
                    if (const auto back = iterate_linearised(K.multiply(motion)))
                        return { std::move(*rest), motion - *back };
            }
            const BlockMatrix& K = assemble(1.0);
            if (!is_single_step()) {
                factorise(K);
                fresh = true;
            }
            Eigen::VectorXd rest = solve_projected(K, unbalanced, fresh);
            return { std::move(rest), motion - solve_projected(K, K.multiply(motion), fresh) };
        }

        /// Solves with the stiffness last assembled; nothing where this takes longer than a factorisation, or where the
        /// stiffness is not positive definite.
        std::optional<Eigen::VectorXd> iterate_linearised(const Eigen::VectorXd& b)
        {
            ConstrainedSolver::Iterated iterated = iterate_linear(b, kStartTolerance, worth_a_factor());
            if (!iterated.converged)
                return std::nullopt;
            return std::move(iterated.solution);
        }

        /// Solves with the projected stiffness K, the one last assembled. @param fresh whether the factor is that of K;
        /// set when it was made here
        Eigen::VectorXd solve_projected(const BlockMatrix& K, const Eigen::VectorXd& b, bool& fresh)
        {
            if (!fresh) {
                if (auto iterated = iterate_linearised(b))
                    return std::move(*iterated);
                factorise(K);
                fresh = true;
            }
            return solver_.solve(b);
        }

        /// Makes one Newton step. @return false when no descent is found
        bool step()
        {
            Eigen::VectorXd r = state_.forces;
            solver_.mask(r);
            // Far from rest a coarse linear solve is sufficient; near rest a step gains two digits (Eisenstat, Walker
            // 1996).
            const double forcing = std::clamp(result_.residual, 1e-2, 0.1);
            const Eigen::VectorXd du = solve(-r, forcing);
            ++result_.newton_iterations;
            const double before = state_.energy, contact_before = contact_energy(u_), slope = r.dot(du);
            const bool found = search(du, slope);
            last_ = { .fall = std::max(-0.5 * slope, before - state_.energy),
                .contact_change = std::abs(contact_energy(u_) - contact_before) };
            return found;
        }

        bool search(const Eigen::VectorXd& du, double slope)
        {
            if (!(slope < 0.0))
                return false;
            Eigen::VectorXd u = u_ + du;
            ElasticBody::Response there = respond(u);
            if (!is_lower(there, 1.0, slope))
                return body_.contact() != nullptr || body_.blades() != nullptr ? shorten(du, slope, there)
                                                                               : halve(du, slope);
            lengthen(du, slope, u, there);
            u_ = std::move(u);
            state_ = std::move(there);
            return true;
        }

        /// Whether the energy falls enough along a step of this length (Armijo's rule).
        bool is_lower(const ElasticBody::Response& there, double length, double slope) const
        {
            constexpr double kArmijo = 1e-4;
            const double noise = 1e-13 * std::abs(state_.energy); // energies closer than this cannot be distinguished
            return std::isfinite(there.energy) && there.energy <= state_.energy + kArmijo * length * slope + noise;
        }

        /// Halves a step that is too long until the energy falls. @return false when no length lowers the energy
        bool halve(const Eigen::VectorXd& du, double slope)
        {
            for (double length = 0.5; length > kShortest; length *= 0.5) {
                Eigen::VectorXd u = u_ + length * du;
                ElasticBody::Response there = respond(u);
                if (!is_lower(there, length, slope))
                    continue;
                u_ = std::move(u);
                state_ = std::move(there);
                return true;
            }
            return false;
        }

        /// Goes along a step that is too long to about the least energy, by false position on the slope. Where a stiff
        /// contact begins along the step, this goes just past its beginning, and the next step knows the contact;
        /// halving the step stays before it. @return false when no length lowers the energy
        bool shorten(const Eigen::VectorXd& du, double slope, const ElasticBody::Response& full)
        {
            constexpr double kInside = 0.1, kFlat = 0.3;
            constexpr int kTrials = 20, kTrialsBeyondTheFirst = 3;
            double low = 0.0, at_low = slope, high = 1.0;
            double at_high = std::isfinite(full.energy) ? full.forces.dot(du) : 0.0;
            bool found = false;
            Eigen::VectorXd best_u;
            ElasticBody::Response best;
            for (int trial = 0, beyond = 0; trial < kTrials && beyond <= kTrialsBeyondTheFirst; ++trial) {
                const double share = at_high > 0.0 ? at_low / (at_low - at_high) : 0.5;
                const double length = low + std::clamp(share, kInside, 1.0 - kInside) * (high - low);
                if (length < kShortest)
                    break;
                Eigen::VectorXd u = u_ + length * du;
                ElasticBody::Response there = respond(u);
                const double at = std::isfinite(there.energy) ? there.forces.dot(du) : 0.0;
                const bool lower = is_lower(there, length, slope);
                if (lower && (!found || there.energy < best.energy)) {
                    found = true;
                    best_u = std::move(u);
                    best = std::move(there);
                }
                beyond += found ? 1 : 0;
                if (lower && std::abs(at) <= kFlat * std::abs(slope))
                    break;
                if (lower && at < 0.0) {
                    low = length;
                    at_low = at;
                } else {
                    high = length;
                    at_high = at;
                }
            }
            if (!found)
                return false;
            u_ = std::move(best_u);
            state_ = std::move(best);
            return true;
        }

        /// A stiffness with raised eigenvalues is too stiff and its steps are too short. This function goes to the
        /// minimum of a parabola through the energies when the minimum lies well beyond the full step and the energy
        /// there is lower.
        void lengthen(const Eigen::VectorXd& du, double slope, Eigen::VectorXd& u, ElasticBody::Response& there)
        {
            constexpr double kWorthATry = 1.5, kFarthest = 4.0;
            if (lift_ == 0.0 && raised_steps_ == 0)
                return;
            const double bend = there.energy - state_.energy - slope;
            const double best = bend > 0.0 ? std::min(-0.5 * slope / bend, kFarthest) : kFarthest;
            if (best < kWorthATry)
                return;
            Eigen::VectorXd further = u_ + best * du;
            ElasticBody::Response beyond = respond(further);
            if (std::isfinite(beyond.energy) && beyond.energy < there.energy) {
                u = std::move(further);
                there = std::move(beyond);
            }
        }

        /// Solves by conjugate gradients with the true stiffness and the present factor. Where that is not positive
        /// definite along the way, this step and the next ones take it with raised extremes (elastic_body.h), lifted by
        /// the smallest share that makes it so. When the iterations cost more than a factorisation, the projected
        /// stiffness is factored anew.
        Eigen::VectorXd solve(const Eigen::VectorXd& b, double tolerance)
        {
            if (body_.model() == Elasticity::hyperelastic) {
                (void)factorise_least_lifted();
                return solver_.solve(b);
            }
            constexpr double kLeast = 1.0 / 16.0;
            constexpr int kRaisedSteps = 4; // until the true stiffness is tried again
            constexpr double kNearStable = 0.1; // residual near an equilibrium, where the lifted stiffness is too stiff
            lift_ = lift_ > kLeast ? 0.5 * lift_ : 0.0;
            raised_steps_ = std::max(0, raised_steps_ - 1);
            bool fresh = false;
            for (;;) {
                assemble(lift_);
                if (solver_.factorised() && !std::exchange(has_poor_factor_, false)) {
                    const ConstrainedSolver::Iterated iterated = iterate_linear(b, tolerance, worth_a_factor());
                    // A factor that needed many iterations would need them again.
                    const bool is_poor = !fresh && 2 * iterated.iterations > worth_a_factor();
                    if (iterated.converged || (fresh && !iterated.negative_curvature)) {
                        has_poor_factor_ = is_poor;
                        return iterated.solution;
                    }
                    if (iterated.negative_curvature && lift_ < 1.0) {
                        if (std::exchange(raised_steps_, std::max(raised_steps_, kRaisedSteps)) > 0 && !is_poor)
                            lift_ = std::min(1.0, std::max(4.0 * lift_, kLeast));
                        if (!is_poor)
                            continue;
                    }
                }
                if (lift_ < 1.0 && result_.residual <= kNearStable && is_definite())
                    return solver_.solve(b);
                factorise(assemble(1.0));
                fresh = true;
                if (lift_ == 1.0)
                    return solver_.solve(b);
            }
        }

        /// Factors the stiffness last assembled. @return whether it is positive definite
        bool is_definite()
        {
            try {
                factorise(body_.last_stiffness());
                return true;
            } catch (const SolverError&) {
                return false;
            }
        }

        /// Factors the true stiffness where it is positive definite, else the stiffness with the smallest sufficient
        /// lift. At a stable equilibrium the whole matrix is positive definite although elements are not, and Newton's
        /// method converges quadratically. Conjugate gradients on the factor of the lifted stiffness need hundreds of
        /// iterations there.
        const BlockMatrix& factorise_least_lifted()
        {
            constexpr double kLeast = 1.0 / 64.0, kFactor = 4.0;
            lift_ = lift_ > kLeast ? lift_ / kFactor : 0.0;
            for (;; lift_ = std::min(1.0, std::max(kFactor * lift_, kLeast))) {
                const BlockMatrix& K = assemble(lift_);
                try {
                    factorise(K);
                    return K;
                } catch (const SolverError&) {
                    if (lift_ == 1.0)
                        throw;
                }
            }
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
            has_poor_factor_ = false;
            solver_.factorise(K);
            result_.factor_seconds += watch.seconds();
            ++result_.factorisations;
            if (first)
                record_part(job_, "factorisation", watch, solver_.bytes());
        }

        const BlockMatrix& assemble(double projected)
        {
            const Stopwatch watch;
            const BlockMatrix& K
                = body_.stiffness(u_, projected, raised_steps_ > 0 ? Extremes::raised : Extremes::as_they_are);
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
        std::size_t& pattern_; ///< as EquilibriumSolver::pattern_
        bool& assembled_;
        double stiffest_; ///< largest diagonal entry of the stiffness, N/mm
        double reach_ = 0.0; ///< mm: largest displacement of a start state
        bool guesses_friction_; ///< the friction of the blades is not known yet
        double largest_load_ = 0.0; ///< largest nodal load, N
        std::optional<LocalRelaxation> locally_; ///< set when it is needed first
        Eigen::VectorXd u_;
        double lift_ = 0.0; ///< share of the negative eigenvalues that was last removed from the element stiffness
        bool has_poor_factor_ = false; ///< the factor at hand preconditions badly
        int raised_steps_ = 0; ///< so many steps more take the stiffness with raised extremes
        ElasticBody::Response state_;
        struct LastStep {
            double fall = std::numeric_limits<double>::infinity(); ///< of the energy, predicted or found, N mm
            double contact_change = std::numeric_limits<double>::infinity(); ///< of the energy at blades, N mm
        };
        LastStep last_;
    };

    Eigen::VectorXd prescribed_part(const std::vector<std::uint8_t>& prescribed, const Eigen::VectorXd& vector)
    {
        Eigen::VectorXd part = Eigen::VectorXd::Zero(vector.size());
        for (std::size_t i = 0; i < prescribed.size(); ++i)
            if (prescribed[i] != 0)
                part[static_cast<Eigen::Index>(i)] = vector[static_cast<Eigen::Index>(i)];
        return part;
    }

    double full_load_step(const Eigen::VectorXd& motion, const EquilibriumOptions& options)
    {
        constexpr double kLongestMm = 3.0; // motion of a node in one step
        const double steps = std::ceil(largest_length(motion) / kLongestMm);
        return 1.0 / std::max(static_cast<double>(options.load_steps), steps);
    }

    struct StepLimits {
        double tolerance; ///< of an intermediate state
        int iterations; ///< of an intermediate state
        int last_iterations; ///< at the full load
        double smallest; ///< smallest step, as a share of the full step
        bool must_rest; ///< intermediate states must be at rest
    };

    StepLimits step_limits(const ElasticBody& body, const EquilibriumOptions& options, const Eigen::VectorXd& u)
    {
        constexpr int kIterationsOnTheWay = 4, kIterationsUnderLoad = 15;
        constexpr int kMoreInContact = 4; // Newton's method finds one by one which points touch
        const bool touches = body.contact() != nullptr && body.contact()->state(u).touching > 0;
        const int last_iterations = (touches ? kMoreInContact : 1) * options.max_newton_iterations;
        if (body.has_loads())
            return { std::max(1e-4, options.tolerance), std::min(kIterationsUnderLoad, options.max_newton_iterations),
                last_iterations, 1.0 / 64.0, true };
        if (touches) // the pairs must belong to a state at rest
            return { std::max(1e-2, options.tolerance), std::min(kIterationsUnderLoad, options.max_newton_iterations),
                last_iterations, 1.0 / 64.0, false };
        return { std::max(0.05, options.tolerance), std::min(kIterationsOnTheWay, options.max_newton_iterations),
            options.max_newton_iterations, 1.0 / 16.0, false };
    }

    /// @param of the quantity that rose from the share `found` to the share `missed`
    std::string no_equilibrium(const std::string& of, double found, double missed)
    {
        const auto percent = [](double share) { return formatted("%.4g %%", 100.0 * share); };
        return "no equilibrium was found above " + percent(found) + " of " + of + " (one at " + percent(found)
            + ", none at " + percent(missed) + ")";
    }

    std::string no_equilibrium(const Equilibrium& result, double missed, double loads_before, bool moves)
    {
        const auto loads = [&](double share) { return loads_before + share * (1.0 - loads_before); };
        if (!result.loads_rest_alone)
            return no_equilibrium("the loads", loads(result.load), loads(missed))
                + (moves ? ", also none while the hooks and supports stay in place" : "");
        return no_equilibrium("the motion of the hooks and supports", result.load, missed)
            + "; the loads alone have an equilibrium";
    }

    std::string hooks_meet(double share)
    {
        return formatted(
            "two hooks or supports collided after %.4g %% of the motion; the opening stops there", 100.0 * share);
    }

    /// Makes full load steps, and halves a step where Newton's method fails. An intermediate state is only a start for
    /// the next step: it takes a few iterations, and the next step removes its residual.
    class LoadSteps {
    public:
        /// @param motion of the prescribed unknowns, zero on free unknowns; lives longer than this object
        LoadSteps(Newton& newton, const Eigen::VectorXd& motion)
            : newton_(newton)
            , motion_(motion)
            , body_(newton.body())
            , options_(newton.options())
            , result_(newton.result())
            , full_step_(full_load_step(motion, options_))
            , loads_before_(body_.has_loads() ? options_.load_at_start : 0.0)
            , step_(full_step_)
        {
        }

        void make_all()
        {
            if (body_.has_loads())
                newton_.take_loads(newton_.displacement());
            while (make_step()) { }
        }

    private:
        struct Step {
            Eigen::VectorXd saved; ///< displacement before the step
            double next = 0.0; ///< share of the whole motion at the end of the step
            StepLimits limits {};
            bool blocked = false; ///< the step is cut short where hooks meet
            double made = 0.0; ///< share of the step that the linearised solve made
        };

        /// @return whether another step follows
        bool make_step()
        {
            Step step = begin_step();
            move(step);
            if (step.made == 0.0 && !body_.has_loads())
                return end(EquilibriumStatus::not_converged);
            const bool last = step.next == 1.0 || (step.blocked && step.made == 1.0);
            const auto outcome = step.made == 0.0 ? Newton::Outcome::failed
                                                  : newton_.settle(last ? options_.tolerance : step.limits.tolerance,
                                                      last ? step.limits.last_iterations : step.limits.iterations);
            if (outcome == Newton::Outcome::cancelled)
                return end(EquilibriumStatus::cancelled);
            if (outcome == Newton::Outcome::converged
                || (outcome == Newton::Outcome::out_of_iterations && !last && !step.limits.must_rest))
                return accept(step, last);
            return go_back(step, outcome);
        }

        bool end(EquilibriumStatus status)
        {
            result_.status = status;
            return false;
        }

        /// Pairs the surfaces in contact and shortens the step to the place where hooks meet.
        Step begin_step()
        {
            constexpr double kWhole = 1.0 - 1e-12;
            Step step { .saved = newton_.displacement(),
                .next = result_.load + step_ > kWhole ? 1.0 : result_.load + step_ };
            (void)newton_.renew_contact();
            step.limits = step_limits(body_, options_, step.saved);
            if (body_.contact() == nullptr)
                return step;
            const double free
                = body_.contact()->free_share(step.saved, (step.next - result_.load) * motion_, newton_.prescribed());
            if (free < 1.0) {
                step.next = result_.load + free * (step.next - result_.load);
                step.blocked = true;
            }
            return step;
        }

        void move(Step& step)
        {
            if (body_.has_loads())
                put_loads(step.next, step.saved);
            step.made = newton_.move((step.next - result_.load) * motion_);
            RETRACTOR_ASSERT(step.made >= 0.0 && step.made <= 1.0);
            if (step.made == 0.0 || step.made == 1.0)
                return;
            step.next = result_.load + step.made * (step.next - result_.load);
            if (body_.has_loads())
                put_loads(step.next, newton_.displacement());
        }

        bool accept(const Step& step, bool last)
        {
            result_.load = step.next;
            newton_.job().report("opening", step.next);
            if (last && step.blocked) {
                result_.status = EquilibriumStatus::not_converged;
                result_.message = hooks_meet(step.next);
            }
            step_ = std::min(full_step_, 2.0 * step.made * step_);
            return !last;
        }

        /// Returns to the state before the step, and tries half of the step or gives up.
        bool go_back(const Step& step, Newton::Outcome outcome)
        {
            step_ = 0.5 * (step.next - result_.load);
            const bool must_rest = step.limits.must_rest;
            const bool give_up = step_ < step.limits.smallest * full_step_
                || (outcome == Newton::Outcome::out_of_iterations && !must_rest);
            if (must_rest)
                put_loads(result_.load, step.saved);
            else if (!give_up || !newton_.displacement().allFinite() || !newton_.forces().allFinite())
                newton_.start_from(step.saved);
            else
                result_.load = step.next; // the best state so far: at the requested load, not fully at rest
            if (!give_up)
                return true;
            return must_rest ? explain(step) : end(EquilibriumStatus::not_converged);
        }

        /// Says whether the loads or the prescribed motion have no equilibrium.
        bool explain(const Step& step)
        {
            const bool moves = largest_length(motion_) > 0.0;
            result_.none_found = true;
            if (moves) {
                const auto alone = loads_rest_alone(step);
                result_.loads_rest_alone = alone == Newton::Outcome::converged;
                if (alone == Newton::Outcome::cancelled)
                    return end(EquilibriumStatus::cancelled);
            }
            result_.message = no_equilibrium(result_, step.next, loads_before_, moves);
            return end(EquilibriumStatus::not_converged);
        }

        /// Tests whether the loads alone have an equilibrium, from the state at rest before the step that failed. The
        /// state is kept.
        Newton::Outcome loads_rest_alone(const Step& step)
        {
            if (loads_before_ == 1.0)
                return Newton::Outcome::converged; // all loads act already
            put_loads(step.next, step.saved);
            const auto outcome = newton_.move(Eigen::VectorXd::Zero(step.saved.size())) == 0.0
                ? Newton::Outcome::failed
                : newton_.settle(step.limits.tolerance, step.limits.iterations);
            put_loads(result_.load, step.saved);
            return outcome;
        }

        void put_loads(double share, const Eigen::VectorXd& u)
        {
            body_.set_load_share(loads_before_ + share * (1.0 - loads_before_));
            newton_.start_from(u);
        }

        Newton& newton_;
        const Eigen::VectorXd& motion_;
        ElasticBody& body_;
        const EquilibriumOptions& options_;
        Equilibrium& result_;
        double full_step_; ///< share of the motion
        double loads_before_; ///< share of the loads that acts on the start state
        double step_; ///< share of the motion that is tried next
    };

} // namespace

Equilibrium EquilibriumSolver::solve(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const Eigen::VectorXd& start, const EquilibriumOptions& options, const Job& job)
{
    RETRACTOR_ASSERT(prescribed.size() == 3 * body.mesh().vertex_count());
    RETRACTOR_ASSERT(target.size() == start.size() && prescribed.size() == static_cast<std::size_t>(start.size()));
    Equilibrium result;
    const bool is_first = !assembled_;
    const bool other_pairs = body.contact() != nullptr && body.find_contact(start);
    if (!assembled_ || other_pairs || body.patterns_made() == 0) {
        const Stopwatch watch;
        (void)body.stiffness(start, 1.0);
        assembled_ = true;
        result.assemble_seconds += watch.seconds();
        record_part(job, "assembly", watch, body.bytes());
    }
    if (!solver_ || solver_->prescribed() != prescribed) {
        const Stopwatch analysis;
        solver_.emplace(body.last_stiffness().pattern, prescribed);
        pattern_ = body.patterns_made();
        result.factor_seconds += analysis.seconds();
    } else if (pattern_ != body.patterns_made()) {
        solver_->change_pattern();
        pattern_ = body.patterns_made();
    }
    Newton newton(body, *solver_, options, job, result, pattern_, assembled_, is_first);
    if (body.has_loads())
        body.set_load_share(body.model() == Elasticity::linear ? 1.0 : options.load_at_start);
    newton.start_from(start);
    if (!std::isfinite(newton.energy()))
        throw InputError("an element is turned over, or the displacement is not finite", "start state");
    const Eigen::VectorXd motion = prescribed_part(prescribed, target - start);
    if (body.model() == Elasticity::linear && body.contact() == nullptr && body.blades() == nullptr) {
        newton.move(motion);
        result.load = 1.0;
        if (newton.iterate(options.tolerance, options.max_newton_iterations) != Newton::Outcome::converged)
            result.status = job.cancelled() ? EquilibriumStatus::cancelled : EquilibriumStatus::not_converged;
    } else {
        LoadSteps(newton, motion).make_all();
    }
    result.residual = newton.residual();
    result.displacement = newton.displacement();
    result.forces = newton.forces();
    return result;
}

Eigen::MatrixXd EquilibriumSolver::response(
    ElasticBody& body, const Eigen::VectorXd& displacement, const Eigen::MatrixXd& motions)
{
    RETRACTOR_ASSERT(solver_ && pattern_ == body.patterns_made() && motions.rows() == displacement.size());
    body.prepare_blade_search(displacement);
    factorise_least_lifted(body, displacement, *solver_);
    const BlockMatrix& K = body.last_stiffness();
    const auto forces_of = [&](const Eigen::MatrixXd& u) {
        Eigen::MatrixXd forces(u.rows(), u.cols());
        for (Eigen::Index c = 0; c < u.cols(); ++c)
            forces.col(c) = K.multiply(u.col(c));
        return forces;
    };
    const Eigen::MatrixXd follow = motions - solver_->solve_all(forces_of(motions));
    const Eigen::MatrixXd R = follow.transpose() * forces_of(follow);
    body.expect_blades(nullptr);
    return 0.5 * (R + R.transpose());
}

} // namespace retractor::fem
