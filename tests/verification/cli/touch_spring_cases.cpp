// Time steps of the springs that fingers press.

#include "haptics/springs/spring_tissue.h"
#include "tests/verification/cli/touch_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

    /// Springs that are plucked and swing without drag or dashpots: the motion must stay bounded.
    void swing(StabilityRow& row, double share, double arm_ratio)
    {
        haptics::SpringMotion motion(
            haptics::make_spring_sheet(), { .voigt_time = 0.0, .arm_ratio = arm_ratio, .drag = 0.0 });
        const Points rest = motion.positions();
        constexpr double kPluck = 0.01; // mm
        for (VertexId v = 0; v < static_cast<VertexId>(rest.rows()); ++v)
            if (!motion.is_held(v)) // all frequencies
                motion.place(v, motion.position(v) + kPluck * Vec3(std::sin(v), std::cos(3.0 * v), std::sin(2.0 * v)));
        double most = 0.0;
        constexpr int kSteps = 3000;
        for (int i = 0; i < kSteps; ++i) {
            motion.step(share * motion.stable_step());
            most = std::max(most, Points(motion.positions() - rest).cwiseAbs().maxCoeff());
        }
        row.quantity = "largest excursion over the pluck, after 3,000 steps";
        row.error = most / kPluck;
        row.bound = 20.0; // many modes superpose; an unstable step grows by powers of ten
        row.residual = 0.0; // no system is solved
        std::array<char, 64> text {};
        (void)std::snprintf(text.data(), text.size(), "bound %.4g us, certain", 1e6 * motion.stable_step());
        row.reason = text.data();
        row.unconditioned = Unconditioned::explicit_steps;
    }

    void step_by(StabilityRow& row, const std::function<double(double)>& dt)
    {
        row.unconditioned = Unconditioned::explicit_steps;
        haptics::SpringMotion motion(haptics::make_spring_sheet(), {});
        motion.step(dt(motion.stable_step()));
        row.residual = row.error = 0.0;
    }

} // namespace

StabilityCase touch_spring_step_case()
{
    return { "time steps of springs under fingers",
        "up to the bound the motion stays bounded; beyond it, or where a tick would need too many, it is refused",
        [](const Job&) {
            std::vector<StabilityRow> rows;
            for (const auto& [name, share] : { std::pair { "half the bound", 0.5 },
                     std::pair { "0.99 of the bound", 0.99 }, std::pair { "the bound itself", 1.0 } })
                for (const auto& [law, arm] :
                    { std::pair { "touched springs", 0.0 }, std::pair { "touched springs, Maxwell arms", 0.8 } })
                    rows.push_back(attempt(std::string("time step: ") + name, law,
                        [&, s = share, a = arm](StabilityRow& row) { swing(row, s, a); }));
            const auto refused = [&](const char* name, const std::function<double(double)>& dt) {
                rows.push_back(expect_refusal(std::string("time step: ") + name, "touched springs",
                    "beyond the springs' stability bound", [&](StabilityRow& row) { step_by(row, dt); }));
            };
            refused("1.01 of the bound", [](double bound) { return 1.01 * bound; });
            refused("ten times the bound", [](double bound) { return 10.0 * bound; });
            refused("NaN", [](double) { return kNoNumber; });
            refused("zero", [](double) { return 0.0; });
            refused("negative", [](double bound) { return -bound; });
            rows.push_back(expect_refusal(
                "springs of 10,000 N/mm", "touched springs", "too stiff for their mass", [](StabilityRow& row) {
                    row.unconditioned = Unconditioned::explicit_steps;
                    const haptics::SpringTissue tissue(haptics::make_spring_sheet({ .stiffness = 1e4 }), {});
                    row.residual = row.error = 0.0;
                }));
            return rows;
        } };
}

std::vector<StabilityCase> touch_cases()
{
    return { device_fault_case(), bone_touch_case(), touch_spring_step_case() };
}

} // namespace retractor::verification
