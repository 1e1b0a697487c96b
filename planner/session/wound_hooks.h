#pragma once
// Hooks that hold wounds open while the knife goes on: an elastic wall that follows the session, its hooks, and the
// numbers a surgeon reads. Used from one thread. Units mm, N; frame patient LPS.
//
// The linear answer of the whole wall (OnlineOpening) follows knife and hand at once; it takes rotations for small, and
// openings beyond 10 to 15 mm a side look swollen. Where it is asked for, the answer that is nonlinear near the wound
// (NearWound) takes its place as soon as it is made, which the hand must rest for. Until then, after a cut or with
// fewer hooks, what the linear answer has changed since is added to the last nonlinear one, so that nothing jumps back;
// with another hook or another limit the linear answer alone is shown. Where the linear answer is refused, nothing of
// it is shown: the nonlinear one, when there is one of the hooks as they are, else what was shown before.
// What is shown, and all numbers with it, is said in HookReport::shown.

#include "fem/interactive/online_opening.h"
#include "fem/interactive/online_strain.h"
#include "planner/session/hook_placement.h"
#include "planner/session/lip_overlap.h"
#include "planner/session/near_wound.h"

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// Hooks that are drawn so far (drive.displacement), or that pull so hard (drive.force_N).
struct HookState {
    fem::HookId id = 0;
    std::string name;
    HookPlacement seat; ///< its side: +1 or -1
    fem::HookDrive drive; ///< as the hand has it now; the hook slips at WoundHooks::set_yield(), too
    std::optional<fem::HookDrive> planned; ///< as the plan has it; none: it was set or drawn by hand
    Vec3 displacement = Vec3::Zero(); ///< where the tissue under it is
    Vec3 force_N = Vec3::Zero(); ///< what the hand must apply
    bool yielded = false;
};

/// How much of its plan a hook that pulls with a force is at, 1 = as planned; none where no hook does.
std::optional<double> share_of_plan(std::span<const HookState> hooks);

/// What is shown of a wound that hooks hold open.
enum class ShownAnswer {
    linear,
    linear_since, ///< the last nonlinear one, and what the linear answer has changed since
    nonlinear,
};

/// What a window shows of the hooks.
struct HookReport {
    std::vector<HookState> hooks;
    ShownAnswer shown = ShownAnswer::linear;
    std::string shown_text; ///< the same in words, with why it is not nonlinear, or how far from the wound it is
    std::array<double, 2> side_N {}; ///< sums of the forces' sizes, of side +1 and of -1
    fem::StrainPeak strain; ///< of the last settled frame
    double residual = 0.0; ///< relative; nonlinear: of the largest force, else: of the linear answer's whole field.
    /// Of linear_since it says nothing: that sum is no equilibrium
    bool settled = true; ///< the strain is of what is shown, and the residual, where there is one
    double frame_ms = 0.0; ///< of the last frame: drag, or cut followed
    int factors_swapped = 0; ///< that were made in the background
    int near_swapped = 0; ///< nonlinear answers that were
    std::string meeting; ///< the hooks that hold each other back: their lips have met; empty: none
    double lip_overlap_mm = 0.0; ///< by which lips pass through each other where no hooks hold them apart
    std::string refusal; ///< why the wound cannot be opened as it is now; what is shown is the last answer
};

class WoundHooks {
public:
    /// Factors the wall as the session has it now: seconds.
    /// @param stress_of_element tension per element of the session's first mesh, or none.
    /// @throws as OnlineOpening.
    WoundHooks(const mesh::CutSession& session, std::span<const fem::Material> material_of_label,
        const fem::Supports& supports, std::span<const VertexId> corridor, std::vector<Mat3> stress_of_element);

