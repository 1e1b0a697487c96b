#pragma once
// Stiffness other than that of the case: factors on the moduli of tissues and on springs. A plan with factors says what
// would be if this patient's tissue were softer or stiffer; it is never saved as the plan of the case.

#include "fem/statics/elastic_problem.h"
#include "planner/case/case.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// The springs and hinges between ribs and spine, and the springs under the shoulder girdle.
inline constexpr std::string_view kJointSprings = "costovertebral joint", kGirdleSprings = "bed of the shoulder girdle";

inline constexpr double kLeastStiffnessFactor = 0.01, kMostStiffnessFactor = 100.0;

/// Factor by material ("skin", "rib"), or by kind of springs. What is not named keeps its stiffness.
using StiffnessFactors = std::map<std::string, double, std::less<>>;

/// The names that have a stiffness: the materials of the wall in the order of the label table, then the springs.
std::vector<std::string> stiffness_names(const Case& planned_case);

/// @throws InputError naming the entry ("fat=0") on an unknown name, a factor that is out of range or not finite, and
/// where the case is solved by the laws of its materials (hyperelastic), which have more than one modulus
void check_stiffness_factors(const Case& planned_case, const StiffnessFactors& factors);

/// Multiplies the moduli of the materials, found by their names.
void scale_materials(const StiffnessFactors& factors, std::vector<fem::Material>& materials);

/// Multiplies the springs and hinges of the supports.
void scale_springs(const StiffnessFactors& factors, const mesh::LabelTable& table, fem::ElasticProblem& problem);

/// "fat=0.8,skin=1.5"; empty without factors.
std::string stiffness_text(const StiffnessFactors& factors);

/// One flag per vertex: it belongs to a rib.
std::vector<std::uint8_t> vertices_on_ribs(const mesh::TetMesh& mesh, const mesh::LabelTable& table);

} // namespace retractor::planner
