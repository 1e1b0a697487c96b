#pragma once
// The interval of force and opening from the ranges of the tissue values. It says how far a plan may be off because
// nobody has measured this patient's tissue; the error bars (error_bars.h) say how far because the mesh is coarse. The
// two stand side by side and are never added.
//
// Each tissue of the wall, and each kind of springs, has one modulus with a published range. Half the logarithm of the
// range is taken as the standard deviation of the modulus, about the value that the plan was made with. Force and
// opening change with each modulus to first order in logarithms (fem/statics/parameter_sensitivity.h): F grows as the
// modulus to the power of its exponent. The moduli are taken as independent, so that the variances add up. Poisson's
// ratios, the shape of a law, tension and supports do not vary. Units mm, N, MPa.

#include "planner/anatomy/bone_stiffness.h"
#include "planner/plan/opened_wound.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// The range of a stiffness.
struct PublishedRange {
    std::string_view name; ///< of the material in the case, or of the springs
    double low = 0.0, high = 0.0;
    std::string_view source;
};

/// The range of a tissue ("skin", "fat", ..., "rib"), or of springs ("costovertebral joint", "bed of the shoulder
/// girdle"). Any other name has a factor of 2 to either side of 1.
PublishedRange published_range(std::string_view name);

/// Sorts the parameters and computes the interval about a force and an opening.
/// @param parameters with value, low, high and exponents
/// @throws InputError naming the parameter whose range or exponent is not finite, or whose range is not in order
ParameterInterval combine_parameters(double force_N, double opening_mm, std::vector<ParameterInfluence> parameters);

/// Computes the interval, or the reason why there is none (ParameterInterval::message). A failure does not change the
/// plan and throws no Error. Takes about the time of one factorisation.
/// @param field the opened and measured field; @param wound the result of open_wound() for this field
/// @param bones moduli of single ribs and cartilages with their own ranges
/// @return nothing where no hook opens the wound
std::optional<ParameterInterval> estimate_parameter_interval(const PlannedField& field, const OpenedWound& wound,
    const SolverSettings& choice, const mesh::LabelTable& table, std::span<const BoneStiffness> bones);

} // namespace retractor::planner
