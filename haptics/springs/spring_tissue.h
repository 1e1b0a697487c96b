#pragma once
// Mass-spring tissue under fingertips, stepped inside the servo's tick. Each tick is divided into equal steps within
// the stability bound (spring_motion.h). Units mm, N, s, tonne. Frame: the scene's.
//
// A finger is a rigid sphere that moves evenly from its position at the last tick to its position at this tick. A
// finger that is placed (Fingertip::placed) releases its grip and touches nothing on the way. Particles that a step
// would carry into the sphere are put on its surface, radially, without friction. The force that this takes, inertia
// included, averaged over the tick's steps, is the force on the finger. Momentum is thus exchanged exactly, and at rest
// the finger feels the springs. The tissue yields fully, so the proxy is the finger itself; the servo couples the force
// to the device's limits.
//
// A grip holds the particle nearest to a finger with its ring, and carries them along until the finger releases them.
// Only a grip can pull the finger.

#include "haptics/condensed/pulse_pressure.h"
#include "haptics/servo/tissue_response.h"
#include "haptics/springs/spring_motion.h"
#include "mesh/base/triple_buffer.h"

#include <atomic>

namespace retractor::haptics {

/// Pressure on the inside of a hollow body. The pressure acts on each of these particles over its area.
struct SpringPulse {
    PulsePressure pulse = PulsePressure::constant(0.0);
    double rest_pressure = 0.0; ///< pressure at which the body has its shape, MPa
    std::vector<VertexId> particles;
    std::vector<Vec3> areas; ///< area vector of each particle, mm^2, pointing out of the hollow
};

struct SpringTissueOptions {
    std::size_t fingers = 1;
    double longest_tick = 0.005; ///< a longer tick moves the tissue by this time only, s
    int ticks_per_frame = 8; ///< number of ticks between positions for follow()
    SpringPulse pulse = {}; ///< no particles: no pulse
    /// Whether contacts report a stiffness. Off for springs with increased masses, which answer a moved finger by their
    /// inertia first. The servo's coupling moves the asked fingertip where tissue is stiffer than the device may
    /// render, and would only make such springs oscillate. The device's force limits and the passivity observer stay
    /// active.
    bool tells_stiffness = true;
};

class SpringTissue final : public TissueResponse {
public:
    /// @throws InputError as SpringMotion; on no fingers; on a tick or a number of ticks that is not positive; on a
    /// pulse with particles that do not exist or areas that do not match the particles; and, naming the bound, on
    /// springs so stiff for their mass that a tick would need more than kMostSteps steps
    SpringTissue(SpringBody body, const ElementLaw& law, const SpringTissueOptions& options = {});

    std::string_view name() const noexcept override { return "springs"; }
    std::size_t finger_count() const noexcept override { return fingers_.size(); }
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    const TriMesh& surface() const noexcept override { return motion_.body().surface; }
    void follow(Points& deformed) override;

    /// Any thread: from the next tick on the finger grips the particles under it, or releases them.
    void grip(std::size_t finger, bool held) noexcept { fingers_[finger].wants_grip.store(held); }
    [[nodiscard]] bool has_pulse() const noexcept { return !options_.pulse.particles.empty(); }
    /// Any thread: sets the rate of the pulse. @throws InputError outside 20 to 300 per minute.
    void set_heart_rate(double per_min) { beat_.set_rate(options_.pulse.pulse.rate_for(per_min)); }
    /// Any thread: pressure of the last tick, MPa.
    [[nodiscard]] double last_pressure() const noexcept { return pressure_.load(std::memory_order_relaxed); }

    /// Number of particles that the finger grips; servo thread.
    std::size_t gripped(std::size_t finger) const noexcept { return fingers_[finger].gripped_count; }

    /// Between ticks only:
    SpringMotion& motion() { return motion_; }
    const SpringMotion& motion() const { return motion_; }
    /// Number of steps in a tick of this length.
    int steps_of(double tick_s) const noexcept;

    static constexpr int kMostSteps = 1000; ///< in the longest tick

private:
    struct Finger {
        std::atomic<bool> wants_grip { false };
        bool holds = false;
        Vec3 last = Vec3::Zero();
        std::vector<VertexId> gripped; ///< room for all particles; the first gripped_count entries are in use
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
    std::vector<std::vector<VertexId>> rings_; ///< ring of each particle for grips
    std::vector<std::uint8_t> gripped_; ///< per particle
    TripleBuffer<Points> frames_;
    BeatClock beat_;
    std::atomic<double> pressure_ { 0.0 };
    int until_frame_ = 0;
    bool started_ = false;
};

} // namespace retractor::haptics
