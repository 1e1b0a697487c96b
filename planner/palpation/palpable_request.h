#pragma once
// A request for palpable tissue from a patient's labels, and the labels by their names. Units mm, MPa; frame patient
// LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// Tissue that is stiffer or softer than the rest: a label or a ball.
struct StiffPlace {
    TargetSpec where;
    double youngs_modulus_MPa = 0.0;
};

struct PalpableRequest {
    /// Labels of the structure. Several labels become one body; in a solid body they keep their own elasticity.
    std::vector<std::string> structure = {};
    /// Thickness of the wall; 0: solid; not set: 2 for labels of a vessel's material, otherwise solid.
    std::optional<double> wall_mm = {};
    /// Edge length of elements; not set: 5 for a wall, a tenth of the structure's size for a solid body.
    std::optional<double> edge_mm = {};
    /// The supports of the structure:
    /// - a label: where the label lies next to the structure;
    /// - "border": where the image cuts the structure off;
    /// - "foot:10" (also head, front, back, left, right): its last 10 mm on that side;
    /// - "ends:20": the last 20 mm of a vessel's two ends (of the largest piece, where there are several).
    /// Empty means border, heart, spine and ends:20 for a wall; border and back:12 for a solid body.
    std::vector<std::string> held = {};
    std::optional<double> youngs_modulus_MPa = {}, poissons_ratio = {}; ///< not set: those of the material
    std::vector<StiffPlace> stiff = {};
    /// More places to press, moved to the nearest point of the surface.
    std::vector<std::pair<std::string, Vec3>> sites = {};
};

/// Names of all labels, for messages: "aorta, heart, spine".
std::string names_of(const mesh::LabelTable& table);
/// @param field field of the request that names the label
/// @throws InputError of this field when the label does not exist, with the existing labels
const mesh::LabelInfo& label_of(const mesh::LabelVolume& labels, const std::string& name, const char* field);

} // namespace retractor::planner
