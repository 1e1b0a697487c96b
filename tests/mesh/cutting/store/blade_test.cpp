#include "mesh/cutting/store/blade.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace retractor::mesh {
namespace blade_test {

    // Coordinates of some tens of mm: a generous multiple of round-off.
    constexpr double kExact = 1e-11;

    Blade straight_blade()
    {
        return {
            .line = { { 0, 0, 0 }, { 10, 0, 0 }, { 30, 0, 0 } }, .directions = { { 0, 0, -2 } }, .depth_mm = 12.0
        };
    }

    /// An arc round the z axis, cut towards the axis and leaning along it.
    Blade arc_blade(double radius, double arc_deg, int segments, double lean, double depth)
    {
        Blade blade;
        for (int i = 0; i <= segments; ++i) {
            const double a = arc_deg * (i - 0.5 * segments) / segments * std::numbers::pi / 180.0;
            const Vec3 out(std::cos(a), std::sin(a), 0.0);
            blade.line.push_back(radius * out);
            blade.directions.push_back((-out + lean * Vec3::UnitZ()).normalized());
        }
        blade.depth_mm = depth;
        return blade;
    }

    TEST(SweptBlade, CoordinatesOfAPlaneAreExact)
    {
        const SweptBlade blade(straight_blade());
        EXPECT_NEAR(blade.length(), 30.0, kExact);
        EXPECT_EQ(blade.depth(), 12.0);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> along(-20, 50), depth(-15, 30), side(-8, 8);
        for (int i = 0; i < 500; ++i) {
            // Seen from above (z up) and cutting along x, the left is +y.
            const Vec3 p(along(random), side(random), depth(random));
            const BladeCoordinates c = blade.coordinates({ p.x(), p.y(), -p.z() });
            EXPECT_NEAR(c.along, p.x(), kExact);
            EXPECT_NEAR(c.depth, p.z(), kExact);
            EXPECT_NEAR(c.side, p.y(), kExact);
            EXPECT_NEAR((blade.project({ p.x(), p.y(), -p.z() }) - Vec3(p.x(), 0, -p.z())).norm(), 0.0, kExact);
            EXPECT_NEAR((blade.at(p.x(), p.z()) - Vec3(p.x(), 0, -p.z())).norm(), 0.0, kExact);
        }
    }

    TEST(SweptBlade, AnObliqueDirectionMeasuresDepthAlongItself)
    {
        const Vec3 direction = Vec3(0.3, 0.4, -1.0).normalized();
        const SweptBlade blade({ .line = { { 1, 2, 3 }, { 41, 2, 3 } }, .directions = { direction }, .depth_mm = 9.0 });
        const BladeCoordinates c = blade.coordinates(Vec3(1, 2, 3) + 17.0 * Vec3::UnitX() + 6.0 * direction);
        EXPECT_NEAR(c.along, 17.0, kExact);
        EXPECT_NEAR(c.depth, 6.0, kExact);
        EXPECT_NEAR(c.side, 0.0, kExact);
    }

    TEST(SweptBlade, AnArcRoundTheChestHasTwoSides)
    {
        // A cone: leaning rays of an arc of 120 degrees. Its axis side is below, along z, of the blade.
        const double radius = 140.0, lean = 0.5, depth = 30.0;
        const SweptBlade blade(arc_blade(radius, 120.0, 24, lean, depth));
        std::mt19937 random(11);
        std::uniform_real_distribution<double> angle(-55, 55), at_depth(-5, 29), offset(-6, 6);
        const double down = 1.0 / std::hypot(1.0, lean); // of the radius, per mm of depth
        // Chords and flat triangles leave the cone by the sagitta of half a segment.
        const double sagitta = radius * (1.0 - std::cos(0.5 * 5.0 * std::numbers::pi / 180.0));
        for (int i = 0; i < 500; ++i) {
            const double a = angle(random) * std::numbers::pi / 180.0, s = at_depth(random), h = offset(random);
            const Vec3 out(std::cos(a), std::sin(a), 0.0);
            const Vec3 ray = (-out + lean * Vec3::UnitZ()).normalized();
            const Vec3 forward(-std::sin(a), std::cos(a), 0.0);
            const BladeCoordinates c = blade.coordinates(radius * out + s * ray + h * forward.cross(ray));
            EXPECT_NEAR(c.side, h, sagitta);
            EXPECT_NEAR(c.depth, s, sagitta / down);
            EXPECT_NEAR(c.along, (a * 180.0 / std::numbers::pi + 60.0) / 120.0 * blade.length(), 0.02 * blade.length());
        }
    }

