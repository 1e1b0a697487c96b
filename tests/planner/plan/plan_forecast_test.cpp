#include "planner/plan/plan_forecast.h"

#include "mesh/base/memory.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {
namespace plan_forecast_test {

    constexpr ElementKind kElements[] = { ElementKind::p1, ElementKind::locking_free, ElementKind::p2 };
    constexpr double kRoundOff = 1e-12; ///< relative
    /// Relative: halving stops at the last bit, and the power 4/3 multiplies round-off.
    constexpr double kInverseTolerance = 1e-9;

    void expect_close(double value, double expected, double relative)
    {
        EXPECT_NEAR(value, expected, relative * expected);
    }

    TEST(PlanForecast, MeetsTheMeasuredPlans)
    {
        const PlanForecast ten_nodes = forecast_plan(50'000.0, ElementKind::p2);
        expect_close(ten_nodes.bytes, 1.6 * kGiB, kRoundOff);
        expect_close(ten_nodes.seconds, 60.0, kRoundOff);
        EXPECT_EQ(ten_nodes.tetrahedra, 50'000.0);
        const PlanForecast eightfold = forecast_plan(400'000.0, ElementKind::p2);
        expect_close(eightfold.bytes, (0.35 + 2.4 + 15.2) * kGiB, kRoundOff);
        const PlanForecast fourfold = forecast_plan(200'000.0, ElementKind::p2);
        expect_close(fourfold.seconds, 480.0, kRoundOff);
        const PlanForecast four_nodes = forecast_plan(50'000.0, ElementKind::p1);
        expect_close(four_nodes.bytes, 0.51 * kGiB, kRoundOff);
        expect_close(four_nodes.seconds, 15.0, kRoundOff);
    }

    TEST(PlanForecast, GrowsWithTheTetrahedra)
    {
        for (const ElementKind element : kElements) {
            PlanForecast last = forecast_plan(0.0, element);
            EXPECT_EQ(last.seconds, 0.0);
            EXPECT_GT(last.bytes, 0.0);
            for (double tetrahedra = 100.0; tetrahedra < 1e8; tetrahedra *= 3.0) {
                const PlanForecast next = forecast_plan(tetrahedra, element);
                EXPECT_GT(next.bytes, last.bytes);
                EXPECT_GT(next.seconds, last.seconds);
                last = next;
            }
        }
    }

    TEST(PlanForecast, TheMostTetrahedraFillTheMemory)
    {
        for (const ElementKind element : kElements) {
            for (double tetrahedra = 1'000.0; tetrahedra < 1e8; tetrahedra *= 7.0)
                expect_close(
                    most_tetrahedra(forecast_plan(tetrahedra, element).bytes, element), tetrahedra, kInverseTolerance);
            double last = 0.0;
            for (double bytes = 0.5 * kGiB; bytes < 1'000.0 * kGiB; bytes *= 1.5) {
                const double most = most_tetrahedra(bytes, element);
                EXPECT_GT(most, last);
                EXPECT_LE(forecast_plan(most, element).bytes, bytes);
                last = most;
            }
        }
        EXPECT_GT(most_tetrahedra(kGiB, ElementKind::p1), most_tetrahedra(kGiB, ElementKind::p2));
    }

    TEST(PlanForecast, NothingFitsIntoTooLittleMemory)
    {
        for (const ElementKind element : kElements) {
            EXPECT_EQ(most_tetrahedra(0.0, element), 0.0);
            EXPECT_EQ(most_tetrahedra(0.35 * kGiB, element), 0.0);
            EXPECT_EQ(most_tetrahedra(std::numeric_limits<double>::quiet_NaN(), element), 0.0);
            EXPECT_EQ(tetrahedra_limit(0.1 * kGiB, element), 1.0) << "0 means no limit to the mesher";
            EXPECT_EQ(tetrahedra_limit(std::nullopt, element), 0.0);
            EXPECT_EQ(tetrahedra_limit(2.0 * kGiB, element), most_tetrahedra(2.0 * kGiB, element));
        }
    }

    TEST(PlanForecast, IsToldInTwoDigits)
    {
        EXPECT_EQ(forecast_text({ .tetrahedra = 56'789.0, .seconds = 72.9, .bytes = 1.68 * kGiB }),
            "about 57,000 tetrahedra, about 73 s, 1.7 GiB");
        EXPECT_EQ(forecast_text({ .tetrahedra = 1'234'567.0, .seconds = 7'281.0, .bytes = 72.0 * kGiB }),
            "about 1,200,000 tetrahedra, about 7,300 s, 72.0 GiB");
        EXPECT_EQ(forecast_text({ .tetrahedra = 8.0, .seconds = 0.01, .bytes = 0.4 * kGiB }),
            "about 8 tetrahedra, about 1 s, 0.4 GiB");
    }

    TEST(PlanForecast, ARefusalNamesTheNeedTheMemoryAndTheField)
    {
        const PlanForecast forecast = forecast_plan(200'000.0, ElementKind::p2);
        check_memory(forecast, std::nullopt);
        check_memory(forecast, forecast.bytes);
        try {
            check_memory(forecast, 2.0 * kGiB);
            FAIL() << "not refused";
        } catch (const MemoryRefusal& refusal) {
            const std::string text = refusal.what();
            EXPECT_NE(text.find("needs about 7.6 GiB"), std::string::npos) << text;
            EXPECT_NE(text.find("200,000 tetrahedra"), std::string::npos) << text;
            EXPECT_NE(text.find("can have 2.0 GiB"), std::string::npos) << text;
            EXPECT_NE(text.find("corridor_edge_mm"), std::string::npos) << text;
            EXPECT_EQ(refusal.fields(), std::vector<std::string> { "corridor_edge_mm" });
            EXPECT_EQ(refusal.where(), "sizing/corridor_edge_mm");
        }
    }

} // namespace plan_forecast_test
} // namespace retractor::planner
