#include "haptics/spheres/sphere_tissue.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::haptics {

SphereTissue::SphereTissue(std::vector<SphereOrgan> organs, const SphereLaw& law, double blend_time)
    : motion_(std::move(organs), law)
    , blend_time_(blend_time)
{
    if (!(blend_time >= 0.0) || !std::isfinite(blend_time))
        throw InputError("the blend time must not be negative, got " + std::to_string(blend_time));
    felt_.fill(Vec3::Zero());
}

FingerContact SphereTissue::contact_of(const Answer& answer, const Fingertip& tip, const Vec3& force) noexcept
{
    FingerContact contact;
    contact.proxy = tip.position;
    contact.force = force;
    const double size = force.norm();
    constexpr double kFelt = 1e-6; // N
    if (size < kFelt)
        return contact;
    contact.touching = true;
    contact.normal = force / size;
    contact.depth = answer.depth;
    contact.stiffness = answer.stiffness;
    return contact;
}

void SphereTissue::tick(
    double time_s, double step_s, std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept
{
    RETRACTOR_ASSERT(fingers.size() == finger_count() && contacts.size() == fingers.size());
    Question& question = questions_.draft();
    question.valid = true;
    question.time_s = time_s;
    std::copy(fingers.begin(), fingers.end(), question.fingers.begin());
    questions_.publish();
    const Answers& answers = answers_.latest();
    const double share = blend_time_ > 0.0 ? -std::expm1(-std::max(0.0, step_s) / blend_time_) : 1.0;
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        const Answer& answer = answers[f];
        // Change of depth since the last answer, along its normal.
        const double deeper = -(fingers[f].position - answer.at).dot(answer.normal);
        Vec3 force = answer.force + answer.stiffness * deeper * answer.normal;
        if (!answer.pulls && force.dot(answer.normal) <= 0.0)
            force.setZero(); // the force only pushes
        felt_[f] += share * (force - felt_[f]);
        contacts[f] = contact_of(answer, fingers[f], felt_[f]);
    }
}

void SphereTissue::follow(Points& deformed)
{
    const Question& question = questions_.latest();
    if (!question.valid)
        return motion_.deform(deformed);
    const std::size_t fingers = finger_count();
    for (std::size_t f = 0; f < fingers; ++f) {
        const bool wants = wants_pinch_[f].load();
        if (wants && !motion_.pinches(f)) {
            try {
                motion_.pinch(f, question.fingers[f]);
            } catch (const InputError&) {
                wants_pinch_[f].store(false); // no surface nearby, which is an expected outcome
            }
        } else if (!wants && motion_.pinches(f))
            motion_.release(f);
    }
    std::array<SphereContact, SphereMotion::kMostFingers> contacts;
    const double dt = std::max(0.0, question.time_s - followed_s_);
    followed_s_ = question.time_s;
    motion_.advance(dt, { question.fingers.data(), fingers }, { contacts.data(), fingers });
    Answers& answers = answers_.draft();
    for (std::size_t f = 0; f < fingers; ++f) {
        Answer& answer = answers[f];
        answer = {};
        answer.at = question.fingers[f].position;
        answer.force = contacts[f].force;
        answer.depth = contacts[f].depth;
        answer.pulls = motion_.pinches(f);
        const double size = contacts[f].force.norm();
        if (size > 0.0) {
            answer.normal = contacts[f].force / size;
            // A lattice does not resolve depths below a sphere's radius. At the first contact the secant would be many
            // times too steep, and would hit a hand that moves on before the next frame.
            answer.stiffness = size / std::max(contacts[f].radius, contacts[f].depth);
        }
    }
    answers_.publish();
    motion_.deform(deformed);
}

} // namespace retractor::haptics
