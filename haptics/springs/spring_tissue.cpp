#include "haptics/springs/spring_tissue.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::haptics {

namespace {

    void check(const SpringTissueOptions& options, double stable_step)
    {
        if (options.fingers < 1 || options.fingers > 16)
            throw InputError("a tissue is touched by 1 to 16 fingers, got " + std::to_string(options.fingers));
        if (!(options.longest_tick > 0.0) || !std::isfinite(options.longest_tick))
            throw InputError("the longest tick must be positive, got " + std::to_string(options.longest_tick));
        if (options.ticks_per_frame < 1)
            throw InputError("ticks per frame must be positive, got " + std::to_string(options.ticks_per_frame));
        if (options.longest_tick / stable_step > SpringTissue::kMostSteps) {
            throw InputError(formatted(
                "the springs are too stiff for their mass: their stability bound is %g s, less than 1/%d of a tick of "
                "%g s",
                stable_step, SpringTissue::kMostSteps, options.longest_tick));
        }
    }

    void check(const SpringPulse& pulse, std::size_t particles)
    {
        if (pulse.particles.size() != pulse.areas.size())
            throw InputError("there must be one area per particle", "pulse");
        for (std::size_t i = 0; i < pulse.particles.size(); ++i)
            if (pulse.particles[i] < 0 || static_cast<std::size_t>(pulse.particles[i]) >= particles
                || !pulse.areas[i].allFinite())
                throw InputError("presses on a particle that does not exist, or on an area that is not finite",
                    "pulse, entry " + std::to_string(i));
        if (!std::isfinite(pulse.rest_pressure))
            throw InputError("the pressure at rest must be finite", "pulse");
    }

    /// The rings of all particles in one pass, because a search through the springs for each particle is slow in a
    /// large sheet.
    std::vector<std::vector<VertexId>> all_rings(const SpringBody& body)
    {
        // A ring includes springs up to kRing times the shortest length: all eight neighbours in a sheet, and edges of
        // similar length in an organ.
        constexpr double kRing = 1.5;
        std::vector<double> shortest(body.mass.size(), std::numeric_limits<double>::infinity());
        for (const TissueSpring& spring : body.springs)
            for (const VertexId v : { spring.a, spring.b })
                shortest[static_cast<std::size_t>(v)] = std::min(shortest[static_cast<std::size_t>(v)], spring.length);
        std::vector<std::vector<VertexId>> rings(body.mass.size());
        for (const TissueSpring& spring : body.springs) {
            if (spring.length < kRing * shortest[static_cast<std::size_t>(spring.a)])
                rings[static_cast<std::size_t>(spring.a)].push_back(spring.b);
            if (spring.length < kRing * shortest[static_cast<std::size_t>(spring.b)])
                rings[static_cast<std::size_t>(spring.b)].push_back(spring.a);
        }
        return rings;
    }

} // namespace

SpringTissue::SpringTissue(SpringBody body, const ElementLaw& law, const SpringTissueOptions& options)
    : motion_(std::move(body), law)
    , options_(options)
    , fingers_(options.fingers)
    , gripped_(motion_.body().mass.size(), 0)
    , frames_(motion_.body().surface.vertices)
{
    check(options, motion_.stable_step());
    check(options.pulse, motion_.body().mass.size());
    for (Finger& finger : fingers_) {
        finger.gripped.resize(motion_.body().mass.size());
        finger.offsets.resize(motion_.body().mass.size());
    }
    rings_ = all_rings(motion_.body());
}

void SpringTissue::press_from_inside(double time_s) noexcept
{
    const SpringPulse& pulse = options_.pulse;
    if (pulse.particles.empty() || !std::isfinite(time_s))
        return;
    const double now = pulse.pulse.at(beat_.at(time_s)), pressure = now - pulse.rest_pressure;
    pressure_.store(now, std::memory_order_relaxed);
    for (std::size_t i = 0; i < pulse.particles.size(); ++i)
        motion_.set_load(pulse.particles[i], pressure * pulse.areas[i]);
}

int SpringTissue::steps_of(double tick_s) const noexcept
{
    return std::max(1, static_cast<int>(std::ceil(tick_s / motion_.stable_step())));
}

void SpringTissue::take_hold(Finger& finger, const Fingertip& tip) noexcept
{
    // A little beyond the sphere, because particles on its surface touch it up to rounding.
    const double reach = 1.001 * tip.radius;
    finger.gripped_count = 0;
    const auto hold = [&](VertexId v) {
        if (gripped_[static_cast<std::size_t>(v)] != 0)
            return; // another finger holds the particle
        RETRACTOR_ASSERT(finger.gripped_count < finger.gripped.size());
        gripped_[static_cast<std::size_t>(v)] = 1;
        finger.gripped[finger.gripped_count] = v;
        finger.offsets[finger.gripped_count++] = motion_.position(v) - tip.position;
    };
    VertexId nearest = -1;
    double least = reach;
    for (const VertexId v : motion_.body().touchable) {
        const double distance = (motion_.position(v) - tip.position).norm();
        if (distance > reach)
            continue;
        if (distance < least || nearest < 0) {
            least = distance;
            nearest = v;
        }
    }
    if (nearest >= 0) {
        hold(nearest);
        for (const VertexId v : rings_[static_cast<std::size_t>(nearest)])
            hold(v);
    }
    finger.holds = finger.gripped_count > 0;
}

