#include "haptics/surroundings/hindered_tissue.h"

#include <algorithm>
#include <utility>

namespace retractor::haptics {

HinderedTissue::HinderedTissue(TissueResponse& tissue, std::shared_ptr<const FingerAccess> access)
    : tissue_(tissue)
    , access_(std::move(access))
    , held_(tissue.finger_count())
    , asked_(tissue.finger_count())
{
}

void HinderedTissue::move(Held& held, const Fingertip& finger) const noexcept
{
    if (!held.begun) {
        held.place.tip = access_->outside(finger.radius);
        held.wanted = finger.position;
        held.begun = true;
    } else if (finger.position == held.wanted && finger.radius == held.radius) {
        held.jumped = false;
        return; // the hand rests
    }
    constexpr double kJumpMm = 3.0; // in a tick, beyond the way of the hand
    const double way = (finger.position - held.wanted).norm();
    const Vec3 before = held.place.tip;
    held.wanted = finger.position;
    held.radius = finger.radius;
    held.place = access_->towards(before, finger.position, finger.radius, held.place.answer.gate);
    held.stopped = held.place.tip != finger.position;
    held.jumped = (held.place.tip - before).norm() > way + kJumpMm;
}

void HinderedTissue::tick(
    double time_s, double step_s, std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept
{
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        move(held_[f], fingers[f]);
        asked_[f] = fingers[f];
        asked_[f].position = held_[f].place.tip;
        asked_[f].placed = fingers[f].placed || held_[f].jumped;
        if (held_[f].stopped)
            asked_[f].velocity.setZero();
    }
    tissue_.tick(time_s, step_s, asked_, contacts);
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        const Held& held = held_[f];
        FingerContact& contact = contacts[f];
        contact.outward = held.place.answer.outward;
        contact.stopped = held.stopped;
        contact.stopped_at = held.place.tip;
        contact.held_back.setZero();
        contact.stopped_by = held.stopped ? held.place.answer.hindrance : DistanceGrid::kNone;
        if (!held.stopped)
            continue;
        const Vec3 back = held.place.tip - fingers[f].position;
        contact.held_back = kSurroundingsNPerMm * back;
        contact.force += contact.held_back;
        contact.stiffness = std::max(contact.stiffness, kSurroundingsNPerMm);
        if (contact.touching)
            continue;
        contact.touching = true;
        contact.proxy = held.place.tip;
        contact.depth = back.norm();
        contact.normal = contact.depth > 0.0 ? Vec3(back / contact.depth) : Vec3(Vec3::Zero());
    }
}

} // namespace retractor::haptics
