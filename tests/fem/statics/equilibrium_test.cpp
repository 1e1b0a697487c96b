#include "fem/statics/equilibrium.h"

#include "fem/linear_algebra/norm.h"
#include "fem/material/material.h"
#include "fem/model/elastic_body.h"
#include "fem/model/loads.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {
namespace equilibrium_test {

    constexpr double kTiny = 1e-9;

    /// A box of 2 x 3 x 4 mm.
    mesh::TetMesh box(int nodes_per_tet)
    {
        return verification::mapped_box(nodes_per_tet, 2, 3, 4, [](const Vec3& p) { return p; });
    }

    std::vector<mesh::TetFace> top(const mesh::TetMesh& mesh)
    {
        return verification::faces_where(mesh, [](const Vec3& p) { return p.z() > 4.0 - kTiny; });
    }

    /// A part of a cylinder's wall of inner radius 130 mm, round z, cut through along its middle; its border is held.
    struct SlitWall {
        mesh::TetMesh mesh;
        verification::Held held;
        std::vector<mesh::TetFace> inner;
    };
    SlitWall slit_wall(double edge)
    {
        constexpr double kRadius = 130.0, kSide = 100.0, kThickness = 16.0, kSlit = 60.0; // mm
        const int n = 2 * static_cast<int>(std::lround(kSide / (2.0 * edge))),
                  layers = static_cast<int>(std::lround(kThickness / edge));
        SlitWall wall;
        mesh::TetMesh& mesh = wall.mesh;
        mesh = verification::mapped_box(4, n, n, layers, [](const Vec3& p) { return p; });
        const auto along = [&](VertexId v) { return kSide * (mesh.vertices(v, 1) / n - 0.5); };
        std::map<VertexId, VertexId> other_lip; // the slit's ends are on both
        const auto count = static_cast<VertexId>(mesh.vertex_count());
        for (VertexId v = 0; v < count; ++v)
            if (mesh.vertices(v, 0) == n / 2 && std::abs(along(v)) < 0.5 * kSlit - kTiny)
                other_lip.emplace(v, count + static_cast<VertexId>(other_lip.size()));
        mesh.vertices.conservativeResize(count + static_cast<VertexId>(other_lip.size()), 3);
        for (const auto& [lip, other] : other_lip)
            mesh.vertices.row(other) = mesh.vertices.row(lip);
        for (std::size_t begin = 0; begin < mesh.nodes.size(); begin += 4) {
            const std::span<VertexId> tet(mesh.nodes.data() + begin, 4);
            double x = 0.0;
            for (const VertexId v : tet)
                x += 0.25 * mesh.vertices(v, 0);
            for (VertexId& v : tet)
                if (const auto found = other_lip.find(v); x > n / 2 && found != other_lip.end())
                    v = found->second;
        }
        wall.held = verification::hold_nothing(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 at = mesh.vertices.row(v);
            if (at.x() == 0 || at.x() == n || at.y() == 0 || at.y() == n)
                for (const int axis : { 0, 1, 2 })
                    hold(wall.held, v, axis);
            const double angle = kSide * (at.x() / n - 0.5) / kRadius, r = kRadius + kThickness * at.z() / layers;
            mesh.vertices.row(v) = Vec3(r * std::sin(angle), along(v), r * std::cos(angle)).transpose();
        }
        wall.inner
            = verification::faces_where(mesh, [](const Vec3& p) { return std::hypot(p.x(), p.z()) < kRadius + kTiny; });
        return wall;
    }

    TEST(Equilibrium, UnderPressureOnACurvedWallWithFreeLipsSettles)
    {
        constexpr double kPressure = 1.6e-3; // MPa: the most that a laparoscopy takes
        constexpr int kFewSteps
            = 20; // in four load steps; 44 where all that the rim adds is taken as constant, about the axis
        const SlitWall wall = slit_wall(6.25);
        ElasticBody body(
            wall.mesh, verification::uniform_tissue(wall.mesh, hyperelastic_law(test_support::material(0.04, 0.45))));
        body.set_loads({ {}, { FollowerPressure(wall.mesh, wall.inner, kPressure) } });
        const verification::VerificationSolve solve = verification::solve_problem(
            body, wall.held.prescribed, {}, { .load_steps = 4, .tolerance = 1e-6 }, Job {});
        ASSERT_EQ(solve.equilibrium.status, EquilibriumStatus::converged) << solve.equilibrium.message;
        EXPECT_LE(solve.equilibrium.newton_iterations, kFewSteps);
    }

