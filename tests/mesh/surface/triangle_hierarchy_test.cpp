#include "mesh/surface/triangle_hierarchy.h"

#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"
#include "tests/mesh/surface/scattered_triangles.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

namespace retractor::mesh {
namespace triangle_hierarchy_test {

    bool is_even(std::int32_t triangle) { return triangle % 2 == 0; }

    std::optional<TriangleHierarchy::Found> nearest_of_all(const TriMesh& mesh, const TriangleHierarchy::Query& query)
    {
        std::optional<TriangleHierarchy::Found> best;
        for (std::int32_t t = 0; t < static_cast<std::int32_t>(mesh.triangles.size()); ++t) {
            const auto corners = triangle_corners(mesh.vertices, mesh.triangles[static_cast<std::size_t>(t)]);
            const double distance = closest_on_triangle(query.point, corners[0], corners[1], corners[2]).distance;
            if (is_even(t) && distance <= query.distance && query.direction.dot(unit_normal(corners)) < query.cosine
                && (!best || distance < best->distance))
                best = TriangleHierarchy::Found { t, distance };
        }
        return best;
    }

    /// @return the number of searches that found a triangle
    int compare_searches(const TriangleHierarchy& hierarchy, const TriMesh& mesh, std::mt19937& random)
    {
        std::uniform_real_distribution<double> place(-3.0, 23.0), any(-1.0, 1.0), reach(0.0, 6.0);
        int found = 0;
        for (int i = 0; i < 500; ++i) {
            const TriangleHierarchy::Query query { Vec3(place(random), place(random), place(random)), reach(random),
                Vec3(any(random), any(random), any(random)).normalized(), any(random) };
            const auto fast = hierarchy.nearest(query, is_even), slow = nearest_of_all(mesh, query);
            EXPECT_EQ(fast.has_value(), slow.has_value()) << i;
            if (!fast || !slow)
                continue;
            ++found;
            EXPECT_EQ(fast->triangle, slow->triangle) << i;
            EXPECT_DOUBLE_EQ(fast->distance, slow->distance) << i;
        }
        return found;
    }

    TEST(TriangleHierarchy, FindsWhatASearchOfAllTrianglesFindsAtRestAndAfterMotion)
    {
        std::mt19937 random(7);
        for (const int count : { 1, 4, 5, 700 }) {
            TriMesh mesh = test_support::scattered_triangles(count, random);
            TriangleHierarchy hierarchy(mesh.vertices, mesh.triangles);
            int found = compare_searches(hierarchy, mesh, random);
            std::uniform_real_distribution<double> motion(-8.0, 8.0);
            for (Eigen::Index i = 0; i < mesh.vertices.size(); ++i)
                mesh.vertices.data()[i] += motion(random);
            hierarchy.refit(mesh.vertices);
            found += compare_searches(hierarchy, mesh, random);
            EXPECT_GT(found, 0) << count;
        }
    }

    TEST(TriangleHierarchy, TakesTheLowerNumberAtEqualDistanceAndNoTriangleWithoutArea)
    {
        TriMesh mesh;
        mesh.vertices.resize(4, 3);
        mesh.vertices << 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 4.0, 0.0, 0.0, 4.0, 0.0;
        mesh.triangles = { { 0, 0, 1 }, { 0, 2, 3 }, { 0, 1, 2 } };
        const TriangleHierarchy hierarchy(mesh.vertices, mesh.triangles);
        const auto any = [](std::int32_t) { return true; };
        const Vec3 above(2.0, 2.0, 1.0); // above the edge that two triangles share
        const auto found = hierarchy.nearest({ above, 2.0, -Vec3::UnitZ(), -0.5 }, any);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->triangle, 1);
        EXPECT_DOUBLE_EQ(found->distance, 1.0);
        EXPECT_FALSE(hierarchy.nearest({ above, 0.9, -Vec3::UnitZ(), -0.5 }, any));
        EXPECT_FALSE(hierarchy.nearest({ above, 2.0, Vec3::UnitZ(), -0.5 }, any)); // all look the same way
    }

    TEST(TriangleHierarchy, FindsNothingOnASurfaceWithoutTriangles)
    {
        const TriangleHierarchy none(Points(0, 3), {});
        EXPECT_FALSE(none.nearest({ Vec3::Zero(), 5.0, Vec3::UnitX(), 0.5 }, [](std::int32_t) { return true; }));
    }

} // namespace triangle_hierarchy_test
} // namespace retractor::mesh
