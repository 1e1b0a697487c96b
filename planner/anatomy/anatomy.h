#pragma once
// Finds landmarks in the labels: the patient's own axes, the sternum and the ribs. The landmarks do not depend on the
// axes of the scanner or of the grid: they move and turn with the patient. Units mm; frame patient LPS.

#include "mesh/image/volume.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// The patient's axes: unit vectors at right angles to each other, left = superior x anterior.
struct AnatomicalFrame {
    Vec3 origin; ///< middle of the chest: half way between the centroids of spine and sternum
    Vec3 superior; ///< long axis of the spine, towards the first rib
    Vec3 anterior; ///< from spine to sternum, at right angles to superior
    Vec3 left;
};

struct SternumAxis {
    Vec3 top; ///< the notch
    Vec3 bottom; ///< tip of the xiphoid
    Vec3 axis; ///< unit, from bottom to top
    std::vector<Vec3> midline; ///< from top to bottom, smoothed
};

/// The centre-line of a rib. The line goes on through the rib's cartilage where "costal_cartilages" are labelled.
/// The angle runs round the long axis of the chest: 0 is straight back, 90 lateral, 180 straight ahead.
struct RibLine {
    Label label = 0;
    std::string name;
    bool left = true;
    int number = 0; ///< 1 to 12
    std::vector<Vec3> points; ///< from the spine end to the front end
    std::vector<double> angle_deg; ///< angle of each point, increasing
};

struct Anatomy {
    AnatomicalFrame frame;
    SternumAxis sternum;
    std::vector<RibLine> ribs;
};

/// Finds the landmarks by the label names of TotalSegmentator: sternum, rib_left_1 ..., rib_right_12, vertebrae_* (or
/// spine).
/// @throws InputError naming a missing label and the remedy, or landmarks that contradict each other (ribs on the wrong
/// side mean a mirrored volume)
Anatomy find_anatomy(const mesh::LabelVolume& labels);

/// Angle of a place round the long axis of the chest, as RibLine::angle_deg of a rib of that side.
/// @returns -90 to 270: 180 is straight ahead, more lies on the other side
double angle_round_chest(const AnatomicalFrame& frame, bool left, const Vec3& place);

/// The rib of this side and number. @throws InputError naming the rib's label when there is none
const RibLine& find_rib(const Anatomy& anatomy, bool left, int number);

/// The point of a rib's centre-line at an angle, linear between points. An angle beyond an end gives the end.
Vec3 point_at_angle(const RibLine& rib, double angle_deg);

/// Centroid of a label. @throws InputError when the label is not in the table or has no voxel
Vec3 label_centroid(const mesh::LabelVolume& labels, std::string_view name);

} // namespace retractor::planner
