#pragma once
// A hand to be shown at the proxies: palm, thumb and four fingers from rounded bones, made here, so that no file is
// needed. Units mm. Its own frame: the middle finger points along +y, the palm looks along -z, the thumb of a right
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

/// Half bent, as for a grasp with thumb, forefinger and middle finger. @param length_mm from wrist to the stretched
/// middle fingertip, 100 to 260. @throws InputError otherwise.
HandModel make_hand(bool left, double length_mm = 180.0);

/// Which finger the i-th of the fingertips shown is: one is the forefinger, two are it and the thumb.
constexpr std::array<std::size_t, 5> kPressingOrder { 1, 0, 2, 3, 4 };

struct HandPlace {
    Mat3 turn = Mat3::Identity();
    Vec3 shift = Vec3::Zero();
};

/// The rigid motion that lays a hand on tissue as the viewer's own: the palm looks into the tissue, fingers point up
/// the picture. The first fingertip (of kPressingOrder) lies where it is meant to; the second turns the hand, which
/// stays as it is above the tissue; a hand that does not bend its fingers cannot follow them all. @param outward of the
/// tissue.
/// @param sight,up the camera's. @throws InputError unless there are 1 to 5 finite fingertips
HandPlace place_hand(
    const HandModel& hand, const Vec3& outward, const Vec3& sight, const Vec3& up, std::span<const Vec3> tips);

/// A fingertip that a hand is shown at.
struct ShownFinger {
    Vec3 tip = Vec3::Zero(); ///< its centre
    double radius = 0.0;
    Vec3 outward = Vec3::Zero(); ///< of the tissue, unit
};
constexpr std::size_t kFingersPerHand = 3;

/// Lays hands on the fingers, in their order kFingersPerHand each: place_hand() with fingers as thick as the hand's,
/// which lie on the tissue, too; those in one place count once. A hand without a finger has no place.
/// @throws as place_hand()
std::array<std::optional<HandPlace>, 2> place_hands(
    const std::array<HandModel, 2>& hands, std::span<const ShownFinger> fingers, const Vec3& sight, const Vec3& up);

} // namespace retractor::haptics
