#include "planner/uncertainty/stiffness_samples.h"

#include "mesh/base/error.h"
#include "planner/plan/parameter_interval.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace retractor::planner {
namespace stiffness_samples_test {

    using test_support::message_of;
    constexpr double kRoundOff = 1e-12;

    Case small_case()
    {
        Case planned_case;
        planned_case.label_table = { { .id = 1, .name = "skin", .material = "skin", .role = mesh::Role::wall },
            { .id = 2, .name = "rib_left_5", .material = "bone", .role = mesh::Role::wall },
            { .id = 3, .name = "sternum", .material = "bone", .role = mesh::Role::wall },
            { .id = 4, .name = "heart", .material = "muscle", .role = mesh::Role::voxel } };
        return planned_case;
    }

    TEST(StiffnessFactors, TheNamesAreTheWallsMaterialsAndTheSprings)
    {
        const std::vector<std::string> expected { "skin", "bone", std::string(kJointSprings),
            std::string(kGirdleSprings) };
        EXPECT_EQ(stiffness_names(small_case()), expected);
    }

    TEST(StiffnessFactors, WrongFactorsAreNamed)
    {
        const auto message = [](const StiffnessFactors& factors) {
            return message_of([&] { check_stiffness_factors(small_case(), factors); });
        };
        EXPECT_EQ(message({ { "skin", 1.5 }, { std::string(kJointSprings), 2.0 } }), "");
        EXPECT_NE(message({ { "muscle", 1.5 } }).find("muscle=1.5"), std::string::npos) << "no material of the wall";
        for (const double wrong : { 0.0, -1.0, 1e6, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_NE(message({ { "skin", wrong } }), "") << wrong;
        Case hyperelastic = small_case();
        hyperelastic.solution.elasticity = fem::Elasticity::hyperelastic;
        EXPECT_THROW(check_stiffness_factors(hyperelastic, { { "skin", 1.5 } }), InputError);
        EXPECT_NO_THROW(check_stiffness_factors(hyperelastic, {}));
    }

    TEST(StiffnessFactors, ScaleMaterialsAndSprings)
    {
        std::vector<fem::Material> materials { { "skin", 0.2, 0.45, 1e-9, "test" },
            { "bone", 5000.0, 0.3, 1e-9, "test" } };
        scale_materials({ { "bone", 2.0 } }, materials);
        EXPECT_EQ(materials[0].youngs_modulus_MPa, 0.2);
        EXPECT_EQ(materials[1].youngs_modulus_MPa, 10000.0);

        // One element of a rib, one of skin, a spring on each.
        fem::ElasticProblem problem;
        problem.mesh.vertices = Points::Zero(8, 3);
        problem.mesh.nodes = { 0, 1, 2, 3, 4, 5, 6, 7 };
        problem.mesh.labels = { 2, 1 };
        problem.supports.bedded = { { 1, 3.0 }, { 6, 5.0 } };
        problem.supports.hinges = { { .stiffness = 7.0, .range = 0.1, .stop_stiffness = 11.0, .toe = 0.2 } };
        scale_springs({ { std::string(kJointSprings), 2.0 }, { std::string(kGirdleSprings), 10.0 } },
            small_case().label_table, problem);
        EXPECT_EQ(problem.supports.bedded[0].stiffness, 6.0);
        EXPECT_EQ(problem.supports.bedded[1].stiffness, 50.0);
        EXPECT_EQ(problem.supports.hinges[0].stiffness, 14.0);
        EXPECT_EQ(problem.supports.hinges[0].stop_stiffness, 22.0);
        EXPECT_EQ(problem.supports.hinges[0].range, 0.1);
    }

    TEST(StiffnessSamples, EveryPartOfEveryRangeIsDrawnFromOnce)
    {
        constexpr int kSamples = 16;
        const std::vector<StiffnessFactors> samples = sample_stiffness(small_case(), kSamples, 3);
        ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
        for (const std::string& name : stiffness_names(small_case())) {
            const PublishedRange range = published_range(name);
            const double half = 0.5 * std::log(range.high / range.low);
            std::vector<int> count(kSamples, 0);
            for (const StiffnessFactors& factors : samples) {
                const double at = 0.5 * (std::log(factors.find(name)->second) / half + 1.0); // 0 to 1
                ASSERT_GE(at, 0.0);
                ASSERT_LT(at, 1.0);
                ++count[static_cast<std::size_t>(at * kSamples)];
            }
            EXPECT_EQ(count, std::vector<int>(kSamples, 1)) << name;
        }
        EXPECT_EQ(sample_stiffness(small_case(), kSamples, 3), samples) << "the same seed gives the same samples";
        EXPECT_NE(sample_stiffness(small_case(), kSamples, 4), samples);
        EXPECT_THROW((void)sample_stiffness(small_case(), 0, 0), InputError);
    }

    TEST(StiffnessSamples, TheSpreadLeavesOneOfTwentyOnEachSide)
    {
        std::vector<double> values;
        for (int n = 100; n >= 0; --n)
            values.push_back(n);
        const Spread spread = *spread_of(values);
        EXPECT_EQ(spread.median, 50.0);
        EXPECT_EQ(spread.low, 5.0);
        EXPECT_EQ(spread.high, 95.0);
        EXPECT_EQ(spread.count, 101U);
        EXPECT_EQ(spread_of({ 4.0 })->low, 4.0);
        EXPECT_FALSE(spread_of({}));
    }

    TEST(StiffnessSamples, ARankingSurvivesWhereTheOrderStays)
    {
        using Scores = std::vector<std::optional<double>>;
        const Scores own { 50.0, 30.0, 40.0 };
        const std::vector<Scores> samples { { 60.0, 20.0, 30.0 }, { 60.0, 31.0, 30.0 }, { 10.0, 20.0, 30.0 },
            { 60.0, std::nullopt, 30.0 } };
        const Survival survival = survival_of(own, samples);
        EXPECT_EQ(survival.samples, 3U) << "a sample without a score of every approach says nothing";
        EXPECT_EQ(survival.same_leader, 2U);
        EXPECT_EQ(survival.same_order, 1U);
        EXPECT_EQ(survival_of(Scores { 50.0, std::nullopt }, std::vector<Scores> { { 1.0, 2.0 } }).samples, 0U);
    }

} // namespace stiffness_samples_test
} // namespace retractor::planner
