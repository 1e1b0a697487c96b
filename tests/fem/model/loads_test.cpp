#include "fem/model/loads.h"

#include "fem/linear_algebra/norm.h"
#include "fem/statics/equilibrium.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/body_force.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <string>

namespace retractor::fem {
namespace loads_test {

    constexpr double kTiny = 1e-9;

    /// A box of 2 x 3 x 4 mm, bent so that P2 faces are curved.
    mesh::TetMesh bent_box(int nodes_per_tet)
    {
        return verification::mapped_box(nodes_per_tet, 2, 3, 4, [](const Vec3& p) -> Vec3 {
            return { p.x() + 0.05 * p.z() * p.z(), p.y(), p.z() + 0.03 * p.x() * p.y() };
        });
    }

    mesh::TetMesh straight_box(int nodes_per_tet)
    {
        return verification::mapped_box(nodes_per_tet, 2, 3, 4, [](const Vec3& p) { return p; });
    }

    std::vector<mesh::TetFace> top(const mesh::TetMesh& mesh)
    {
        return verification::faces_where(mesh, [](const Vec3& p) { return p.z() > 4.0 - kTiny; });
    }

    Vec3 sum(const Eigen::VectorXd& nodal)
    {
        Vec3 total = Vec3::Zero();
        for (Eigen::Index i = 0; i < nodal.size(); i += 3)
            total += nodal.segment<3>(i);
        return total;
    }

    Eigen::VectorXd random_motion(const mesh::TetMesh& mesh, double size, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> entry(-size, size);
        return Eigen::VectorXd::NullaryExpr(3 * mesh.vertices.rows(), [&] { return entry(random); });
    }

    TEST(Loads, TractionsAndBodyForcesAddUpToAreaAndVolume)
    {
        constexpr double kRoundOff = 1e-13;
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = straight_box(n);
            const Vec3 t(0.1, -0.2, 0.3);
            EXPECT_LE((sum(traction_loads(mesh, top(mesh), t)) - 6.0 * t).norm(), kRoundOff * 10.0) << n;
            EXPECT_LE(
                (sum(verification::body_force_loads(mesh, [&](const Vec3&) { return t; })) - 24.0 * t).norm(), 1e-11)
                << n;
            // The rule's weights have 15 digits. Linear in z: the mean is that of the middle.
            EXPECT_LE(
                (sum(verification::body_force_loads(mesh, [&](const Vec3& p) -> Vec3 { return p.z() * t; })) - 48.0 * t)
                    .norm(),
                1e-11)
                << n;
        }
    }

