#pragma once
// Finds the aorta. The descending aorta beside the spine, and the ascending aorta behind the sternum, are each a chain
// of discs, one disc per plane. Dynamic programming over the planes finds the chain whose discs look most like a vessel
// (soft tissue or contrast inside, other tissue around) and follow each other smoothly. The arch is the bow between the
// two chains that looks most like a vessel. Units mm and HU; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

/// The image and the structures that guide the search. All masks are on the working grid.
struct AortaInput {
    const WorkingImage& image;
    const Mask& room; ///< voxels that may be aorta: mediastinum and upper abdomen
    const Lungs& lungs;
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones;
};

/// The aorta, and how the search found it.
struct Aorta {
    Mask mask; ///< all zero when no aorta was found
    bool contrast = false; ///< true: contrast shows the aorta; false: the mask is a rough region
    double usual_hu = 0.0; ///< median HU along the centreline, from values clamped to 350
    double radius_mm = 0.0; ///< mean radius of the discs
};

/// Finds the aorta with this number of threads.
Aorta find_aorta(const AortaInput& input, int threads);

} // namespace retractor::datasets::segmentation
