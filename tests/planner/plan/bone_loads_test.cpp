#include "planner/plan/bone_loads.h"

#include "fem/statics/opening.h"
#include "planner/measures/bones/bone_limits.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace retractor::planner {
namespace bone_loads_test {

    constexpr double kWidth = 10.0, kLength = 100.0, kOpening = 40.0; // mm
    constexpr double kModulus = 1e4; // MPa, as of a rib

    AnatomicalFrame upright() { return { Vec3::Zero(), Vec3::UnitZ(), -Vec3::UnitY(), Vec3::UnitX() }; }

    const mesh::LabelTable kTable { { 1, "rib_left_5", "bone", mesh::Role::wall } };

    /// A field whose wall is one straight piece of a rib at the left side of the chest, held at its posterior end and
    /// pulled headwards at its anterior end.
    PlannedField pulled_rib(double force_N, const SolverSettings& choice)
    {
        PlannedField field;
        field.wall = mesh::kuhn_box(2, 2, 20, 0.5 * kWidth);
        for (Eigen::Index v = 0; v < field.wall.vertices.rows(); ++v) {
            const Vec3 p = field.wall.vertices.row(v).transpose();
            field.wall.vertices.row(v) << 95.0 + p.x(), 0.5 * kLength - p.z(), p.y();
        }
        field.problem.mesh = field.wall;
        field.problem.material_of_label = { {}, test_support::material(kModulus, 0.3) };
        for (VertexId v = 0; v < static_cast<VertexId>(field.wall.vertex_count()); ++v)
            if (field.wall.vertices(v, 1) > 0.5 * kLength - 1e-9)
                field.problem.supports.fixed.push_back(v);
        for (const mesh::TetFace& face : mesh::boundary_faces(field.wall)) {
            const auto corners = mesh::face_vertices(field.wall, face);
            if (std::ranges::all_of(
                    corners, [&](VertexId v) { return field.wall.vertices(v, 1) < -0.5 * kLength + 1e-9; }))
                field.problem.loads.push_back({ face, force_N / (kWidth * kWidth) * Vec3::UnitZ() });
        }
        fem::Opening opening(field.problem, { .elasticity = choice.elasticity });
        field.opening = opening.open({});
        for (const int side : { 1, -1 })
            field.metrics.hooks.push_back({ .name = "hook", .side = side, .moved_mm = 0.5 * kOpening });
        return field;
    }

    TEST(BoneLoads, ARibBeyondItsCapacityIsNamedWithTheOpeningBelowIt)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::corotational, .element = ElementKind::p1 };
        PlannedField field = pulled_rib(100.0, choice);
        measure_bones(field, {}, choice, kTable, upright());
        const FieldMetrics& m = field.metrics;
        ASSERT_EQ(m.bones.size(), 1U) << m.bones_message;
        const BoneMetrics& rib = m.bones.front();
        // 100 N times the lever of 95 mm at the first section; the rib shortens by less than 1 % as it bends.
        EXPECT_NEAR(rib.bending_Nm, 9.5, 0.03 * 9.5);
        EXPECT_NEAR(rib.at_mm, 5.0, 1.0);
        EXPECT_EQ(rib.part, "posterior");
        EXPECT_GT(rib.utilisation, 1.0);
        EXPECT_EQ(m.attainable, Attainable::with_injury);
        EXPECT_NEAR(m.largest_uninjured_opening_mm.value(), kOpening * *rib.capacity_Nm / rib.moment_Nm, 1e-9);
        EXPECT_EQ(field.message, "attainable with injury: rib 5 on the left");
        EXPECT_TRUE(m.bones_rough);
        EXPECT_FALSE(rib.spine_joint.has_value());
        EXPECT_FALSE(rib.cartilage.has_value());
    }

    TEST(BoneLoads, BelowTheCapacityNothingIsRemarked)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::linear, .element = ElementKind::p1 };
        PlannedField field = pulled_rib(10.0, choice);
        measure_bones(field, {}, choice, kTable, upright());
        EXPECT_EQ(field.metrics.attainable, Attainable::yes);
        EXPECT_NEAR(field.metrics.largest_uninjured_opening_mm.value(), kOpening, 1e-9);
        EXPECT_TRUE(field.message.empty());
    }

    TEST(BoneLoads, AreNotGivenWithoutAnEquilibriumOrWithLinearTissueFarAway)
    {
        const SolverSettings choice { .elasticity = fem::Elasticity::corotational, .element = ElementKind::p1 };
        PlannedField field = pulled_rib(100.0, choice), far = field;
        field.opening.status = fem::OpeningStatus::not_converged;
        measure_bones(field, {}, choice, kTable, upright());
        EXPECT_EQ(field.metrics.attainable, Attainable::no);
        EXPECT_TRUE(field.metrics.bones.empty());
        EXPECT_NE(bones_text(field.metrics).find("not attainable"), std::string::npos);
        far.opening.far.emplace().kept = true;
        measure_bones(far, {}, choice, kTable, upright());
        EXPECT_EQ(far.metrics.attainable, Attainable::unknown);
        EXPECT_FALSE(far.metrics.bones_message.empty());
    }

} // namespace bone_loads_test
} // namespace retractor::planner