void SpringTissue::let_go(Finger& finger) noexcept
{
    for (std::size_t i = 0; i < finger.gripped_count; ++i)
        gripped_[static_cast<std::size_t>(finger.gripped[i])] = 0;
    finger.holds = false;
    finger.gripped_count = 0;
}

void SpringTissue::touch(Finger& finger, const Vec3& centre, double radius) noexcept
{
    if (finger.holds) {
        for (std::size_t i = 0; i < finger.gripped_count; ++i)
            finger.impulse -= motion_.hold_next(finger.gripped[i], centre + finger.offsets[i]);
        return;
    }
    const double squared = radius * radius;
    for (const VertexId v : motion_.body().touchable) {
        const Vec3 out = motion_.next(v) - centre;
        const double distance = out.squaredNorm();
        if (distance >= squared || distance == 0.0 || gripped_[static_cast<std::size_t>(v)] != 0)
            continue;
        finger.impulse -= motion_.hold_next(v, centre + out * (radius / std::sqrt(distance)));
    }
}

FingerContact SpringTissue::contact_of(const Finger& finger, const Fingertip& tip, int steps) const noexcept
{
    FingerContact contact;
    contact.proxy = tip.position;
    RETRACTOR_ASSERT(steps > 0);
    contact.force = finger.impulse / steps;
    const double force = contact.force.norm();
    if (!(force > 0.0))
        return contact;
    contact.touching = true;
    contact.normal = contact.force / force;
    const auto deepen = [&](VertexId v) {
        const auto rest = motion_.body().surface.vertices.row(v).transpose();
        contact.depth = std::max(contact.depth, (rest - motion_.position(v)).dot(contact.normal));
    };
    if (finger.holds)
        std::for_each(
            finger.gripped.begin(), finger.gripped.begin() + static_cast<std::ptrdiff_t>(finger.gripped_count), deepen);
    else {
        const double reach = 1.001 * tip.radius;
        for (const VertexId v : motion_.body().touchable)
            if ((motion_.position(v) - tip.position).squaredNorm() < reach * reach)
                deepen(v);
    }
    // The secant stiffness, because a slack sheet is much stiffer deep down than at first touch. At a smaller depth the
    // secant is noise.
    constexpr double kShallow = 1e-3; // mm
    contact.stiffness = options_.tells_stiffness && contact.depth > kShallow ? force / contact.depth : 0.0;
    return contact;
}

void SpringTissue::tick(
    double time_s, double step_s, std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept
{
    RETRACTOR_ASSERT(fingers.size() == fingers_.size() && contacts.size() == fingers_.size());
    const double tick = std::min(step_s, options_.longest_tick);
    if (!(tick > 0.0)) { // no time to move in, or NaN; the servo takes NaN as a fault
        for (std::size_t f = 0; f < fingers.size(); ++f) {
            contacts[f] = {};
            contacts[f].proxy = fingers[f].position;
            contacts[f].force.setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        return;
    }
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        Finger& finger = fingers_[f];
        if (!started_ || fingers[f].placed) {
            let_go(finger); // else the finger would carry its grip along
            finger.last = fingers[f].position;
        }
        finger.impulse.setZero();
        const bool wants = finger.wants_grip.load(std::memory_order_relaxed);
        if (wants && !finger.holds)
            take_hold(finger, { finger.last, Vec3::Zero(), fingers[f].radius });
        else if (!wants)
            let_go(finger);
    }
    started_ = true;
    press_from_inside(time_s);
    const int steps = steps_of(tick);
    const double dt = tick / steps;
    for (int s = 1; s <= steps; ++s) {
        motion_.begin_step(dt); // dt is within the bound
        const double share = static_cast<double>(s) / steps;
        for (std::size_t f = 0; f < fingers_.size(); ++f)
            touch(fingers_[f], fingers_[f].last + share * (fingers[f].position - fingers_[f].last), fingers[f].radius);
        motion_.end_step();
    }
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        contacts[f] = contact_of(fingers_[f], fingers[f], steps);
        fingers_[f].last = fingers[f].position;
    }
    if (--until_frame_ <= 0) {
        until_frame_ = options_.ticks_per_frame;
        frames_.draft() = motion_.positions(); // sizes are equal, so no allocation
        frames_.publish();
    }
}

void SpringTissue::follow(Points& deformed) { deformed = frames_.latest(); }

} // namespace retractor::haptics
