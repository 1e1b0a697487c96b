#include "tests/support/half_space.h"

#include "haptics/condensed/sneddon.h"
#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::haptics {
namespace half_space_test {

    using test_support::flat_punch_force;
    using test_support::HalfSpace;

    constexpr double kPromised = 0.03; // relative
    constexpr double E = 0.020, nu = 0.49;

    TEST(HalfSpace, FlatPunchAndSphere)
    {
        EXPECT_NEAR(flat_punch_force(5.0, 2.0, E, nu), 0.5264, 5e-5); // published
        constexpr double R = 8.0, a = 5.663;
        const double d = sneddon_depth(R, a), exact = sneddon_force(d, R, E, nu);
        EXPECT_NEAR(d, 5.0, 1e-3); // published: R 8, d 5 gives a 5.663, F 1.0401
        EXPECT_NEAR(exact, 1.0401, 5e-4);

        const HalfSpace block(a, E, nu);
        const HalfSpace::Answer sphere
            = block.press([&](double r) { return r < R ? d - (R - std::sqrt(R * R - r * r)) : -R; });
        EXPECT_NEAR(sphere.force / exact, 1.0, kPromised);
        constexpr double kOneElement = 0.04; // of the radius, at its edge
        EXPECT_NEAR(sphere.contact_radius / a, 1.0, kOneElement);

        const auto punch = [&](double depth) {
            return block
                .press([&](double r) { return r <= a * (1.0 + 1e-9) ? depth : -std::numeric_limits<double>::max(); })
                .force;
        };
        EXPECT_NEAR(punch(2.0) / flat_punch_force(a, 2.0, E, nu), 1.0, kPromised);
        EXPECT_NEAR(punch(4.0), 2.0 * punch(2.0), 1e-9); // linear
    }

    TEST(HalfSpace, BadInputIsRefused)
    {
        EXPECT_THROW(HalfSpace(-1.0, E, nu), InputError);
        EXPECT_THROW(HalfSpace(1.0, E, nu, 0), InputError);
    }

} // namespace half_space_test
} // namespace retractor::haptics
