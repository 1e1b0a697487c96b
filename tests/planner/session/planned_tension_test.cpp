// The case's tension under the knife, against what a plan makes of it.

#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening.h"
#include "planner/wall/wall_cut.h"
#include "planner/wall/wall_tension.h"
#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace retractor::planner {
namespace planned_tension_test {

    SurgerySetup wall_under_tension(const Vec3& pull = Vec3::UnitZ())
    {
        SurgerySetup setup = wall_with_planned_hooks({}, 7.0);
        setup.materials[kSkin].pre_strain
            = { .kind = fem::PreStrainKind::biaxial, .strain = 0.05, .pull = pull, .across = 0.02 };
        setup.materials[kFat].pre_strain = { .kind = fem::PreStrainKind::equibiaxial, .strain = 0.02 };
        return setup;
    }

    struct Opened {
        std::vector<double> hook_forces_N;
        double gape_mm = 0.0; ///< of the widest place
    };

    Opened under_the_knife(const SurgerySetup& setup, double tension)
    {
        SurgerySession live_session(setup);
        live_session.set_tension(tension);
        const auto at = [&](double x) { return *touch(*live_session.picture(), ray_down(x, 60.0)); };
        EXPECT_TRUE(live_session.begin_stroke(at(30.0), { .depth_mm = 20.0 }).done);
        for (double x = 32.0; x <= 90.0; x += 2.0)
            (void)live_session.draw_to(at(x));
        EXPECT_TRUE(live_session.finish_stroke().done);
        EXPECT_TRUE(live_session.take_planned_hooks().done);
        while (live_session.moving())
            live_session.relax(100.0);
        Opened opened { .hook_forces_N = {}, .gape_mm = live_session.gape_mm() };
        for (const HookState& hook : live_session.hooks().hooks)
            opened.hook_forces_N.push_back(hook.force_N.norm());
        return opened;
    }

    /// The same wall, blade and hooks as plan_approach() goes about them.
    Opened as_planned(const SurgerySetup& setup)
    {
        const WallTension tension = wall_tension(setup.wall, setup.materials, setup.labels, setup.held, setup.outward);
        const CutWall cut = cut_wall(setup.wall, setup.approach, setup.labels, { .fixed = setup.held }, {});
        const fem::ElasticProblem problem { .mesh = cut.wall,
            .material_of_label = setup.materials,
            .supports = cut.supports,
            .hooks = cut.hooks,
            .loads = released_tension(cut.wall, cut.origin, cut.wound, tension).tractions };
        fem::Opening opening(problem, { .elasticity = fem::Elasticity::linear, .tolerance = 1e-8 });
        const fem::OpeningResult result = opening.open(problem.hooks);
        Opened opened;
        for (const Vec3& force : result.hook_forces_N)
            opened.hook_forces_N.push_back(force.norm());
        return opened;
    }

    TEST(PlannedTension, HooksBearTheSameUnderTheKnifeAsInAPlan)
    {
        const SurgerySetup setup = wall_under_tension();
        SurgerySetup slack = setup;
        for (fem::Material& material : slack.materials)
            material.pre_strain = {};
        const Opened plan = as_planned(setup), plan_without = as_planned(slack),
                     knife = under_the_knife(setup, SurgerySession(setup).case_tension()),
                     knife_without = under_the_knife(slack, 0.0);
        constexpr double kMeshes = 0.05; // a stroke divides elements otherwise than one blade does
        ASSERT_EQ(knife.hook_forces_N.size(), 2U);
        for (std::size_t h = 0; h < 2; ++h) {
            EXPECT_NEAR(knife.hook_forces_N[h] / plan.hook_forces_N[h], 1.0, kMeshes);
            // What the tension takes off the hooks is alike too.
            const double relief = plan_without.hook_forces_N[h] - plan.hook_forces_N[h];
            EXPECT_GT(relief, 0.1 * plan.hook_forces_N[h]);
            EXPECT_NEAR((knife_without.hook_forces_N[h] - knife.hook_forces_N[h]) / relief, 1.0, 2.0 * kMeshes);
        }
    }

    /// A direction along which the stress of some element is symmetric but for rounding. Whether a direction rounds
    /// depends on the mesh and the compiler, so it is looked for.
    Vec3 direction_that_rounds()
    {
        for (int step = 1; step <= 100; ++step) {
            const double angle = 0.01 * step;
            const Vec3 pull = Vec3(std::sin(angle), 0.1, std::cos(angle)).normalized();
            const SurgerySetup setup = wall_under_tension(pull);
            const WallTension tension
                = wall_tension(setup.wall, setup.materials, setup.labels, setup.held, setup.outward);
            if (std::ranges::any_of(tension.stress_of_element, [](const Mat3& stress) { return stress != stress.transpose(); }))
                return pull;
        }
        throw std::runtime_error("the stress is symmetric to the last bit along every direction tried");
    }

    /// The stress along a slanted direction is symmetric but for rounding: hooks must not be refused for that.
    TEST(PlannedTension, HooksBearTheSameUnderATensionAlongASlantedDirection)
    {
        const SurgerySetup setup = wall_under_tension(direction_that_rounds());
        const Opened plan = as_planned(setup), knife = under_the_knife(setup, SurgerySession(setup).case_tension());
        constexpr double kMeshes = 0.05; // as above
        ASSERT_EQ(knife.hook_forces_N.size(), 2U);
        for (std::size_t h = 0; h < 2; ++h)
            EXPECT_NEAR(knife.hook_forces_N[h] / plan.hook_forces_N[h], 1.0, kMeshes);
    }

    TEST(PlannedTension, TheCasesTensionIsScaledAsAWhole)
    {
        const SurgerySetup setup = wall_under_tension();
        EXPECT_EQ(SurgerySession(setup).case_tension(), 0.05);
        EXPECT_EQ(SurgerySession(wall_with_planned_hooks({}, 7.0)).case_tension(), 0.0);
        // Linear: what the hooks bear falls in proportion to the tension; but the stroke is drawn on a wound that
        // gapes.
        constexpr double kDrawn = 0.02;
        const Opened none = under_the_knife(setup, 0.0), half = under_the_knife(setup, 0.025),
                     all = under_the_knife(setup, 0.05);
        for (std::size_t h = 0; h < 2; ++h)
            EXPECT_NEAR(none.hook_forces_N[h] - half.hook_forces_N[h], half.hook_forces_N[h] - all.hook_forces_N[h],
                kDrawn * (none.hook_forces_N[h] - half.hook_forces_N[h]));
    }

} // namespace planned_tension_test
} // namespace retractor::planner
