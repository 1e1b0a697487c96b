#include "planner/measures/sight/aperture.h"

#include "mesh/base/error.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "tests/planner/measures/sight/sight_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace retractor::planner {
namespace aperture_test {

    using namespace sight_scenes;

    constexpr double kSkin = 70.0, kInner = 40.0; ///< heights of the two sides of the wall
    constexpr double kLength = 60.0, kWidth = 24.0;
    constexpr ApertureWidth kParallel { .skin_mm = kWidth, .inner_mm = kWidth };
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

    /// A straight line along x over the origin.
    std::vector<ApertureSection> straight()
    {
        std::vector<ApertureSection> sections;
        for (int n = 0; n <= 6; ++n) {
            const double x = kLength * (n / 6.0 - 0.5);
            sections.push_back({ .skin = Vec3(x, 0, kSkin), .inner = Vec3(x, 0, kInner) });
        }
        return sections;
    }

    /// A plate in the plane z with a hole between two parabolas along x.
    TriMesh plate_with_lens(double z, double width = kWidth)
    {
        constexpr int kSteps = 200;
        constexpr double kFar = 2000.0;
        TriMesh mesh;
        const auto add = [&](double x, double y) {
            mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
            mesh.vertices.row(mesh.vertices.rows() - 1) << x, y, z;
            return static_cast<VertexId>(mesh.vertices.rows() - 1);
        };
        for (const double side : { 1.0, -1.0 })
            for (int n = 0; n < kSteps; ++n) {
                const auto lip = [&](int at) {
                    const double t = 2.0 * at / kSteps - 1.0;
                    return std::pair(0.5 * kLength * t, side * 0.5 * width * (1.0 - t * t));
                };
                const auto [x0, y0] = lip(n);
                const auto [x1, y1] = lip(n + 1);
                add_quad(mesh, add(x0, y0), add(x1, y1), add(x1, side * kFar), add(x0, side * kFar));
            }
        for (const double end : { 1.0, -1.0 })
            add_quad(mesh, add(end * 0.5 * kLength, -kFar), add(end * kFar, -kFar), add(end * kFar, kFar),
                add(end * 0.5 * kLength, kFar));
        return mesh;
    }

    constexpr int kRays = 20000;
    struct Passed {
        int passing = 0; ///< through the aperture
        int different = 0; ///< from what the plates let through
    };

