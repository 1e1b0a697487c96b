#pragma once
// Finds the supports of palpated tissue: neighbours, the image's border, a side of the tissue, the ends of a vessel.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/palpation/palpable_request.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// Gives the surface's vertices (numbers of the scene's mesh) their roles, and adds notes about the supports.
/// @throws InputError on a holder that cannot be read, does not exist or is the structure itself
void hold_surface(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request, bool hollow, std::vector<std::string>& notes);

/// Removes small pieces that nothing holds. @throws InputError on a large piece that nothing holds
void refuse_floating(datasets::PalpationScene& scene, std::vector<std::string>& notes);

} // namespace retractor::planner
