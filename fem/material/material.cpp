#include "fem/material/material.h"

#include "fem/material/element_fibres.h"
#include "fem/material/hyperelasticity.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <cmath>
#include <string>

namespace retractor::fem {

namespace {

    constexpr double kTonnePerMm3 = 1e-9; ///< density of 1 g/cm^3 in tonne/mm^3

    Material tissue(const char* name, double youngs, double poisson, double grams_per_cm3, const char* source)
    {
        return { name, youngs, poisson, grams_per_cm3 * kTonnePerMm3, source };
    }

    void require(bool good, const Material& material, const char* quantity, double value, const char* range)
    {
        if (!good)
            throw InputError(std::string(quantity) + " " + std::to_string(value) + " is not " + range,
                "material '" + material.name + "'");
    }

} // namespace

const MaterialTable& default_materials()
{
    static const MaterialTable table {
        tissue("skin", 0.2, 0.48, 1.10,
            "arXiv 1302.3022: in-plane stretch of tens of per cent; 0.02 MPa at small strain (shear wave), 83 MPa in "
            "tension to failure"),
        tissue("fat", 0.01, 0.49, 0.92, "range 0.005 - 0.02 MPa, small to moderate strain; middle value"),
        tissue("muscle", 0.04, 0.49, 1.06, "PMC9711973: relaxed, across the fibres, light load; 0.06 MPa at 5 N"),
        tissue("intercostal", 0.2, 0.45, 1.06,
            "range 0.1 - 0.3 MPa, muscle with its fasciae under retraction; middle value"),
        tissue("bone", 4000.0, 0.30, 1.4,
            "Pezowicz 2012: whole ribs in bending, homogenised over cortex and marrow, 2,000 - 8,000 MPa; geometric "
            "mean"),
        tissue("cartilage", 28.5, 0.40, 1.10,
            "costal cartilage, range 5 - 25 MPa, small strain: 15 MPa times 1.9 for the perichondrium (Forman 2010)"),
        tissue("vessel", 1.0, 0.48, 1.05,
            "aortic wall at pulse strain; 0.25 MPa young, 0.9 MPa old from in-vivo stretch (PMC6982607)"),
        tissue(
            "vessel_sclerotic", 3.0, 0.48, 1.05, "sclerotic aortic wall at pulse strain, three times the normal wall"),
        tissue("heart", 0.02, 0.49, 1.06,
            "passive myocardium, small strain, order of magnitude: shear modulus 2 - 10 kPa"),
        tissue("lung", 0.003, 0.40, 0.30, "inflated parenchyma, small strain, order of magnitude: 1 - 5 kPa"),
        tissue("liver", 0.0054, 0.49, 1.06, "PMC6925591: shear modulus 1.8 kPa, small strain (elastography)"),
    };
    return table;
}

const Material& find_material(const MaterialTable& table, std::string_view name)
{
    for (const Material& material : table)
        if (material.name == name)
            return material;
    std::string known;
    for (const Material& material : table)
        known += (known.empty() ? "" : ", ") + material.name;
    throw InputError("there is no material of this name; known are: " + known, "material '" + std::string(name) + "'");
}

void check_material(const Material& m)
{
    require(std::isfinite(m.youngs_modulus_MPa) && m.youngs_modulus_MPa > 0.0, m, "Young's modulus (MPa)",
        m.youngs_modulus_MPa, "a positive number");
    require(m.poissons_ratio > -1.0 && m.poissons_ratio < 0.5, m, "Poisson's ratio", m.poissons_ratio,
        "between -1 and 0.5 (0.5 itself, incompressible, needs a mixed element)");
    require(std::isfinite(m.density_tonne_per_mm3) && m.density_tonne_per_mm3 > 0.0, m, "density (tonne/mm^3)",
        m.density_tonne_per_mm3, "a positive number");
    if (!m.law)
        return;
    constexpr double kUnit = 1e-6; // error of the length of a unit direction that was read from text
    if (m.law->around)
        check_fibres_around(*m.law->around, "material '" + m.name + "'");
    else if (has_fibres(m.law->law))
        for (const Vec3& direction : { m.law->fibres.first, m.law->fibres.second })
            if (!(std::abs(direction.norm() - 1.0) <= kUnit))
                throw InputError("a fibre direction must be a unit vector", "material '" + m.name + "'");
    try {
        check_hyperelastic(with_bulk(m.law->law, m.poissons_ratio));
    } catch (const InputError& error) {
        throw InputError(error.where() + ": " + error.what(), "material '" + m.name + "'");
    }
}

Lame lame(const Material& m)
{
    check_material(m);
    const double E = m.youngs_modulus_MPa, nu = m.poissons_ratio;
    return { E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) };
}

Hyperelastic hyperelastic_law(const Material& material)
{
    const Lame l = lame(material);
    return material.law ? with_bulk(material.law->law, material.poissons_ratio)
                        : Hyperelastic(NeoHookean { l.mu, l.lambda });
}

std::string law_in_words(const Material& material)
{
    std::string words(law_name(material.law ? material.law->law : NeoHookean {}));
    if (!material.law || !material.law->around)
        return words;
    return words
        + formatted(" with fibres at %g degrees to the circumference round an axis", material.law->around->angle_deg);
}

} // namespace retractor::fem
