#include "mesh/base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace retractor {
namespace {

    TEST(DisjointSets, EveryNumberBeginsAlone)
    {
        DisjointSets<> sets(4);
        EXPECT_EQ(sets.roots(), (std::vector<std::size_t> { 0, 1, 2, 3 }));
    }

    TEST(DisjointSets, TheRootIsTheSmallestNumber)
    {
        DisjointSets<> sets(6);
        EXPECT_TRUE(sets.join(5, 4));
        EXPECT_TRUE(sets.join(4, 2));
        EXPECT_FALSE(sets.join(2, 5));
        EXPECT_EQ(sets.root(5), 2U);
        EXPECT_EQ(sets.roots(), (std::vector<std::size_t> { 0, 1, 2, 3, 2, 2 }));
    }

    TEST(DisjointSets, TheOrderOfTheJoinsDoesNotMatter)
    {
        constexpr std::uint32_t kSize = 200;
        std::mt19937 random(7);
        std::uniform_int_distribution<std::uint32_t> any(0, kSize - 1);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs(120);
        for (auto& [a, b] : pairs) {
            a = any(random);
            b = any(random);
        }
        const auto joined = [&] {
            DisjointSets<std::uint32_t> sets(kSize);
            for (const auto& [a, b] : pairs)
                sets.join(a, b);
            return sets.roots();
        };
        const std::vector<std::uint32_t> roots = joined();
        std::shuffle(pairs.begin(), pairs.end(), random);
        EXPECT_EQ(joined(), roots);
        for (const auto& [a, b] : pairs)
            EXPECT_EQ(roots[a], roots[b]);
    }

} // namespace
} // namespace retractor
