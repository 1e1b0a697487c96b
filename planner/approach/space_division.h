#pragma once
// Finds the strokes that divide intercostal muscle and pleura beyond the ends of the skin incision: forwards to the
// margin of the mammary artery, and backwards to the paraspinal muscle (AccessSurgery 42074673 and
// 72426220). The distances from sternum, artery and spine are chosen here. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"
#include "planner/case/assumed_vessel.h"

#include <span>

namespace retractor::planner {

/// Distance of the division from the sternum. The mammary artery runs beside the sternum, up to about this distance.
inline constexpr double kFromSternumMm = 15.0;
/// Distance of the division from a mammary artery, labelled or assumed.
inline constexpr double kFromMammaryMm = 5.0;
/// Distance of the division from the spine's midline, where the paraspinal muscle covers the ribs' joints.
inline constexpr double kFromSpineMm = 40.0;

/// Fills Division::strokes and Division::words of an approach with full division; clears them otherwise. Where the
/// space cannot be found, there are no strokes, and the words tell the reason.
/// @param assumed vessels that no label shows; of them, the mammary arteries end the division
void find_space_division(Approach& approach, const mesh::LabelVolume& labels, const Anatomy& anatomy,
    std::span<const AssumedVessel> assumed = {});

} // namespace retractor::planner
