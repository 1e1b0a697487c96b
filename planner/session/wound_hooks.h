#pragma once
// Hooks that hold wounds open during later cuts: an elastic wall that follows the session, its hooks, and their
// numbers. Used from one thread. Units mm, N; frame patient LPS.
//
// The linear solution of the whole wall (OnlineOpening) follows knife and hand at once. The linear solution assumes
// small rotations, and looks swollen beyond openings of 10 to 15 mm a side. On request the solution that is nonlinear
// near the wound (NearWound) replaces the linear one as soon as it is ready; the hand must rest for this. Until then,
// after a cut or with fewer hooks, the change of the linear solution is added to the last nonlinear solution, so that
// nothing jumps back. With another hook or another limit the linear solution alone is shown. When the linear solution
// is refused, the nonlinear solution is shown if it belongs to the present hooks; else the last shown solution stays.
// HookReport::shown tells which solution the picture and the numbers belong to.

#include "fem/interactive/online_opening.h"
#include "fem/interactive/online_strain.h"
#include "planner/session/hook_placement.h"
#include "planner/session/lip_overlap.h"
#include "planner/session/near_wound.h"
#include "planner/session/retractor/rack_balance.h"

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// A hook at a given displacement (drive.displacement) or with a given force (drive.force_N).
struct HookState {
    fem::HookId id = 0;
    std::string name;
    HookPlacement placement; ///< held patch; its side is +1 or -1
    fem::HookDrive drive; ///< drive as the hand sets it now; WoundHooks::set_yield() limits the force too
    std::optional<fem::HookDrive> planned; ///< drive of the plan; none: the hook was set or pulled by hand
    Vec3 displacement = Vec3::Zero(); ///< displacement of the held tissue
    Vec3 force_N = Vec3::Zero(); ///< force that the hand must apply
    bool yielded = false;
};

/// A retractor on a wound: a rack that pushes two blades apart. Only the tissue carries it, so that it moves along its
/// rack until both blades bear the same force. Its blades turn as blade_bearing.h says.
struct RetractorState {
    std::string kind; ///< as in the table of instruments
    std::array<fem::HookId, 2> blades {};
    double opening_mm = 0.0; ///< of the arms, from where the lips met
    double play_rad = 0.0; ///< largest turn of a blade about its arm
    std::array<double, 2> arm_mm {}; ///< how far each arm has moved along its blade's pull
    std::array<double, 2> turn_rad {}; ///< of each blade about its arm, with its end into the wound
    double greatest_opening_mm = 0.0;
    std::array<double, 2> blade_N {}; ///< pushes of the rack on each blade, outwards; negative: it holds the lip back
    double force_N = 0.0; ///< mean of the two blades' forces
    double imbalance = 0.0; ///< difference of the blades' forces along the rack, relative to the larger one
};

/// Share of its planned force at which a force-driven hook is, 1 = as planned; none without such a hook.
std::optional<double> share_of_plan(std::span<const HookState> hooks);

/// The solution that is shown of a wound with hooks.
enum class ShownAnswer {
    linear,
    linear_since, ///< last nonlinear solution plus the later change of the linear solution
    nonlinear,
};

/// The numbers of the hooks for display.
struct HookReport {
    std::vector<HookState> hooks; ///< blades of retractors among them
    std::vector<RetractorState> retractors;
    ShownAnswer shown = ShownAnswer::linear;
    /// The same in words, with the reason against a nonlinear solution, or the distance from the wound within which it
    /// is nonlinear.
    std::string shown_text;
    std::array<double, 2> side_N {}; ///< sums of the forces' norms on side +1 and side -1
    std::optional<double> force_factor {}; ///< the forces were multiplied by it, to match a plan (force_match.h)
    fem::StrainPeak strain; ///< of the last settled frame
    /// Relative residual; nonlinear: relative to the largest force; linear: of the whole field; linear_since: without
    /// meaning, because the sum is no equilibrium.
    double residual = 0.0;
    /// The tissue beyond the nonlinear region is off so much that the forces are no more than a hint.
    bool rough_forces = false;
    bool linear_only = false; ///< the nonlinear solution is wanted, and there is none to show
    bool settled = true; ///< the strain, and the residual if any, belong to the shown solution
    double frame_ms = 0.0; ///< time of the last frame (a drag or a followed cut)
    int factors_swapped = 0; ///< number of factors that were made in the background
    int near_swapped = 0; ///< number of nonlinear solutions that were made in the background
    std::string meeting; ///< hooks that block each other because their lips have met; empty: none
    double lip_overlap_mm = 0.0; ///< overlap of lips where no hooks hold them apart
    std::string refusal; ///< why the present wound cannot be opened; the last solution stays shown
};

