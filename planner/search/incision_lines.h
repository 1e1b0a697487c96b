#pragma once
// Lines on the skin along which an incision can lie: over the spaces between two ribs, and straight lines anywhere.
// Units mm; frame patient LPS.

#include "planner/anatomy/anatomy.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/intercostal_space.h"
#include "planner/measures/sight/aperture.h"

#include <optional>
#include <vector>

namespace retractor::planner {

struct LinePlace {
    ApertureSection wall;
    double along_mm = 0.0; ///< on the skin, from the first place
    double angle_deg = 0.0; ///< round the chest, see RibLine; of a line over a space
    bool free = true; ///< an incision can lie here
};

struct IncisionLine {
    std::optional<SpaceNumber> space; ///< not set: a line anywhere on the skin
    std::vector<LinePlace> places; ///< at least two
};

/// The skin over a space, from the back muscles to the sternum. No incision lies where ribs join, where bone (the
/// shoulder blade) covers the space, or where the skin jumps to an arm.
/// @throws InputError as find_intercostal_space() does, and where no skin is found
IncisionLine line_over_space(const BodyProbe& probe, const Anatomy& anatomy, bool left, int number);

/// A straight line on the skin about a point, in a direction; nothing where no cavity lies behind the wall, or where
/// the skin is not found.
/// @param inward, along unit vectors at right angles
std::optional<IncisionLine> line_on_skin(
    const BodyProbe& probe, const Vec3& middle, const Vec3& inward, const Vec3& along, double length_mm);

/// The sections of the wall between two distances along the line; nothing where an incision cannot lie there.
std::optional<std::vector<ApertureSection>> sections_between(const IncisionLine& line, double from_mm, double to_mm);

} // namespace retractor::planner
