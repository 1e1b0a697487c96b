#pragma once
// The coupling between a finger in the scene and the tissue: computes the force for the hand from the tissue's answer.
// Units mm, N, s.

#include "haptics/device/velocity_estimate.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/tissue_response.h"

namespace retractor::haptics {

struct CouplingOptions {
    /// Damping as a share of the device's range: 0.9 in Tang et al. 2020; less where passivity requires it.
    double damping_share = 0.9;
    bool within_limits = true; ///< off only to measure the effect of the limits
};

/// One finger feels the tissue's own force. Where the tissue is stiffer than the device can render, a spring acts in
/// series with the tissue. Servo thread; allocates nothing.
class FingerCoupling {
public:
    /// @param limits of the finger's device
    /// @param gain as in within_limits()
    /// @throws InputError when the share is not between 0 and 1
    FingerCoupling(const CouplingOptions& options, const DeviceLimits& limits, double step_s, double gain);

    /// The fingertip that the tissue is asked about. A spring in series holds this fingertip back from the finger. The
    /// distance is a little shorter than the spring's, so that a small step back does not lose the contact.
    [[nodiscard]] Fingertip asked(const Fingertip& finger) const noexcept;
    /// The force on the hand, scene frame, N; never pulls the finger into the tissue.
    Vec3 force(const Fingertip& finger, const FingerContact& contact, double step_s) noexcept;
    /// For a finger that is placed anew: forgets the spring in series.
    void restart() noexcept
    {
        held_back_.setZero();
        was_touching_ = false;
    }
    /// Damping, and largest rendered stiffness, within the device's limits.
    [[nodiscard]] const Coupling& coupling() const noexcept { return coupling_; }

private:
    Coupling coupling_;
    double resolution_; ///< of the finger's position, mm
    Vec3 held_back_ = Vec3::Zero(); ///< asked() minus the finger's position, mm
    VelocityEstimate proxy_velocity_;
    bool was_touching_ = false;
};

} // namespace retractor::haptics
