#include "planner/approach/hooks.h"

#include "mesh/base/error.h"
#include "mesh/cutting/store/blade.h"
#include "planner/measures/metrics.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/planned_field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace retractor::planner {
namespace hooks_test {

    /// 100 mm along y on the plane z = 0, straight down.
    Approach straight()
    {
        Approach approach;
        approach.name = "straight";
        for (int n = 0; n <= 10; ++n) {
            approach.incision.emplace_back(0.0, 10.0 * n, 0.0);
            approach.directions.emplace_back(0.0, 0.0, -1.0);
            approach.wall_thickness_mm.push_back(30.0);
            approach.hook_depth_mm.push_back(18.0);
        }
        approach.depth_mm = 35.0;
        approach.target.radius_mm = 10.0;
        return approach;
    }

    /// A quarter of a circle round z, blade towards the axis.
    Approach curved()
    {
        Approach approach = straight();
        for (std::size_t n = 0; n < approach.incision.size(); ++n) {
            const double angle = 0.15 * static_cast<double>(n);
            approach.directions[n] = -Vec3(std::cos(angle), std::sin(angle), 0.0);
            approach.incision[n] = -100.0 * approach.directions[n];
        }
        return approach;
    }

    TEST(Hooks, StandEvenlyOverTheMiddleOfTheIncision)
    {
        const auto hooks = make_hooks(straight(), "4", 60.0);
        ASSERT_EQ(hooks.size(), 4u);
        const double along[] = { 30.0, 70.0, 30.0, 70.0 }; // 10 + 80 (n + 1/2) / 2
        for (std::size_t h = 0; h < 4; ++h) {
            EXPECT_NEAR(hooks[h].along_mm, along[h], 1e-12);
            EXPECT_NEAR(hooks[h].depth_mm, 15.0, 1e-12);
            EXPECT_EQ(hooks[h].side, h < 2 ? 1 : -1);
            EXPECT_EQ(hooks[h].opening_mm, 30.0);
            EXPECT_LT((hooks[h].direction - Vec3(-hooks[h].side, 0.0, 0.0)).norm(),
                1e-12); // left of +y, seen from above, is -x
        }
        EXPECT_EQ(make_hooks(straight(), "2", 1.0).size(), 2u);
        EXPECT_EQ(make_hooks(straight(), "8", 1.0).size(), 8u);
    }

    TEST(Hooks, CannotOpenAWoundFartherThanItsSkinStretches)
    {
        Approach approach = straight(); // 100 mm
        approach.hooks = make_hooks(approach, "2", 170.0);
        EXPECT_NO_THROW(check_approach(approach));
        approach.hooks = make_hooks(approach, "2", 172.0);
        try {
            check_approach(approach);
            ADD_FAILURE() << "an opening of 172 mm was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "/hooks");
            EXPECT_NE(std::string(error.what()).find("hooks open 172 mm"), std::string::npos) << error.what();
        }
    }

    /// Two hooks on lips +1 and -1, opened with these forces.
    PlannedField opened_with(const std::vector<Vec3>& forces_N)
    {
        PlannedField field;
        field.approach.hooks = { { .name = "left", .side = 1, .direction = -Vec3::UnitX() },
            { .name = "right", .side = -1, .direction = Vec3::UnitX() } };
        field.hooks = { { "left", 1, {}, Vec3::Zero() }, { "right", -1, {}, Vec3::Zero() } };
        field.opening.hook_forces_N = forces_N;
        return field;
    }

    std::vector<bool> pushing(const PlannedField& field)
    {
        return pushing_hooks(field.approach, field.opening.hook_forces_N);
    }

