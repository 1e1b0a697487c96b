#pragma once
// Tissue materials with published default values, all of which the user can change. Units MPa, tonne/mm^3.

#include "fem/material/elasticity.h"
#include "fem/material/tissue_law.h"
#include "fem/material/tissue_tension.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::fem {

struct Material {
    std::string name;
    double youngs_modulus_MPa = 0.0; ///< > 0
    double poissons_ratio = 0.0; ///< -1 < nu < 0.5
    double density_tonne_per_mm3 = 0.0; ///< > 0
    std::string source; ///< publication of the values, and the strain range in which the values hold
    std::optional<TissueLaw> law {}; ///< hyperelastic law; without one, a neo-Hookean law with the two moduli above
    /// Stretch of the tissue before the cut. Solvers ignore this member; pre_strain.h computes the load that a cut
    /// releases.
    PreStrain pre_strain {};
};

using MaterialTable = std::vector<Material>;

/// Published values of skin, fat, muscle, intercostal, bone, cartilage, vessel, heart, lung and liver.
const MaterialTable& default_materials();

/// @throws InputError when the table has no material of this name.
const Material& find_material(const MaterialTable& table, std::string_view name);

/// @throws InputError naming the material and the value when a value of the material or of its law is NaN or out of
/// range.
void check_material(const Material& material);

/// Lame's parameters from the material's Young's modulus and Poisson's ratio.
Lame lame(const Material& material);

/// The material's hyperelastic law with its bulk modulus set by with_bulk(). A material without a law gets a
/// neo-Hookean one from Young's modulus and Poisson's ratio.
/// @throws InputError as check_material does.
Hyperelastic hyperelastic_law(const Material& material);
/// The name of the material's law with the course of its fibres, for example "Holzapfel-Gasser-Ogden with fibres at
/// 40 degrees to the circumference round an axis".
std::string law_in_words(const Material& material);

} // namespace retractor::fem