    TEST(Loads, PressurePushesInwardsByItsArea)
    {
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = straight_box(n);
            const FollowerPressure pressure(mesh, top(mesh), 0.01);
            const Vec3 total = sum(pressure.force(Eigen::VectorXd::Zero(3 * mesh.vertices.rows())));
            EXPECT_LE((total - Vec3(0, 0, -0.06)).norm(), 1e-15) << n;
        }
    }

    TEST(Loads, PressureAllRoundIsTheDerivativeOfTheVolumeAndLeavesNoForce)
    {
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = bent_box(n);
            const FollowerPressure pressure(mesh, mesh::boundary_faces(mesh), 0.01);
            const Eigen::VectorXd u = random_motion(mesh, 0.1, 3), force = pressure.force(u);
            EXPECT_LE(sum(force).norm(), 1e-15) << n;
            Eigen::VectorXd gradient = Eigen::VectorXd::Zero(u.size());
            (void)pressure.add_response(u, 1.0, gradient);
            EXPECT_LE((force + gradient).norm(), 1e-14) << n;
        }
    }

    TEST(Loads, PressureIsDerivedRight)
    {
        constexpr double h = 1e-5; // the energy is cubic: central differences err by h^2
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = bent_box(n);
            FollowerPressure pressure(
                mesh, verification::faces_where(mesh, [](const Vec3& p) { return p.y() < kTiny; }), 0.01);
            const Eigen::VectorXd u = random_motion(mesh, 0.1, 5), d = random_motion(mesh, 1.0, 6);
            pressure.renew_rim(random_motion(mesh, 0.1, 8));
            const auto gradient = [&](const Eigen::VectorXd& at) {
                Eigen::VectorXd g = Eigen::VectorXd::Zero(u.size());
                (void)pressure.add_response(at, 0.7, g);
                return g;
            };
            Eigen::VectorXd unused = Eigen::VectorXd::Zero(u.size());
            const double slope = 0.7
                * (pressure.add_response(u + h * d, 1.0, unused) - pressure.add_response(u - h * d, 1.0, unused))
                / (2 * h);
            EXPECT_NEAR(slope, gradient(u).dot(d), 1e-9) << n;
            BlockMatrix K { block_pattern(mesh), {} };
            K.values.assign(9 * K.pattern.block_count(), 0.0);
            pressure.add_stiffness(u, 0.7, K);
            const Eigen::VectorXd difference = (gradient(u + h * d) - gradient(u - h * d)) / (2 * h);
            EXPECT_GT(difference.norm(), 1e-3);
            EXPECT_LE((K.multiply(d) - difference).norm(), 1e-8 * difference.norm()) << n;
        }
    }

    /// What is constant within a Newton step and renewed after it.
    Eigen::VectorXd without_energy(const FollowerPressure& pressure, const Eigen::VectorXd& u)
    {
        Eigen::VectorXd rest = pressure.force(u);
        (void)pressure.add_response(u, 1.0, rest);
        return rest;
    }

    /// How that changes along d at u, where the rim was renewed.
    Eigen::VectorXd change_without_energy(
        FollowerPressure& pressure, const Eigen::VectorXd& u, const Eigen::VectorXd& d)
    {
        constexpr double h = 1e-5; // quadratic: central differences are exact
        pressure.renew_rim(u);
        return (without_energy(pressure, u + h * d) - without_energy(pressure, u - h * d)) / (2 * h);
    }

    /// Wherever the rim lies: else steps under load do not settle far from its planes of symmetry.
    TEST(Loads, WhatAFreeRimHasNoEnergyForIsSkew)
    {
        constexpr double kRoundOff = 1e-9;
        for (const int n : { 4, 10 })
            for (const Vec3& middle : { Vec3(Vec3::Zero()), Vec3(100.0, -50.0, 30.0) }) {
                mesh::TetMesh mesh = bent_box(n);
                mesh.vertices.rowwise() += middle.transpose();
                FollowerPressure pressure(mesh,
                    verification::faces_where(mesh, [&](const Vec3& p) { return p.y() - middle.y() < kTiny; }), 0.01);
                const Eigen::VectorXd u = random_motion(mesh, 0.1, 5), a = random_motion(mesh, 1.0, 6),
                                      b = random_motion(mesh, 1.0, 7);
                const Eigen::VectorXd by_a = change_without_energy(pressure, u, a),
                                      by_b = change_without_energy(pressure, u, b);
                EXPECT_GT(std::abs(b.dot(by_a)), 1e-4) << "the rim is free";
                EXPECT_NEAR(b.dot(by_a), -a.dot(by_b), kRoundOff) << n;
                EXPECT_NEAR(a.dot(by_a), 0.0, kRoundOff) << n;
            }
    }

    TEST(Loads, RimsInPlanesOfSymmetryHaveAnEnergyForAll)
    {
        for (const int n : { 4, 10 }) {
            const verification::QuarterTube tube = verification::quarter_tube(n, 12.5, 14.5, 24, 2, 1);
            FollowerPressure pressure(tube.mesh, tube.inner_faces, 0.01);
            const auto free_part = [&](Eigen::VectorXd forces) {
                for (Eigen::Index i = 0; i < forces.size(); ++i)
                    if (tube.held.prescribed[static_cast<std::size_t>(i)] != 0)
                        forces[i] = 0.0;
                return forces;
            };
            const Eigen::VectorXd u = free_part(random_motion(tube.mesh, 0.02, 3)),
                                  d = free_part(random_motion(tube.mesh, 1.0, 4));
            const Eigen::VectorXd changed = free_part(pressure.force(u + d) - pressure.force(u));
            constexpr double kRoundOff = 1e-7; // of the differences
            EXPECT_LT(free_part(change_without_energy(pressure, u, d)).lpNorm<Eigen::Infinity>(),
                kRoundOff * changed.lpNorm<Eigen::Infinity>())
                << n;
        }
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
        Bar b { straight_box(nodes_per_tet), {} };
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
        const mesh::TetMesh mesh = straight_box(4);
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

    TEST(LoadsBadInput, IsNamed)
    {
        const mesh::TetMesh mesh = straight_box(4);
        mesh::TetFace inner;
        for (inner.tet = 0;; ++inner.tet) { // a face that no boundary face is
            for (inner.corner = 0; inner.corner < 4; ++inner.corner) {
                bool boundary = false;
                for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
                    boundary = boundary || (face.tet == inner.tet && face.corner == inner.corner);
                if (!boundary)
                    break;
            }
            if (inner.corner < 4)
                break;
        }
        const std::string inside = test_support::message_of([&] { const FollowerPressure p(mesh, { inner }, 1.0); });
        EXPECT_NE(inside.find("element " + std::to_string(inner.tet)), std::string::npos) << inside;
        EXPECT_NE(inside.find("inside"), std::string::npos) << inside;
        const double nan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_NE(test_support::message_of([&] { const FollowerPressure p(mesh, top(mesh), nan); }).find("not finite"),
            std::string::npos);
        EXPECT_NE(test_support::message_of([&] {
            (void)traction_loads(mesh, top(mesh), { 0, nan, 0 });
        }).find("not finite"),
            std::string::npos);
        EXPECT_NE(test_support::message_of([&] {
            (void)traction_loads(mesh, {}, { 0, 0, 0 });
        }).find("at least one face"),
            std::string::npos);
        ElasticBody body = make_body(mesh, verification::VerificationElement::p1, verification::linear_law(1.0, 0.3));
        EXPECT_NE(test_support::message_of([&] {
            body.set_loads({ Eigen::VectorXd::Zero(3), {} });
        }).find("three entries per node"),
            std::string::npos);
        Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        loads[7] = nan;
        EXPECT_EQ(test_support::message_of([&] {
            body.set_loads({ loads, {} });
        }),
            "node 2: a nodal load is not finite");
    }

} // namespace loads_test
} // namespace retractor::fem
