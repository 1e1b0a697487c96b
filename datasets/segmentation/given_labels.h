#pragma once
// Labels that the user gives to a segmentation, in the words it uses.

#include "mesh/image/volume.h"

namespace retractor::datasets::segmentation {

/// Parts of one structure become that structure: lobes of a lung ("lung_upper_lobe_left") the lung ("lung_left"),
/// vertebrae ("vertebrae_T5") the spine. Everything else is left as it is.
mesh::LabelVolume with_parts_joined(mesh::LabelVolume labels);

} // namespace retractor::datasets::segmentation
