// Plans of walls under tension, against the closed form of a cut sheet (tests/verification/framework/tension.h) and
// against each other.

#include "mesh/base/error.h"
#include "planner/measures/metrics.h"
#include "planner/plan/plan.h"
#include "planner/wall/wall_tension.h"
#include "tests/support/block_case.h"
#include "tests/verification/framework/tension.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace retractor::planner {
namespace tension_plan_test {

    constexpr double kStrain = 0.04, kLess = 0.01, kRatio = 0.3;
    constexpr double kCutMm = 50.0;

    /// The cut runs along z, so x is across it.
    fem::PreStrain biaxial(double along_x, double across_x)
    {
        return { .kind = fem::PreStrainKind::biaxial, .strain = along_x, .pull = Vec3::UnitX(), .across = across_x };
    }

    struct Block {
        double width_mm = 110.0, region_mm = 30.0;
        SolverSettings solution { .elasticity = fem::Elasticity::linear };
        ContactMode contact = ContactMode::never;
    };

    /// One tissue through and through, held where its region ends, planned with hooks that open it to a
    /// width, or without hooks.
    PlannedField plan_under(const fem::PreStrain& tension, std::optional<double> opening_mm, const Block& block = {})
    {
        datasets::BlockParameters parameters;
        parameters.size_mm = { block.width_mm, 70.0, block.width_mm };
        parameters.spacing_mm = Vec3::Constant(3.0);
        static int count = 0;
        Case planned_case
            = test_support::block_case("tension_" + std::to_string(++count), datasets::make_block_phantom(parameters));
        planned_case.solution = block.solution;
        planned_case.contact = block.contact;
        planned_case.accept_implausible = true; // every tissue gets the same modulus, also bone
        for (fem::Material& material : planned_case.materials) {
            material.youngs_modulus_MPa = 0.1;
            material.poissons_ratio = kRatio;
            material.pre_strain = tension;
        }
        Patient patient(planned_case);
        Approach approach
            = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), opening_mm.value_or(0.0));
        if (!opening_mm)
            approach.hooks.clear();
        approach.sizing.region_mm = block.region_mm;
        approach.sizing.corridor_edge_mm = 10.0;
        approach.sizing.coarse_edge_mm = 20.0;
        approach.view.eye_count = 1;
        return plan_approach(patient, approach);
    }

    TEST(PlanUnderTension, AWoundWithoutHooksGapesAsACutSheetDoes)
    {
        // Of a sheet without end, thin beside its cut; this one is held at 90 mm and half as thick as the cut is long.
        constexpr double kNear = 0.15;
        const PlannedField field = plan_under(biaxial(kStrain, kStrain), std::nullopt,
            { .width_mm = 230.0,
                .region_mm = 90.0,
                .solution = { .elasticity = fem::Elasticity::linear, .element = ElementKind::p2 } });
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        ASSERT_TRUE(field.metrics.tension.has_value());
        EXPECT_EQ(field.metrics.tension->message, "");
        EXPECT_EQ(field.metrics.tension->gape_mm, field.metrics.opening_width_mm) << "there are no hooks";
        const double sheet = verification::sheet_gape(fem::PreStrainKind::equibiaxial, kStrain, kCutMm, kRatio);
        EXPECT_NEAR(field.metrics.tension->gape_mm / sheet, 1.0, kNear);
        EXPECT_EQ(field.metrics.error->message, "");
        EXPECT_GT(field.metrics.error->opening_width_mm, 0.0);
        EXPECT_EQ(field.metrics.tension->tissues.size(), 3U);
    }

    TEST(PlanUnderTension, OnlyTheStressAcrossTheCutCounts)
    {
        constexpr double kBent = 1e-3; // the cut is not quite straight
        const auto gape = [](const fem::PreStrain& tension) {
            const PlannedField field = plan_under(tension, std::nullopt);
            EXPECT_EQ(field.status, PlanStatus::done) << field.message;
            return field.metrics.opening_width_mm;
        };
        const double both = gape(biaxial(kStrain, kStrain));
        EXPECT_GT(both, 1.0);
        const double of_both = kStrain * (1.0 + kRatio);
        EXPECT_NEAR(gape(biaxial(kStrain, kLess)) / both, (kStrain + kRatio * kLess) / of_both, kBent);
        EXPECT_NEAR(gape(biaxial(kLess, kStrain)) / both, (kLess + kRatio * kStrain) / of_both, kBent);
        // Along the cut, free to narrow: nothing across.
        EXPECT_NEAR(
            gape({ .kind = fem::PreStrainKind::uniaxial_stress, .strain = kStrain, .pull = Vec3::UnitZ() }) / both, 0.0,
            0.01);
    }

    TEST(PlanUnderTension, HooksHaveLessToDoAndTheGapeIsToldWithoutThem)
    {
        constexpr double kOpening = 12.0;
        const fem::PreStrain tension = biaxial(kStrain, kStrain);
        const PlannedField bare = plan_under(tension, std::nullopt), hooked = plan_under(tension, kOpening),
                           slack = plan_under({}, kOpening);
        ASSERT_EQ(hooked.status, PlanStatus::done) << hooked.message;
        EXPECT_FALSE(slack.metrics.tension.has_value());
        constexpr double kMeshes = 0.05; // the mesh is finer round the patches of hooks
        EXPECT_NEAR(
            hooked.metrics.tension->gape_mm, bare.metrics.opening_width_mm, kMeshes * bare.metrics.opening_width_mm);
        EXPECT_LT(hooked.metrics.hook_force_N, 0.9 * slack.metrics.hook_force_N);
        EXPECT_GT(hooked.metrics.opening_width_mm, slack.metrics.opening_width_mm);
        EXPECT_EQ(hooked.metrics.error->message, "");
        const std::string said = tension_text(hooked.metrics);
        EXPECT_NE(said.find("skin 4.0 % both ways"), std::string::npos) << said;
        EXPECT_NE(said.find("gapes"), std::string::npos) << said;
    }

    TEST(PlanUnderTension, HooksThatHoldTheWoundBackPullNothing)
    {
        constexpr double kBarely = 0.2; // mm, of a wound that gapes by more
        const PlannedField field = plan_under(biaxial(kStrain, kStrain), kBarely);
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        EXPECT_GT(field.metrics.tension->gape_mm, field.metrics.opening_width_mm);
        EXPECT_EQ(field.metrics.hook_force_N, 0.0);
        for (const HookForce& hook : field.metrics.hooks) {
            EXPECT_TRUE(hook.pushes) << hook.name;
            EXPECT_GT(hook.force_N, 0.0) << hook.name;
        }
        EXPECT_NE(hooks_text(field.metrics).find("holds back its lip"), std::string::npos);
    }

    TEST(PlanUnderTension, AStrainOfZeroIsNone)
    {
        const PlannedField field = plan_under(biaxial(0.0, 0.0), 6.0);
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        EXPECT_FALSE(field.metrics.tension.has_value());
    }

    /// Small strains: what is nonlinear is nearly linear.
    TEST(PlanUnderTension, EveryWayOfSolvingIsGivenIt)
    {
        constexpr double kSmall = 0.005, kAlike = 0.05;
        const fem::PreStrain tension = biaxial(kSmall, kSmall);
        const double linear = plan_under(tension, std::nullopt).metrics.opening_width_mm;
        EXPECT_GT(linear, 0.1);
        const auto expect_alike = [&](const Block& block) {
            const PlannedField field = plan_under(tension, std::nullopt, block);
            EXPECT_EQ(field.status, PlanStatus::done) << field.message;
            EXPECT_NEAR(field.metrics.opening_width_mm / linear, 1.0, kAlike);
            EXPECT_EQ(field.metrics.error->message, "");
        };
        expect_alike({ .solution = { .elasticity = fem::Elasticity::corotational } });
        expect_alike({ .solution = { .elasticity = fem::Elasticity::hyperelastic } });
        expect_alike({ .solution = { .elasticity = fem::Elasticity::hyperelastic, .near_mm = 25.0 } });
        expect_alike({ .solution = { .elasticity = fem::Elasticity::linear, .element = ElementKind::locking_free } });
        expect_alike({ .contact = ContactMode::always });
    }

    TEST(PlanUnderTension, ADirectionThroughTheTissueIsSaid)
    {
        fem::PreStrain through = biaxial(kStrain, kLess); // down into the body, as the block lies
        through.pull = Vec3::UnitY();
        const PlannedField field = plan_under(through, std::nullopt);
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        EXPECT_NE(field.message.find("points through the tissue"), std::string::npos) << field.message;
        const PlannedField mean = plan_under(biaxial(0.5 * (kStrain + kLess), 0.5 * (kStrain + kLess)), std::nullopt);
        EXPECT_NEAR(field.metrics.opening_width_mm, mean.metrics.opening_width_mm, 1e-6);
        // Through the plane it has been given, which is not the skin's: nothing of it acts across the skin.
        through.pull = Vec3(0.02, 0.0, 1.0), through.normal = Vec3::UnitZ();
        const PlannedField own = plan_under(through, std::nullopt);
        ASSERT_EQ(own.status, PlanStatus::done) << own.message;
        EXPECT_NE(own.message.find("points through the tissue"), std::string::npos) << own.message;
        constexpr double kBent = 1e-3; // the cut is not quite straight, and x alone lies in both planes
        EXPECT_NEAR(own.metrics.opening_width_mm / mean.metrics.opening_width_mm, 1.0, kBent);
    }

    /// Whether the plane across the blade was taken for want of skin.
    bool takes_the_plane_across_the_blade(const fem::PreStrain& tension, const std::string& material)
    {
        const mesh::LabelTable table { { 1, "chest wall", material, mesh::Role::wall } };
        std::vector<fem::Material> materials(2);
        materials[1].name = material;
        materials[1].youngs_modulus_MPa = 0.1;
        materials[1].poissons_ratio = kRatio;
        materials[1].density_tonne_per_mm3 = 1e-9;
        materials[1].pre_strain = tension;
        return wall_tension(mesh::kuhn_box(2, 2, 2, 4.0), materials, table, {}, -Vec3::UnitY()).without_skin;
    }

    TEST(PlanUnderTension, ThePlaneAcrossTheBladeIsToldWhereItIsTaken)
    {
        fem::PreStrain tension = biaxial(kStrain, kLess);
        EXPECT_TRUE(takes_the_plane_across_the_blade(tension, "muscle"));
        EXPECT_FALSE(takes_the_plane_across_the_blade(tension, "skin"));
        tension.normal = Vec3::UnitZ();
        EXPECT_FALSE(takes_the_plane_across_the_blade(tension, "muscle")) << "it has a normal of its own";
        EXPECT_FALSE(takes_the_plane_across_the_blade({}, "muscle")) << "no tension";
        EXPECT_FALSE(
            takes_the_plane_across_the_blade({ .kind = fem::PreStrainKind::isotropic, .strain = kStrain }, "muscle"))
            << "it needs no plane";
    }

} // namespace tension_plan_test
} // namespace retractor::planner
