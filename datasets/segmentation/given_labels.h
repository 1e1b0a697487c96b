#pragma once
// Converts labels that the user gives to the names that the segmentation uses.

#include "mesh/image/volume.h"

namespace retractor::datasets::segmentation {

/// Joins the parts of one structure: lobes of a lung ("lung_upper_lobe_left") become the lung ("lung_left"), vertebrae
/// ("vertebrae_T5") become the spine. Other labels stay the same.
mesh::LabelVolume with_parts_joined(mesh::LabelVolume labels);

} // namespace retractor::datasets::segmentation
