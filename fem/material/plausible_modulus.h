#pragma once
// Young's moduli that tissue can have. A value beyond them is a slip of units (kPa for MPa) and no tissue. Units MPa.

#include <string_view>

namespace retractor::fem {

/// A closed range of Young's moduli.
struct ModulusRange {
    double least = 0.0, most = 0.0; ///< MPa
};

/// The range for a tissue of default_materials(): what is published for the tissue (the sources stand in
/// default_materials() and in docs/method/elasticity.md), widened up to fourfold on either side. A default
/// modulus in the wrong unit (a factor of 1,000) lies outside. Any other name: from the softest gel to enamel.
ModulusRange plausible_modulus(std::string_view tissue);

} // namespace retractor::fem
