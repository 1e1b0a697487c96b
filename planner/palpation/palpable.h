#pragma once
// Makes tissue for palpation from a patient's labels. An organ becomes tetrahedra with elasticity, supports and places
// to press. A hollow organ becomes a wall; in a vessel or the heart, blood presses on this wall from inside. All other
// organs are solid. The surroundings of the organ only count where they hold the organ. Units mm, MPa, mmHg; frame
// patient LPS.

#include "datasets/phantoms/elastic_model.h"
#include "fem/material/material.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/anatomy/bone_stiffness.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable_request.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

struct Palpable {
    datasets::PalpationScene scene;
    std::vector<std::string> notes; ///< decisions and findings, one line each
};

/// The scene has these sites: "front", "left", "right" (the free place farthest to that side), "stiff-1", ..., and the
/// requested ones. NAME-opposite is the place of a second finger that pinches the tissue.
/// @param bones moduli of single ribs and cartilages, in place of those of their material
/// @throws InputError naming a label that is missing or has no voxel, with the existing ones; on values out of range;
/// when nothing holds the structure; SolverError when the structure cannot be meshed or the job is cancelled
Palpable make_palpable(const mesh::LabelVolume& labels, const fem::MaterialTable& materials,
    const PalpableRequest& request, const Job& job = {}, std::span<const BoneStiffness> bones = {});
/// The same of a patient, whose ribs and cartilages have moduli of their own.
/// @throws as above; InputError, IoError as Patient::labels()
Palpable make_palpable(Patient& patient, const PalpableRequest& request, const Job& job = {});

} // namespace retractor::planner