    TEST(SweptBlade, TheSideIsContinuousAcrossCreases)
    {
        Blade blade = arc_blade(60.0, 100.0, 3, 0.4, 20.0);
        blade.line[1] += Vec3(0, 0, 4.0);
        const SweptBlade swept(blade);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> along(1, swept.length() - 1), depth(0, 20), offset(-4, 4), unit(-1, 1);
        constexpr double kStep = 1e-3;
        for (int i = 0; i < 3000; ++i) {
            const Vec3 p
                = swept.at(along(random), depth(random)) + offset(random) * Vec3(unit(random), unit(random), 1.0);
            const Vec3 q = p + kStep * Vec3(unit(random), unit(random), unit(random)).normalized();
            // A signed distance changes by no more than the step.
            EXPECT_LE(std::abs(swept.coordinates(p).side - swept.coordinates(q).side), kStep * (1.0 + 1e-6));
        }
    }

    TEST(SweptBlade, EveryPointOfTheSurfaceHasItsOwnCoordinates)
    {
        const SweptBlade blade(arc_blade(90.0, 110.0, 9, 0.3, 25.0));
        std::mt19937 random(5);
        std::uniform_real_distribution<double> along(0, blade.length()), depth(-9, 25);
        for (int i = 0; i < 500; ++i) {
            const double a = along(random), d = depth(random);
            const BladeCoordinates c = blade.coordinates(blade.at(a, d));
            EXPECT_NEAR(c.along, a, 1e-9);
            EXPECT_NEAR(c.depth, d, 1e-9);
            EXPECT_NEAR(c.side, 0.0, kExact);
        }
    }

    TEST(SweptBlade, TheSurfaceIsTheBladeOnly)
    {
        const SweptBlade blade(straight_blade());
        const TriMesh& surface = blade.surface();
        double area = 0.0;
        for (const auto& t : surface.triangles) {
            const Vec3 a = surface.vertices.row(t[0]), b = surface.vertices.row(t[1]), c = surface.vertices.row(t[2]);
            area += 0.5 * (b - a).cross(c - a).norm();
        }
        EXPECT_NEAR(area, 30.0 * (12.0 + 10.0), 1e-9);
    }

    void expect_refused(const Blade& blade, const std::string& what, const std::string& where)
    {
        try {
            const SweptBlade swept(blade);
            FAIL() << "accepted; expected: " << what;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
            EXPECT_EQ(error.where(), where) << error.what();
        }
    }

    TEST(SweptBlade, BadBladesAreRefusedByName)
    {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        Blade b = straight_blade();
        b.line.resize(1);
        expect_refused(b, "at least two points", "line");
        b = straight_blade();
        b.line[1].y() = nan;
        expect_refused(b, "not finite", "line point 1");
        b = straight_blade();
        b.line[2] = b.line[1];
        expect_refused(b, "same as the one before", "line point 2");
        b = straight_blade();
        b.directions = { Vec3::UnitZ(), Vec3::UnitZ() };
        expect_refused(b, "one per point", "directions");
        b = straight_blade();
        b.directions = { Vec3::Zero() };
        expect_refused(b, "not zero", "direction 0");
        b = straight_blade();
        b.directions = { { 0, nan, -1 } };
        expect_refused(b, "finite", "direction 0");
        b = straight_blade();
        b.directions = { Vec3::UnitX() };
        expect_refused(b, "runs along the line", "line point 0");
        for (const double depth : { 0.0, -1.0, nan }) {
            b = straight_blade();
            b.depth_mm = depth;
            expect_refused(b, "depth must be positive", "depth_mm");
        }
        b = straight_blade();
        b.above_mm = -1.0;
        expect_refused(b, "must not be negative", "above_mm");
        b = straight_blade();
        b.line[2] = { 2, 0.01, 0 };
        expect_refused(b, "turns back", "line point 1");
        // Rays towards the middle of an arc cross there.
        expect_refused(arc_blade(40.0, 15.0, 1, 0.0, 45.0), "cross", "line point 0");
        EXPECT_NO_THROW(SweptBlade(arc_blade(40.0, 90.0, 6, 0.0, 35.0)));
        // A loop.
        b = { .line = { { 0, 0, 0 }, { 20, 0, 0 }, { 20, 10, 0 }, { 10, 10, 0 }, { 10, -10, 0 } },
            .directions = { -Vec3::UnitZ() },
            .depth_mm = 5.0 };
        expect_refused(b, "crosses itself", "line point 3");
    }

} // namespace blade_test
} // namespace retractor::mesh
