#pragma once
// Tissue materials. Units MPa, tonne/mm^3. Values with their sources; the user can change all of them.

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
    std::string source; ///< where the values come from, and the strain regime they hold in
    std::optional<TissueLaw> law {}; ///< as hyperelastic tissue; none: neo-Hookean by the values above
    /// What it is stretched by before the cut. Solvers do not ask for it: see pre_strain.h for what a cut sets free.
    PreStrain pre_strain {};
};

using MaterialTable = std::vector<Material>;

/// skin, fat, muscle, intercostal, bone, cartilage, vessel, heart, lung, liver with published values.
const MaterialTable& default_materials();

/// @throws InputError when the table has no material of this name.
const Material& find_material(const MaterialTable& table, std::string_view name);

/// @throws InputError naming the material and the value, of its law too, when one is NaN or out of its range.
void check_material(const Material& material);

/// The parameters of linear elasticity that the material's Young's modulus and Poisson's ratio give.
/// @throws InputError as check_material does.
Lame lame(const Material& material);

/// The law a material has as hyperelastic tissue: its own, by with_bulk(); without one neo-Hookean by Young's modulus
/// and Poisson's ratio.
/// @throws InputError as check_material does.
Hyperelastic hyperelastic_law(const Material& material);
/// Its name, and how its fibres wind: "Holzapfel-Gasser-Ogden with fibres at 40 degrees to the circumference round an
/// axis".
std::string law_in_words(const Material& material);

} // namespace retractor::fem
