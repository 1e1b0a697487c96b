#include "fem/model/loads.h"

#include "fem/model/elastic_body.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/body_force.h"
#include "tests/verification/framework/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

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
