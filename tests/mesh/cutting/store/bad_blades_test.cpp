// Blades with zero, negative or infinite lengths and NaN: each is refused.

#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/support/cutting/cut_mesh.h"
#include "tests/support/refusals.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace retractor::mesh {
namespace bad_blades_test {

    using namespace test_support;

    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

    test_support::SpoiltCalls bad_cuts()
    {
        test_support::SpoiltCalls all;
        const TetMesh block = kuhn_box(12, 8, 4, 5.0); // 60 x 40 x 20 mm
        const Blade good {
            .line = { { 15.0, 20.0, 20.0 }, { 45.0, 20.0, 20.0 } }, .directions = { -Vec3::UnitZ() }, .depth_mm = 10.0
        };
        const auto add = [&](const std::function<void(Blade&)>& spoil) {
            Blade blade = good;
            spoil(blade);
            all.spoilt.emplace_back([blade, block] { (void)cut(block, blade); });
        };
        all.sound.emplace_back([good, block] { (void)cut(block, good); });
        for (const double bad : { 0.0, -1.0, kNan })
            add([=](Blade& b) { b.depth_mm = bad; });
        add([](Blade& b) { b.line.resize(1); });
        add([](Blade& b) { b.line[1] = b.line[0]; });
        add([](Blade& b) { b.line[1].x() = kNan; });
        add([](Blade& b) { b.directions[0].setZero(); });
        add([](Blade& b) { b.directions[0].setConstant(kNan); });
        add([](Blade& b) { b.directions[0] = b.line[1] - b.line[0]; });
        return all;
    }

    TEST(BadBlades, AreRefused) { test_support::expect_all_refused(bad_cuts()); }

} // namespace bad_blades_test
} // namespace retractor::mesh