    /// Bar of 2 x 3 x 4 mm on its bottom, free to slide there, pulled up at its top.
    struct Bar {
        mesh::TetMesh mesh;
        verification::Held held;
    };
    Bar bar(int nodes_per_tet)
    {
        Bar b { box(nodes_per_tet), {} };
        b.held = verification::hold_nothing(b.mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(b.mesh.vertex_count()); ++v)
            for (int axis = 0; axis < 3; ++axis)
                if (b.mesh.vertices(v, axis) < kTiny)
                    hold(b.held, v, axis);
        return b;
    }

    TEST(Equilibrium, UnderADeadLoadHasTheClosedForm)
    {
        // Nominal stress of a bar of an incompressible neo-Hookean solid: mu (l - l^-2).
        constexpr double kMu = 0.05, kBulk = 500.0, kStretch = 1.6;
        for (const int n : { 4, 10 }) {
            const Bar b = bar(n);
            ElasticBody body(b.mesh, verification::uniform_tissue(b.mesh, MooneyRivlin { 0.5 * kMu, 0.0, kBulk }));
            const double nominal = kMu * (kStretch - 1 / (kStretch * kStretch));
            body.set_loads({ traction_loads(b.mesh, top(b.mesh), { 0, 0, nominal }), {} });
            EquilibriumSolver solver;
            const Equilibrium result = solver.solve(body, b.held.prescribed, b.held.target,
                Eigen::VectorXd::Zero(b.held.target.size()), { .load_steps = 8, .tolerance = 1e-9 }, Job {});
            ASSERT_EQ(result.status, EquilibriumStatus::converged) << result.message;
            double highest = 0.0;
            for (Eigen::Index v = 0; v < b.mesh.vertices.rows(); ++v)
                highest = std::max(highest, b.mesh.vertices(v, 2) + result.displacement[3 * v + 2]);
            EXPECT_NEAR(highest / 4.0, kStretch, 10.0 * kMu / kBulk) << n; // it gives by mu / K
            // What holds it is the load, turned round.
            double held = 0.0;
            for (Eigen::Index i = 2; i < result.forces.size(); i += 3)
                held += result.forces[i];
            EXPECT_NEAR(held, -6.0 * nominal, 1e-6) << n;
        }
    }

    TEST(Equilibrium, UnderLoadsThatBalanceEachOtherIsJudgedByTheLoads)
    {
        // Its supports take rigid motions away and bear nothing: no force is left to compare the rest with.
        constexpr double kTolerance = 1e-4, kNominal = 0.02;
        const mesh::TetMesh mesh = box(4);
        ElasticBody body(mesh, verification::uniform_tissue(mesh, MooneyRivlin { 0.025, 0.0, 0.5 }));
        const auto bottom = verification::faces_where(mesh, [](const Vec3& p) { return p.z() < kTiny; });
        const Eigen::VectorXd loads
            = traction_loads(mesh, top(mesh), { 0, 0, kNominal }) + traction_loads(mesh, bottom, { 0, 0, -kNominal });
        body.set_loads({ loads, {} });
        verification::Held held = verification::hold_nothing(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 p = mesh.vertices.row(v);
            const bool foot = (p - Vec3(0, 0, 0)).norm() < kTiny, along_x = (p - Vec3(2, 0, 0)).norm() < kTiny,
                       along_y = (p - Vec3(0, 3, 0)).norm() < kTiny;
            for (const int axis : { 0, 1, 2 })
                if (foot || (along_x && axis != 0) || (along_y && axis == 2))
                    hold(held, v, axis);
        }
        EquilibriumSolver solver;
        const Equilibrium result = solver.solve(body, held.prescribed, held.target,
            Eigen::VectorXd::Zero(held.target.size()), { .load_steps = 4, .tolerance = kTolerance }, Job {});
        ASSERT_EQ(result.status, EquilibriumStatus::converged) << result.message;
        EXPECT_LE(result.residual, kTolerance);
        EXPECT_LE(largest_length(result.forces), kTolerance * largest_length(loads));
        EXPECT_GT(result.residual, 1e-3 * kTolerance) << "no more was asked for";
    }

