#pragma once
// From a patient's case to tissue that fingers touch: an organ of its labels becomes tetrahedra with elasticity, what
// holds it, and places to press. A hollow organ becomes a wall, which blood presses on from inside where it is a vessel
// or the heart; all others are solid. What lies around the organ is left out but for where it holds the organ. Units
// mm, MPa, mmHg; frame patient LPS.

#include "datasets/phantoms/elastic_model.h"
#include "fem/material/material.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/palpation/palpable_request.h"

#include <string>
#include <vector>

namespace retractor::planner {

struct Palpable {
    datasets::PalpationScene scene;
    std::vector<std::string> notes; ///< what was decided and found, one line each
};

/// Sites of the scene: "front", "left", "right" (where the structure is farthest on that side and free), "stiff-1", ...
/// and those asked for; with NAME-opposite where a second finger would be when it is pinched.
/// @throws InputError naming the label that is not there or has no voxel, with those that are; values out of range;
/// that nothing holds the structure; SolverError when it cannot be meshed or the job is cancelled.
Palpable make_palpable(const mesh::LabelVolume& labels, const fem::MaterialTable& materials,
    const PalpableRequest& request, const Job& job = {});

} // namespace retractor::planner
