#pragma once
// From a patient's case to tissue that fingers touch: an organ of its labels becomes tetrahedra with elasticity, what
// holds it, and places to press. A hollow organ becomes a wall, which blood presses on from inside where it is a vessel
// or the heart; all others are solid. What lies around the organ is left out but for where it holds the organ. Units
// mm, MPa, mmHg; frame patient LPS.

#include "datasets/elastic_model.h"
#include "fem/material.h"
#include "mesh/base/job.h"
#include "mesh/volume.h"
#include "planner/approach.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor {

/// Tissue that is stiffer (or softer) than the rest: a label's, or a ball's.
struct StiffPlace {
    TargetSpec where;
    double youngs_modulus_MPa = 0.0;
};

struct PalpableRequest {
    /// Labels of the structure; several become one body, and keep their own elasticity where it is solid.
    std::vector<std::string> structure = {};
    std::optional<double> wall_mm = {}; ///< 0: solid. Not given: 2 for labels of a vessel's material, else solid
    std::optional<double> edge_mm = {}; ///< of elements; not given: 5 for a wall, a tenth of its size for a solid
    /// What holds it: labels, where they lie next to it; "border": where the image cuts it off; "foot:10" (head, front,
    /// back, left, right): its last 10 mm on that side; "ends:20": the last 20 mm of a vessel's two ends (of the
    /// largest piece, where there are several). Empty: border and, for a wall, heart, spine and ends:20, for a solid
    /// body, back:12.
    std::vector<std::string> held = {};
    std::optional<double> youngs_modulus_MPa = {}, poissons_ratio = {}; ///< not given: the material's
    std::vector<StiffPlace> stiff = {};
    std::vector<std::pair<std::string, Vec3>> sites = {}; ///< more places to press: nearest on the surface
};

struct Palpable {
    PalpationScene scene;
    std::vector<std::string> notes; ///< what was decided and found, one line each
};

/// "aorta, heart, spine": the labels there are, for refusals.
std::string names_of(const LabelTable& table);
/// @param field of the request that names the label.
/// @throws InputError of this field when the label is not there, with the labels that are.
const LabelInfo& label_of(const LabelVolume& labels, const std::string& name, const char* field);

/// Sites of the scene: "front", "left", "right" (where the structure is farthest on that side and free), "stiff-1", ...
/// and those asked for; with NAME-opposite where a second finger would be when it is pinched.
/// @throws InputError naming the label that is not there or has no voxel, with those that are; values out of range;
/// that nothing holds the structure; SolverError when it cannot be meshed or the job is cancelled.
Palpable make_palpable(
    const LabelVolume& labels, const MaterialTable& materials, const PalpableRequest& request, const Job& job = {});

} // namespace retractor
