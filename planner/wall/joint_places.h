#pragma once
// Finds where the ribs meet the spine in an image of labels, so that nothing depends on a mesh. Units mm; frame patient
// LPS.
//
// A rib has two joints with the spine: its head at the vertebral bodies, and its tubercle at the transverse process,
// some 25 mm along the rib. Ribs 11 and 12 have no joint at the tubercle. The rib's voxels near the spine are ordered
// by their way along the rib from its other end. Those farthest from there are the head. The tubercle is the last place
// along the rib, between kLeastNeckMm and kTubercleReachMm from the head, within kJointGapMm of the spine; or, where
// labels lose the tip of the process, within kTubercleGapMm. Labels that merge along the neck change neither end.
// Where the labels show no tubercle of one of ribs 1 to 10, the rib takes the axis of the nearest rib of its side that
// shows one: the axes of neighbours are nearly parallel.

#include "mesh/image/volume.h"

#include <optional>
#include <span>
#include <vector>

namespace retractor::planner {

/// Largest distance over a joint of rib and spine, between centres of voxels: the width of the joint, and the half
/// voxels between the bones' surfaces and the labels.
inline constexpr double kJointGapMm = 5.0;
/// Largest distance over the joint of the tubercle where no voxel is nearer. A rib that leaves the spine without a
/// tubercle is farther away than this at kLeastNeckMm.
inline constexpr double kTubercleGapMm = 10.0;
/// Farthest tubercle from the head, along the rib: 25 mm and as much again as necks differ and voxels blur.
inline constexpr double kTubercleReachMm = 40.0;
/// Nearest tubercle from the head, along the rib. Nearer voxels belong to the joint of the head.
inline constexpr double kLeastNeckMm = 12.0;
/// Least distance of the two places. Nearer places tell no axis.
inline constexpr double kShortestAxisMm = 5.0;
/// Length of a joint along the rib. Head and tubercle are about as long.
inline constexpr double kJointLengthMm = 7.0;

/// The joint of one rib.
struct JointPlaces {
    Label label = 0; ///< of the rib
    Vec3 head = Vec3::Zero(); ///< middle of the rib's voxels near the spine at its head, mm
    std::optional<Vec3> tubercle {}; ///< the same at its tubercle; not set: the labels show no second place
    bool axis_of_neighbour = false; ///< the tubercle stands beside the head as that of the nearest rib
};

/// The joints of all connected parts of bone in the wall that reach voxels with a label in `fixed_labels`, by rising
/// label.
std::vector<JointPlaces> joint_places(const mesh::LabelVolume& labels, std::span<const Label> fixed_labels);

/// Distance of a point from the nearest centre of a voxel with a wanted label, mm; infinite beyond `reach`.
double distance_to_labels(
    const mesh::LabelVolume& labels, const mesh::LabelFlags& wanted, const Vec3& point, double reach);

} // namespace retractor::planner
