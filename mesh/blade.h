#pragma once
// A blade: a polyline swept into the body. The swept surface is triangulated once, so that "which
// side is this point on" has one answer. Units mm; frame patient LPS.

#include "mesh/geometry.h"

#include <vector>

namespace retractor {

/// A cutting line on the skin and how the blade goes in from it.
struct Blade {
    std::vector<Vec3> line; ///< at least two points, mm, in cutting order
    std::vector<Vec3> directions; ///< into the body; one for all points, or one per point; need not be unit
    double depth_mm = 0.0; ///< how far below the line the blade reaches, along its direction
    double above_mm = 10.0; ///< how far above the line it starts: skin bulges between the points of a line
};

/// A point in the blade's own coordinates.
struct BladeCoordinates {
    double along = 0.0; ///< mm along the line; negative before its start, beyond its length after its end
    double depth = 0.0; ///< mm below the line, along the direction; negative above
    double side = 0.0; ///< signed distance (mm) from the extended blade; positive on the left of the
                       ///< cutting direction seen against the blade direction (looking down on the skin)
};

/// The blade's surface, extended straight past its two ends, its top and its front, so that it divides
/// the tissue near it into two sides; the true blade is where 0 <= along <= length() and depth <= depth_mm.
class SweptBlade {
public:
    /// @throws InputError on fewer than two points, zero length, zero depth, NaN, a direction along the line.
    explicit SweptBlade(const Blade& blade);

    BladeCoordinates coordinates(const Vec3& point) const;
    /// The nearest point on the extended surface.
    Vec3 project(const Vec3& point) const;
    double length() const;
    double depth() const;
    /// The triangulated (not extended) blade, for pictures and tests.
    const TriMesh& surface() const;

private:
    Blade blade_;
    TriMesh surface_;
    TriMesh extended_;
    std::vector<double> along_;
};

} // namespace retractor
