#pragma once
// Tissue bounded by planes, with closed forms, for the tests of the servo.

#include "haptics/servo/tissue_response.h"

#include <cmath>
#include <limits>
#include <vector>

namespace retractor::test_support {

/// The half space y < height. The force is stiffness (N/mm) times depth, for any number of fingers. Fingers are points,
/// not spheres.
class Wall : public haptics::TissueResponse {
public:
    explicit Wall(double stiffness, std::size_t fingers = 1)
        : stiffness_(stiffness)
        , fingers_(fingers)
    {
    }

    std::string_view name() const noexcept override { return "wall"; }
    std::size_t finger_count() const noexcept override { return fingers_; }
    void tick(double, double, std::span<const haptics::Fingertip> fingers,
        std::span<haptics::FingerContact> contacts) noexcept override
    {
        ++ticks;
        for (std::size_t f = 0; f < fingers.size(); ++f) {
            const Vec3& at = fingers[f].position;
            haptics::FingerContact& c = contacts[f];
            c = { .proxy = at };
            c.touching = at.y() < height;
            if (c.touching) {
                c.normal = Vec3::UnitY();
                c.depth = height - at.y();
                c.proxy.y() = height;
                c.stiffness = stiffness_;
                c.force = stiffness_ * c.depth * c.normal;
            }
            if (ticks == bad_tick)
                c.force.x() = std::numeric_limits<double>::quiet_NaN();
            if (ticks == far_tick)
                c.proxy.y() = std::numeric_limits<double>::max();
        }
    }
    const TriMesh& surface() const noexcept override { return surface_; }
    void follow(Points&) override { }

    double height = 0.0;
    std::uint64_t ticks = 0, bad_tick = 0, far_tick = 0;

private:
    double stiffness_;
    std::size_t fingers_;
    TriMesh surface_;
};

} // namespace retractor::test_support
