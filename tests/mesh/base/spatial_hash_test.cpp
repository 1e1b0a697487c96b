#include "mesh/base/spatial_hash.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace retractor {
namespace {

    TEST(SpatialHash, FindsAllThatLieWithinTheDistance)
    {
        constexpr double kCell = 2.0;
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(-30.0, 30.0);
        std::vector<Vec3> points;
        SpatialHash<std::size_t> hash(kCell);
        for (std::size_t i = 0; i < 2000; ++i) {
            points.emplace_back(any(random), any(random), any(random));
            hash.add(points.back(), i);
        }
        for (const double distance : { 1.5, 2.0, 5.0 })
            for (int n = 0; n < 20; ++n) {
                const Vec3 from(any(random), any(random), any(random));
                std::set<std::size_t> met, near;
                EXPECT_TRUE(hash.visit_near(from, distance, [&](std::size_t i) { return met.insert(i).second; }));
                for (std::size_t i = 0; i < points.size(); ++i)
                    if ((points[i] - from).norm() < distance)
                        near.insert(i);
                for (const std::size_t i : near)
                    EXPECT_TRUE(met.contains(i));
                EXPECT_LT(met.size(), points.size() / 2) << "the search looks at far more than what is near";
            }
    }

    TEST(SpatialHash, StopsWhereItIsTold)
    {
        SpatialHash<int> hash(1.0);
        for (int i = 0; i < 5; ++i)
            hash.add(Vec3::Constant(0.5), i);
        int visited = 0;
        EXPECT_FALSE(hash.visit_near(Vec3::Constant(0.5), 1.0, [&](int) { return ++visited < 3; }));
        EXPECT_EQ(visited, 3);
    }

} // namespace
} // namespace retractor
