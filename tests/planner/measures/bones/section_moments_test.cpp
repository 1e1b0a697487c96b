#include "planner/measures/bones/section_moments.h"

#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "planner/measures/bones/bone_centreline.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace section_moments_test {

    constexpr double kWidth = 10.0, kLength = 100.0; // of the bars, mm
    constexpr double kModulus = 1000.0; // MPa, a soft bone
    /// Of a moment, as a share of the largest: the centre-line of a coarse bar leaves its axis by less than 0.2 mm of
    /// the lever of 100 mm, and the solver leaves a residual of 1e-4.
    constexpr double kShare = 0.01;

    struct Bar {
        fem::ElasticProblem problem;
        fem::TissueModel model;
        Eigen::VectorXd displacement;
    };

    using Traction = std::function<Vec3(const Vec3& at)>;
    using Shape = std::function<Vec3(const Vec3& straight)>;

    /// A square bar along z with its lower end held, bent into a shape, and with a traction on its upper end.
    Bar loaded_bar(int nodes_per_tet, fem::Elasticity elasticity, const Traction& traction, const Shape& shape)
    {
        Bar bar { {}, { .elasticity = elasticity, .locking_free = false }, {} };
        mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 20, 0.5 * kWidth);
        std::vector<VertexId> held;
        std::vector<mesh::TetFace> loaded;
        constexpr double kTiny = 1e-9;
        if (nodes_per_tet == 10)
            mesh = mesh::with_midpoints(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 2) < kTiny)
                held.push_back(v);
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto corners = mesh::face_vertices(mesh, face);
            if (std::ranges::all_of(corners, [&](VertexId v) { return mesh.vertices(v, 2) > kLength - kTiny; }))
                loaded.push_back(face);
        }
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            mesh.vertices.row(v) = shape(mesh.vertices.row(v).transpose()).transpose();
        if (nodes_per_tet == 10) // straight edges
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                    mesh.vertices.row(mesh.tet(t)[4 + e]) = 0.5
                        * (mesh.vertices.row(mesh.tet(t)[static_cast<std::size_t>(mesh::kTetEdges[e][0])])
                            + mesh.vertices.row(mesh.tet(t)[static_cast<std::size_t>(mesh::kTetEdges[e][1])]));
        for (const mesh::TetFace& face : loaded) {
            Vec3 centre = Vec3::Zero();
            for (const VertexId v : mesh::face_vertices(mesh, face))
                centre += point_at(mesh.vertices, v) / 3.0;
            bar.problem.loads.push_back({ face, traction(centre) });
        }
        bar.problem.mesh = std::move(mesh);
        bar.problem.material_of_label = { {}, test_support::material(kModulus, 0.3) };
        bar.problem.supports.fixed = std::move(held);
        fem::Opening opening(bar.problem, { .elasticity = elasticity });
        const fem::OpeningResult result = opening.open({});
        EXPECT_EQ(result.status, fem::OpeningStatus::converged) << result.message;
        bar.displacement = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
        return bar;
    }

    Vec3 straight(const Vec3& p) { return p - Vec3(0.5 * kWidth, 0.5 * kWidth, 0.0); }

    BoneForces forces_on(const Bar& bar)
    {
        auto pieces
            = bone_forces(bar.problem.mesh, bar.problem.material_of_label, bar.model, bar.displacement, Label { 1 });
        EXPECT_EQ(pieces.size(), 1U);
        return std::move(pieces.front());
    }

    /// The sections from the held end on.
    BoneBar sections_of(const Bar& bar, const Vec3& held_end)
    {
        BoneBar found = section_moments(forces_on(bar));
        EXPECT_GE(found.sections.size(), 15U);
        const auto from = [&](const BoneSection& section) { return (section.centre - held_end).norm(); };
        return from(found.sections.front()) < from(found.sections.back()) ? found : reversed(found);
    }

    // -- Closed form.

    class OfElements : public testing::TestWithParam<int> { };
    INSTANTIATE_TEST_SUITE_P(SectionMoments, OfElements, testing::Values(4, 10));

    TEST_P(OfElements, ACantileverBearsTheForceTimesTheLever)
    {
        const double force = 2.0; // N
        const Bar bar = loaded_bar(
            GetParam(), fem::Elasticity::linear, [&](const Vec3&) { return Vec3(force / (kWidth * kWidth), 0.0, 0.0); },
            straight);
        const double largest = 1e-3 * force * kLength;
        for (const BoneSection& section : sections_of(bar, Vec3::Zero()).sections) {
            EXPECT_NEAR(section.bending_Nm, 1e-3 * force * (kLength - section.centre.z()), kShare * largest);
            EXPECT_NEAR(section.torsion_Nm, 0.0, kShare * largest);
            EXPECT_NEAR(section.area_mm2, kWidth * kWidth, 0.02 * kWidth * kWidth);
        }
    }

    TEST_P(OfElements, ATwistedBarBearsTheTorqueEverywhere)
    {
        const auto traction = [](const Vec3& at) -> Vec3 { return 1e-3 * Vec3::UnitZ().cross(at); };
        const Bar bar = loaded_bar(GetParam(), fem::Elasticity::linear, traction, straight);
        double torque = 0.0; // N mm
        for (const fem::FaceTraction& load : bar.problem.loads) {
            Vec3 corner[3];
            for (std::size_t i = 0; i < 3; ++i)
                corner[i] = point_at(bar.problem.mesh.vertices, mesh::face_vertices(bar.problem.mesh, load.face)[i]);
            const double area = 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
            torque += area * ((corner[0] + corner[1] + corner[2]) / 3.0).cross(load.traction).z();
        }
        ASSERT_GT(torque, 0.0);
        for (const BoneSection& section : sections_of(bar, Vec3::Zero()).sections) {
            EXPECT_NEAR(section.torsion_Nm, 1e-3 * torque, kShare * 1e-3 * torque);
            EXPECT_NEAR(section.bending_Nm, 0.0, kShare * 1e-3 * torque);
        }
    }

    TEST_P(OfElements, AQuarterRingPulledOutOfItsPlaneBendsAndTwists)
    {
        // Held at (R, 0, 0), loaded by F along z at (0, R, 0): bending F R cos a, torsion F R (1 - sin a)
        // [Timoshenko, Strength of Materials, part 1, bars with a curved axis].
        const double R = kLength / (0.5 * std::numbers::pi), force = 1.0;
        const auto ring = [&](const Vec3& p) -> Vec3 {
            const double angle = p.z() / R, r = R + p.x() - 0.5 * kWidth;
            return { r * std::cos(angle), r * std::sin(angle), 0.5 * kWidth - p.y() };
        };
        const Bar bar = loaded_bar(
            GetParam(), fem::Elasticity::linear, [&](const Vec3&) { return Vec3(0.0, 0.0, force / (kWidth * kWidth)); },
            ring);
        const double largest = 1e-3 * force * R;
        const BoneBar found = sections_of(bar, { R, 0.0, 0.0 });
        // The line of the centroids of slices runs inside the ring by the sagitta, and its tangent at the first and
        // last section is one-sided: 3 % of the largest moment.
        constexpr double kRingShare = 0.03;
        for (const BoneSection& section : found.sections) {
            const double angle = std::atan2(section.centre.y(), section.centre.x());
            if (&section == &found.sections.front() || &section == &found.sections.back())
                continue;
            EXPECT_NEAR(section.bending_Nm, largest * std::cos(angle), kRingShare * largest) << angle;
            EXPECT_NEAR(section.torsion_Nm, largest * (1.0 - std::sin(angle)), kRingShare * largest) << angle;
        }
        EXPECT_NEAR(found.length_mm, kLength, 0.03 * kLength);
    }

    // -- Invariants.

    TEST(BoneForces, OfABarThatBendsFarAreInBalanceAndMeasuredWhereTheBarIs)
    {
        const double force = 20.0; // deflects the end by about 8 mm
        const Bar bar = loaded_bar(
            10, fem::Elasticity::corotational, [&](const Vec3&) { return Vec3(force / (kWidth * kWidth), 0.0, 0.0); },
            straight);
        const BoneForces body = forces_on(bar);
        Vec3 sum = Vec3::Zero(), moment = Vec3::Zero(), end = Vec3::Zero();
        int nodes = 0;
        for (VertexId v = 0; v < static_cast<VertexId>(body.forces.rows()); ++v) {
            sum += point_at(body.forces, v);
            moment += point_at(body.positions, v).cross(point_at(body.forces, v));
            if (body.part.vertices(v, 2) > kLength - 1e-9)
                end += point_at(body.positions, v), ++nodes;
        }
        end /= nodes;
        // Sums over elements that are each in balance: round-off.
        EXPECT_LT(sum.norm(), 1e-8 * force);
        EXPECT_LT(moment.norm(), 1e-8 * force * kLength);
        ASSERT_GT(end.x(), 2.0);
        const BoneBar found = sections_of(bar, Vec3::Zero());
        // The lever is the height of the deformed end over the deformed section.
        const double highest = 1e-3 * force * (end.z() - 5.0);
        EXPECT_NEAR(found.sections.front().bending_Nm, highest, 2.0 * kShare * highest);
    }

    TEST(BoneForces, ARigidMotionLoadsNothing)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 8, 10.0);
        const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
        Points moved = mesh.vertices * turn.transpose() - mesh.vertices;
        moved.rowwise() += Eigen::RowVector3d(3.0, -4.0, 5.0);
        const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size());
        const std::vector<fem::Material> materials { {}, test_support::material(kModulus, 0.3) };
        const auto pieces = bone_forces(mesh, materials, { .elasticity = fem::Elasticity::corotational }, u, 1);
        ASSERT_EQ(pieces.size(), 1U);
        for (const BoneSection& section : section_moments(pieces.front()).sections) {
            EXPECT_NEAR(section.bending_Nm, 0.0, 1e-6); // round-off of E times 100 mm2 times the lever
            EXPECT_NEAR(section.torsion_Nm, 0.0, 1e-6);
        }
    }

    TEST(BoneForces, EachPieceOfABoneIsAFreeBody)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 9, 10.0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto corners = mesh::tet_corners(mesh, t);
            const double height = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]).z();
            mesh.labels[static_cast<std::size_t>(t)] = height > 50.0 && height < 60.0 ? 2 : 1;
        }
        const Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        const fem::Material bone = test_support::material(kModulus, 0.3);
        const std::vector<fem::Material> materials { {}, bone, bone };
        const auto pieces = bone_forces(mesh, materials, {}, u, 1);
        ASSERT_EQ(pieces.size(), 2U);
        EXPECT_EQ(pieces[0].part.tet_count(), 5U * 6U);
        EXPECT_EQ(pieces[1].part.tet_count(), 3U * 6U);
        EXPECT_TRUE(bone_forces(mesh, materials, {}, u, 3).empty());
    }

    TEST(BoneCentreline, OfAStraightBarIsItsHeightAndOfACubeNothing)
    {
        const mesh::TetMesh bar = mesh::kuhn_box(2, 2, 20, 5.0);
        const BoneCentreline line = bone_centreline(bar);
        // The first and last slices of a mesh without mirror symmetry are a little askew: up to 0.15 over half a width.
        constexpr double kAskewMm = 1.5;
        EXPECT_NEAR(line.length_mm, 100.0, kAskewMm);
        const bool rises = line.along_mm.back() > line.along_mm.front();
        for (VertexId v = 0; v < static_cast<VertexId>(bar.vertex_count()); ++v)
            EXPECT_NEAR(line.along_mm[static_cast<std::size_t>(v)],
                rises ? bar.vertices(v, 2) : 100.0 - bar.vertices(v, 2), kAskewMm);
        EXPECT_EQ(bone_centreline(mesh::kuhn_box(2, 2, 2, 5.0)).length_mm, 0.0);
        EXPECT_EQ(bone_centreline({}).length_mm, 0.0);
    }

    TEST(BoneForces, RefuseADisplacementOfAnotherWall)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 10.0);
        const std::vector<fem::Material> materials { {}, test_support::material(kModulus, 0.3) };
        const std::string message = test_support::message_of(
            [&] { static_cast<void>(bone_forces(mesh, materials, {}, Eigen::VectorXd::Zero(3), 1)); });
        EXPECT_NE(message.find("the displacement has 3 numbers, the wall 8 nodes"), std::string::npos) << message;
        EXPECT_THROW(static_cast<void>(section_moments(BoneForces {}, 0.0)), InputError);
    }

} // namespace section_moments_test
} // namespace retractor::planner
