#pragma once
// Hooks that hold wounds open while the knife goes on: a linear elastic wall (OnlineOpening) that follows the session,
// its hooks, and the numbers a surgeon reads. Used from one thread. Units mm, N; frame patient LPS.
//
// What is shown is the linear answer: exact for the model, which takes rotations for small. Openings beyond 10 to 15 mm
// a side look swollen; the plan (corotational) is what to measure by.

#include "fem/online_opening.h"
#include "fem/online_strain.h"
#include "ui/workstation/hook_seat.h"

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace retractor {

struct HookState {
    HookId id = 0;
    std::string name;
    HookSeat seat; ///< its side: +1 or -1
    Vec3 asked = Vec3::Zero(); ///< where the hand is, mm from rest
    Vec3 displacement = Vec3::Zero(); ///< where the tissue under it is
    Vec3 force_N = Vec3::Zero(); ///< what the hand must apply
    bool yielded = false;
};

/// What a window shows of the hooks.
struct HookReport {
    std::vector<HookState> hooks;
    std::array<double, 2> side_N {}; ///< sums of the forces' sizes, of side +1 and of -1
    StrainPeak strain; ///< of the last settled frame
    double residual = 0.0; ///< relative, of the whole field
    bool settled = true; ///< residual and strain are of what is shown
    double frame_ms = 0.0; ///< of the last frame: drag, or cut followed
    int factors_swapped = 0; ///< that were made in the background
    std::string refusal; ///< why the wound cannot be opened as it is now; what is shown is the last answer
};

class WoundHooks {
public:
    /// Factors the wall as the session has it now: seconds.
    /// @param stress_of_element tension per element of the session's first mesh, or none.
    /// @throws as OnlineOpening.
    WoundHooks(const CutSession& session, std::span<const Material> material_of_label, const Supports& supports,
        std::span<const VertexId> corridor, std::vector<Mat3> stress_of_element);

    /// @param opened mm from rest, at once.
    /// @throws InputError as OnlineOpening::attach().
    HookId attach(HookSeat seat, std::string name, const Vec3& opened);
    void take_off(HookId hook); ///< @throws InputError when there is none
    void pull(HookId hook, const Vec3& asked); ///< @throws InputError when there is none, or on NaN
    void pull_all(double mm); ///< each along its own pull
    /// Every hook slips rather than pull harder. @throws InputError when it is not positive.
    void set_yield(double force_N);
    double yield_N() const { return yield_N_; }
    bool empty() const { return report_.hooks.empty(); }
    bool has(HookId hook) const;

    /// Takes a change of the session in and opens the wound again. Hooks that no longer lie on a lip are taken off.
    /// When cuts have left what was factored for them, that is done anew in the background, round the knife's last
    /// step.
    void follow(const MeshDelta& delta, const CutSession& session);
    /// The hooks where the hand is now: a product with columns that are made when they are needed.
    void frame();
    /// The exact answer with its residual, and the strain.
    void settle();
    bool settled() const { return report_.settled; }

    const HookReport& report() const { return report_; }
    /// mm, three per vertex id of the session.
    const Eigen::VectorXd& displacement() const { return displacement_; }
    std::vector<VertexId> held_vertices() const { return opening_.held_vertices(); } ///< of all hooks
    /// What the surgeon should know since the last call; empty: nothing.
    std::string take_remark() { return std::exchange(remark_, {}); }
    std::size_t bytes() const { return opening_.bytes(); }

private:
    HookState& state(HookId hook);
    HookDrive drive_of(const HookState& hook) const;
    bool solve();
    bool take(const OnlineAnswer& answer);
    void carry(const MeshDelta& delta);
    void lost(const std::string& name);
    void take_off_lost(const CutSession& session);
    void renew_factor(const MeshDelta& delta);
    void swap_factor();

    OnlineOpening opening_;
    HookReport report_;
    Eigen::VectorXd displacement_;
    double yield_N_ = std::numeric_limits<double>::infinity();
    bool columns_ = false; ///< made, and right
    std::size_t corridor_ = 0; ///< its size when the body was factored last
    std::string remark_;
};

} // namespace retractor