    TEST(Hooks, PushOnlyWhereMostOfTheirForceHoldsTheLipBack)
    {
        const double aside = 8.0; // N
        for (const double along : { -0.0011, -0.0009, 0.0, 0.001 }) { // of the second one's, next to nothing of it
            const PlannedField field = opened_with({ Vec3(-1.0, 0.0, 0.0), Vec3(along, aside, 0.0) });
            EXPECT_EQ(pushing(field), std::vector<bool>({ false, false })) << along;
            EXPECT_NEAR(side_forces(field, field.opening.hook_forces_N)[1], aside, 1e-6) << along;
        }
        const PlannedField pushed = opened_with({ Vec3(-5.0, 0.0, 0.0), Vec3(-2.0, 0.5, 0.0) });
        EXPECT_EQ(pushing(pushed), std::vector<bool>({ false, true }));
        EXPECT_EQ(side_forces(pushed, pushed.opening.hook_forces_N), (std::array<double, 2> { 5.0, 0.0 }));
        // Nothing is nothing beside what the others bear, however little that is.
        EXPECT_EQ(
            pushing(opened_with({ Vec3(-5.0, 0.0, 0.0), Vec3(-2e-3, 0.0, 0.0) })), std::vector<bool>({ false, false }));
        EXPECT_EQ(
            pushing(opened_with({ Vec3(-5e-6, 0.0, 0.0), Vec3(-2e-6, 0.0, 0.0) })), std::vector<bool>({ false, true }));
        EXPECT_EQ(pushing(opened_with({ Vec3::Zero(), Vec3::Zero() })), std::vector<bool>({ false, false }));
    }

    TEST(Hooks, ThatPushInOneAnswerDoNotComeAndGoWithTheOthers)
    {
        const PlannedField field = opened_with({ Vec3(-5.0, 0.0, 0.0), Vec3(-4.0, 3.9, 0.0) });
        ASSERT_TRUE(pushing(field)[1]);
        const std::vector<Vec3> other { Vec3(-5.0, 0.0, 0.0), Vec3(-4.0, 4.1, 0.0) };
        EXPECT_EQ(side_forces(field, other), side_forces(field, field.opening.hook_forces_N));
    }

    TEST(Hooks, ThatPushSayHowFarTheyWentAndThatTheyYielded)
    {
        FieldMetrics field;
        field.hooks = { { .name = "left",
            .side = 1,
            .force_N = 1.0,
            .pushes = true,
            .moved_mm = 5.1,
            .asked_mm = 2.0,
            .pull = { .force_limit_N = 1.0 },
            .yielded = true } };
        const std::string back = "hook left holds back its lip, which would move farther without the hook:";
        EXPECT_EQ(hooks_text(field), back + " yields at 1.0 N: 5.1 of 2.0 mm");
        field.hooks[0].pull = {};
        EXPECT_EQ(hooks_text(field), back + " 1.0 N");
    }

    TEST(Hooks, BladesOfOneLipAreParallelOnACurvedIncision)
    {
        const auto hooks = make_hooks(curved(), "4", 60.0);
        ASSERT_EQ(hooks.size(), 4u);
        EXPECT_LT((hooks[0].direction - hooks[1].direction).norm(), 1e-12);
        EXPECT_LT((hooks[0].direction + hooks[2].direction).norm(), 1e-12);
        EXPECT_NEAR(hooks[0].direction.norm(), 1.0, 1e-12);
        EXPECT_NEAR(std::abs(hooks[0].direction.z()), 1.0, 1e-9); // square to the circle's plane
    }

    TEST(Hooks, SpreaderIsWide)
    {
        const auto hooks = make_hooks(straight(), "blade", 60.0);
        ASSERT_EQ(hooks.size(), 2u);
        EXPECT_NEAR(hooks[0].patch_width_mm, 50.0, 1e-12);
        EXPECT_NEAR(hooks[0].along_mm, 50.0, 1e-12);
    }

    TEST(Hooks, PullAwayFromTheOtherLip)
    {
        for (const Approach& approach : { straight(), curved() }) {
            const mesh::SweptBlade blade(blade_of(approach));
            for (const HookSpec& hook : make_hooks(approach, "8", 40.0)) {
                EXPECT_NEAR(hook.direction.norm(), 1.0, 1e-12);
                const Vec3 place = blade.at(hook.along_mm, hook.depth_mm);
                EXPECT_GT(hook.side * blade.coordinates(place + 5.0 * hook.direction).side, 4.5);
            }
        }
    }

