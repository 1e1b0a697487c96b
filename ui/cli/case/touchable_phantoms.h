#pragma once
// Makes synthetic bodies for palpation: an abdomen, a liver and a sheet of tissue, as tetrahedra with sites. Units mm.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/job.h"

namespace retractor::ui::cli {

/// The liver of the abdomen phantom, meshed with edges of `edge_mm`. The liver's back is fixed, within 12 mm of its
/// hindmost point. The sites "right-lobe" and "left-lobe" are on its front.
/// @throws InputError on an edge out of 4 to 40 mm
datasets::PalpationScene make_liver_scene(double edge_mm, const Job& job);

/// The whole abdomen phantom on its spine, with its organs grown together. The skin has six sites, three for each hand:
/// "liver-1" to "liver-3" and "stomach-1" to "stomach-3".
/// @throws InputError on an edge out of 8 to 40 mm
datasets::PalpationScene make_abdomen_scene(double edge_mm, const Job& job);

/// The solid that corresponds to the 25 x 25 sheet of springs: 24 x 24 x 8 mm, held at its sides, with the upper face
/// at z = 0. The site is "centre".
datasets::PalpationScene make_sheet_scene();

} // namespace retractor::ui::cli
