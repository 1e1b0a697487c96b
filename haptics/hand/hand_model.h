#pragma once
// A hand to show at the proxies. Palm, thumb and four fingers are made of rounded bones in code, so that no file is
// needed. Units mm. Frame of the hand: the middle finger points along +y, the palm faces -z, and the thumb of a right
// hand lies towards -x.

#include "mesh/base/geometry.h"

#include <array>
#include <optional>
#include <span>

namespace retractor::haptics {

struct HandModel {
    TriMesh surface; ///< closed, oriented outwards
    std::array<Vec3, 5> tips; ///< centres of the fingertips: thumb, fore, middle, ring and little finger
    std::array<double, 5> tip_radius {};
};

/// A half bent hand, as for a grasp with thumb, forefinger and middle finger.
/// @param length_mm from wrist to the stretched middle fingertip, 100 to 260
/// @throws InputError on another length
HandModel make_hand(bool left, double length_mm = 180.0);

/// Finger of the hand for the i-th shown fingertip: the first is the forefinger, the second the thumb.
constexpr std::array<std::size_t, 5> kPressingOrder { 1, 0, 2, 3, 4 };

/// A rigid motion of a hand: scene mm = turn * hand mm + shift.
struct HandPlace {
    Mat3 turn = Mat3::Identity();
    Vec3 shift = Vec3::Zero();
};

/// The rigid motion that lays a hand on tissue as if it were the viewer's: the palm faces the tissue, the fingers point
/// up in the picture. The first fingertip (of kPressingOrder) lies at its tip. The second fingertip turns the hand
/// about `outward`. Other fingertips have no effect, because the fingers of the model do not bend.
/// @param outward outward unit normal of the tissue
/// @param sight,up directions of the camera
/// @throws InputError unless there are 1 to 5 finite fingertips
HandPlace place_hand(
    const HandModel& hand, const Vec3& outward, const Vec3& sight, const Vec3& up, std::span<const Vec3> tips);

/// A fingertip that a hand is shown at.
struct ShownFinger {
    Vec3 tip = Vec3::Zero(); ///< centre of the fingertip, mm
    double radius = 0.0;
    Vec3 outward = Vec3::Zero(); ///< outward unit normal of the tissue
};
constexpr std::size_t kFingersPerHand = 3;

/// Places hands on the fingers, kFingersPerHand fingers to each hand in order, by place_hand(). Fingers in one place
/// count once. The fingertips are moved outward so that the thicker fingers of the hand lie on the tissue. A hand
/// without fingers has no place.
/// @throws InputError as place_hand()
std::array<std::optional<HandPlace>, 2> place_hands(
    const std::array<HandModel, 2>& hands, std::span<const ShownFinger> fingers, const Vec3& sight, const Vec3& up);

} // namespace retractor::haptics
