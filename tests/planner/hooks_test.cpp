#include "planner/hooks.h"

#include "mesh/base/error.h"
#include "mesh/blade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor {
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
            const SweptBlade blade(blade_of(approach));
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
} // namespace retractor
