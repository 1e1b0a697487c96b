#pragma once
// A vessel, or vessels and a nerve in one bundle, that no label shows. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Its place is assumed from the bones (planner/anatomy/assumed_vessels.h), or was set by hand.
struct AssumedVessel {
    std::string name; ///< spelt as a label: "mammary_artery_left"
    std::vector<Vec3> line; ///< along its middle, in order; two places at least
    double radius_mm = 1.0;
};

/// Behind the name of such a structure, wherever people read it.
inline constexpr std::string_view kAssumedPlace = " (assumed place)";

/// The largest radius of an assumed vessel, mm: an aorta is no wider.
inline constexpr double kLargestVesselRadiusMm = 25.0;

} // namespace retractor::planner
