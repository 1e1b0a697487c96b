#pragma once
// What the wall encloses: the thoracic cavity above the diaphragm and the upper abdomen below it. The wall's inner
// surface is a radius over angle and height round an axis in front of the spine, seen where lung or bone shows it and
// smooth in between. Units mm; working grid.

#include "datasets/segmentation/lungs.h"

namespace retractor::datasets::segmentation {

struct CavityInput {
    const WorkingImage& image;
    const Mask& body;
    const Lungs& lungs;
    const Mask& cage; ///< ribs, cartilages, sternum, spine
    const Mask& spine;
    const Mask& sternum;
    const Mask& bones; ///< all of them
};

struct Cavity {
    Mask thorax; ///< lungs, airways and what lies between them
    Mask abdomen; ///< below the diaphragm, inside the wall
    Mask shell; ///< the wall's innermost layer, as thick as a rib and its cover; what it encloses is set too
    std::vector<std::string> warnings;
};

Cavity segment_cavity(const CavityInput& input, int threads);

} // namespace retractor::datasets::segmentation
