#include "fem/material/material.h"

#include "fem/material/hyperelasticity.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::fem {
namespace material_test {

    using test_support::material;

    std::string refusal(const Material& m)
    {
        try {
            check_material(m);
        } catch (const InputError& error) {
            return error.where() + ": " + error.what();
        }
        return "accepted";
    }

    TEST(Material, DefaultsAreValidAndNameTheirSource)
    {
        for (const Material& m : default_materials()) {
            EXPECT_NO_THROW(check_material(m)) << m.name;
            EXPECT_FALSE(m.source.empty()) << m.name;
        }
        for (const char* name : { "skin", "fat", "muscle", "intercostal", "bone", "cartilage", "vessel",
                 "vessel_sclerotic", "heart", "lung", "liver" })
            EXPECT_EQ(find_material(default_materials(), name).name, name);
    }

    TEST(Material, LameParametersOfTheTextbook)
    {
        const Lame l = lame(test_support::material(1.0, 0.25)); // E = 1, nu = 1/4: mu = lambda = 0.4
        EXPECT_DOUBLE_EQ(l.mu, 0.4);
        EXPECT_DOUBLE_EQ(l.lambda, 0.4);
    }

    TEST(Material, BadValuesAreRefusedByName)
    {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
        for (const double E : { 0.0, -1.0, nan, inf })
            EXPECT_NE(
                refusal(test_support::material(E, 0.3)).find("material 'test': Young's modulus"), std::string::npos)
                << E;
        for (const double nu : { 0.5, 0.7, -1.0, nan })
            EXPECT_NE(
                refusal(test_support::material(1.0, nu)).find("material 'test': Poisson's ratio"), std::string::npos)
                << nu;
        Material heavy = test_support::material(1.0, 0.3);
        heavy.density_tonne_per_mm3 = -1.0;
        EXPECT_NE(refusal(heavy).find("density"), std::string::npos);
        EXPECT_EQ(refusal(test_support::material(1.0, 0.4999)), "accepted");
        EXPECT_THROW((void)lame(test_support::material(1.0, 0.5)), InputError);
        EXPECT_THROW((void)find_material(default_materials(), "granite"), InputError);
    }

    TEST(Material, ALawTakesItsBulkModulusFromPoissonsRatio)
    {
        Material m = test_support::material(0.06, 0.45);
        const Lame small = lame(m);
        EXPECT_EQ(std::get<NeoHookean>(hyperelastic_law(m)).lambda, small.lambda);
        m.law = TissueLaw { MooneyRivlin { .c10 = 0.3 * small.mu, .c01 = 0.2 * small.mu } };
        const Lame same = small_strain_moduli(hyperelastic_law(m)); // 2 (c10 + c01) = mu
        EXPECT_NEAR(same.mu, small.mu, 1e-15);
        EXPECT_NEAR(same.lambda, small.lambda, 1e-12 * small.lambda);
    }

    TEST(Material, BadLawsAreRefusedByName)
    {
        Material m = test_support::material(0.06, 0.45);
        m.law = TissueLaw { MooneyRivlin { .c10 = -0.1, .c01 = 0.05 } };
        EXPECT_NE(refusal(m).find("material 'test': Mooney-Rivlin: the parameter c10"), std::string::npos)
            << refusal(m);
        m.law = TissueLaw { HolzapfelGasserOgden { .mu = 0.01, .k1 = 0.1, .k2 = 1.0, .dispersion = 0.4 } };
        EXPECT_NE(refusal(m).find("dispersion"), std::string::npos) << refusal(m);
        m.law = TissueLaw { Guccione { .C = 0.01, .bf = 8.0, .bt = 2.0, .bfs = 4.0 },
            { .first = Vec3(2.0, 0.0, 0.0), .second = Vec3::UnitX() } };
        EXPECT_NE(refusal(m).find("unit vector"), std::string::npos) << refusal(m);
        m.law->fibres = {};
        EXPECT_EQ(refusal(m), "accepted");
    }

} // namespace material_test
} // namespace retractor::fem
