#include "planner/plan/parameter_interval.h"

#include "mesh/base/error.h"
#include "planner/approach/retractors.h"
#include "planner/measures/metrics.h"
#include "planner/measures/tissue_values.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/reference_problems.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace retractor::planner {
namespace parameter_interval_test {

    constexpr double kRoundOff = 1e-12;
    /// Of a sum of exponents: plans are solved to 1e-4 of the largest nodal force.
    constexpr double kSum = 0.01;
    /// Of an exponent: a difference over +-10 % in a wound that opens by large rotations, where few elements turn over.
    constexpr double kExponent = 0.05;

    ParameterInfluence influence(const std::string& name, double value, double factor, double force, double opening)
    {
        return { .name = name,
            .unit = "MPa",
            .value = value,
            .low = value / factor,
            .high = value * factor,
            .force_exponent = force,
            .opening_exponent = opening,
            .source = "test" };
    }

    TEST(ParameterInterval, AddsTheVariancesOfIndependentParameters)
    {
        // Deviations of ln F: 0.6 ln 4 and 0.4 ln 2.
        const ParameterInterval interval = combine_parameters(
            100.0, 50.0, { influence("soft", 0.01, 2.0, 0.4, 0.0), influence("stiff", 10.0, 4.0, 0.6, -0.1) });
        const double of_force = std::hypot(0.6 * std::log(4.0), 0.4 * std::log(2.0));
        EXPECT_NEAR(interval.force_low_N, 100.0 * std::exp(-of_force), kRoundOff * 100.0);
        EXPECT_NEAR(interval.force_high_N, 100.0 * std::exp(of_force), kRoundOff * 1000.0);
        EXPECT_NEAR(interval.opening_low_mm, 50.0 * std::pow(4.0, -0.1), kRoundOff * 100.0);
        EXPECT_NEAR(interval.opening_high_mm, 50.0 * std::pow(4.0, 0.1), kRoundOff * 100.0);
        ASSERT_EQ(interval.parameters.size(), 2U);
        EXPECT_EQ(interval.parameters[0].name, "stiff"); // the largest influence first
        EXPECT_NEAR(interval.parameters[0].force_change_percent, 100.0 * (std::pow(4.0, 0.6) - 1.0), 1e-9);
        EXPECT_NEAR(interval.parameters[0].opening_change_percent, 100.0 * (std::pow(4.0, -0.1) - 1.0), 1e-9);
        EXPECT_EQ(deciding_parameters(interval), (std::vector<std::string> { "stiff" }));
    }

    TEST(ParameterInterval, WithoutInfluenceIsThePoint)
    {
        const ParameterInterval interval = combine_parameters(7.0, 3.0, { influence("fat", 0.01, 2.0, 0.0, 0.0) });
        EXPECT_EQ(interval.force_low_N, 7.0);
        EXPECT_EQ(interval.force_high_N, 7.0);
        EXPECT_EQ(interval.opening_high_mm, 3.0);
        EXPECT_TRUE(deciding_parameters(interval).empty());
    }

    TEST(ParameterInterval, RefusesBadParametersByName)
    {
        ParameterInfluence upside_down = influence("fat", 0.01, 2.0, 0.1, 0.1);
        std::swap(upside_down.low, upside_down.high);
        EXPECT_EQ(test_support::message_of([&] { (void)combine_parameters(1.0, 1.0, { upside_down }); }),
            "parameter 'fat': the range from 0.02 to 0.005 is not a range of a stiffness");
        EXPECT_EQ(test_support::message_of(
                      [] { (void)combine_parameters(1.0, 1.0, { influence("skin", 0.2, 2.0, NAN, 0.0) }); }),
            "parameter 'skin': an exponent is not finite");
    }

    TEST(ParameterInterval, EveryTissueHasARange)
    {
        for (const fem::Material& material : fem::default_materials()) {
            const PublishedRange range = published_range(material.name);
            EXPECT_GT(range.low, 0.0) << material.name;
            EXPECT_GT(range.high, range.low) << material.name;
            EXPECT_FALSE(range.source.empty()) << material.name;
        }
        EXPECT_EQ(published_range("granite").high, 2.0);
    }

