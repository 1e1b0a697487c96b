#pragma once
// A hole through the wall at rest, as wide as a wound that is held open: what an incision would show, before any tissue
// is computed. The hole is a lens along a line on the skin, with its middle wide and its ends closed, on the skin and,
// narrower or as wide, on the inner side of the wall. A ray passes where it goes through both lenses. Units mm; frame
// patient LPS.

#include "mesh/base/geometry.h"
#include "planner/wall/field_geometry.h"

#include <array>
#include <vector>

namespace retractor::planner {

/// A place on the line.
struct ApertureSection {
    Vec3 skin = Vec3::Zero();
    Vec3 inner = Vec3::Zero(); ///< the inner side of the wall behind it
};

/// Thickness of the wall, weighted by the width of the hole along the line. @pre sections are not empty
double thickness_at_aperture(const std::vector<ApertureSection>& sections);

/// Between what holds the lips, in the middle of the line.
struct ApertureWidth {
    double skin_mm = 0.0;
    double inner_mm = 0.0; ///< on the inner side of the wall; 0 or less: the hole is closed there
};

class Aperture {
public:
    /// @throws InputError on fewer than two sections, sections that coincide, a wall without thickness, a width on the
    /// skin that is not above 0, or one on the inner side that is not finite
    Aperture(const std::vector<ApertureSection>& sections, const ApertureWidth& width);

    /// Whether the straight line through a point passes both lenses. @param direction unit
    bool passes(const Vec3& from, const Vec3& direction) const;

    /// Distance from a point to the skin's plane in the middle of the hole, along a unit direction; 0 for a line in the
    /// plane.
    double distance_to_skin(const Vec3& from, const Vec3& direction) const;

    /// The hole in the skin, as an opened wound is measured.
    const OpeningGeometry& opening() const { return opening_; }

private:
    /// A straight piece of the line on one side of the wall.
    struct Piece {
        Vec3 start = Vec3::Zero(), along = Vec3::UnitX(), across = Vec3::UnitY(), normal = Vec3::UnitZ();
        double length_mm = 0.0;
        double from_mm = 0.0; ///< along the line
    };
    struct Lens {
        std::vector<Piece> pieces;
        double length_mm = 0.0;
        double width_mm = 0.0;

        bool passes(const Vec3& from, const Vec3& direction) const;
    };

    static Lens lens_of(const std::vector<ApertureSection>& sections, bool skin, double width_mm);

    std::array<Lens, 2> lenses_; ///< on the skin and on the inner side
    OpeningGeometry opening_;
};

} // namespace retractor::planner
