#include "planner/plan/uninjured_opening.h"

#include "fem/statics/opening.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/plan/bone_loads.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace retractor::planner {
namespace uninjured_opening_test {

    TEST(UninjuredOpening, TheSecantFindsTheCapacityOfACurvedUse)
    {
        for (const double power : { 0.6, 1.0, 1.5, 2.5 }) {
            const double full = 2.7;
            std::vector<double> asked;
            const auto use_at = [&](double share) -> std::optional<double> {
                asked.push_back(share);
                return full * std::pow(share, power);
            };
            const std::optional<UseAtShare> found = find_full_use(full, 6, use_at);
            ASSERT_TRUE(found.has_value()) << power;
            EXPECT_GE(found->use, kLeastFullUse) << power;
            EXPECT_LE(found->use, kMostFullUse) << power;
            EXPECT_NEAR(found->share, std::pow(found->use / full, 1.0 / power), 1e-12);
            EXPECT_LE(asked.size(), power == 1.0 ? 1u : 6u);
        }
    }

    TEST(UninjuredOpening, WithoutAnAnswerTheBestSmallerOpeningCounts)
    {
        int solves = 0;
        const std::optional<UseAtShare> none
            = find_full_use(2.0, 4, [&](double) { return ++solves, std::optional<double>(); });
        EXPECT_FALSE(none.has_value());
        EXPECT_EQ(solves, 1);
        const std::optional<UseAtShare> one = find_full_use(
            2.0, 4, [&](double share) { return share < 0.6 ? std::optional(0.5) : std::optional<double>(); });
        ASSERT_TRUE(one.has_value());
        EXPECT_EQ(one->use, 0.5);
    }

    constexpr double kWidth = 10.0, kLength = 100.0, kOpening = 40.0; // mm
    constexpr double kModulus = 1e4; // MPa, as of a rib

    AnatomicalFrame upright() { return { Vec3::Zero(), Vec3::UnitZ(), -Vec3::UnitY(), Vec3::UnitX() }; }

    const mesh::LabelTable kTable { { 1, "rib_left_5", "bone", mesh::Role::wall } };

    /// A straight piece of a rib, held at its posterior end. A hook moves its anterior end headwards by 40 mm.
    PlannedField bent_rib(const SolverSettings& choice, int across)
    {
        PlannedField field;
        field.wall = mesh::kuhn_box(across, across, 10 * across, kWidth / across);
        for (Eigen::Index v = 0; v < field.wall.vertices.rows(); ++v) {
            const Vec3 p = field.wall.vertices.row(v).transpose();
            field.wall.vertices.row(v) << 95.0 + p.x(), 0.5 * kLength - p.z(), p.y();
        }
        fem::HookPatch hook { .name = "hook", .side = 1, .nodes = {}, .displacement = kOpening * Vec3::UnitZ() };
        field.problem.mesh = field.wall;
        field.problem.material_of_label = { {}, test_support::material(kModulus, 0.3) };
        for (VertexId v = 0; v < static_cast<VertexId>(field.wall.vertex_count()); ++v) {
            if (field.wall.vertices(v, 1) > 0.5 * kLength - 1e-9)
                field.problem.supports.fixed.push_back(v);
            if (field.wall.vertices(v, 1) < -0.5 * kLength + 1e-9)
                hook.nodes.push_back(v);
        }
        field.hooks = field.problem.hooks = { hook };
        field.approach.name = "test";
        field.approach.hooks = { { .name = "hook", .direction = Vec3::UnitZ(), .opening_mm = kOpening } };
        fem::Opening opening(field.problem, opening_options(choice));
        field.opening = opening.open(field.problem.hooks);
        field.metrics.hooks.push_back({ .name = "hook", .side = 1, .moved_mm = kOpening });
        return field;
    }

    TEST(UninjuredOpening, IsSolvedForABentRibOnSeveralMeshes)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::corotational, .element = ElementKind::p1 };
        for (const int across : { 2, 3 }) {
            PlannedField field = bent_rib(choice, across);
            ASSERT_EQ(field.opening.status, fem::OpeningStatus::converged);
            measure_bones(field, {}, choice, kTable, upright());
            FieldMetrics& m = field.metrics;
            ASSERT_EQ(m.attainable, Attainable::with_injury);
            solve_uninjured_opening(field, {}, choice, kTable, upright(), {});
            ASSERT_TRUE(m.uninjured_opening.has_value());
            const UninjuredOpening& found = *m.uninjured_opening;
            EXPECT_EQ(found.message, "");
            EXPECT_EQ(found.bone, "rib_left_5");
            EXPECT_GE(found.utilisation, kLeastFullUse);
            EXPECT_LE(found.utilisation, kMostFullUse);
            EXPECT_LE(found.solves, 4);
            EXPECT_EQ(m.largest_uninjured_opening_mm.value(), found.opening_mm);
            EXPECT_TRUE(is_uninjured_opening_solved(m));
            EXPECT_NE(bones_text(m).find("(solved)"), std::string::npos) << bones_text(m);
            // An opening of this size, computed from rest, gives the same moment.
            PlannedField smaller = bent_rib(choice, across);
            for (fem::HookPatch& hook : smaller.problem.hooks)
                hook.displacement = found.opening_mm * Vec3::UnitZ();
            fem::Opening opening(smaller.problem, opening_options(choice));
            smaller.opening = opening.open(smaller.problem.hooks);
            measure_bones(smaller, {}, choice, kTable, upright());
            constexpr double kEquilibrium = 1e-3; // two Newton iterations that end at a residual of 1e-4
            EXPECT_NEAR(smaller.metrics.bones.front().utilisation, found.utilisation, kEquilibrium);
        }
    }

    TEST(UninjuredOpening, AnUninjuredFieldIsLeftAsItIs)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::linear, .element = ElementKind::p1 };
        PlannedField field = bent_rib(choice, 2);
        field.metrics.attainable = Attainable::yes;
        solve_uninjured_opening(field, {}, choice, kTable, upright(), {});
        EXPECT_FALSE(field.metrics.uninjured_opening.has_value());
        EXPECT_FALSE(with_divided_bone(field.approach, field).has_value());
    }

    TEST(UninjuredOpening, TheBoneThatBreaksIsDividedWhereItBreaks)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::corotational, .element = ElementKind::p1 };
        PlannedField field = bent_rib(choice, 2);
        measure_bones(field, {}, choice, kTable, upright());
        field.approach.sizing.region_mm = 120.0;
        Approach approach;
        approach.name = "space 5";
        const std::optional<Approach> divided = with_divided_bone(approach, field);
        ASSERT_TRUE(divided.has_value());
        EXPECT_EQ(divided->name, "space 5 (rib_left_5 divided)");
        ASSERT_EQ(divided->ablations.size(), 1u);
        const AblationSpec& ball = divided->ablations.front();
        EXPECT_EQ(ball.label, "rib_left_5");
        EXPECT_EQ(ball.centre, field.metrics.bones.front().place);
        EXPECT_GT(ball.radius_mm, kWidth); // as high as a rib of this section
        EXPECT_LT(ball.radius_mm, 2.0 * kWidth);
        EXPECT_EQ(divided->sizing.region_mm, 120.0);
    }

} // namespace uninjured_opening_test
} // namespace retractor::planner
