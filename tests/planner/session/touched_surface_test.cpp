#include "planner/session/touched_surface.h"

#include "mesh/surface/surface_normals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::planner {
namespace touched_surface_test {

    constexpr double kRoundOff = 1e-12;

    /// A square of 20 mm in the plane z = height, facing up.
    TriMesh plate(double height)
    {
        TriMesh mesh;
        mesh.vertices.resize(4, 3);
        mesh.vertices << -10, -10, height, 10, -10, height, 10, 10, height, -10, 10, height;
        mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        return mesh;
    }

    TEST(TouchedSurface, ARayMeetsTheFirstSideThatFacesIt)
    {
        TriMesh two = plate(0.0);
        const TriMesh upper = plate(5.0);
        two.vertices.conservativeResize(8, 3);
        two.vertices.bottomRows(4) = upper.vertices;
        for (const auto& t : upper.triangles)
            two.triangles.push_back({ t[0] + 4, t[1] + 4, t[2] + 4 });
        const Points normals = mesh::vertex_normals(two);
        const Ray down { Vec3(2.0, 3.0, 50.0), -Vec3::UnitZ() };
        const auto place = place_under(two, normals, down);
        ASSERT_TRUE(place);
        EXPECT_NEAR((place->point - Vec3(2.0, 3.0, 5.0)).norm(), 0.0, kRoundOff);
        EXPECT_NEAR((place->outward - Vec3::UnitZ()).norm(), 0.0, kRoundOff);
        EXPECT_FALSE(place_under(two, normals, { Vec3(2.0, 3.0, -50.0), Vec3::UnitZ() })) << "from behind";
        EXPECT_FALSE(place_under(two, normals, { Vec3(20.0, 3.0, 50.0), -Vec3::UnitZ() })) << "beside it";
    }

    TEST(TouchedSurface, AFingertipIsSeatedOnTheTissueAndNotInIt)
    {
        const TriMesh flat = plate(0.0);
        constexpr double kRadius = 4.0, kSeat = 0.01; // of the radius: what an eye does not see
        const auto seat = [&](double z) {
            return seated_on(flat.vertices, flat.triangles, Vec3(1.0, 1.0, z), kRadius, Vec3::UnitZ());
        };
        EXPECT_EQ(seat(6.0), Vec3(1.0, 1.0, 6.0)) << "free";
        for (const double z : { 3.5, 1.0, 0.1, -2.0 }) {
            EXPECT_NEAR(seat(z).z(), kRadius, kSeat * kRadius) << z;
            EXPECT_EQ(seat(z).head<2>(), Eigen::Vector2d(1.0, 1.0));
        }
        EXPECT_LE(seat(-30.0).z(), -30.0 + 3.0 * kRadius) << "too deep to be seated: nothing is made up";
    }

    TEST(TouchedSurface, OutlinesLieOnTheirTemplate)
    {
        haptics::ElasticTemplate shape { .centre = Vec3(1.0, 2.0, 3.0), .half_size = Vec3(4.0, 5.0, 6.0) };
        const auto box = outline_of(shape);
        ASSERT_EQ(box.size(), 12U);
        double length = 0.0;
        for (const auto& [a, b] : box) {
            length += (a - b).norm();
            EXPECT_NEAR((a - shape.centre).cwiseAbs().cwiseQuotient(shape.half_size).minCoeff(), 1.0, kRoundOff);
        }
        EXPECT_NEAR(length, 4.0 * 2.0 * (4.0 + 5.0 + 6.0), 1e-9);
        shape.shape = haptics::ElasticTemplate::Shape::sphere;
        for (const auto& [a, b] : outline_of(shape)) {
            EXPECT_NEAR((a - shape.centre).norm(), 4.0, 1e-12);
            EXPECT_NEAR((b - shape.centre).norm(), 4.0, 1e-12);
        }
    }

} // namespace touched_surface_test
} // namespace retractor::planner