    TEST(Equilibrium, OfALinearBodyUnderPressureHasTheClosedForm)
    {
        const Bar b = bar(4);
        const verification::VerificationLaw law = verification::linear_law(1.0, 0.3);
        ElasticBody body = make_body(b.mesh, verification::VerificationElement::p1, law);
        body.set_loads({ {}, { FollowerPressure(b.mesh, top(b.mesh), 0.01) } });
        const verification::VerificationSolve solve
            = verification::solve_problem(body, b.held.prescribed, {}, { .tolerance = 1e-10 }, Job {});
        for (Eigen::Index v = 0; v < b.mesh.vertices.rows(); ++v)
            EXPECT_NEAR(solve.equilibrium.displacement[3 * v + 2], -0.01 * b.mesh.vertices(v, 2), 1e-12);
    }

    TEST(Equilibrium, ThatDoesNotExistIsSaidSo)
    {
        // A tube of an incompressible neo-Hookean solid holds at most mu ln(ro / ri).
        constexpr double kMu = 1.0 / 3.0;
        const double limit = kMu * std::log(14.5 / 12.5);
        const verification::QuarterTube tube = verification::quarter_tube(10, 12.5, 14.5, 8, 1, 1);
        ElasticBody body(
            tube.mesh, verification::uniform_tissue(tube.mesh, MooneyRivlin { 0.5 * kMu, 0.0, 1e3 * kMu }));
        body.set_loads({ {}, { FollowerPressure(tube.mesh, tube.inner_faces, 1.3 * limit) } });
        const verification::VerificationSolve solve
            = verification::solve_problem(body, tube.held.prescribed, {}, { .load_steps = 6 }, Job {});
        EXPECT_EQ(solve.equilibrium.status, EquilibriumStatus::not_converged);
        EXPECT_NE(solve.equilibrium.message.find("no equilibrium was found above"), std::string::npos)
            << solve.equilibrium.message;
        constexpr double kCoarse = 0.06; // one layer of elements, and load steps
        EXPECT_NEAR(1.3 * solve.equilibrium.load, 1.0, kCoarse) << solve.equilibrium.message;
        EXPECT_TRUE(solve.equilibrium.displacement.allFinite());
    }

    TEST(Equilibrium, ThatDoesNotExistLeavesNothingBehind)
    {
        constexpr double kFarTooMuch = 0.05, kRoundOff = 1e-12; // MPa; of the forces
        const SlitWall wall = slit_wall(12.5);
        const auto pressed = [&] {
            ElasticBody body(wall.mesh,
                verification::uniform_tissue(wall.mesh, hyperelastic_law(test_support::material(0.04, 0.45))));
            body.set_loads({ {}, { FollowerPressure(wall.mesh, wall.inner, kFarTooMuch) } });
            return body;
        };
        ElasticBody body = pressed(), other = pressed();
        const auto solved
            = [&] { return verification::solve_problem(body, wall.held.prescribed, {}, {}, Job {}).equilibrium; };
        const Equilibrium first = solved();
        ASSERT_EQ(first.status, EquilibriumStatus::not_converged);
        ASSERT_GT(first.load, 0.0);
        other.set_load_share(first.load);
        (void)other.renew_follower_loads(first.displacement);
        const Eigen::VectorXd forces = other.response(first.displacement).forces;
        EXPECT_LT((first.forces - forces).norm(), kRoundOff * forces.norm()) << "of the state that is told";
        const Equilibrium second = solved();
        EXPECT_EQ((second.displacement - first.displacement).norm(), 0.0) << "it begins as the first did";
        EXPECT_EQ(second.residual, first.residual);
    }

} // namespace equilibrium_test
} // namespace retractor::fem
