#pragma once
// The aorta: a chain of discs, one per plane, that look most like a vessel (soft or full of contrast inside, something
// else round it) and follow each other smoothly [dynamic programming over the planes], for the descending aorta beside
// the spine and the ascending one behind the sternum; the arch is the bow between them that fits best.
// Units mm and HU; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

struct AortaInput {
    const WorkingImage& image;
    const Mask& room; ///< where it may be: mediastinum and upper abdomen
    const Lungs& lungs;
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones;
};

struct Aorta {
    Mask mask; ///< empty of voxels when it was not found
    bool contrast = false; ///< seen by its contrast; otherwise a rough region
    double usual_hu = 0.0; ///< median along its middle, cut at 350
    double radius_mm = 0.0; ///< mean of the discs'
};

Aorta find_aorta(const AortaInput& input, int threads);

} // namespace retractor::datasets::segmentation