    TEST(Hooks, PatchStaysOnTheLip)
    {
        Approach thin = straight();
        thin.wall_thickness_mm.assign(11, 12.0);
        for (const HookSpec& hook : make_hooks(thin, "4", 10.0)) {
            EXPECT_GT(hook.depth_mm - 0.5 * hook.patch_height_mm, 0.0);
            EXPECT_LT(hook.depth_mm + 0.5 * hook.patch_height_mm, 12.0);
        }
        Approach deep = straight();
        deep.hook_depth_mm.assign(11, 29.0);
        for (const HookSpec& hook : make_hooks(deep, "4", 10.0))
            EXPECT_LT(hook.depth_mm + 0.5 * hook.patch_height_mm, 30.0);
    }

    TEST(Hooks, AllOfASetPullAlike)
    {
        for (const HookSpec& hook :
            make_hooks(straight(), "4", 60.0, { .force_limit_N = 20.0, .grip_N_per_mm = 3.0 })) {
            EXPECT_EQ(hook.opening_mm, 30.0);
            EXPECT_EQ(hook.pull.force_limit_N, 20.0);
            EXPECT_EQ(hook.pull.grip_N_per_mm, 3.0);
            EXPECT_FALSE(hook.pull.force_N.has_value());
        }
    }

    TEST(Hooks, PullsThatContradictThemselvesAreRefusedByName)
    {
        Approach approach = straight();
        approach.target.label = "target";
        const auto refusal = [&](const HookPull& pull, double opening_mm) -> std::string {
            approach.hooks = make_hooks(straight(), "2", opening_mm);
            approach.hooks[1].pull = pull;
            try {
                check_approach(approach, "/approaches/0");
            } catch (const InputError& error) {
                return error.where();
            }
            return "";
        };
        EXPECT_EQ(refusal({ .force_N = 5.0 }, 0.0), "");
        EXPECT_EQ(refusal({ .force_limit_N = 5.0, .grip_N_per_mm = 1.0 }, 10.0), "");
        const std::string hook = "/approaches/0/hooks/1/";
        EXPECT_EQ(refusal({ .force_N = -5.0 }, 0.0), hook + "force_N");
        EXPECT_EQ(refusal({ .force_limit_N = std::numeric_limits<double>::quiet_NaN() }, 10.0), hook + "force_limit_N");
        EXPECT_EQ(refusal({ .grip_N_per_mm = 0.0 }, 10.0), hook + "grip_N_per_mm");
        EXPECT_EQ(refusal({ .grip_N_per_mm = 1e-12 }, 10.0), hook + "grip_N_per_mm"); // holds nothing
        EXPECT_EQ(refusal({ .force_N = 5.0 }, 10.0), hook + "opening_mm, " + hook + "force_N");
        EXPECT_EQ(refusal({ .force_N = 5.0, .force_limit_N = 6.0 }, 0.0), hook + "force_N, " + hook + "force_limit_N");
        EXPECT_EQ(refusal({ .force_N = 5.0, .grip_N_per_mm = 6.0 }, 0.0), hook + "force_N, " + hook + "grip_N_per_mm");
    }

    TEST(Hooks, BadRequestsAreRefused)
    {
        EXPECT_THROW(make_hooks(straight(), "3", 10.0), InputError);
        EXPECT_THROW(make_hooks(straight(), "", 10.0), InputError);
        EXPECT_THROW(make_hooks(straight(), "4", -1.0), InputError);
        EXPECT_NO_THROW(make_hooks(straight(), "4", 300.0));
        EXPECT_THROW(make_hooks(straight(), "4", 301.0), InputError); // no wound is opened so far
        EXPECT_THROW(make_hooks(straight(), "4", std::numeric_limits<double>::quiet_NaN()), InputError);
        Approach paper = straight();
        paper.wall_thickness_mm.assign(11, 3.0);
        EXPECT_THROW(make_hooks(paper, "2", 10.0), InputError);
        Approach brief = straight();
        brief.incision.resize(4);
        brief.directions.resize(4);
        brief.wall_thickness_mm.clear();
        brief.hook_depth_mm.clear();
        EXPECT_THROW(make_hooks(brief, "8", 10.0), InputError); // 30 mm for four patches of 10 mm on each lip
    }

} // namespace hooks_test
} // namespace retractor::planner
