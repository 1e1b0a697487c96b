#pragma once
// Landmarks from the labels: the patient's own axes, sternum, ribs. Nothing here knows the axes of the scanner or of
// the grid: a patient who is shifted or turned has the same landmarks, shifted and turned. Units mm; frame patient LPS.

#include "mesh/image/volume.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// The patient's axes: unit, orthogonal, left = superior x anterior.
struct AnatomicalFrame {
    Vec3 origin; ///< the axis of the chest: half way between the centroids of spine and sternum
    Vec3 superior; ///< long axis of the spine, towards the first rib
    Vec3 anterior; ///< from spine to sternum, square to superior
    Vec3 left;
};

struct SternumAxis {
    Vec3 top; ///< notch
    Vec3 bottom; ///< tip of the xiphoid
    Vec3 axis; ///< unit, from bottom to top
    std::vector<Vec3> midline; ///< from top to bottom, smooth
};

/// The centre-line of a rib and, where "costal_cartilages" are labelled, of its cartilage. `angle_deg` runs round the
/// axis of the chest: 0 straight back, 90 lateral, 180 straight ahead.
struct RibLine {
    Label label = 0;
    std::string name;
    bool left = true;
    int number = 0; ///< 1 to 12
    std::vector<Vec3> points; ///< from the spine end to the front end
    std::vector<double> angle_deg; ///< per point, increasing
    std::size_t bone_points = 0; ///< so many of them lie in bone, the others in cartilage
};

struct Anatomy {
    AnatomicalFrame frame;
    SternumAxis sternum;
    std::vector<RibLine> ribs;
};

/// Names as TotalSegmentator spells them: sternum, rib_left_1 ..., rib_right_12, vertebrae_* (or spine).
/// @throws InputError naming the label that is missing and what to do, or the landmarks that contradict each other
/// (ribs on the wrong side: a mirrored volume).
Anatomy find_anatomy(const mesh::LabelVolume& labels);

/// The rib of this side and number. @throws InputError naming its label.
const RibLine& find_rib(const Anatomy& anatomy, bool left, int number);

/// The point of a rib's centre-line at an angle; ends are not passed. Linear between points.
Vec3 point_at_angle(const RibLine& rib, double angle_deg);

/// Centroid of a label. @throws InputError when it is not in the table or has no voxel.
Vec3 label_centroid(const mesh::LabelVolume& labels, std::string_view name);

} // namespace retractor::planner
