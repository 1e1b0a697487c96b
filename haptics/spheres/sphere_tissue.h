#pragma once
// Sphere-filled organs under the servo. The spheres move at the display's rate, in follow(). The servo computes forces
// from the last answer about each finger: a force and its growth with depth (an "intermediate representation"), so that
// the hand feels 1,000 Hz for any number of spheres. A new answer is blended in over `blend_time`, so that its step is
// not felt. Units mm, N, s. Frame: the scene's.

#include "haptics/servo/tissue_response.h"
#include "haptics/spheres/sphere_motion.h"
#include "mesh/base/triple_buffer.h"

#include <array>
#include <atomic>

namespace retractor::haptics {

class SphereTissue final : public TissueResponse {
public:
    /// @throws InputError as SphereMotion, or when blend_time is negative or not finite
    SphereTissue(std::vector<SphereOrgan> organs, const SphereLaw& law, double blend_time = 0.01);

    std::string_view name() const noexcept override { return "spheres"; }
    std::size_t finger_count() const noexcept override { return motion_.law().fingers; }
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    const TriMesh& surface() const noexcept override { return motion_.surface(); }
    /// Also carries out the pinches and releases of want_pinch(). Before the first tick nothing touches the spheres.
    void follow(Points& deformed) override;

    /// Any thread: from the next follow() on the finger holds the exact surface point under it, or releases it. A pinch
    /// without a surface nearby is dropped.
    void want_pinch(std::size_t finger, bool pinched) noexcept { wants_pinch_[finger].store(pinched); }

    /// Simulation thread:
    SphereMotion& motion() { return motion_; }
    const SphereMotion& motion() const { return motion_; }

private:
    struct Question {
        bool valid = false; ///< false until the first tick, when there are no fingers yet
        double time_s = 0.0;
        std::array<Fingertip, SphereMotion::kMostFingers> fingers;
    };
    struct Answer {
        Vec3 force = Vec3::Zero(), normal = Vec3::Zero();
        Vec3 at = Vec3::Zero(); ///< position of the finger in the question
        double depth = 0.0, stiffness = 0.0;
        bool pulls = false; ///< the finger pinches, so the force may pull
    };
    using Answers = std::array<Answer, SphereMotion::kMostFingers>;

    static FingerContact contact_of(const Answer& answer, const Fingertip& tip, const Vec3& force) noexcept;

    SphereMotion motion_;
    double blend_time_;
    TripleBuffer<Question> questions_;
    TripleBuffer<Answers> answers_;
    std::array<std::atomic<bool>, SphereMotion::kMostFingers> wants_pinch_ {};
    std::array<Vec3, SphereMotion::kMostFingers> felt_; ///< servo thread: force of the last tick
    double followed_s_ = 0.0; ///< time of the last answered question
};

} // namespace retractor::haptics
