#pragma once
// Finds the space that the wall encloses: the thoracic cavity above the diaphragm and the upper abdomen below. The
// inner surface of the wall is a radius over angle and height, about an axis in front of the spine. Lung and bone show
// this surface, and a smooth membrane closes the gaps. Units mm; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

/// The image and the structures found before. All masks are on the working grid.
struct CavityInput {
    const WorkingImage& image;
    const Mask& body;
    const Lungs& lungs;
    const Mask& cage; ///< ribs, cartilages, sternum, spine
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones; ///< all bones
};

/// The enclosed spaces.
struct Cavity {
    Mask thorax; ///< lungs, airways and the structures between them
    Mask abdomen; ///< inside the wall, below the diaphragm
    /// The innermost layer of the wall, as thick as a rib with its cover (10 mm), and the whole space inside this
    /// layer.
    Mask shell;
    std::vector<std::string> warnings;
};

/// Finds the cavity with this number of threads.
Cavity segment_cavity(const CavityInput& input, int threads);

} // namespace retractor::datasets::segmentation
