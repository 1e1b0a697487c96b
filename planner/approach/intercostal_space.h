#pragma once
// The space between two neighbouring ribs, from the spine to the front: its middle, the line along which it is cut, and
// the levels between which intercostal muscle and pleura lie. Units mm; frame patient LPS.

#include "planner/anatomy/anatomy.h"
#include "planner/anatomy/body_probe.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// Distance of a cut from the lower rib's surface (chosen here). Surgeons go along the upper edge of the lower rib:
/// vessels and nerve run under the upper one.
inline constexpr double kAboveLowerRibMm = 4.0;
/// Most muscle that a cut leaves at the upper rib, so that a retractor's blade bears on the rib through it (chosen
/// here; see kBearingMm of bearing_points.h). In a wider gap the cut lies higher, at most half way.
inline constexpr double kMostBelowUpperRibMm = 11.0;

/// A place in an intercostal space.
struct SpacePlace {
    double angle_deg = 0.0; ///< angle round the chest, see RibLine
    Vec3 middle = Vec3::Zero(); ///< middle of the gap between the surfaces of the two ribs
    Vec3 cut = Vec3::Zero(); ///< along the lower rib, see height_of_cut()
    Vec3 outward = Vec3::Zero(); ///< unit vector at right angles to the space and to the line between the ribs
    double gap_mm = 0.0; ///< distance between the two ribs' surfaces
    double inner_mm = 0.0; ///< from the middle, or the cut, inwards to the inner side of the wall
    double outer_mm = 0.0; ///< from the middle, or the cut, outwards to the level of the ribs' outer side
    bool open = true; ///< false: the ribs or their cartilages join, or no cavity lies behind the wall
    bool cavity = true; ///< a cavity lies behind the wall
    double along_mm = 0.0; ///< along the middle, from the first place
};

struct IntercostalSpace {
    bool left = true;
    int number = 0; ///< between rib `number` and rib `number` + 1
    std::vector<SpacePlace> places; ///< from the back to the front; at least two
};

/// Side and number of a space.
struct SpaceNumber {
    bool left = true;
    int number = 0;
};

/// "4th", of the number of a space in words.
std::string ordinal(const std::string& number);

/// "left intercostal space 4".
std::string space_name(bool left, int number);

/// Height of the cut above the lower rib's surface in a gap, mm.
double height_of_cut(double gap_mm);

/// Finds the space between two ribs, over the length that both have; cartilages count where they are labelled.
/// @throws InputError when a rib has no label, or when the ribs hardly overlap
IntercostalSpace find_intercostal_space(const BodyProbe& probe, const Anatomy& anatomy, bool left, int number);

/// The space that the approach's blade follows: the one whose middle lies nearest to the blade.
/// @returns nothing when the blade passes every space at more than about half the distance of two ribs
std::optional<SpaceNumber> space_under_incision(const Anatomy& anatomy, const Approach& approach);

/// The space in which a place of the wall lies: the ribs of its side above and below it, at its own angle round the
/// chest.
/// @returns nothing above the first rib, below the last one, and more than 10 degrees beyond the ends of the ribs
std::optional<SpaceNumber> space_at(const Anatomy& anatomy, const Vec3& place);

/// The place at a distance along the space, interpolated. A distance beyond an end gives the end. A place between an
/// open and a closed one is closed.
SpacePlace place_along(const IntercostalSpace& space, double along_mm);

} // namespace retractor::planner
