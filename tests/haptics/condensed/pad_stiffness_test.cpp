#include "haptics/condensed/pad_stiffness.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace retractor::haptics {
namespace pad_stiffness_test {

    constexpr double kRadius = ContactNodeCompliance::kFallbackRadius;

    CondensedTissue& vessel()
    {
        static CondensedTissue tissue = [] {
            datasets::AortaParameters p;
            p.shape = datasets::AortaParameters::Shape::tube;
            p.region = { 12.0, 120.0 };
            p.length_mm = 40.0;
            p.along = 12;
            CondensedOptions options;
            options.element = TouchElement::p1;
            options.fetch_all_below = 0;
            return CondensedTissue(datasets::make_aorta_phantom(p).body, PulsePressure::constant(80.0), options);
        }();
        return tissue;
    }

    const ContactNode& at(std::int32_t s)
    {
        return vessel().touch_surface().contact_nodes()[static_cast<std::size_t>(s)];
    }

    TEST(PadStiffness, EveryContactNodeIsAMiddleOnceAndWhatItsPadPressesIsThere)
    {
        const std::vector<PadGroup> groups = pad_groups(vessel().touch_surface(), kRadius);
        const auto contact_nodes = static_cast<std::int32_t>(vessel().touch_surface().contact_nodes().size());
        std::vector<int> middle(static_cast<std::size_t>(contact_nodes), 0);
        for (const PadGroup& group : groups)
            for (const std::int32_t m : group.middles) {
                ++middle[static_cast<std::size_t>(m)];
                EXPECT_EQ(std::count(group.pressed.begin(), group.pressed.end(), m), 1);
                for (const std::int32_t s :
                    vessel().touch_surface().contact_node_neighbours().of(static_cast<std::size_t>(m))) {
                    const bool near = (at(s).point - at(m).point).norm() < kRadius;
                    const bool facing = at(s).normal.dot(at(m).normal) > 0.5;
                    EXPECT_EQ(std::count(group.pressed.begin(), group.pressed.end(), s) == 1 || !(near && facing), true)
                        << m << ' ' << s;
                }
            }
        EXPECT_EQ(middle, std::vector<int>(middle.size(), 1));
    }

    TEST(PadStiffness, SpringsThatDoNotFeelEachOtherAddUp)
    {
        constexpr double kGive = 0.4; // mm/N
        const PadGroup group = pad_groups(vessel().touch_surface(), kRadius).front();
        const auto count = static_cast<Eigen::Index>(group.pressed.size());
        const Eigen::MatrixXd C = kGive * Eigen::MatrixXd::Identity(count, count);
        const std::int32_t middle = group.middles.front();
        double sum = 0.0; // of 1 - (r / R)^24 over the pad, r beside its axis
        for (const std::int32_t s : group.pressed) {
            const Vec3 from = at(s).point - at(middle).point;
            const double r = from.cross(at(middle).normal).norm();
            if (from.norm() < kRadius && at(s).normal.dot(at(middle).normal) >= 0.2)
                sum += (1.0 - std::pow(r / kRadius, 24)) / kGive;
        }
        EXPECT_NEAR(pad_stiffness(vessel().touch_surface(), middle, kRadius, group.pressed, C), sum, 1e-9 * sum);
    }

    TEST(PadStiffness, OfAVesselIsWhatFullSolvesGive)
    {
        const ContactNodeCompliance& compliance = vessel().compliance();
        const TouchSurface& surface = vessel().touch_surface();
        const std::vector<PadGroup> groups = pad_groups(surface, kRadius);
        for (const std::size_t g : { std::size_t { 0 }, groups.size() / 2, groups.size() - 1 }) {
            const std::vector<std::int32_t>& pressed = groups[g].pressed;
            const auto count = static_cast<Eigen::Index>(pressed.size());
            Eigen::MatrixXd C(count, count);
            for (Eigen::Index b = 0; b < count; ++b) {
                const std::int32_t s = pressed[static_cast<std::size_t>(b)];
                const ContactNodeCompliance::ContactNodeForce force { s, at(s).normal };
                const Eigen::VectorXd u = compliance.solve(0.0, { &force, 1 });
                for (Eigen::Index a = 0; a < count; ++a) {
                    const std::int32_t other = pressed[static_cast<std::size_t>(a)];
                    C(a, b) = at(other).normal.dot(compliance.mean(u, other));
                }
            }
            constexpr double kRounding = 1e-7; // of two ways through a factor whose condition is some 1e5
            for (const std::int32_t m : groups[g].middles) {
                const double full = pad_stiffness(surface, m, kRadius, pressed, C);
                EXPECT_GT(full, 0.0);
                EXPECT_NEAR(compliance.fallback_stiffness(m), full, kRounding * full) << m;
            }
        }
    }

} // namespace pad_stiffness_test
} // namespace retractor::haptics
