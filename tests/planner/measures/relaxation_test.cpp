#include "planner/measures/relaxation.h"

#include "mesh/base/error.h"
#include "planner/case/opening_protocol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace retractor::planner {
namespace relaxation_test {

    constexpr double kRoundOff = 1e-12; ///< relative, of sums with a handful of terms

    /// A standard linear solid: half of the force relaxes with 20 s.
    Relaxation solid() { return { .long_term = 0.5, .terms = { { .share = 0.5, .time_s = 20.0 } } }; }

    std::string refused_at(const Relaxation& relaxation)
    {
        try {
            check_relaxation(relaxation, "/relaxation");
        } catch (const InputError& error) {
            return error.where();
        }
        return "accepted";
    }

    /// The elastic force of a ramp, in many small steps at the middles of equal intervals: the midpoint rule.
    std::vector<ForceStep> fine_steps(double elastic_N, double ramp_s, int count)
    {
        std::vector<ForceStep> steps;
        for (int n = 0; n < count; ++n)
            steps.push_back({ ramp_s * (n + 0.5) / count, elastic_N / count });
        return steps;
    }

    TEST(Relaxation, AStepRelaxesAsTheFunctionSays)
    {
        const std::vector<ForceStep> step { { 5.0, 100.0 } };
        EXPECT_EQ(stepped_force(solid(), step, 4.9), 0.0);
        EXPECT_NEAR(stepped_force(solid(), step, 5.0), 100.0, kRoundOff * 100.0); // G(0) = 1
        EXPECT_NEAR(stepped_force(solid(), step, 25.0), 50.0 + 50.0 * std::exp(-1.0), kRoundOff * 100.0);
        EXPECT_NEAR(stepped_force(solid(), step, 1e6), 50.0, kRoundOff * 100.0); // g_inf F_e
    }

    TEST(Relaxation, OfARampHasAClosedForm)
    {
        // F(T) = F_e (g_inf + g tau / T (1 - exp(-T / tau))); while held, the second term decays.
        const double at_end = 100.0 * (0.5 + 0.5 * 20.0 / 60.0 * (1.0 - std::exp(-3.0)));
        EXPECT_NEAR(ramp_force(solid(), 100.0, 60.0, 60.0), at_end, kRoundOff * 100.0);
        EXPECT_NEAR(ramp_force(solid(), 100.0, 60.0, 80.0), 50.0 + (at_end - 50.0) * std::exp(-1.0), kRoundOff * 100.0);
        EXPECT_EQ(ramp_force(solid(), 100.0, 60.0, -1.0), 0.0);
        EXPECT_EQ(ramp_force(solid(), 100.0, 60.0, 0.0), 0.0);
    }

    TEST(Relaxation, OfARampIsTheConvolution)
    {
        // The midpoint rule's error is of order (step / tau)^2 / 24: 0.03 s of 15 s gives 2e-7.
        constexpr double kMidpoint = 1e-6;
        const Relaxation& wall = chest_wall_relaxation();
        const std::vector<ForceStep> steps = fine_steps(200.0, 90.0, 3000);
        for (const double at : { 90.0, 120.0, 390.0 })
            EXPECT_NEAR(stepped_force(wall, steps, at), ramp_force(wall, 200.0, 90.0, at), kMidpoint * 200.0) << at;
    }

    TEST(Relaxation, HasTheLimitsOfSuddenAndSlowOpening)
    {
        const Relaxation& wall = chest_wall_relaxation();
        EXPECT_NEAR(ramp_force(wall, 200.0, 0.0, 0.0), 200.0, kRoundOff * 200.0);
        // A ramp much faster than the shortest time loses about half its length over that time: 1e-6 s of 15 s.
        EXPECT_NEAR(ramp_force(wall, 200.0, 1e-6, 1e-6), 200.0, 1e-7 * 200.0);
        // A slow ramp keeps g_inf and sum of g_i tau_i / T: 102 s of 1e9 s.
        EXPECT_NEAR(ramp_force(wall, 200.0, 1e9, 1e9), wall.long_term * 200.0, 2e-7 * 200.0);
    }

    TEST(Relaxation, OfTheChestWallLiesWithinThePublishedSpread)
    {
        const Relaxation& wall = chest_wall_relaxation();
        EXPECT_EQ(refused_at(wall), "accepted");
        std::vector<double> peaks;
        for (const PublishedRetraction& row : published_retractions()) {
            OpeningProtocol protocol;
            const int count = step_count(protocol, row.opening_mm);
            protocol.wait_s = row.opened_in_s / (count - 1);
            std::vector<ForceStep> steps;
            for (int n = 0; n < count; ++n)
                steps.push_back({ n * protocol.wait_s, 1.0 / count });
            const double end = steps.back().at_s;
            peaks.push_back(stepped_force(wall, steps, end));
            const double ratio = stepped_force(wall, steps, end + protocol.hold_s) / peaks.back();
            const double published = row.held_N / row.peak_N;
            EXPECT_NEAR(ratio, published, held_deviation() * published) << row.what;
        }
        // The faster opening has the larger peak: 369 over 255 N, and the deviations of these are 30 to 36 %.
        EXPECT_GT(peaks[0], peaks[1]);
        EXPECT_NEAR(peaks[0] / peaks[1], 369.0 / 255.0, 0.3);
    }

    TEST(Relaxation, RefusesBadNumbers)
    {
        EXPECT_EQ(refused_at({}), "accepted"); // elastic
        EXPECT_EQ(refused_at(solid()), "accepted");
        for (const double bad : { -0.1, 1.1, std::numeric_limits<double>::quiet_NaN() }) {
            Relaxation relaxation = solid();
            relaxation.long_term = bad;
            EXPECT_EQ(refused_at(relaxation), "/relaxation/long_term");
            relaxation = solid();
            relaxation.terms[0].share = bad;
            EXPECT_EQ(refused_at(relaxation), "/relaxation/terms/0/share");
        }
        for (const double bad : { 0.0, -1.0, std::numeric_limits<double>::infinity() }) {
            Relaxation relaxation = solid();
            relaxation.terms[0].time_s = bad;
            EXPECT_EQ(refused_at(relaxation), "/relaxation/terms/0/time_s");
        }
        Relaxation relaxation = solid();
        relaxation.long_term = 0.4;
        EXPECT_EQ(refused_at(relaxation), "/relaxation/terms");
    }

} // namespace relaxation_test
} // namespace retractor::planner
