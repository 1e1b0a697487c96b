#pragma once
// What holds tissue that is palpated: its neighbours, the image's border, a side of it, a vessel's ends.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/palpation/palpable_request.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// Roles of the surface's vertices (numbers of the scene's mesh), and what is to be said of them.
/// @throws InputError on a holder that cannot be read, is not there, or is the structure itself.
void hold_surface(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request, bool hollow, std::vector<std::string>& notes);

/// Pieces that nothing holds would float: small ones are left out. @throws InputError on a large one.
void refuse_floating(datasets::PalpationScene& scene, std::vector<std::string>& notes);

} // namespace retractor::planner
