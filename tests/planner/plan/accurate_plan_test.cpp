#include "planner/plan/accurate_plan.h"

#include "mesh/base/error.h"
#include "mesh/base/memory.h"
#include "planner/plan/plan_forecast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace accurate_plan_test {

    constexpr double kEdgeMm = 8.0, kForceN = 100.0;
    constexpr double kRoundOff = 1e-12; ///< mm, and shares
    constexpr AccuracyGoal kGoal { .force = 0.15, .opening_mm = 2.0, .time_s = 600.0 };

    /// Error bars of one mesh: the share of the force, mm of the opening.
    struct Bars {
        double force, opening_mm;
    };

    PlannedField field_with(Bars bars, double edge_mm)
    {
        PlannedField field;
        field.approach.sizing.corridor_edge_mm = edge_mm;
        FieldMetrics& m = field.metrics;
        m.tets = static_cast<std::size_t>(1e4 * std::pow(kEdgeMm / edge_mm, 3));
        m.hooks = { { "left", 1, kForceN }, { "right", -1, kForceN } };
        m.hook_force_N = kForceN;
        ErrorBars& error = m.error.emplace();
        error.hook_force_N = bars.force * kForceN;
        error.opening_width_mm = bars.opening_mm;
        return field;
    }

    /// Plans without meshing: the bars of each mesh are given, and a clock runs by the seconds of each plan.
    class Planner {
    public:
        explicit Planner(std::vector<Bars> bars)
            : bars_(std::move(bars))
        {
        }

        PlannedField search(const AccuracyGoal& goal = kGoal)
        {
            const AccuracySearch asked {
                .goal = goal, .element = element, .memory_bytes = memory_bytes, .elapsed_s = [this] { return clock_; }
            };
            return plan_to_accuracy(asked, [this](double factor) { return round(factor); });
        }

        double round_s = 1.0; ///< of the first mesh; later ones take as much more as their forecasts say
        ElementKind element = ElementKind::p2;
        std::optional<double> memory_bytes;
        /// Changes the field of a round, or throws.
        std::function<void(std::size_t round, PlannedField& field)> change;
        std::vector<double> factors; ///< of the edges, that were asked for

    private:
        PlannedField round(double factor)
        {
            const std::size_t n = factors.size();
            factors.push_back(factor);
            PlannedField field = field_with(bars_.at(std::min(n, bars_.size() - 1)), factor * kEdgeMm);
            const double tets = static_cast<double>(field.metrics.tets);
            clock_ += round_s * forecast_plan(tets, element).seconds / forecast_plan(1e4, element).seconds;
            if (change)
                change(n, field);
            return field;
        }

        std::vector<Bars> bars_;
        double clock_ = 0.0;
    };

    TEST(AccuratePlan, OneMeshIsEnoughWhereItsBarsAreSmall)
    {
        Planner planner({ { 0.1, 1.5 } });
        const PlannedField field = planner.search();
        ASSERT_TRUE(field.metrics.accuracy);
        const AccuracyMetrics& accuracy = *field.metrics.accuracy;
        EXPECT_EQ(planner.factors, std::vector<double> { 1.0 });
        EXPECT_EQ(accuracy.ended_by, AccuracyEnd::reached);
        EXPECT_EQ(accuracy.asked, kGoal);
        EXPECT_EQ(accuracy.rounds, 1);
        EXPECT_NEAR(accuracy.reached_force.value(), 0.1, kRoundOff);
        EXPECT_NEAR(accuracy.reached_opening_mm.value(), 1.5, kRoundOff);
        EXPECT_NEAR(accuracy.edge_mm, kEdgeMm, kRoundOff);
    }

    TEST(AccuratePlan, RefinesUntilBothBarsAreSmall)
    {
        Planner planner({ { 0.3, 3.0 }, { 0.1, 2.5 }, { 0.09, 1.9 } });
        const PlannedField field = planner.search();
        const AccuracyMetrics& accuracy = field.metrics.accuracy.value();
        EXPECT_EQ(accuracy.ended_by, AccuracyEnd::reached);
        EXPECT_EQ(accuracy.rounds, 3);
        EXPECT_NEAR(accuracy.reached_force.value(), 0.09, kRoundOff);
        ASSERT_EQ(planner.factors.size(), 3u);
        EXPECT_NEAR(planner.factors[1], 0.8, kRoundOff);
        EXPECT_NEAR(planner.factors[2], 0.64, kRoundOff);
        EXPECT_NEAR(accuracy.edge_mm, 0.64 * kEdgeMm, kRoundOff);
        EXPECT_NEAR(field.approach.sizing.corridor_edge_mm, 0.64 * kEdgeMm, kRoundOff);
    }

    TEST(AccuratePlan, AnswerThatMeetsBothIsKeptThoughAnotherHasASmallerForceBar)
    {
        Planner planner({ { 0.05, 3.0 }, { 0.1, 1.0 } });
        const PlannedField field = planner.search();
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::reached);
        EXPECT_NEAR(field.metrics.accuracy->reached_force.value(), 0.1, kRoundOff);
    }

    TEST(AccuratePlan, EndsAfterFourMeshesWithTheSmallestForceBar)
    {
        Planner planner({ { 0.5, 5.0 }, { 0.3, 4.0 }, { 0.2, 3.0 }, { 0.25, 2.5 } });
        const PlannedField field = planner.search();
        const AccuracyMetrics& accuracy = field.metrics.accuracy.value();
        EXPECT_EQ(accuracy.ended_by, AccuracyEnd::rounds);
        EXPECT_EQ(accuracy.rounds, 4);
        EXPECT_EQ(planner.factors.size(), 4u);
        EXPECT_NEAR(accuracy.reached_force.value(), 0.2, kRoundOff);
        EXPECT_NEAR(accuracy.reached_opening_mm.value(), 3.0, kRoundOff);
        EXPECT_NEAR(field.approach.sizing.corridor_edge_mm, 0.64 * kEdgeMm, kRoundOff) << "the kept answer's";
        EXPECT_NEAR(accuracy.edge_mm, 0.512 * kEdgeMm, kRoundOff) << "the finest that was tried";
    }

    TEST(AccuratePlan, DoesNotBeginAMeshThatTakesTooLong)
    {
        // The second mesh takes 2.7 times as long as the first, and the third 7.5 times as long.
        Planner planner({ { 0.5, 5.0 } });
        planner.round_s = 100.0;
        const PlannedField field = planner.search();
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::time);
        EXPECT_EQ(field.metrics.accuracy->rounds, 2);
        EXPECT_EQ(planner.factors.size(), 2u);
        Planner slower({ { 0.5, 5.0 } });
        slower.round_s = 200.0;
        EXPECT_EQ(slower.search().metrics.accuracy->rounds, 1);
        Planner patient({ { 0.5, 5.0 } });
        patient.round_s = 200.0;
        AccuracyGoal longer = kGoal;
        longer.time_s = 1e5;
        EXPECT_EQ(patient.search(longer).metrics.accuracy->ended_by, AccuracyEnd::rounds);
    }

    TEST(AccuratePlan, DoesNotBeginAMeshThatDoesNotFit)
    {
        Planner planner({ { 0.5, 5.0 } });
        planner.memory_bytes = forecast_plan(1.5e4, planner.element).bytes; // the second mesh has 2e4 tetrahedra
        const PlannedField field = planner.search();
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::memory);
        EXPECT_EQ(planner.factors.size(), 1u);
        Planner roomier({ { 0.5, 5.0 } });
        roomier.memory_bytes = forecast_plan(2.5e4, roomier.element).bytes;
        EXPECT_EQ(roomier.search().metrics.accuracy->rounds, 2);
    }

    TEST(AccuratePlan, AMeshThatTurnsOutTooLargeEndsTheSearch)
    {
        Planner planner({ { 0.5, 5.0 } });
        planner.change = [](std::size_t round, PlannedField&) {
            if (round == 1)
                throw MemoryRefusal("too large");
        };
        const PlannedField field = planner.search();
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::memory);
        EXPECT_EQ(field.metrics.accuracy->rounds, 1);
        EXPECT_NEAR(field.metrics.accuracy->reached_force.value(), 0.5, kRoundOff);
    }

    TEST(AccuratePlan, AFailureAfterTheFirstMeshKeepsTheAnswerAndSaysSo)
    {
        const std::vector<std::function<void(PlannedField&)>> failures {
            [](PlannedField&) { throw SolverError("the matrix is singular"); },
            [](PlannedField&) { throw InputError("the matrix is singular"); },
            [](PlannedField& field) {
                field.status = PlanStatus::not_converged;
                field.message = "the matrix is singular";
            },
        };
        for (const auto& fail : failures) {
            Planner planner({ { 0.5, 5.0 }, { 0.3, 3.0 }, { 0.1, 1.0 } });
            planner.change = [&](std::size_t round, PlannedField& field) {
                if (round == 2)
                    fail(field);
            };
            const PlannedField field = planner.search();
            const AccuracyMetrics& accuracy = field.metrics.accuracy.value();
            EXPECT_EQ(field.status, PlanStatus::done);
            EXPECT_EQ(accuracy.ended_by, AccuracyEnd::failure);
            EXPECT_EQ(accuracy.rounds, 2);
            EXPECT_NEAR(accuracy.reached_force.value(), 0.3, kRoundOff);
            EXPECT_NEAR(accuracy.edge_mm, 0.8 * kEdgeMm, kRoundOff);
            EXPECT_NE(accuracy.message.find("the matrix is singular"), std::string::npos) << accuracy.message;
        }
    }

    TEST(AccuratePlan, TheFirstMeshFailsAsWithoutASearch)
    {
        Planner planner({ { 0.5, 5.0 } });
        planner.change = [](std::size_t, PlannedField&) { throw SolverError("the body floats"); };
        EXPECT_THROW(static_cast<void>(planner.search()), SolverError);
        Planner broken({ { 0.5, 5.0 } });
        broken.change = [](std::size_t round, PlannedField&) {
            if (round == 1)
                throw std::logic_error("a bug");
        };
        EXPECT_THROW(static_cast<void>(broken.search()), std::logic_error) << "bugs are not hidden";
        Planner missed({ { 0.5, 5.0 } });
        missed.change = [](std::size_t, PlannedField& field) { field.status = PlanStatus::cut_missed; };
        const PlannedField field = missed.search();
        EXPECT_EQ(field.status, PlanStatus::cut_missed);
        EXPECT_FALSE(field.metrics.accuracy);
        EXPECT_EQ(missed.factors.size(), 1u);
    }

    TEST(AccuratePlan, AWoundThatDoesNotOpenIsNotPlannedAgain)
    {
        Planner planner({ { 0.5, 5.0 } });
        planner.change = [](std::size_t, PlannedField& field) {
            field.status = PlanStatus::not_converged;
            field.metrics.error->message = "the wound did not open as requested";
        };
        const PlannedField field = planner.search();
        EXPECT_EQ(planner.factors.size(), 1u);
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::failure);
        EXPECT_FALSE(field.metrics.accuracy->reached_opening_mm);
    }

    TEST(AccuratePlan, CancellingEndsWithTheCancelledField)
    {
        for (const std::size_t when : { 0U, 1U }) {
            Planner planner({ { 0.5, 5.0 } });
            planner.change = [&](std::size_t round, PlannedField& field) {
                if (round == when)
                    field.status = PlanStatus::cancelled;
            };
            EXPECT_EQ(planner.search().status, PlanStatus::cancelled);
            EXPECT_EQ(planner.factors.size(), when + 1);
        }
    }

    TEST(AccuratePlan, WithoutBarsAFinerMeshIsTried)
    {
        Planner planner({ { 0.1, 1.0 } });
        planner.change = [](std::size_t round, PlannedField& field) {
            if (round == 0)
                field.metrics.error->message = "the elements are too flat";
        };
        const PlannedField field = planner.search();
        EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::reached);
        EXPECT_EQ(field.metrics.accuracy->rounds, 2);
        EXPECT_NEAR(field.metrics.accuracy->reached_force.value(), 0.1, kRoundOff);
    }

    TEST(AccuratePlan, KnownOrMissingForcesAreNotJudged)
    {
        const std::vector<std::function<void(FieldMetrics&)>> changes {
            [](FieldMetrics& m) {
                for (HookForce& hook : m.hooks)
                    hook.pull.force_N = kForceN;
            },
            [](FieldMetrics& m) { m.retractor.emplace().asked_force_N = kForceN; },
            [](FieldMetrics& m) {
                m.hooks.clear();
                m.hook_force_N = 0.0;
            },
        };
        for (const auto& change : changes) {
            Planner planner({ { 0.5, 3.0 }, { 0.5, 2.5 }, { 0.6, 1.5 } });
            planner.change = [&](std::size_t, PlannedField& field) { change(field.metrics); };
            const PlannedField field = planner.search();
            EXPECT_EQ(field.metrics.accuracy->ended_by, AccuracyEnd::reached);
            EXPECT_EQ(field.metrics.accuracy->rounds, 3);
            EXPECT_FALSE(field.metrics.accuracy->reached_force);
            EXPECT_NEAR(field.metrics.accuracy->reached_opening_mm.value(), 1.5, kRoundOff);
        }
    }

} // namespace accurate_plan_test
} // namespace retractor::planner
