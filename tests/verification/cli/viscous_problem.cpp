#include "tests/verification/cli/viscous_problem.h"

#include "haptics/springs/spring_motion.h"
#include "tests/support/haptics/spring_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kStiffness = 0.5; // N/mm
    constexpr double kMass = 1e-9; // tonne: small enough for an intrinsic time, mass over dashpot, of at most 1e-7 s
    constexpr double kBarLength = 10.0, kStretch = 1.0; // mm
    constexpr double kForce = 0.3; // N
    constexpr double kDuration = 1.0; // s
    constexpr std::array kSteps { 6e-5, 3e-5, 1.5e-5, 7.5e-6 }; // s; the last one for the fine series only
    constexpr std::size_t kUsualSteps = 3;

    struct Test {
        std::string problem, law, quantity;
        haptics::ElementLaw element;
        bool stretched = false; ///< stretched and held (relaxation), or pulled by a force (creep)
        std::function<double(double time)> right; ///< elongation (mm) under the force, or force (N) when stretched
        double expected_order = 1.0, bound = 0.0;
    };

    /// k x + c x' + q = F with q' = k1 x' - q / arm_time, from x = q = 0: the sum of two exponentials.
    double creep_with_arm(const haptics::ElementLaw& law, double time)
    {
        const double k = kStiffness, c = k * law.voigt_time, k1 = k * law.arm_ratio;
        const double a = c * law.arm_time, b = c + (k + k1) * law.arm_time;
        const double root = std::sqrt(b * b - 4.0 * a * k);
        const double fast = -(b + root) / (2.0 * a), slow = -2.0 * k / (b + root);
        const double of_fast = kForce * (1.0 / c + slow / k) / (fast - slow);
        return kForce / k * (1.0 - std::exp(slow * time)) + of_fast * (std::exp(fast * time) - std::exp(slow * time));
    }

    std::vector<Test> tests()
    {
        const haptics::ElementLaw voigt { .voigt_time = 0.2, .drag = 0.0 };
        const haptics::ElementLaw solid { .voigt_time = 0.0, .arm_ratio = 0.8, .arm_time = 0.5, .drag = 0.0 };
        const haptics::ElementLaw damped { .voigt_time = 0.02, .arm_ratio = 1.0, .arm_time = 0.1, .drag = 0.0 };
        constexpr double kShare = 1e-3; // relative to the error of the longest of the three steps
        constexpr double kRoundOff = 1e-12;
        return {
            { "Voigt element, creep", "Voigt", "largest error of the elongation over its limit", voigt, false,
                [=](double t) { return kForce / kStiffness * (1.0 - std::exp(-t / voigt.voigt_time)); }, 1.0, kShare },
            { "Voigt element, held stretched", "Voigt", "largest error of the force over its first: no relaxation",
                voigt, true, [](double) { return kStiffness * kStretch; }, std::numeric_limits<double>::quiet_NaN(),
                kRoundOff },
            { "standard linear solid, relaxation", "standard linear solid", "largest error of the force over its first",
                solid, true,
                [=](double t) {
                    return kStiffness * kStretch * (1.0 + solid.arm_ratio * std::exp(-t / solid.arm_time));
                },
                1.0, kShare },
            { "standard linear solid, creep", "solid with dashpot", "largest error of the elongation over its limit",
                damped, false, [=](double t) { return creep_with_arm(damped, t); }, 1.0, kShare },
        };
    }

    VerificationRow run(const Test& test, double dt)
    {
        haptics::SpringMotion motion(
            test_support::spring_element(kBarLength, kStiffness, kMass, test.stretched), test.element);
        if (test.stretched) {
            motion.place(1, Vec3(kBarLength + kStretch, 0.0, 0.0));
        } else {
            motion.set_load(1, Vec3(kForce, 0.0, 0.0));
        }
        VerificationRow row;
        row.problem = test.problem;
        row.element = "spring element";
        row.law = test.law;
        row.nodes = 2;
        row.size = std::isnan(test.expected_order) ? 0.0 : dt / kSteps[0]; // 0: exact at any step, so there is no curve
        double worst = 0.0, largest = 0.0;
        const Stopwatch watch;
        for (int i = 1; i * dt <= kDuration; ++i) {
            motion.step(dt);
            // A step computes forces at its beginning and positions at its end.
            const double right = test.right(test.stretched ? (i - 1) * dt : i * dt);
            const double ours = test.stretched ? -motion.element_force(1).x() : motion.position(1).x() - kBarLength;
            worst = std::max(worst, std::abs(ours - right));
            largest = std::max(largest, right);
        }
        row.seconds = watch.seconds();
        compare(row, test.quantity, worst / largest, 0.0);
        std::array<char, 32> text {};
        (void)std::snprintf(text.data(), text.size(), "steps of %.3g us", 1e6 * dt);
        row.note = text.data();
        return row;
    }

} // namespace

VerificationProblem viscous_problem()
{
    return { "viscous elements",
        "Voigt: e = s / E (1 - exp(-E t / eta)), which does not relax; the standard linear solid does: one element in "
        "time, at three steps",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const Test& test : tests()) {
                std::vector<VerificationRow> series;
                for (std::size_t i = 0; i < (options.fine ? kSteps.size() : kUsualSteps) && !job.cancelled(); ++i)
                    series.push_back(run(test, kSteps[i]));
                if (std::isnan(test.expected_order)) // exact at any step
                    for (VerificationRow& row : series)
                        row.bound = test.bound;
                append_series(rows, series, test.expected_order, test.bound);
            }
            return rows;
        } };
}

} // namespace retractor::verification
