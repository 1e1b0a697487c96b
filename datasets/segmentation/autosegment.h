#pragma once
// Segmentation of a chest CT without labels, by classical steps (thresholds, distances, connected pieces, anatomy) on
// an isotropic grid. The labels are good enough for planning, and the notes mark rough structures. Units mm and
// Hounsfield units; frame patient LPS.
//
// Order of the steps: body, lungs and airways, bones (bones.h), thoracic cavity, vessels and heart, layers of the wall.
// Given labels of the same names overrule every step (AutosegmentOptions::given).

#include "datasets/segmentation/image/found_structure.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets {

/// Resolution, and labels that are known already.
struct AutosegmentOptions {
    /// Spacing of the labels' grid in all directions, 0.5 to 4 mm. The default resolves a rib (8 mm) and the skin, and
    /// a CT of full resolution then costs no more than a reduced CT.
    double spacing_mm = 1.5;
    /// Labels that are correct already. Their voxels (by world position) keep their labels, and the steps do not search
    /// for a structure with given voxels. The names in their table identify the structures.
    std::optional<mesh::LabelVolume> given = std::nullopt;
};

/// The labels, and how each structure was found.
struct Segmentation {
    /// On their own grid; names and roles are those of make_thorax_phantom(), where these apply.
    mesh::LabelVolume labels;
    std::vector<FoundStructure> structures; ///< in the order of the steps
    /// Results that the user must check ("rib 1 left not found", "no contrast: the aorta is rough").
    std::vector<std::string> warnings;
};

/// Labels every voxel of the body. Role wall: skin, fat, muscle, rib_left_1 .. rib_right_12 (the ribs found),
/// costal_cartilages, sternum, spine, scapula_left/right, clavicle_left/right, bone_other (humeri and unclassified
/// bone). Tissue of the arms is muscle, fat and skin like other tissue. Role voxel: lung_left/right, trachea,
/// mediastinum (the remaining contents of the cavity between the lungs), upper_abdomen (below the diaphragm). Role at
/// risk: heart, aorta. Records the parts "segmentation" and "labels".
/// @throws InputError when the image shows no body or no lungs (the message gives the criterion), for a spacing out of
/// range, and for more than 120 million voxels.
Segmentation autosegment(const mesh::Volume& ct, const AutosegmentOptions& options = {}, const Job& job = {});

} // namespace retractor::datasets
