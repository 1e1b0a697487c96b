#pragma once
// Synthetic bodies to be touched: an abdomen, a liver and a sheet of tissue, as tetrahedra with their sites.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/job.h"

namespace retractor::ui::cli {

/// The abdomen phantom's liver, meshed with edges of `edge_mm`; its back (within 12 mm of the hindmost point) is fixed.
/// Sites "right-lobe" and "left-lobe" on its front. @throws InputError on an edge out of 4 to 40 mm.
datasets::PalpationScene make_liver_scene(double edge_mm, const Job& job);

/// The whole abdomen phantom, its organs grown together, on its spine. Six sites on the skin, three for each hand:
/// "liver-1" to "liver-3" and "stomach-1" to "stomach-3". @throws InputError on an edge out of 8 to 40 mm.
datasets::PalpationScene make_abdomen_scene(double edge_mm, const Job& job);

/// 24 x 24 x 8 mm, held at its sides: the solid that the 25 x 25 sheet of springs stands for; its upper face is z = 0.
/// Site "centre".
datasets::PalpationScene make_sheet_scene();

} // namespace retractor::ui::cli
