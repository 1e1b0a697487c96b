#include "haptics/servo/finger_coupling.h"

#include "mesh/base/error.h"

#include <algorithm>

namespace retractor::haptics {

FingerCoupling::FingerCoupling(const CouplingOptions& options, const DeviceLimits& limits, double step_s, double gain)
    : resolution_(limits.resolution)
    , proxy_velocity_(limits.resolution)
{
    if (!(options.damping_share >= 0.0) || !(options.damping_share <= 1.0))
        throw InputError("a share of the device's range lies between 0 and 1", "damping_share");
    // The tissue's own stiffness is rendered up to the device's largest stiffness.
    coupling_ = { limits.max_stiffness / gain, options.damping_share * limits.max_damping / gain };
    if (options.within_limits)
        coupling_ = within_limits(coupling_, limits, step_s, gain);
}

Fingertip FingerCoupling::asked(const Fingertip& finger) const noexcept
{
    Fingertip asked = finger;
    asked.position += held_back_;
    return asked;
}

Vec3 FingerCoupling::force(const Fingertip& finger, const FingerContact& contact, double step_s) noexcept
{
    if (!contact.touching) {
        restart();
        return Vec3::Zero();
    }
    if (!was_touching_)
        proxy_velocity_.restart();
    was_touching_ = true;
    const Vec3 proxy_velocity = proxy_velocity_.update(contact.proxy, step_s);
    const Vec3& normal = contact.normal;
    Vec3 force = contact.force;
    if (contact.stiffness > coupling_.stiffness) {
        // A spring Kc in series gives the stiffest combination that the device renders: k Kc / (k + Kc) = K. The tissue
        // was asked at `held_back_`. The next question is at the point where both forces agree, with the tissue taken
        // as linear in between.
        const double k = contact.stiffness, series = k * coupling_.stiffness / (k - coupling_.stiffness);
        const double at = held_back_.dot(normal), tissue = contact.force.dot(normal);
        const double place = (tissue + k * at) / (series + k);
        force += (series * place - tissue) * normal;
        const double margin = 3.0 * resolution_ + 2.0 * step_s * finger.velocity.norm();
        held_back_ = std::max(0.0, place - margin) * normal;
    } else
        held_back_.setZero();
    force += coupling_.damping * (proxy_velocity - finger.velocity).dot(normal) * normal;
    return force - std::min(0.0, force.dot(normal)) * normal;
}

} // namespace retractor::haptics
