#pragma once
// Between a finger in the scene and the tissue's answer to it: what the hand is to feel.

#include "haptics/device/velocity_estimate.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/tissue_response.h"

namespace retractor::haptics {

struct CouplingOptions {
    double damping_share = 0.9; ///< D of the device's range; the source's value, less where passivity asks for it
    bool within_limits = true; ///< off only to measure what the limits do
};

/// One finger feels the tissue's own force; where the tissue is stiffer than the device can render, a spring in series
/// with it. Servo thread; allocates nothing.
class FingerCoupling {
public:
    /// @param limits of the finger's device; `gain` as in within_limits()
    /// @throws InputError when the share is not between 0 and 1
    FingerCoupling(const CouplingOptions& options, const DeviceLimits& limits, double step_s, double gain);

    /// Where the tissue is to be asked: the finger, held back by the spring in series when there is one, less a little,
    /// so that a small step back does not lose the touch.
    [[nodiscard]] Fingertip asked(const Fingertip& finger) const noexcept;
    /// The force on the hand, scene frame; it never pulls the finger into the tissue.
    Vec3 force(const Fingertip& finger, const FingerContact& contact, double step_s) noexcept;
    /// The finger is placed anew: nothing holds it back.
    void restart() noexcept
    {
        held_back_.setZero();
        was_touching_ = false;
    }
    /// The damping, and the stiffest that is rendered, after the device's limits.
    [[nodiscard]] const Coupling& coupling() const noexcept { return coupling_; }

private:
    Coupling coupling_;
    double resolution_; ///< of the finger's place, mm
    Vec3 held_back_ = Vec3::Zero(); ///< asked() minus the finger's place
    VelocityEstimate proxy_velocity_;
    bool was_touching_ = false;
};

} // namespace retractor::haptics