/// Hooks and retractors as they are set, to come back to them. A hook is known by its name.
struct HookSet {
    std::vector<HookState> hooks;
    std::vector<RetractorState> retractors; ///< their blades are among the hooks
};

/// How far a hook has been moved from rest: of the blade of a retractor its arm, which moves further than the tissue
/// under the blade; of a hook that pulls with a force the tissue.
Vec3 moved_by_hand(const HookReport& report, const HookState& hook);

class WoundHooks {
public:
    /// Factors the session's present wall, which takes seconds.
    /// @param stress_of_element tension per element of the session's first mesh, or empty
    /// @throws as OnlineOpening
    WoundHooks(const mesh::CutSession& session, std::span<const fem::Material> material_of_label,
        const fem::Supports& supports, std::span<const VertexId> corridor, std::vector<Mat3> stress_of_element);

    /// Attaches a hook and drives it at once. Here and below a pulled hook stops where its lip meets the lip of a hook
    /// in its way, which stays in place; hooks that are pulled together give way alike.
    /// @throws InputError as OnlineOpening::attach()
    fem::HookId attach(HookPlacement placement, std::string name, const fem::HookDrive& drive,
        std::optional<fem::HookDrive> planned = {});
    /// Joins two attached hooks by a rack, as a retractor with blades that bear by bear_on_bone(). How far they are
    /// driven apart tells its opening. Tissue slides along the blades from then on.
    /// @throws InputError when a hook does not exist, has a rack, or pulls with a force, when the greatest opening is
    /// not positive, or the play is negative or more than a right angle
    void join(std::array<fem::HookId, 2> blades, std::string kind, double greatest_opening_mm, double play_rad);
    /// Opens a retractor by its crank, at most as far as it goes. Both blades move, and forget their plan.
    /// @param blade one of its blades
    /// @throws InputError when the hook does not exist or has no rack, or on NaN
    void crank(fem::HookId blade, double opening_mm);
    /// Takes a hook off; of a retractor both blades.
    /// @throws InputError when the hook does not exist
    void take_off(fem::HookId hook);
    /// Pulls a hook by hand to a displacement, mm from rest. The hook keeps its limit and grip, and forgets its plan.
    /// Of a blade this is how far its arm shall move along its pull, which cranks its retractor.
    /// @throws InputError when the hook does not exist, or on NaN
    void pull(fem::HookId hook, const Vec3& asked);
    /// The hooks as they are set, with the vertices that they still hold.
    HookSet hook_set() const;
    /// Sets hooks as they were: takes the others off, attaches those that are missing, and drives all as then.
    /// @throws InputError as attach() and join()
    void return_to(const HookSet& then);
    void pull_all(double mm); ///< each hook along its own pull direction; retractors open by twice as much
    /// Gives a hook that was pulled by hand a plan again, to which pull_share() drives it.
    /// @throws InputError when the hook does not exist
    void plan(fem::HookId hook, const fem::HookDrive& planned);
    /// Drives all planned hooks to this share of their planned force and displacement. Hooks pulled by hand stay.
    /// @throws InputError on NaN
    void pull_share(double share);
    /// Sets the force at which every hook slips, beside its own force or limit.
    /// @throws InputError when the force is not positive
    void set_yield(double force_N);
    double yield_N() const { return yield_N_; }
    bool empty() const { return report_.hooks.empty(); }
    bool has(fem::HookId hook) const;

    /// Takes a change of the session and opens the wound again. Hooks that no longer lie on a lip are removed. When
    /// cuts have left the factored region, the factor is renewed in the background, around the last step of the knife.
    void follow(const mesh::MeshDelta& delta, const mesh::CutSession& session);
    /// Solves for the present drives of the hooks: a product with columns, which are made when needed.
    void frame();
    /// Computes the exact linear solution with its residual and the strain; then the nonlinear solution, if ready,
    /// until it is at rest or the job is cancelled. Starts a missing nonlinear solution unless a cut is going on.
    void settle(bool cutting = false, const Job& job = {});
    bool settled() const;
    /// Whether settle() would change nothing yet, because the nonlinear solution is still being made.
    bool waits(bool cutting = false) const;

