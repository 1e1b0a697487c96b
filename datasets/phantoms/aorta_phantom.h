#pragma once
// A vessel with a stiff region, for palpation: an aortic arch or a straight tube. The mesh is swept along the
// centreline in equal steps, without a mesher, and is the same on every machine. The ends are fixed, and blood presses
// from inside. The tissue values are those of Nakao M and others, "Transferring bioelasticity knowledge through haptic
// interaction", IEEE MultiMedia 13(3), 2006. Units mm, MPa; frame patient LPS.

#include "datasets/phantoms/elastic_model.h"

namespace retractor::datasets {

/// The sclerotic part of the wall: a length of the centreline, over the whole circumference or an angle about the site.
struct StiffRegion {
    double length_mm = 30.0; ///< along the centreline; 0: no sclerotic part
    double angle_deg = 360.0; ///< angle of the circumference; 360: a ring
};

/// Shape, tissue and mesh of the vessel.
struct AortaParameters {
    enum class Shape {
        /// Ascending part of 45 mm, arch of radius 35 mm over half a turn, descending part of 65 mm. The places where
        /// branches leave the arch are fixed.
        arch,
        /// Straight along z, `length_mm` long, with the stiff region in the middle.
        tube,
    };
    Shape shape = Shape::arch;
    double length_mm = 100.0; ///< length of the tube; not used for the arch
    double inner_radius_mm = 12.5, outer_radius_mm = 14.5; ///< radii of the wall's two surfaces
    StiffRegion region {};
    /// Young's moduli of the normal and the sclerotic wall (MPa), and Poisson's ratio, after Nakao and others (2006).
    double normal_MPa = 1.0, sclerotic_MPa = 3.0, poissons_ratio = 0.48;
    /// Elements round the vessel, through the wall and along the centreline. The mesh has 1,640 vertices; the mesh of
    /// Nakao and others (2006) had 1,651.
    int around = 20, through = 1, along = 40;
    int nodes_per_tet = 4; ///< 4 or 10; with 10, the midpoints lie on the curved wall
};

/// Makes the scene. Labels: 1 normal, 2 sclerotic.
///
/// Sites of the arch: "normal" and "sclerotic" at 45 and 135 degrees of the arch, on its side; "normal-opposite" and
/// "sclerotic-opposite" on the opposite side of the vessel. The sites avoid the outer curvature, because there the
/// movement of the whole arch with every beat almost cancels the pulse of the wall. Sites of the tube: "centre",
/// "centre-opposite".
/// @throws InputError naming the parameter that is out of its range.
PalpationScene make_aorta_phantom(const AortaParameters& parameters);

} // namespace retractor::datasets
