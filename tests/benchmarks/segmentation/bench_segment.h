#pragma once
// Labels found in phantoms of a chest, compared with the true ones: three shapes, noises and resolutions.

#include "ui/cli/framework/command.h"

#include <string>

namespace retractor::benchmarks {

struct SegmentBenchOptions {
    bool quick = false; ///< one phantom on a coarse grid
    std::string out; ///< folder for bench_segment.json; empty: none
};

/// Segments thorax phantoms without labels and measures the overlap of each rib, sternum, cartilages, spine, lungs,
/// heart and aorta with the true label: Dice's coefficient, 2 |A and B| / (|A| + |B|), on the phantom's grid [Dice
/// 1945, Ecology 26:297]. The segmentation makes no label of the diaphragm.
ui::cli::Outcome bench_segment(const SegmentBenchOptions& options, const Job& job);

} // namespace retractor::benchmarks