    /// Whether the nonlinear solution is shown when possible; off at the start.
    void set_nonlinear(bool wanted);

    const HookReport& report() const { return report_; }
    /// Shown displacement, mm, three numbers per vertex id of the session.
    const Eigen::VectorXd& displacement() const { return displacement_; }
    std::vector<VertexId> held_vertices() const { return opening_.held_vertices(); } ///< of all hooks
    /// Message for the surgeon since the last call; empty: none.
    std::string take_remark() { return std::exchange(remark_, {}); }
    std::size_t bytes() const { return opening_.bytes() + near_.bytes(); }

private:
    struct Rack {
        RetractorState state;
        std::array<Vec3, 2> across {}; ///< displacements of the blades across the rack, which stay
        RackBalance balance {};
    };
    Rack* rack_of(fem::HookId hook); ///< null: the hook has none
    static double arm_mm(const Rack& rack, std::size_t blade);
    std::array<fem::HookDrive, 2> drives_of(const Rack& rack) const;
    void open_rack(Rack& rack, double opening_mm);
    struct HookNumbers {
        Vec3 displacement = Vec3::Zero(), force_N = Vec3::Zero();
        bool yielded = false;
    };
    void read_rack(Rack& rack);
    bool is_stopped(const Rack& rack) const;
    std::array<double, 2> rack_forces(const Rack& rack, const std::map<fem::HookId, HookNumbers>& numbers) const;
    bool step_racks(const std::map<fem::HookId, HookNumbers>& numbers);
    bool linear_alone() const;
    void balance_linear(bool exactly);
    void balance_nonlinear(const Job& job);
    void report_racks();
    HookState& state(fem::HookId hook);
    fem::HookDrive limited(const fem::HookDrive& drive) const;
    void drive(const std::map<fem::HookId, fem::HookDrive>& asked);
    void drive_one(fem::HookId hook, const fem::HookDrive& asked);
    void see_wound(const mesh::CutSession& session);
    std::string names_of(std::span<const fem::FacingHooks> meeting) const;
    bool solve();
    bool take(const fem::OnlineAnswer& answer);
    std::vector<fem::HookDrive> drives() const;
    void outdate_near();
    bool near_usable() const;
    bool near_missing() const;
    bool near_pending() const;
    void begin_near();
    void drag_near();
    void forget_since();
    bool show();
    void show_linear();
    void show_near();
    std::string shown_in_words() const;
    void lose(fem::HookId hook);
    void take_off_lost();
    void renew_factor(const mesh::MeshDelta& delta);
    void swap_factor();

    fem::OnlineOpening opening_;
    std::vector<fem::Material> materials_;
    HookReport report_;
    Eigen::VectorXd displacement_; ///< as shown
    Eigen::VectorXd linear_;
    double linear_residual_ = 0.0;
    std::map<fem::HookId, HookNumbers> linear_hooks_;
    std::vector<Rack> racks_;
    std::string stopped_; ///< hooks that met when they were last pulled
    std::set<fem::HookId> stopped_hooks_; ///< the same
    std::string linear_meeting_; ///< hooks that block each other in the linear solution
    bool linear_settled_ = true;
    bool held_ = true; ///< no part has lost its support: the wall can be solved
    bool answered_ = false; ///< linear_ belongs to the present wall and hooks
    bool as_before_ = false; ///< the shown solution belongs to an earlier wall or earlier hooks
    std::vector<VertexId> wound_; ///< vertices of all lips
    std::vector<LipPair> lip_pairs_;
    bool nonlinear_ = false;
    NearWound near_;
    bool near_begun_ = false; ///< the nonlinear solution was begun for this mesh and these hooks
    Eigen::VectorXd since_; ///< last nonlinear field minus the linear one; empty: none
    std::map<fem::HookId, HookNumbers> since_hooks_; ///< the same difference for each hook's numbers
    double yield_N_ = std::numeric_limits<double>::infinity();
    bool columns_ = false; ///< columns are made and valid
    std::size_t corridor_ = 0; ///< size of the corridor at the last factorisation
    std::string remark_;
};

} // namespace retractor::planner
