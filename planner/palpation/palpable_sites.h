#pragma once
// Finds places to press on palpated tissue.

#include "datasets/phantoms/elastic_model.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/palpation/palpable_request.h"

namespace retractor::planner {

/// Adds "front", "left", "right", the stiff places and the requested sites, with their opposites: see make_palpable().
/// @param surface visible surface, with the roles of the scene
void add_sites(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request);

} // namespace retractor::planner
