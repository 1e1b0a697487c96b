#include "fem/model/elastic_body.h"
#include "fem/statics/equilibrium.h"
#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/uniform_tissue.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace retractor::fem {
namespace hyperelastic_body_test {

    using namespace test_support;

    constexpr double kMu = 0.05, kBulk = 2.0; // MPa

    std::vector<Hyperelastic> laws()
    {
        return { NeoHookean { kMu, kBulk - 2.0 / 3.0 * kMu }, MooneyRivlin { 0.4 * kMu, 0.1 * kMu, kBulk },
            HolzapfelGasserOgden { kMu, 0.08, 3.0, 0.1, kBulk }, Guccione { 0.002, 8.0, 2.0, 4.0, kBulk } };
    }

    mesh::TetMesh p1_or_p2(const mesh::TetMesh& mesh, int nodes_per_tet)
    {
        return nodes_per_tet == 10 ? mesh::with_midpoints(mesh) : mesh;
    }

    /// All laws in one body, with fibres that turn from element to element.
    HyperelasticTissue mixed(const mesh::TetMesh& mesh)
    {
        HyperelasticTissue tissue { laws(), {}, {} };
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            tissue.law_of_element.push_back(static_cast<std::int32_t>(t % tissue.laws.size()));
            const double angle = 0.1 * static_cast<double>(t);
            tissue.fibres.push_back(
                { Vec3(std::cos(angle), std::sin(angle), 0.0), Vec3(0.0, std::cos(angle), std::sin(angle)) });
        }
        return tissue;
    }

    /// A unit cube pulled along x by `stretch` with free sides: the Cauchy stress.
    double uniaxial_stress(const Hyperelastic& law, int nodes_per_tet, double stretch)
    {
        const mesh::TetMesh mesh = p1_or_p2(mesh::kuhn_box(2, 2, 2, 0.5), nodes_per_tet);
        ElasticBody body(mesh, verification::uniform_tissue(mesh, law));
        const auto size = static_cast<std::size_t>(3 * mesh.vertices.rows());
        std::vector<std::uint8_t> prescribed(size, 0);
        Eigen::VectorXd target = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        const double tiny = 1e-9;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const Vec3 p = mesh.vertices.row(v).transpose();
            const auto i = static_cast<std::size_t>(3 * v);
            prescribed[i] = p.x() < tiny || p.x() > 1.0 - tiny;
            prescribed[i + 1] = p.y() < tiny;
            prescribed[i + 2] = p.z() < tiny;
            if (p.x() > 1.0 - tiny)
                target[3 * v] = stretch - 1.0;
        }
        EquilibriumSolver solver;
        const Equilibrium result = solver.solve(
            body, prescribed, target, Eigen::VectorXd::Zero(target.size()), { .tolerance = 1e-10 }, Job {});
        EXPECT_EQ(result.status, EquilibriumStatus::converged);
        double force = 0.0, top = 0.0;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            if (mesh.vertices(v, 0) > 1.0 - tiny)
                force += result.forces[3 * v];
            if (mesh.vertices(v, 1) > 1.0 - tiny)
                top = result.displacement[3 * v + 1];
        }
        return force / ((1.0 + top) * (1.0 + top));
    }

    TEST(HyperelasticBody, UniaxialStressOfAnIncompressibleSolid)
    {
        constexpr double kFirm = 1e3; // MPa: incompressible but for mu / K
        constexpr double kTol = 5.0 * kMu / kFirm; // relative
        for (const int n : { 4, 10 })
            for (const double stretch : { 0.7, 1.3, 1.8 }) {
                const double exact = kMu * (stretch * stretch - 1.0 / stretch);
                for (const Hyperelastic& law :
                    { Hyperelastic(NeoHookean { kMu, kFirm }), Hyperelastic(MooneyRivlin { 0.5 * kMu, 0.0, kFirm }) })
                    EXPECT_NEAR(uniaxial_stress(law, n, stretch), exact, kTol * std::abs(exact)) << n << " " << stretch;
            }
    }

    TEST(HyperelasticBody, HasSixZeroEigenvaluesAtRest)
    {
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(2, 1.0, 0.2, 2), n);
            ElasticBody body(mesh, mixed(mesh));
            const Eigen::MatrixXd K
                = test_support::dense(body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 0.0));
            const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
            EXPECT_GE(values.minCoeff(), -1e-13 * values.maxCoeff());
            EXPECT_EQ((values.array() < 1e-12 * values.maxCoeff()).count(), 6) << n;
        }
    }

    TEST(HyperelasticBody, RotationCostsNothing)
    {
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(3, 1.0, 0.2, 3), n);
            const ElasticBody body(mesh, mixed(mesh));
            const auto turned = body.response(
                verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p + Vec3(5, 0, 0); }));
            constexpr double kRoundOff = 1e-12; // of K times the volume, 27 mm^3
            EXPECT_LE(std::abs(turned.energy), kRoundOff * kBulk * 27.0) << n;
            EXPECT_LE(turned.forces.norm(), kRoundOff * kBulk * 27.0) << n;
        }
    }

    TEST(HyperelasticBody, ForcesAndStiffnessAreDerivatives)
    {
        std::mt19937 random(9);
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        for (const int n : { 4, 10 }) {
            const mesh::TetMesh mesh = p1_or_p2(verification::distorted_box(2, 1.0, 0.2, 5), n);
            ElasticBody body(mesh, mixed(mesh));
            const auto size = 3 * mesh.vertices.rows();
            const Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(size, [&] { return 0.05 * entry(random); });
            const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(size, [&] { return entry(random); });
            constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
            const auto plus = body.response(u + h * d), minus = body.response(u - h * d);
            const double slope = body.response(u).forces.dot(d);
            EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), slope, 1e-6 * std::abs(slope)) << n;
            const Eigen::VectorXd Kd = body.stiffness(u, 0.0).multiply(d);
            EXPECT_LE((Kd - (plus.forces - minus.forces) / (2 * h)).norm(), 1e-6 * Kd.norm()) << n;
        }
    }

    TEST(HyperelasticBody, AnElementTurnedOverHasInfiniteEnergyAndIsNoStart)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 1.0);
        ElasticBody body(mesh, verification::uniform_tissue(mesh, laws()[0]));
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        u[3 * 13] = 1.5; // the middle vertex, beyond its neighbour
        EXPECT_EQ(body.response(u).energy, std::numeric_limits<double>::infinity());
        std::vector<std::uint8_t> prescribed(static_cast<std::size_t>(u.size()), 0);
        for (std::size_t i = 0; i < 12; ++i)
            prescribed[i] = 1;
        EquilibriumSolver solver;
        EXPECT_NE(test_support::message_of([&] {
            (void)solver.solve(body, prescribed, u, u, {}, Job {});
        }).find("turned over"),
            std::string::npos);
    }

    TEST(HyperelasticBody, ALargePullTurnsNoElementOver)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 2, 2, 1.0);
        ElasticBody body(mesh, verification::uniform_tissue(mesh, MooneyRivlin { 0.5 * kMu, 0.0, kBulk }));
        std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
        Eigen::VectorXd target = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            if (const double x = mesh.vertices(v, 0); x < 0.5 || x > 3.5) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    prescribed[3 * static_cast<std::size_t>(v) + axis] = 1;
                target[3 * v] = x > 3.5 ? 6.0 : 0.0; // two and a half times as long
            }
        EquilibriumSolver solver;
        const Equilibrium result = solver.solve(
            body, prescribed, target, Eigen::VectorXd::Zero(target.size()), { .load_steps = 12 }, Job {});
        EXPECT_EQ(result.status, EquilibriumStatus::converged);
        for (const double ratio : body.deformation(result.displacement).smallest_ratio)
            EXPECT_GT(ratio, 0.0);
    }

    TEST(HyperelasticBody, EachElementOfAUniformStretchHasItsVolumeRatio)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 1.0);
        const ElasticBody body(mesh, verification::uniform_tissue(mesh, NeoHookean { kMu, 1.0 }));
        const Vec3 stretch(1.5, 0.8, 1.1);
        Eigen::VectorXd displacement(3 * mesh.vertices.rows());
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            displacement.segment<3>(3 * v)
                = (stretch.array() - 1.0).matrix().cwiseProduct(mesh.vertices.row(v).transpose());
        const std::vector<double> ratios = body.deformation(displacement).volume_ratio;
        ASSERT_EQ(ratios.size(), mesh.tet_count());
        constexpr double kRounding = 1e-12;
        for (const double ratio : ratios)
            EXPECT_NEAR(ratio, stretch.prod(), kRounding);
    }

    TEST(HyperelasticBodyBadInput, IsNamed)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0);
        const auto refuse = [&](const HyperelasticTissue& tissue) {
            return test_support::message_of([&] { const ElasticBody body(mesh, tissue); });
        };
        HyperelasticTissue tissue = verification::uniform_tissue(mesh, NeoHookean { kMu, 0.0 });
        tissue.law_of_element[3] = 1;
        EXPECT_EQ(refuse(tissue), "element 3: there is no law 1");
        tissue.law_of_element.pop_back();
        EXPECT_EQ(refuse(tissue), "materials: a body needs a law for each element");
        tissue = verification::uniform_tissue(mesh, NeoHookean { 0.0, 1.0 });
        EXPECT_NE(refuse(tissue).find("mu"), std::string::npos) << refuse(tissue);
        tissue = verification::uniform_tissue(mesh, NeoHookean { std::nan(""), 1.0 });
        EXPECT_NE(refuse(tissue).find("mu"), std::string::npos) << refuse(tissue);
        tissue = verification::uniform_tissue(mesh, NeoHookean { kMu, 1.0 });
        tissue.fibres.assign(mesh.tet_count(), {});
        tissue.fibres[2].second = Vec3(1, 1, 0);
        EXPECT_EQ(refuse(tissue), "element 2: a fibre direction must be a unit vector");
        tissue.fibres.pop_back();
        EXPECT_EQ(refuse(tissue), "fibres: fibres are given for all elements or for none");
        EXPECT_NE(
            test_support::message_of([&] { const ElasticBody body(mesh, Elasticity::hyperelastic, {}); }).find("laws"),
            std::string::npos);
        EXPECT_NE(test_support::message_of([&] {
            const ElasticBody body(mesh, Elasticity::linear, {});
        }).find("each element"),
            std::string::npos);
    }

} // namespace hyperelastic_body_test
} // namespace retractor::fem