    /// Driven so at once. A hook that is drawn, here and below, stops where its lip meets that of a hook that is in its
    /// way, which stays where it is; hooks that are drawn at once give way alike. @throws InputError as
    /// OnlineOpening::attach().
    fem::HookId attach(
        HookPlacement seat, std::string name, const fem::HookDrive& drive, std::optional<fem::HookDrive> planned = {});
    void take_off(fem::HookId hook); ///< @throws InputError when there is none
    /// The hand draws it there, mm from rest: it keeps its limit and its grip, and forgets its plan.
    /// @throws InputError when there is none, or on NaN
    void pull(fem::HookId hook, const Vec3& asked);
    void pull_all(double mm); ///< each along its own pull
    /// Hooks as planned are driven so much of that: force and way. Those in the hand stay. @throws InputError on NaN
    void pull_share(double share);
    /// Every hook slips rather than pull harder, whatever its own force or limit. @throws InputError when it is not
    /// positive.
    void set_yield(double force_N);
    double yield_N() const { return yield_N_; }
    bool empty() const { return report_.hooks.empty(); }
    bool has(fem::HookId hook) const;

    /// Takes a change of the session in and opens the wound again. Hooks that no longer lie on a lip are taken off.
    /// When cuts have left what was factored for them, that is done anew in the background, round the knife's last
    /// step.
    void follow(const mesh::MeshDelta& delta, const mesh::CutSession& session);
    /// The hooks where the hand is now: a product with columns that are made when they are needed.
    void frame();
    /// The exact answer with its residual, and the strain; then the nonlinear one, as far as it is there, until it is
    /// at rest or the job is cancelled. Begins to make it where it is missing, unless a cut is going on.
    void settle(bool cutting = false, const Job& job = {});
    bool settled() const;
    /// settle() would change nothing yet: the nonlinear answer is being made.
    bool waits(bool cutting = false) const;

    /// Whether the nonlinear answer is shown where there can be one; not at first.
    void set_nonlinear(bool wanted);
    bool nonlinear() const { return nonlinear_; }

    const HookReport& report() const { return report_; }
    /// mm, three per vertex id of the session.
    const Eigen::VectorXd& displacement() const { return displacement_; }
    std::vector<VertexId> held_vertices() const { return opening_.held_vertices(); } ///< of all hooks
    /// What the surgeon should know since the last call; empty: nothing.
    std::string take_remark() { return std::exchange(remark_, {}); }
    std::size_t bytes() const { return opening_.bytes() + near_.bytes(); }

private:
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
    void lost(const std::string& name);
    void take_off_lost();
    void renew_factor(const mesh::MeshDelta& delta);
    void swap_factor();

    fem::OnlineOpening opening_;
    std::vector<fem::Material> materials_;
    HookReport report_;
    Eigen::VectorXd displacement_; ///< as shown
    Eigen::VectorXd linear_;
    double linear_residual_ = 0.0;
    struct HookNumbers {
        Vec3 displacement = Vec3::Zero(), force_N = Vec3::Zero();
        bool yielded = false;
    };
    std::map<fem::HookId, HookNumbers> linear_hooks_;
    std::string stopped_; ///< hooks that met when they were drawn last
    std::string linear_meeting_; ///< hooks that hold each other back in the linear answer
    bool linear_settled_ = true;
    bool held_ = true; ///< nothing has come off: the wall can be solved
    bool answered_ = false; ///< linear_ is of the wall and the hooks as they are
    bool as_before_ = false; ///< what is shown is not
    std::vector<VertexId> wound_; ///< the vertices of all lips
    std::vector<LipPair> lip_pairs_;
    bool nonlinear_ = false;
    NearWound near_;
    bool near_begun_ = false; ///< for this mesh and these hooks
    Eigen::VectorXd since_; ///< the last nonlinear field less the linear one; empty: none
    std::map<fem::HookId, HookNumbers> since_hooks_; ///< likewise
    double yield_N_ = std::numeric_limits<double>::infinity();
    bool columns_ = false; ///< made, and right
    std::size_t corridor_ = 0; ///< its size when the body was factored last
    std::string remark_;
};

} // namespace retractor::planner
