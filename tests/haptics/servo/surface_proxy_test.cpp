#include "haptics/servo/surface_proxy.h"

#include "tests/support/allocation_count.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace retractor::haptics {
namespace surface_proxy_test {

    /// A flat sheet in z = 0, facing +z, `n` squares of 2 mm a side, around the origin.
    TriMesh sheet(int n)
    {
        TriMesh mesh;
        mesh.vertices.resize((n + 1) * (n + 1), 3);
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i)
                mesh.vertices.row(j * (n + 1) + i) << 2.0 * i - n, 2.0 * j - n, 0.0;
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const VertexId a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
                mesh.triangles.push_back({ a, b, d });
                mesh.triangles.push_back({ a, d, c });
            }
        return mesh;
    }

    /// A ball of radius 30 by latitude and longitude.
    TriMesh ball(int rings, int around)
    {
        TriMesh mesh;
        mesh.vertices.resize((rings - 1) * around + 2, 3);
        for (int r = 1; r < rings; ++r)
            for (int a = 0; a < around; ++a) {
                const double lat = std::numbers::pi * r / rings, lon = 2.0 * std::numbers::pi * a / around;
                mesh.vertices.row((r - 1) * around + a) << 30.0 * std::sin(lat) * std::cos(lon),
                    30.0 * std::sin(lat) * std::sin(lon), 30.0 * std::cos(lat);
            }
        const VertexId north = (rings - 1) * around, south = north + 1;
        mesh.vertices.row(north) << 0, 0, 30;
        mesh.vertices.row(south) << 0, 0, -30;
        for (int a = 0; a < around; ++a) {
            const int b = (a + 1) % around;
            mesh.triangles.push_back({ north, a, b });
            mesh.triangles.push_back({ south, (rings - 2) * around + b, (rings - 2) * around + a });
            for (int r = 0; r + 2 < rings; ++r) {
                const VertexId p = r * around + a, q = r * around + b, s = p + around, t = q + around;
                mesh.triangles.push_back({ p, s, t });
                mesh.triangles.push_back({ p, t, q });
            }
        }
        return mesh;
    }

    Fingertip tip(const Vec3& at, double radius = 0.0) { return { .position = at, .radius = radius }; }

    TEST(SurfaceProxy, HoldsTheFingerOnAFlatSheet)
    {
        SurfaceProxy proxy(sheet(10));
        EXPECT_FALSE(proxy.move(0, tip(Vec3(1.0, 2.0, 3.0))).touching);
        const ProxyContact& c = proxy.move(0, tip(Vec3(1.3, 2.0, -1.0)));
        ASSERT_TRUE(c.touching);
        EXPECT_NEAR((c.normal - Vec3::UnitZ()).norm(), 0.0, 1e-12);
        EXPECT_NEAR((c.proxy - Vec3(1.3, 2.0, 0.0)).norm(), 0.0, 1e-9) << "without friction it is right above";
        EXPECT_NEAR(c.depth, 1.0, 1e-9);
        proxy.move(0, tip(Vec3(-4.0, 3.0, -2.0))); // across many triangles
        EXPECT_NEAR((c.proxy - Vec3(-4.0, 3.0, 0.0)).norm(), 0.0, 1e-9);
        proxy.move(0, tip(Vec3(-4.0, 3.0, 0.5)));
        EXPECT_FALSE(c.touching);
        proxy.move(0, tip(Vec3(-4.0, 3.0, -0.5)));
        EXPECT_TRUE(c.touching);
    }

    TEST(SurfaceProxy, AFingertipTouchesWithItsSurfaceFromWhereverItComes)
    {
        SurfaceProxy proxy(sheet(20));
        const ProxyContact& c = proxy.move(0, tip(Vec3(-10.0, 0.0, 4.5), 4.0));
        for (int i = 0; i < 200; ++i) // nearly along the surface
            proxy.move(0, tip(Vec3(-10.0 + 0.1 * i, 0.0, 4.5 - 0.004 * i), 4.0));
        ASSERT_TRUE(c.touching);
        EXPECT_NEAR(c.depth, 4.0 - (4.5 - 0.004 * 199), 1e-9);
    }

    TEST(SurfaceProxy, ThinTissueIsNotPassedThroughInOneTick)
    {
        TriMesh both = sheet(10); // its underside, 0.2 mm below
        const auto n = static_cast<VertexId>(both.vertices.rows());
        both.vertices.conservativeResize(2 * n, 3);
        both.vertices.bottomRows(n) = both.vertices.topRows(n);
        both.vertices.bottomRows(n).col(2).setConstant(-0.2);
        for (std::size_t t = 0, count = both.triangles.size(); t < count; ++t) {
            const auto tri = both.triangles[t];
            both.triangles.push_back({ tri[0] + n, tri[2] + n, tri[1] + n });
        }
        SurfaceProxy proxy(both);
        proxy.move(0, tip(Vec3(0.3, 0.2, 5.0)));
        const ProxyContact& c = proxy.move(0, tip(Vec3(0.3, 0.2, -5.0)));
        ASSERT_TRUE(c.touching);
        EXPECT_NEAR(c.proxy.z(), 0.0, 1e-9) << "the side it came from";
        EXPECT_NEAR(c.depth, 5.0, 1e-9);
        Fingertip beyond = tip(Vec3(0.3, 0.2, -50.0));
        beyond.placed = true;
        proxy.move(0, beyond);
        EXPECT_FALSE(c.touching) << "placed there, it came from no side";
    }

    TEST(SurfaceProxy, FrictionHoldsItWithinItsCone)
    {
        constexpr double kFriction = 0.5;
        SurfaceProxy proxy(sheet(10), { .friction = kFriction });
        proxy.move(0, tip(Vec3(0.1, 0.1, 1.0)));
        const ProxyContact& c = proxy.move(0, tip(Vec3(0.1, 0.1, -2.0)));
        const Vec3 stuck = c.proxy;
        proxy.move(0, tip(Vec3(1.0, 0.1, -2.0))); // 0.9 mm of pull, 1 mm held
        EXPECT_NEAR((c.proxy - stuck).norm(), 0.0, 1e-9);
        proxy.move(0, tip(Vec3(3.1, 0.1, -2.0)));
        EXPECT_NEAR(3.1 - c.proxy.x(), kFriction * 2.0, 1e-9) << "it slides until the pull is at the cone";
    }

    TEST(SurfaceProxy, FollowsASurfaceThatMoves)
    {
        TriMesh mesh = sheet(10);
        SurfaceProxy proxy(mesh);
        proxy.move(0, tip(Vec3(0.3, 0.4, 1.0)));
        const ProxyContact& c = proxy.move(0, tip(Vec3(0.3, 0.4, -1.0)));
        mesh.vertices.col(2).array() += 0.5;
        proxy.publish(mesh.vertices);
        proxy.move(0, tip(Vec3(0.3, 0.4, -1.0)));
        EXPECT_NEAR(c.depth, 1.0, 1e-9) << "not before it is taken";
        proxy.refresh();
        proxy.move(0, tip(Vec3(0.3, 0.4, -1.0)));
        EXPECT_NEAR(c.depth, 1.5, 1e-9);
        mesh.vertices.col(2).array() -= 3.0;
        proxy.publish(mesh.vertices);
        proxy.refresh();
        proxy.move(0, tip(Vec3(0.3, 0.4, -1.0)));
        EXPECT_FALSE(c.touching) << "it has gone away from under the finger";
        EXPECT_EQ(test_support::message_of([&] { proxy.publish(Points::Zero(3, 3)); }),
            "the surface has 121 vertices, not 3 []");
    }

    TEST(SurfaceProxy, ShadingMakesABallRound)
    {
        // Drawn round the equator, 2 mm deep: how far normals are from the ball's, and their largest jump.
        const auto worst = [](bool shaded) {
            SurfaceProxy proxy(ball(24, 48), { .shaded = shaded });
            double error = 0.0, jump = 0.0;
            Vec3 last = Vec3::Zero();
            for (int i = 0; i <= 720; ++i) {
                const double angle = i * std::numbers::pi / 360.0;
                const Vec3 out(std::cos(angle), std::sin(angle), 0.05);
                proxy.move(0, tip(out.normalized() * (i == 0 ? 40.0 : 28.0)));
                const ProxyContact& c = proxy.move(0, tip(out.normalized() * 28.0));
                EXPECT_TRUE(c.touching) << i;
                error = std::max(error, (c.normal - c.proxy.normalized()).norm());
                if (i > 0)
                    jump = std::max(jump, (c.normal - last).norm());
                last = c.normal;
            }
            return std::pair { error, jump };
        };
        const auto [round_error, round_jump] = worst(true);
        const auto [flat_error, flat_jump] = worst(false);
        EXPECT_LT(round_error, 0.25 * flat_error);
        EXPECT_LT(round_jump, 0.35 * flat_jump);
    }

    TEST(SurfaceProxy, AsksForNoMemory)
    {
        if (!test_support::allocations_are_counted())
            GTEST_SKIP() << "a sanitizer has its own malloc";
        const TriMesh mesh = ball(24, 48);
        SurfaceProxy proxy(mesh, { .fingers = 2, .friction = 0.2 });
        proxy.publish(mesh.vertices);
        const std::size_t before = test_support::allocation_count();
        for (int i = 0; i < 500; ++i) {
            proxy.refresh();
            const Vec3 at(32.0 * std::cos(0.01 * i), 32.0 * std::sin(0.01 * i), 0.02 * i);
            proxy.move(0, tip(at, 4.0));
            proxy.move(1, tip(-at, 4.0));
        }
        EXPECT_EQ(test_support::allocation_count(), before);
    }

    TEST(SurfaceProxy, RefusesWhatIsNoSurface)
    {
        const auto message = [](const TriMesh& mesh, const SurfaceProxyOptions& options = {}) {
            return test_support::message_of([&] { SurfaceProxy proxy(mesh, options); });
        };
        EXPECT_EQ(message({}), "the surface has no triangle []");
        TriMesh mesh = sheet(2);
        mesh.triangles[3][1] = 99;
        EXPECT_EQ(message(mesh), "a vertex does not exist [triangle 3]");
        mesh = sheet(2);
        mesh.vertices(4, 2) = NAN;
        EXPECT_EQ(message(mesh), "the surface has a vertex that is not finite []");
        mesh = sheet(2);
        mesh.triangles.push_back(mesh.triangles[0]);
        EXPECT_NE(message(mesh).find("an edge has more than two triangles [triangle 8]"), std::string::npos);
        EXPECT_EQ(message(sheet(2), { .fingers = 0 }), "there are no fingers []");
        EXPECT_EQ(message(sheet(2), { .friction = -1.0 }), "the coefficient of friction must not be negative []");
    }

} // namespace surface_proxy_test
} // namespace retractor::haptics