    /// Rays between the height 0 and an eye, both ways.
    Passed compare_with_plates(const Aperture& aperture, const RayScene& plates)
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-25.0, 25.0), eye(-150.0, 150.0);
        Passed count;
        for (int n = 0; n < kRays; ++n) {
            const Vec3 from(place(random), place(random), 0.0), to(eye(random), eye(random), 400.0);
            const Vec3 direction = (to - from).normalized();
            const bool passes = aperture.passes(from, direction);
            count.passing += passes ? 1 : 0;
            count.different += passes != plates.clear(from, direction, 1.0, 600.0, kWallMask) ? 1 : 0;
            EXPECT_EQ(passes, aperture.passes(to, -direction));
        }
        return count;
    }

    TEST(Aperture, PassesTheRaysThatPlatesWithTheSameHolePass)
    {
        const RayScene plates(
            ring(0.0, kDisc, 0.0), { wall(plate_with_lens(kSkin)), wall(plate_with_lens(kInner)) }, {});
        const Passed rays = compare_with_plates(Aperture(straight(), kParallel), plates);
        EXPECT_GT(rays.passing, kRays / 20);
        EXPECT_LT(rays.different, kRays / 1000); // rays that touch a lip
    }

    TEST(Aperture, NarrowsBelowTheSkin)
    {
        constexpr double kInnerWidth = 9.0;
        const RayScene plates(
            ring(0.0, kDisc, 0.0), { wall(plate_with_lens(kSkin)), wall(plate_with_lens(kInner, kInnerWidth)) }, {});
        const Passed rays
            = compare_with_plates(Aperture(straight(), { .skin_mm = kWidth, .inner_mm = kInnerWidth }), plates);
        EXPECT_GT(rays.passing, kRays / 50);
        EXPECT_LT(rays.different, kRays / 1000);
        const Aperture closed(straight(), { .skin_mm = kWidth, .inner_mm = -1.0 });
        EXPECT_FALSE(closed.passes(Vec3::Zero(), Vec3::UnitZ()));
        EXPECT_EQ(closed.opening().width_mm, kWidth);
    }

    TEST(Aperture, ItsWallCountsMostWhereTheHoleIsWide)
    {
        EXPECT_NEAR(thickness_at_aperture(straight()), kSkin - kInner, 1e-9);
        std::vector<ApertureSection> wedge = straight();
        wedge.front().inner.z() += 25.0; // at the ends the hole is closed
        wedge.back().inner.z() += 25.0;
        EXPECT_NEAR(thickness_at_aperture(wedge), kSkin - kInner, 1e-3);
        EXPECT_EQ(thickness_at_aperture({ straight().front() }), kSkin - kInner);
    }

    TEST(Aperture, ShowsTheBestEyeWhatTheSameHoleInPlatesShows)
    {
        const RayScene open(
            ring(0.0, kDisc, 0.0), { { .name = "wall", .surface = {}, .labels = {}, .material = {} } }, {});
        const RayScene behind(open, Aperture(straight(), kParallel), "wall");
        const RayScene plates(
            ring(0.0, kDisc, 0.0), { wall(plate_with_lens(kSkin)), wall(plate_with_lens(kInner)) }, {});
        const EyePlaces places { .cone = from_above(kEye, 20.0, 37), .nearest_mm = 300.0, .farthest_mm = 500.0 };
        const auto samples = surface_samples(open.target(), 2000);
        const SurgeonEye by_hole = best_eye(behind, places, samples), by_plates = best_eye(plates, places, samples);
        EXPECT_GT(by_plates.seen_fraction, 0.1);
        EXPECT_NEAR(by_hole.seen_fraction, by_plates.seen_fraction, 0.005);
        EXPECT_EQ(by_hole.bound_area_mm2, by_plates.bound_area_mm2);
        ASSERT_FALSE(by_hole.hidden_by.empty());
        EXPECT_EQ(by_hole.hidden_by.front().name, "wall");
        EXPECT_EQ(best_eye(open, places, samples).seen_fraction, 1.0); // the open scene is unchanged
    }

    TEST(Aperture, FollowsABentLine)
    {
        // A line round a chest of 100 mm, with a wall of 20 mm: straight in it is open everywhere but at its ends.
        std::vector<ApertureSection> sections;
        for (int deg = -40; deg <= 40; deg += 5) {
            const Vec3 out(std::sin(deg * kPi / 180.0), 0, std::cos(deg * kPi / 180.0));
            sections.push_back({ .skin = 100.0 * out, .inner = 80.0 * out });
        }
        const Aperture aperture(sections, { .skin_mm = 20.0, .inner_mm = 20.0 });
        for (const double deg : { -38.0, -20.0, 1.0, 30.0 }) {
            const Vec3 out(std::sin(deg * kPi / 180.0), 0, std::cos(deg * kPi / 180.0));
            EXPECT_TRUE(aperture.passes(50.0 * out, out)) << deg;
            EXPECT_FALSE(aperture.passes(50.0 * out + Vec3(0, 11, 0), out)) << deg;
        }
        const Vec3 beside(std::sin(0.8), 0, std::cos(0.8)); // 46 degrees
        EXPECT_FALSE(aperture.passes(50.0 * beside, beside));
        EXPECT_NEAR(aperture.opening().centre.z(), 97.0, 3.0);
        EXPECT_NEAR(aperture.opening().normal.z(), 1.0, 1e-9);
        EXPECT_NEAR(aperture.opening().incision_length_mm, 100.0 * 80.0 * kPi / 180.0, 0.1);
    }

    TEST(Aperture, RefusesWhatIsNoHole)
    {
        EXPECT_THROW(Aperture({ straight().front() }, kParallel), InputError);
        EXPECT_THROW(Aperture(straight(), { .skin_mm = 0.0, .inner_mm = 10.0 }), InputError);
        EXPECT_THROW(Aperture(straight(), { .skin_mm = kNaN, .inner_mm = 10.0 }), InputError);
        EXPECT_THROW(Aperture(straight(), { .skin_mm = kWidth, .inner_mm = kNaN }), InputError);
        std::vector<ApertureSection> twice { straight()[0], straight()[0] };
        EXPECT_THROW(Aperture(twice, kParallel), InputError);
        std::vector<ApertureSection> flat = straight();
        for (ApertureSection& section : flat)
            section.inner = section.skin;
        EXPECT_THROW(Aperture(flat, kParallel), InputError);
        const RayScene scene(ring(0.0, kDisc, 0.0), {}, {});
        EXPECT_THROW(RayScene(scene, Aperture(straight(), kParallel), "wall"), InputError);
    }

} // namespace aperture_test
} // namespace retractor::planner
