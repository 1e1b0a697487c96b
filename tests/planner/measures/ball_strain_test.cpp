#include "planner/measures/ball_strain.h"

#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/metrics.h"
#include "tests/support/reference_problems.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace retractor::planner {
namespace ball_strain_test {

    using Map = std::function<Vec3(const Vec3&)>;

    constexpr double kRoundOff = 1e-12;
    constexpr Label kSkin = 1, kMuscle = 2, kRib = 3;

    mesh::LabelTable table()
    {
        return { { kSkin, "skin", "skin", mesh::Role::wall }, { kMuscle, "muscle_left", "muscle", mesh::Role::wall },
            { kRib, "rib_left_5", "bone", mesh::Role::wall } };
    }

    Mat3 turn(double angle, const Vec3& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).matrix(); }

    Eigen::VectorXd displacement_by(const mesh::TetMesh& mesh, const Map& moved_to)
    {
        return verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return moved_to(p) - p; });
    }

    std::vector<std::uint8_t> all_of(const mesh::TetMesh& mesh)
    {
        return std::vector<std::uint8_t>(mesh.tet_count(), 1);
    }

    /// A box of 20 x 16 x 12 mm in any pose.
    mesh::TetMesh box(int nodes_per_tet)
    {
        const Mat3 pose = turn(0.7, { 1.0, -2.0, 0.5 });
        return verification::mapped_box(
            nodes_per_tet, 5, 4, 3, [&](const Vec3& p) -> Vec3 { return pose * (4.0 * p) + Vec3(120.0, -40.0, 15.0); });
    }

    TEST(BallStrain, AHomogeneousStretchIsExact)
    {
        const Mat3 stretch = turn(1.1, { 0.2, 1.0, -0.4 }) * Vec3(1.35, 0.9, 0.8).asDiagonal() * turn(0.3, { 1, 1, 0 });
        for (const int nodes : { 4, 10 }) {
            const mesh::TetMesh wall = box(nodes);
            const auto u = displacement_by(wall, [&](const Vec3& p) -> Vec3 { return stretch * p + Vec3(3, 2, 1); });
            for (const double radius : { 2.0, 5.0, 15.0 }) {
                const auto found = largest_ball_strain(wall, all_of(wall), u, radius);
                ASSERT_TRUE(found.has_value());
                EXPECT_NEAR(found->strain, 0.35, kRoundOff) << nodes << " nodes, radius " << radius;
            }
        }
    }

    TEST(BallStrain, TissueThatOnlyTurnsHasNone)
    {
        for (const int nodes : { 4, 10 }) {
            const mesh::TetMesh wall = box(nodes);
            const Mat3 half_turn = turn(3.0, { 1.0, 2.0, 3.0 });
            const auto u = displacement_by(wall, [&](const Vec3& p) -> Vec3 { return half_turn * p; });
            EXPECT_NEAR(largest_ball_strain(wall, all_of(wall), u)->strain, 0.0, kRoundOff);
        }
    }

    TEST(BallStrain, LipsThatRollOppositeWaysDoNotHideTheStretch)
    {
        // Two slabs, 1 mm apart, in the same ball: both are stretched by 40 %, and turn by 60 degrees to either side.
        const mesh::TetMesh slab = mesh::kuhn_box(4, 4, 4, 1.0);
        mesh::TetMesh wall = slab;
        const auto n = static_cast<Eigen::Index>(slab.vertex_count());
        wall.vertices.conservativeResize(2 * n, 3);
        wall.vertices.bottomRows(n) = slab.vertices.rowwise() + Eigen::RowVector3d(5.0, 0.0, 0.0);
        for (const VertexId v : slab.nodes)
            wall.nodes.push_back(v + static_cast<VertexId>(n));
        wall.labels.insert(wall.labels.end(), slab.labels.begin(), slab.labels.end());
        const auto u = displacement_by(wall, [](const Vec3& p) -> Vec3 {
            const Vec3 stretched(p.x(), 1.4 * p.y(), p.z());
            return turn(p.x() < 4.5 ? M_PI / 3.0 : -M_PI / 3.0, Vec3::UnitX()) * stretched;
        });
        EXPECT_NEAR(largest_ball_strain(wall, all_of(wall), u)->strain, 0.4, kRoundOff);
    }

    TEST(BallStrain, TheCentreLiesWhereTheStretchIsAndEachTissueCountsAlone)
    {
        // Muscle up to x = 20 mm, skin beyond; the strain along x is 0.01 x.
        mesh::TetMesh wall = mesh::kuhn_box(20, 8, 8, 2.0);
        std::vector<std::uint8_t> in_skin(wall.tet_count(), 0);
        for (std::size_t t = 0; t < wall.tet_count(); ++t) {
            double x = 0.0;
            for (const VertexId v : wall.tet(static_cast<TetId>(t)))
                x += 0.25 * wall.vertices(v, 0);
            wall.labels[t] = x > 20.0 ? kSkin : kMuscle;
            in_skin[t] = x > 20.0 ? 1 : 0;
        }
        const auto u = displacement_by(wall, [](const Vec3& p) -> Vec3 {
            return { p.x() + 0.005 * p.x() * p.x(), p.y(), p.z() };
        });
        const std::vector<TissueStrain> found = tissue_strains(wall, table(), u);
        ASSERT_EQ(found.size(), 2U);
        EXPECT_EQ(found[0].tissue, "skin");
        EXPECT_EQ(found[1].tissue, "muscle");
        EXPECT_GT(found[0].at.x(), 35.0);
        EXPECT_DOUBLE_EQ(found[0].strain, largest_ball_strain(wall, in_skin, u)->strain);
        // Half a ball at the end has its middle 3/8 of the radius before the end: 0.01 (40 - 1.9) and 0.01 (20 - 1.9).
        constexpr double kElement = 0.01; // half an element
        EXPECT_NEAR(found[0].strain, 0.381, kElement);
        EXPECT_NEAR(found[1].strain, 0.181, kElement);
    }

    TEST(BallStrain, BonesAndUnknownLabelsAreNoTissueAndSpecksAreNoMean)
    {
        mesh::TetMesh wall = mesh::kuhn_box(6, 6, 6, 2.0);
        const auto u = displacement_by(wall, [](const Vec3& p) -> Vec3 { return 1.5 * p; });
        wall.labels.assign(wall.tet_count(), kRib);
        EXPECT_TRUE(tissue_strains(wall, table(), u).empty());
        wall.labels.assign(wall.tet_count(), 99);
        EXPECT_TRUE(tissue_strains(wall, table(), u).empty());
        wall.labels.assign(wall.tet_count(), kRib);
        wall.labels[0] = kSkin; // 4/3 mm^3 of a ball of 524 mm^3
        EXPECT_TRUE(tissue_strains(wall, table(), u).empty());
    }

    struct Notched {
        double ball = 0.0, element = 0.0; ///< largest strains of balls, and of single elements
    };

    /// A block of 24 x 24 x 8 mm with a notch from the side, pulled by 10 %, in linear elasticity.
    Notched pull_notched(double edge, const Mat3& pose)
    {
        const auto cells = [&](double mm) { return static_cast<int>(std::lround(mm / edge)); };
        const mesh::TetMesh whole = mesh::kuhn_box(cells(24.0), cells(24.0), cells(8.0), edge);
        mesh::TetMesh wall = whole;
        wall.nodes.clear();
        wall.labels.clear();
        std::vector<std::uint8_t> used(whole.vertex_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(whole.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : whole.tet(t))
                middle += 0.25 * whole.vertices.row(v).transpose();
            if (middle.x() < 12.0 && middle.y() > 8.0 && middle.y() < 12.0)
                continue; // the notch
            for (const VertexId v : whole.tet(t)) {
                wall.nodes.push_back(v);
                used[static_cast<std::size_t>(v)] = 1;
            }
            wall.labels.push_back(kSkin);
        }
        const auto unknowns = static_cast<std::size_t>(3 * whole.vertices.rows());
        std::vector<std::uint8_t> prescribed(unknowns, 0);
        Eigen::VectorXd values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns));
        for (Eigen::Index v = 0; v < whole.vertices.rows(); ++v) {
            const double y = whole.vertices(v, 1);
            const bool at_end = y < 1e-9 || y > 24.0 - 1e-9;
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                if (at_end || used[static_cast<std::size_t>(v)] == 0)
                    prescribed[static_cast<std::size_t>(3 * v + axis)] = 1;
            if (at_end && used[static_cast<std::size_t>(v)] != 0)
                values.segment<3>(3 * v) = pose * Vec3(0.0, 0.1 * y, 0.0);
        }
        wall.vertices = whole.vertices * pose.transpose();
        fem::ElasticBody body(
            wall, fem::Elasticity::linear, test_support::uniform(wall, test_support::material(0.2, 0.45)));
        const Eigen::VectorXd u = test_support::solve_linear(
            body, prescribed, values, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns)));
        Notched found { .ball = largest_ball_strain(wall, all_of(wall), u)->strain };
        const auto deformed = body.deformation(u);
        found.element = *std::ranges::max_element(deformed.strain);
        return found;
    }

    TEST(BallStrain, ConvergesAtANotchWhereElementsDoNot)
    {
        std::vector<Notched> found;
        for (const double edge : { 4.0, 2.0, 1.0 })
            found.push_back(pull_notched(edge, Mat3::Identity()));
        // The field is unbounded at the notch's corners: each refinement adds more to the largest strain of an element.
        EXPECT_GT(found[1].element, 1.04 * found[0].element);
        EXPECT_GT(found[2].element - found[1].element, found[1].element - found[0].element);
        const double last = std::abs(found[2].ball - found[1].ball), before = std::abs(found[1].ball - found[0].ball);
        EXPECT_LT(last, before);
        EXPECT_LT(last, 0.05 * found[2].ball) << found[0].ball << " " << found[1].ball << " " << found[2].ball;
    }

    TEST(BallStrain, DoesNotDependOnThePose)
    {
        const double upright = pull_notched(2.0, Mat3::Identity()).ball;
        constexpr double kSolver = 1e-7;
        EXPECT_NEAR(pull_notched(2.0, turn(0.9, { 0.3, -1.0, 2.0 })).ball, upright, kSolver);
    }

    TEST(BallStrain, BadInputIsRefused)
    {
        const mesh::TetMesh wall = mesh::kuhn_box(2, 2, 2, 4.0);
        const auto message = [&](const Eigen::VectorXd& u, double radius) {
            return test_support::message_of([&] { (void)largest_ball_strain(wall, all_of(wall), u, radius); });
        };
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(3 * wall.vertices.rows());
        EXPECT_NE(message(Eigen::VectorXd::Zero(3), 5.0).find("has 3 numbers"), std::string::npos);
        Eigen::VectorXd nan = none;
        nan[4] = std::numeric_limits<double>::quiet_NaN();
        EXPECT_NE(message(nan, 5.0).find("not finite"), std::string::npos);
        for (const double radius : { 0.0, -1.0, std::numeric_limits<double>::infinity() })
            EXPECT_NE(message(none, radius).find("radius"), std::string::npos);
    }

    FieldMetrics field_with(double skin)
    {
        FieldMetrics field;
        field.name = "intercostal";
        field.mechanics_status = "converged";
        field.tissue_strain = { { "muscle", 1.2, Vec3::Zero(), "10 mm along the incision" },
            { "skin", skin, Vec3(1.0, 2.0, 3.0), "38 mm along the incision" } };
        return field;
    }

    TEST(BallStrain, SkinBeyondTheRangeOfTornSamplesIsAnInjury)
    {
        FieldMetrics whole = field_with(0.30), doubtful = field_with(0.5), torn = field_with(0.82);
        for (FieldMetrics* field : { &whole, &doubtful, &torn })
            set_attainable(*field, true);
        EXPECT_EQ(whole.attainable, Attainable::yes);
        EXPECT_TRUE(tearing_text(whole).empty());
        EXPECT_EQ(doubtful.attainable, Attainable::yes) << "a caution is no verdict";
        EXPECT_EQ(tearing_text(doubtful),
            "skin may tear: 50 % 38 mm along the incision, torn samples failed between 37 and 71 %");
        EXPECT_EQ(torn.attainable, Attainable::with_injury);
        EXPECT_EQ(attainable_text(torn), "with injury: skin");
        EXPECT_EQ(tearing_text(torn),
            "skin would tear: 82 % 38 mm along the incision, torn samples failed between 37 and 71 %");
        EXPECT_FALSE(breaks_bone(torn));
        torn.bones_message = "far tissue was linear";
        set_attainable(torn, true);
        EXPECT_EQ(torn.attainable, Attainable::with_injury) << "torn skin is an injury whatever the bones bear";
        set_attainable(torn, false);
        EXPECT_EQ(torn.attainable, Attainable::no);
    }

    TEST(BallStrain, IsWrittenWithItsRangeWhereThereIsOne)
    {
        const auto document = metrics_document({ field_with(0.82), field_with(0.1) });
        const auto& torn = document["approaches"][0];
        ASSERT_EQ(torn["tissue_strain"].size(), 2U);
        EXPECT_EQ(torn["tissue_strain"][0]["tissue"], "muscle");
        EXPECT_FALSE(torn["tissue_strain"][0].contains("torn_between"));
        EXPECT_EQ(torn["tissue_strain"][1]["strain"], 0.82);
        EXPECT_EQ(torn["tissue_strain"][1]["at_mm"][2], 3.0);
        EXPECT_EQ(torn["tissue_strain"][1]["torn_between"][1], kSkinTearsTo);
        EXPECT_NE(torn["tearing"].get<std::string>().find("would tear"), std::string::npos);
        EXPECT_FALSE(document["approaches"][1].contains("tearing"));
        EXPECT_EQ(tissue_strain_text(field_with(0.1)),
            "largest strain, averaged over balls of 5 mm radius: muscle 120 % 10 mm along the incision; skin 10 % 38 "
            "mm "
            "along the incision");
    }

} // namespace ball_strain_test
} // namespace retractor::planner
