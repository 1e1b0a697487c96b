#include "haptics/hand/hand_model.h"

#include "mesh/base/error.h"
#include "mesh/surface/label_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace retractor::haptics {

namespace {

    constexpr double kApart = 0.1; ///< mm; fingertips closer than this define no direction

    /// A bone with its flesh: two balls and the cone between them.
    struct Capsule {
        Vec3 a, b;
        double radius_a = 0.0, radius_b = 0.0;

        double distance(const Vec3& p) const
        {
            const Vec3 ab = b - a;
            const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
            return (p - a - t * ab).norm() - (radius_a + t * (radius_b - radius_a));
        }
    };

    struct Finger {
        Vec3 knuckle;
        double yaw = 0.0; ///< angle from +y in the plane of the palm, rad
        std::array<double, 3> bones {}, bend {}; ///< length of each bone, mm; bend at each joint towards the palm, rad
        double radius = 8.0; ///< radius at the knuckle, mm; the tip has 0.8 of this radius
    };

    /// Fingers of a right hand of 180 mm.
    const std::array<Finger, 5>& fingers()
    {
        static const std::array<Finger, 5> hand { {
            { Vec3(-32.0, 28.0, -8.0), -0.75, { 34.0, 30.0, 24.0 }, { 0.45, 0.35, 0.3 }, 11.0 },
            { Vec3(-27.0, 88.0, 0.0), -0.10, { 40.0, 25.0, 20.0 }, { 0.55, 0.55, 0.35 }, 9.0 },
            { Vec3(-8.0, 92.0, 2.0), 0.0, { 44.0, 28.0, 21.0 }, { 0.5, 0.55, 0.35 }, 9.2 },
            { Vec3(11.0, 88.0, 0.0), 0.08, { 41.0, 26.0, 21.0 }, { 0.5, 0.6, 0.4 }, 8.6 },
            { Vec3(28.0, 80.0, -3.0), 0.18, { 32.0, 20.0, 18.0 }, { 0.5, 0.6, 0.4 }, 7.6 },
        } };
        return hand;
    }

    std::vector<Capsule> bones_of(HandModel& hand, bool left, double scale)
    {
        std::vector<Capsule> bones;
        const Vec3 wrist(0.0, 0.0, 0.0);
        for (std::size_t f = 0; f < 5; ++f) {
            const Finger& finger = fingers()[f];
            bones.push_back(
                { wrist + Vec3(0.35 * finger.knuckle.x(), 4.0, 0.0), finger.knuckle, 17.0, finger.radius + 4.0 });
            Vec3 joint = finger.knuckle;
            double pitch = 0.0;
            for (std::size_t b = 0; b < 3; ++b) {
                pitch += finger.bend[b];
                const Vec3 way(
                    std::sin(finger.yaw) * std::cos(pitch), std::cos(finger.yaw) * std::cos(pitch), -std::sin(pitch));
                const Vec3 next = joint + finger.bones[b] * way;
                const double from = finger.radius * (1.0 - 0.2 * static_cast<double>(b) / 3.0),
                             to = finger.radius * (1.0 - 0.2 * static_cast<double>(b + 1) / 3.0);
                bones.push_back({ joint, next, from, to });
                joint = next;
            }
            hand.tips[f] = joint;
            hand.tip_radius[f] = 0.8 * finger.radius * scale;
        }
        bones.push_back({ Vec3(0.0, -45.0, 0.0), Vec3(0.0, 6.0, 0.0), 23.0, 22.0 }); // end of the forearm
        for (Capsule& bone : bones) {
            bone.radius_a *= scale;
            bone.radius_b *= scale;
            for (Vec3* end : { &bone.a, &bone.b }) {
                *end *= scale;
                if (left)
                    end->x() = -end->x();
            }
        }
        for (Vec3& tip : hand.tips) {
            tip *= scale;
            if (left)
                tip.x() = -tip.x();
        }
        return bones;
    }

} // namespace

