#include "mesh/base/statistics.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace retractor {
namespace {

    TEST(Statistics, ARankCountsFromTheSmallest)
    {
        const std::vector<int> values { 5, 1, 4, 2, 3 };
        for (std::size_t rank = 0; rank < values.size(); ++rank)
            EXPECT_EQ(value_of_rank(std::vector<int>(values), rank), static_cast<int>(rank) + 1);
    }

    TEST(Statistics, ARankCountsFromTheLargestWhereThatIsTheOrder)
    {
        EXPECT_EQ(value_of_rank(std::vector<int> { 5, 1, 4, 2, 3 }, 1, std::greater<> {}), 4);
    }

    TEST(Statistics, TheMedianOfAnEvenCountIsTheLargerOfTheMiddleTwo)
    {
        EXPECT_EQ(upper_median(std::vector<double> { 3.0, 1.0, 2.0 }), 2.0);
        EXPECT_EQ(upper_median(std::vector<double> { 4.0, 3.0, 1.0, 2.0 }), 3.0);
        EXPECT_EQ(upper_median(std::vector<double> { 7.0 }), 7.0);
    }

    struct Weighted {
        double value, weight;
    };

    TEST(Statistics, AWeightedPercentileIsTheFirstThatReachesTheShare)
    {
        const std::vector<Weighted> sorted { { 1.0, 4.0 }, { 2.0, 4.0 }, { 3.0, 2.0 } };
        const auto at = [&](double share) {
            return weighted_percentile(sorted, share, 10.0, [](const Weighted& w) { return w.weight; });
        };
        EXPECT_EQ(at(0.0)->value, 1.0);
        EXPECT_EQ(at(0.4)->value, 1.0);
        EXPECT_EQ(at(0.5)->value, 2.0);
        EXPECT_EQ(at(0.9)->value, 3.0);
        EXPECT_EQ(at(1.1), sorted.end());
    }

} // namespace
} // namespace retractor
