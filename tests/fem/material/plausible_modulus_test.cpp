#include "fem/material/plausible_modulus.h"

#include "fem/material/material.h"

#include <gtest/gtest.h>

namespace retractor::fem {
namespace plausible_modulus_test {

    TEST(PlausibleModulus, HoldsEveryDefaultAndRefusesItInTheWrongUnit)
    {
        for (const Material& material : default_materials()) {
            const ModulusRange range = plausible_modulus(material.name);
            EXPECT_LT(range.least, material.youngs_modulus_MPa) << material.name;
            EXPECT_GT(range.most, material.youngs_modulus_MPa) << material.name;
            constexpr double kWrongUnit = 1000.0; // kPa for MPa
            EXPECT_GT(kWrongUnit * material.youngs_modulus_MPa, range.most) << material.name;
            EXPECT_LT(material.youngs_modulus_MPa / kWrongUnit, range.least) << material.name;
        }
    }

    TEST(PlausibleModulus, HoldsPublishedValues)
    {
        const auto holds = [](const char* tissue, double modulus) {
            const ModulusRange range = plausible_modulus(tissue);
            return modulus >= range.least && modulus <= range.most;
        };
        for (const double skin : { 0.02, 0.2, 1.18, 83.0 }) // shear wave, in plane, tension first and last
            EXPECT_TRUE(holds("skin", skin)) << skin;
        for (const double bone : { 1000.0, 2800.0, 7400.0, 13500.0 }) // homogenised, bending (two ages), cortical
            EXPECT_TRUE(holds("bone", bone)) << bone;
        for (const double cartilage : { 5.0, 25.0, 95.0 }) // substance, calcified
            EXPECT_TRUE(holds("cartilage", cartilage)) << cartilage;
        EXPECT_FALSE(holds("skin", 5000.0));
        EXPECT_TRUE(holds("suture", 3000.0)) << "no tissue of the table";
    }

} // namespace plausible_modulus_test
} // namespace retractor::fem