HandModel make_hand(bool left, double length_mm)
{
    if (!(length_mm >= 100.0 && length_mm <= 260.0))
        throw InputError("a hand is 100 to 260 mm long, got " + std::to_string(length_mm));
    constexpr double kLength = 185.0, kVoxel = 2.0; // length of the hand laid out above; mm
    HandModel hand;
    const std::vector<Capsule> bones = bones_of(hand, left, length_mm / kLength);
    Vec3 low = bones.front().a, high = low;
    for (const Capsule& bone : bones)
        for (const auto& [end, radius] : { std::pair { bone.a, bone.radius_a }, { bone.b, bone.radius_b } }) {
            low = low.cwiseMin((end.array() - radius).matrix());
            high = high.cwiseMax((end.array() + radius).matrix());
        }
    mesh::ImageGrid grid;
    grid.spacing = Vec3::Constant(kVoxel);
    grid.origin = low.array() - 3.0 * kVoxel;
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.size[axis] = static_cast<int>((high - low)(static_cast<Eigen::Index>(axis)) / kVoxel) + 7;
    std::vector<std::uint8_t> inside(grid.voxel_count(), 0);
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i) {
                const Vec3 p = grid.world(Vec3(i, j, k));
                inside[grid.offset(i, j, k)] = std::any_of(bones.begin(), bones.end(),
                                                   [&](const Capsule& bone) { return bone.distance(p) < 0.0; })
                    ? 1
                    : 0;
            }
    hand.surface = mesh::mask_surface(grid, inside, 2.0);
    return hand;
}

HandPlace place_hand(
    const HandModel& hand, const Vec3& outward, const Vec3& sight, const Vec3& up, std::span<const Vec3> tips)
{
    if (tips.empty() || tips.size() > hand.tips.size())
        throw InputError("a hand is placed by 1 to 5 fingertips, got " + std::to_string(tips.size()));
    for (std::size_t i = 0; i < tips.size(); ++i)
        if (!tips[i].allFinite())
            throw InputError("its place is not finite", "fingertip " + std::to_string(i));
    const auto flat = [&](const Vec3& v) -> Vec3 { return v - v.dot(outward) * outward; };
    constexpr double kAlong = 0.2; // a projected unit vector shorter than this defines no direction
    HandPlace place;
    Vec3 ahead = flat(up);
    if (ahead.norm() < kAlong)
        ahead = flat(sight);
    if (ahead.norm() < kAlong) // the camera looks from the side
        ahead = outward.unitOrthogonal();
    ahead.normalize();
    place.turn.col(2) = outward;
    place.turn.col(1) = ahead;
    place.turn.col(0) = ahead.cross(outward);
    const Vec3& first = hand.tips[kPressingOrder[0]];
    if (tips.size() > 1 && (tips[1] - tips[0]).norm() > kApart) {
        const Vec3 from = flat(place.turn * (hand.tips[kPressingOrder[1]] - first)), to = flat(tips[1] - tips[0]);
        const double angle = std::atan2(from.cross(to).dot(outward), from.dot(to));
        place.turn = Eigen::AngleAxisd(angle, outward).toRotationMatrix() * place.turn;
    }
    place.shift = tips[0] - place.turn * first;
    return place;
}

std::array<std::optional<HandPlace>, 2> place_hands(
    const std::array<HandModel, 2>& hands, std::span<const ShownFinger> fingers, const Vec3& sight, const Vec3& up)
{
    std::array<std::optional<HandPlace>, 2> placed;
    for (std::size_t h = 0; h < hands.size() && h * kFingersPerHand < fingers.size(); ++h) {
        const std::size_t first = h * kFingersPerHand;
        std::vector<Vec3> met, tips;
        Vec3 out = Vec3::Zero();
        for (const ShownFinger& finger : fingers.subspan(first, std::min(kFingersPerHand, fingers.size() - first))) {
            out += finger.outward;
            if (std::any_of(
                    met.begin(), met.end(), [&](const Vec3& other) { return (finger.tip - other).norm() <= kApart; }))
                continue;
            const double lift = hands[h].tip_radius[kPressingOrder[tips.size()]] - finger.radius;
            met.push_back(finger.tip);
            tips.push_back(finger.tip + lift * finger.outward);
        }
        // Opposed fingers have no common outward direction; the hand then comes from the eye.
        constexpr double kAgree = 0.5;
        const Vec3 outward = out.norm() > kAgree ? Vec3(out.normalized()) : Vec3(-sight.normalized());
        placed[h] = place_hand(hands[h], outward, sight, up, tips);
    }
    return placed;
}

} // namespace retractor::haptics
