#pragma once
// A vessel with a stiff region, to be palpated: an aortic arch or a straight tube, swept along its centreline in equal
// steps (no mesher: the same on every machine). Ends fixed, blood inside. Units mm, MPa; frame patient LPS.

#include "datasets/phantoms/elastic_model.h"

#include <string>

namespace retractor::datasets {

/// Where the wall is sclerotic: a length of the centreline, all round or within an angle about the site.
struct StiffRegion {
    double length_mm = 30.0; ///< 0: nowhere
    double angle_deg = 360.0; ///< of the circumference; 360: a ring
};

struct AortaParameters {
    enum class Shape {
        arch, ///< ascending 45, arch of radius 35 over half a turn, descending 65 mm; held where its branches leave
        tube, ///< straight along z, `length_mm` long; the region lies in the middle
    };
    Shape shape = Shape::arch;
    double length_mm = 100.0; ///< tube only
    double inner_radius_mm = 12.5, outer_radius_mm = 14.5;
    StiffRegion region {};
    double normal_MPa = 1.0, sclerotic_MPa = 3.0, poissons_ratio = 0.48; ///< the source's
    int around = 20, through = 1, along = 40; ///< elements: 1,640 vertices, the source had 1,651
    int nodes_per_tet = 4; ///< 4 or 10; midpoints then lie on the curved wall
};

/// Labels: 1 normal, 2 sclerotic. Sites: arch: "normal" and "sclerotic" at 45 and 135 degrees of the arch, on its side,
/// "normal-opposite" and "sclerotic-opposite" across the vessel from them (on its outer curvature the pulse of the wall
/// is all but undone by the whole arch, which moves with every beat); tube: "centre", "centre-opposite".
/// @throws InputError naming the parameter that is out of its range.
PalpationScene make_aorta_phantom(const AortaParameters& parameters);

} // namespace retractor::datasets