    PlannedField plan(const SolverSettings& choice, const std::function<void(Case&, Approach&)>& change)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("tissue values", phantom);
        planned_case.solution = choice;
        Approach approach;
        {
            Patient patient(planned_case);
            approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 8.0);
        }
        approach.sizing.corridor_edge_mm = choice.element == ElementKind::p2 ? 9.0 : 6.0; // ten nodes take their time
        change(planned_case, approach);
        Patient patient(planned_case);
        PlannedField field = plan_approach(patient, approach, {});
        EXPECT_EQ(field.status, PlanStatus::done) << field.message;
        return field;
    }

    double sum_of(const ParameterInterval& interval, double ParameterInfluence::*exponent)
    {
        double sum = 0.0;
        for (const ParameterInfluence& parameter : interval.parameters)
            sum += parameter.*exponent;
        return sum;
    }

    TEST(ParameterInterval, ExponentsOfHeldHooksAddUpToOne)
    {
        for (const ElementKind element : { ElementKind::p1, ElementKind::p2, ElementKind::locking_free }) {
            const PlannedField field = plan({ .element = element }, [](Case&, Approach&) {});
            ASSERT_TRUE(field.metrics.parameters);
            const ParameterInterval& interval = *field.metrics.parameters;
            ASSERT_EQ(interval.message, "");
            EXPECT_NEAR(sum_of(interval, &ParameterInfluence::force_exponent), 1.0, kSum) << to_string(element);
            EXPECT_NEAR(sum_of(interval, &ParameterInfluence::opening_exponent), 0.0, kSum) << to_string(element);
            EXPECT_LT(interval.force_low_N, field.metrics.hook_force_N);
            EXPECT_GT(interval.force_high_N, field.metrics.hook_force_N);
            EXPECT_FALSE(deciding_parameters(interval).empty());
            EXPECT_NE(force_with_intervals(field.metrics).find("; tissue values: "), std::string::npos);
            const auto document = metrics_document({ field.metrics })["approaches"][0]["parameter_interval"];
            EXPECT_EQ(document["parameters"].size(), interval.parameters.size());
            EXPECT_EQ(document["force_low_N"], interval.force_low_N);
        }
    }

    TEST(ParameterInterval, ExponentsAreThoseOfPlansWithOtherModuli)
    {
        const auto skin_times = [](double factor) {
            return [factor](Case& planned_case, Approach&) {
                for (fem::Material& material : planned_case.materials)
                    if (material.name == "skin")
                        material.youngs_modulus_MPa *= factor;
            };
        };
        const PlannedField field = plan({}, [](Case&, Approach&) {}), more = plan({}, skin_times(1.1)),
                           less = plan({}, skin_times(0.9));
        ASSERT_TRUE(field.metrics.parameters);
        const std::vector<ParameterInfluence>& all = field.metrics.parameters->parameters;
        const auto skin = std::ranges::find(all, "skin", &ParameterInfluence::name);
        ASSERT_NE(skin, all.end());
        const double step = std::log(1.1 / 0.9);
        EXPECT_NEAR(
            skin->force_exponent, std::log(more.metrics.hook_force_N / less.metrics.hook_force_N) / step, kExponent);
        EXPECT_NEAR(skin->opening_exponent,
            std::log(more.metrics.opening_width_mm / less.metrics.opening_width_mm) / step, kExponent);
    }

    TEST(ParameterInterval, OfHooksThatPullWithAForceIsOneOfTheOpening)
    {
        const PlannedField field = plan({ .elasticity = fem::Elasticity::linear }, [](Case&, Approach& approach) {
            for (HookSpec& hook : approach.hooks) {
                hook.opening_mm = 0.0;
                hook.pull.force_N = 0.5;
            }
        });
        ASSERT_TRUE(field.metrics.parameters);
        const ParameterInterval& interval = *field.metrics.parameters;
        ASSERT_EQ(interval.message, "");
        EXPECT_NEAR(interval.force_low_N, interval.force_high_N, 1e-3 * interval.force_high_N);
        EXPECT_GT(interval.opening_high_mm, 1.1 * interval.opening_low_mm);
        // Linear tissue twice as stiff opens half as far.
        EXPECT_NEAR(sum_of(interval, &ParameterInfluence::opening_exponent), -1.0, kExponent);
    }

    TEST(ParameterInterval, OfARetractorHoldsAtItsBalance)
    {
        // The stiffness with which a blade in contact pushes is no tissue value, and takes a small part.
        constexpr double kPushes = 0.1;
        for (const auto& [hold, bar] : { std::pair { HookHold::fixed, kSum }, { HookHold::contact, kPushes } }) {
            const PlannedField field = plan({ .element = ElementKind::p1 }, [hold = hold](Case&, Approach& approach) {
                approach.hooks.clear();
                approach.sizing.region_mm = 30.0; // the border of the region holds the wall
                RetractorKind kind = find_retractor(built_in_retractors(), "midcab");
                kind.blade_width_mm = 20.0;
                approach.retractor = make_retractor(approach, kind, { .opening_mm = 8.0 });
                approach.retractor->hold = hold;
            });
            ASSERT_TRUE(field.metrics.parameters);
            ASSERT_EQ(field.metrics.parameters->message, "");
            EXPECT_NEAR(sum_of(*field.metrics.parameters, &ParameterInfluence::force_exponent), 1.0, bar);
        }
    }

    TEST(ParameterInterval, SaysWhyThereIsNone)
    {
        const PlannedField near = plan({ .near_mm = 24.0 }, [](Case& c, Approach& approach) {
            c.accept_implausible = true; // no hook is drawn so little
            for (HookSpec& hook : approach.hooks)
                hook.opening_mm = 0.02; // the linear region is then exact enough to be kept
        });
        ASSERT_TRUE(near.metrics.parameters);
        ASSERT_TRUE(near.opening.far && near.opening.far->kept);
        EXPECT_NE(near.metrics.parameters->message.find("linear"), std::string::npos);
        EXPECT_NE(parameter_text(near.metrics).find("no interval from tissue values"), std::string::npos);
        const auto document = metrics_document({ near.metrics })["approaches"][0]["parameter_interval"];
        EXPECT_TRUE(document.contains("message"));
        EXPECT_FALSE(document.contains("force_low_N"));
    }

} // namespace parameter_interval_test
} // namespace retractor::planner
