#pragma once
// Places to press on tissue that is palpated.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/palpation/palpable_request.h"

namespace retractor::planner {

/// "front", "left", "right", stiff places and those asked for, with their opposites: see make_palpable().
/// @param surface what fingers see, with the scene's roles given
void add_sites(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request);

} // namespace retractor::planner
