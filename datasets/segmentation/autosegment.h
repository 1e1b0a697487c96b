#pragma once
// Segmentation of a chest CT that comes without labels: classical steps (thresholds, distances, connected pieces,
// anatomy) on a grid of even spacing, good enough to plan on and never taken for more than it is: what is rough says
// so in the notes. Units mm and Hounsfield units; frame patient LPS.
//
// Order of the steps: body, lungs and airways, bones (segmentation/bones.h), thoracic cavity, vessels and heart, layers
// of the wall. Each step can be overruled by given labels of the same names (AutosegmentOptions::given).

#include "datasets/segmentation/image/found_structure.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets {

struct AutosegmentOptions {
    /// Spacing of the labels' grid, even in all directions: thin enough for a rib (8 mm) and for skin, coarse enough
    /// that a full-resolution CT costs no more than a reduced one. 0.5 to 4 mm.
    double spacing_mm = 1.5;
    /// Labels that are right already: each voxel of theirs (by world position) keeps its label, and a structure that
    /// they hold is not searched for. Their table's names decide what they stand for.
    std::optional<mesh::LabelVolume> given = std::nullopt;
};

struct Segmentation {
    mesh::LabelVolume
        labels; ///< on its own grid; names and roles as make_thorax_phantom() gives them, where they apply
    std::vector<FoundStructure> structures; ///< in the order of the steps
    std::vector<std::string>
        warnings; ///< what the user must look at ("rib 1 left not found", "no contrast: the aorta is rough")
};

/// Labels given: skin, fat, muscle, rib_left_1 .. rib_right_12 (those found), costal_cartilages, sternum, spine,
/// scapula_left/right, clavicle_left/right, bone_other (humeri and unclassified bone), all wall; arm tissue is wall
/// muscle/fat/skin like any other. lung_left/right, trachea, mediastinum (what fills the cavity between the lungs and
/// is nothing else), upper_abdomen (below the diaphragm) (voxel); heart, aorta (at risk). Everything of the body has a
/// label. Records the parts "segmentation" and "labels".
/// @throws InputError when the image shows no body or no lungs (what was looked for is in the message).
Segmentation autosegment(const mesh::Volume& ct, const AutosegmentOptions& options = {}, const Job& job = {});

} // namespace retractor::datasets
