#pragma once
// What is asked for when labels of a patient become tissue that fingers touch, and the labels by their names. Units mm,
// MPa; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

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

/// "aorta, heart, spine": the labels there are, for refusals.
std::string names_of(const mesh::LabelTable& table);
/// @param field of the request that names the label.
/// @throws InputError of this field when the label is not there, with the labels that are.
const mesh::LabelInfo& label_of(const mesh::LabelVolume& labels, const std::string& name, const char* field);

} // namespace retractor::planner
