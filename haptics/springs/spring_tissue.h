#pragma once
// Mass-spring tissue under fingertips, stepped inside the servo's own tick: each tick is divided into as many equal
// steps as the stability bound asks for (haptics/spring_motion.h). Units mm, N, s, tonne; the frame is the scene's.
//
// A finger is a rigid sphere that moves evenly from where the last tick left it to where this one has it; one that is
// placed there (Fingertip::placed) lets go of what it held, and touches nothing on the way. Particles
// that a step would carry inside are put on its surface, radially, without friction. What that takes, inertia included,
// is the finger's force, averaged over the tick's steps: momentum is exchanged exactly, and at rest it is what the
// springs press with. The tissue yields wholly, so the proxy is the finger itself; a coupling to the device's limits is
// the servo's.
//
// A grip takes hold of the particles under a finger (all it touches, the nearest one, or the nearest with its ring) and
// carries them along until let go: then, and only then, the finger is pulled as well.

#include "haptics/condensed/pulse_pressure.h"
#include "haptics/servo/tissue_response.h"
#include "haptics/springs/spring_motion.h"
#include "mesh/base/triple_buffer.h"

#include <atomic>
#include <memory>

namespace retractor::haptics {

/// What a grip takes hold of.
enum class GripPatch { touched, point, ring };

/// A pressure on the inside of a hollow body: on each of these particles, along its area.
struct SpringPulse {
    PulsePressure pulse = PulsePressure::constant(0.0);
    double rest_pressure = 0.0; ///< MPa, at which the body has its shape
    std::vector<VertexId> particles;
    std::vector<Vec3> areas; ///< mm^2, out of the hollow; per entry of `particles`
};

struct SpringTissueOptions {
    std::size_t fingers = 1;
    GripPatch grip = GripPatch::ring;
    double longest_tick = 0.005; ///< s: a later tick moves the tissue by this much time only
    int ticks_per_frame = 8; ///< every so many ticks the positions are handed to follow()
    SpringPulse pulse = {}; ///< without particles: none
    /// Off for springs made heavier: they answer a moved finger by their inertia first, and a coupling that moves where
    /// they are asked, as it does for tissue stiffer than a device may render, would only set them swinging. The
    /// device's force limits and the passivity observer stay.
    bool tells_stiffness = true;
};

class SpringTissue final : public TissueResponse {
public:
    /// @throws InputError as SpringMotion, and on no fingers, a tick or a number of ticks that is not positive, a pulse
    /// on particles that do not exist or with areas that are not theirs, or
    /// springs so stiff for their mass that a tick would need more than kMostSteps steps, naming the bound.
    SpringTissue(SpringBody body, const ElementLaw& law, const SpringTissueOptions& options = {});

    std::string_view name() const noexcept override { return "springs"; }
    std::size_t finger_count() const noexcept override { return fingers_.size(); }
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    const TriMesh& surface() const noexcept override { return motion_.body().surface; }
    void follow(Points& deformed) override;

    /// Any thread: from the next tick on the finger holds what is under it, or lets go.
    void grip(std::size_t finger, bool held) noexcept { fingers_[finger].wants_grip.store(held); }
    [[nodiscard]] bool has_pulse() const noexcept { return !options_.pulse.particles.empty(); }
    /// Any thread: the pulse goes on at this rate. @throws InputError outside 20 to 300 per minute.
    void set_heart_rate(double per_min) { beat_.set_rate(options_.pulse.pulse.rate_for(per_min)); }
    /// Any thread: of the last tick, MPa.
    [[nodiscard]] double last_pressure() const noexcept { return pressure_.load(std::memory_order_relaxed); }

    /// How many particles the finger holds; servo thread.
    std::size_t gripped(std::size_t finger) const noexcept { return fingers_[finger].gripped_count; }

    /// Between ticks only.
    SpringMotion& motion() { return motion_; }
    const SpringMotion& motion() const { return motion_; }
    /// Steps that a tick of so long is divided into.
    int steps_of(double tick_s) const noexcept;

    static constexpr int kMostSteps = 1000; ///< of the longest tick

private:
    struct Finger {
        std::atomic<bool> wants_grip { false };
        bool holds = false;
        Vec3 last = Vec3::Zero();
        std::vector<VertexId> gripped; ///< room for all particles; gripped_count of them in use
        std::vector<Vec3> offsets;
        std::size_t gripped_count = 0;
        Vec3 impulse = Vec3::Zero();
        double depth = 0.0;
    };

    void press_from_inside(double time_s) noexcept;
    void take_hold(Finger& finger, const Fingertip& tip) noexcept;
    void let_go(Finger& finger) noexcept;
    void touch(Finger& finger, const Vec3& centre, double radius) noexcept;
    FingerContact contact_of(const Finger& finger, const Fingertip& tip, int steps) const noexcept;

    SpringMotion motion_;
    SpringTissueOptions options_;
    std::vector<Finger> fingers_;
    std::vector<std::vector<VertexId>> rings_; ///< per particle, for grips; empty unless GripPatch::ring
    std::vector<std::uint8_t> gripped_; ///< per particle
    TripleBuffer<Points> frames_;
    BeatClock beat_;
    std::atomic<double> pressure_ { 0.0 };
    int until_frame_ = 0;
    bool started_ = false;
};

} // namespace retractor::haptics
