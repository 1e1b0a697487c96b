#include "mesh/surface/proximity.h"

#include "mesh/base/error.h"
#include "tests/mesh/surface/scattered_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace retractor::mesh {
namespace proximity_test {

    const Vec3 kA(0.0, 0.0, 0.0), kB(4.0, 0.0, 0.0), kC(0.0, 3.0, 0.0);
    constexpr double kRoundOff = 1e-14;

    struct Known {
        Vec3 point, barycentric;
        double distance;
    };

    TEST(Proximity, FindsTheClosestPointOfATriangle)
    {
        const std::vector<Known> known {
            { { 1.0, 1.0, 2.0 }, { 5.0 / 12.0, 0.25, 1.0 / 3.0 }, 2.0 }, // above its inside
            { { 1.0, 1.0, -2.0 }, { 5.0 / 12.0, 0.25, 1.0 / 3.0 }, 2.0 }, // and below
            { { 2.0, -3.0, 4.0 }, { 0.5, 0.5, 0.0 }, 5.0 }, // an edge
            { { 2.0 + 3.0, 1.5 + 4.0, 0.0 }, { 0.0, 0.5, 0.5 }, 5.0 }, // the slanted edge, along its normal
            { { -3.0, -4.0, 0.0 }, { 1.0, 0.0, 0.0 }, 5.0 }, // corners
            { { 7.0, -4.0, 0.0 }, { 0.0, 1.0, 0.0 }, 5.0 },
            { { -3.0, 7.0, 0.0 }, { 0.0, 0.0, 1.0 }, 5.0 },
            { kB, { 0.0, 1.0, 0.0 }, 0.0 },
        };
        for (const Known& k : known) {
            const ClosestPoint closest = closest_on_triangle(k.point, kA, kB, kC);
            EXPECT_NEAR(closest.distance, k.distance, kRoundOff * 10.0);
            EXPECT_LT((closest.barycentric - k.barycentric).norm(), kRoundOff * 10.0) << k.point.transpose();
        }
    }

    TEST(Proximity, TakesTrianglesWithoutArea)
    {
        EXPECT_NEAR(closest_on_triangle({ 1.0, 2.0, 0.0 }, kA, kB, 0.5 * kB).distance, 2.0, kRoundOff);
        EXPECT_NEAR(closest_on_triangle({ 3.0, 4.0, 0.0 }, kA, kA, kA).distance, 5.0, kRoundOff);
    }

    TEST(Proximity, FindsWhatATestOfAllTrianglesFinds)
    {
        std::mt19937 random(4711);
        const TriMesh mesh = test_support::scattered_triangles(300, random);
        std::uniform_real_distribution<double> place(-4.0, 24.0);
        for (const double reach : { 0.3, 2.0, 9.0 }) {
            const TriangleProximity near(mesh.vertices, mesh.triangles, reach);
            std::size_t found = 0;
            for (int i = 0; i < 200; ++i) {
                const Vec3 p(place(random), place(random), place(random));
                const auto nearby = near.within(p, reach);
                std::vector<std::int32_t> all;
                for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
                    const auto& corner = mesh.triangles[t];
                    if (closest_on_triangle(p, mesh.vertices.row(corner[0]).transpose(),
                            mesh.vertices.row(corner[1]).transpose(), mesh.vertices.row(corner[2]).transpose())
                            .distance
                        <= reach)
                        all.push_back(static_cast<std::int32_t>(t));
                }
                found += all.size();
                std::vector<std::int32_t> mine;
                for (std::size_t k = 0; k < nearby.size(); ++k) {
                    mine.push_back(nearby[k].triangle);
                    EXPECT_LE(nearby[k == 0 ? 0 : k - 1].point.distance, nearby[k].point.distance);
                }
                std::sort(mine.begin(), mine.end());
                EXPECT_EQ(mine, all);
            }
            EXPECT_GT(found, 0U);
        }
    }

    TEST(Proximity, FindsNothingInNothingAndFarAway)
    {
        EXPECT_TRUE(TriangleProximity(Points(0, 3), {}, 1.0).within(kA, 1.0).empty());
        Points vertices(3, 3);
        vertices << kA.transpose(), kB.transpose(), kC.transpose();
        const TriangleProximity near(vertices, { { 0, 1, 2 } }, 1.0);
        EXPECT_TRUE(near.within({ 1e12, -1e12, 0.0 }, 1.0).empty());
        EXPECT_TRUE(near.within({ std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0 }, 1.0).empty());
        EXPECT_EQ(near.within({ 1.0, 1.0, 0.9 }, 5.0).size(), 1U); // no farther than the reach
        EXPECT_TRUE(near.within({ 1.0, 1.0, 1.1 }, 5.0).empty());
    }

    TEST(Proximity, RefusesBadSurfaces)
    {
        Points vertices(3, 3);
        vertices << kA.transpose(), kB.transpose(), kC.transpose();
        EXPECT_THROW(TriangleProximity(vertices, { { 0, 1, 2 } }, 0.0), InputError);
        EXPECT_THROW(TriangleProximity(vertices, { { 0, 1, 3 } }, 1.0), InputError);
        vertices(1, 1) = std::numeric_limits<double>::infinity();
        EXPECT_THROW(TriangleProximity(vertices, { { 0, 1, 2 } }, 1.0), InputError);
    }

} // namespace proximity_test
} // namespace retractor::mesh
