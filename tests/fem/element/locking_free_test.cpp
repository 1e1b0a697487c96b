#include "fem/element/locking_free.h"

#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/nodal_element.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <random>

namespace retractor::fem {
namespace locking_free_test {

    const std::vector<verification::VerificationElement> kElements { verification::VerificationElement::locking_free,
        verification::VerificationElement::nodal };

    std::vector<verification::VerificationLaw> laws()
    {
        const Lame l = verification::linear_law(1.0, 0.45).lame;
        const double bulk = l.lambda + 2.0 / 3.0 * l.mu;
        verification::VerificationLaw fibres
            = verification::hyperelastic_law("fibres", HolzapfelGasserOgden { l.mu, l.mu, 2.0, 0.1, bulk });
        fibres.fibres = { Vec3(1, 2, 2).normalized(), Vec3(2, 1, -2).normalized() };
        return { verification::linear_law(1.0, 0.45), { "corotational", Elasticity::corotational, l, {}, {} },
            verification::hyperelastic_law("neo-Hookean", NeoHookean { l.mu, l.lambda }),
            verification::hyperelastic_law("Mooney-Rivlin", MooneyRivlin { 0.4 * l.mu, 0.1 * l.mu, bulk }), fibres,
            verification::hyperelastic_law("Guccione", Guccione { 0.1 * l.mu, 8.0, 2.0, 4.0, bulk }) };
    }

    Eigen::VectorXd random_motion(const mesh::TetMesh& mesh, double size, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> entry(-size, size);
        return Eigen::VectorXd::NullaryExpr(3 * mesh.vertices.rows(), [&] { return entry(random); });
    }

    TEST(LockingFree, ThickTubeDoesNotLock)
    {
        // [Lame]; ri 12.5, ro 14.5, 288 elements. Plain elements err by 17 % at nu 0.4999.
        constexpr double E = 0.5, p = 16.0 / 3.0 * 1e-3, ri = 12.5, ro = 14.5;
        const verification::QuarterTube tube = verification::quarter_tube(4, ri, ro, 24, 2, 1);
        for (const double nu : { 0.3, 0.49, 0.4999, 0.499999 }) {
            const double exact = (1 + nu) / E * p * ri * ri / (ro * ro - ri * ri) * ((1 - 2 * nu) * ri + ro * ro / ri);
            ElasticBody body = make_body(
                tube.mesh, verification::VerificationElement::locking_free, verification::linear_law(E, nu));
            body.set_loads({ {}, { FollowerPressure(tube.mesh, tube.inner_faces, p) } });
            const verification::VerificationSolve solve
                = verification::solve_problem(body, tube.held.prescribed, {}, { .tolerance = 1e-8 }, Job {});
            EXPECT_NEAR(verification::inner_displacement(tube, solve.equilibrium.displacement) / exact, 1.0, 5e-4)
                << nu;
        }
    }

    TEST(LockingFree, LinearFieldIsExactAlsoAcrossMaterials)
    {
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        const mesh::TetMesh mesh = verification::distorted_box(4, 1.0, 0.2, 3);
        const verification::Held held
            = verification::hold_boundary(mesh, [&](const Vec3& p) -> Vec3 { return gradient * p; });
        const Eigen::VectorXd exact
            = verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return gradient * p; });
        for (const verification::VerificationElement element : kElements)
            for (const verification::VerificationLaw& law : laws()) {
                ElasticBody body = make_body(mesh, element, law);
                const verification::VerificationSolve solve
                    = verification::solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-11 }, Job {});
                EXPECT_LE((solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff(), 1e-9) << law.name;
            }
    }

    TEST(LockingFree, NoDomainSpansTwoMaterials)
    {
        // Two layers pulled in series: each stretches by its own stiffness, with nu 0 as two springs do.
        const mesh::TetMesh mesh = verification::mapped_box(4, 2, 2, 4, [](const Vec3& p) { return p; });
        std::vector<Lame> lame;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            double z = 0.0;
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                z += 0.25 * mesh.vertices(v, 2);
            lame.push_back({ z < 2.0 ? 0.5 : 500.0, 0.0 });
        }
        verification::Held held = verification::hold_nothing(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            for (const int axis : { 0, 1 })
                if (mesh.vertices(v, axis) == 0.0)
                    hold(held, v, axis);
            if (mesh.vertices(v, 2) == 0.0)
                hold(held, v, 2);
            if (mesh.vertices(v, 2) == 4.0)
                hold(held, v, 2, 1.001);
        }
        for (const verification::VerificationElement element : kElements) {
            ElasticBody body(mesh, Elasticity::linear, lame);
            body.avoid_locking(
                element == verification::VerificationElement::nodal ? verification::nodal_domains : edge_patch_domains);
            const verification::VerificationSolve solve
                = verification::solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-10 }, Job {});
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
                const double z = mesh.vertices(v, 2);
                EXPECT_NEAR(
                    solve.equilibrium.displacement[3 * v + 2], z <= 2.0 ? 0.5 * z : 1.0 + 0.0005 * (z - 2.0), 1e-9);
            }
        }
    }

    TEST(LockingFree, HasSixZeroEigenvaluesAndRotationCostsNothing)
    {
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        const mesh::TetMesh mesh = verification::distorted_box(3, 1.0, 0.2, 2);
        for (const verification::VerificationElement element : kElements)
            for (const verification::VerificationLaw& law : laws()) {
                ElasticBody body = make_body(mesh, element, law);
                const Eigen::MatrixXd K
                    = test_support::dense(body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 0.0));
                const Eigen::VectorXd values
                    = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
                EXPECT_GE(values.minCoeff(), -1e-12 * values.maxCoeff()) << law.name;
                EXPECT_EQ((values.array() < 1e-11 * values.maxCoeff()).count(), 6) << law.name;
                if (law.model == Elasticity::linear)
                    continue;
                const auto turned
                    = body.response(verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p; }));
                EXPECT_LE(std::abs(turned.energy), 1e-11) << law.name; // round-off of lambda, 3 MPa, times 27 mm^3
                EXPECT_LE(turned.forces.norm(), 1e-11) << law.name;
            }
    }

    TEST(LockingFree, ForcesAndStiffnessAreDerivatives)
    {
        constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
        const mesh::TetMesh mesh = verification::distorted_box(3, 1.0, 0.2, 5);
        const Eigen::VectorXd u = random_motion(mesh, 0.05, 7), d = random_motion(mesh, 1.0, 8);
        for (const verification::VerificationElement element : kElements)
            for (const verification::VerificationLaw& law : laws()) {
                ElasticBody body = make_body(mesh, element, law);
                const auto plus = body.response(u + h * d), minus = body.response(u - h * d);
                const double slope = body.response(u).forces.dot(d);
                EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), slope, 1e-6 * std::abs(slope)) << law.name;
                const Eigen::VectorXd Kd = body.stiffness(u, 0.0).multiply(d);
                EXPECT_LE((Kd - (plus.forces - minus.forces) / (2 * h)).norm(), 2e-6 * Kd.norm()) << law.name;
            }
    }

    TEST(LockingFree, LiftedStiffnessHasNoNegativeEigenvalue)
    {
        const mesh::TetMesh mesh = verification::distorted_box(2, 1.0, 0.2, 5);
        const Eigen::VectorXd u = random_motion(mesh, 0.12, 9);
        for (const verification::VerificationElement element : kElements)
            for (const verification::VerificationLaw& law : laws()) {
                ElasticBody body = make_body(mesh, element, law);
                const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                    test_support::dense(body.stiffness(u, 1.0)), Eigen::EigenvaluesOnly)
                                                   .eigenvalues();
                EXPECT_GE(values.minCoeff(), -1e-11 * values.maxCoeff()) << law.name;
            }
    }

    TEST(LockingFree, IsTheSameOnEveryRun)
    {
        const mesh::TetMesh mesh = verification::distorted_box(9, 1.0, 0.2, 5); // enough elements for two threads
        const Eigen::VectorXd u = random_motion(mesh, 0.05, 7);
        ElasticBody a = make_body(mesh, verification::VerificationElement::locking_free, laws()[2]),
                    b = make_body(mesh, verification::VerificationElement::locking_free, laws()[2]);
        EXPECT_EQ(a.response(u).forces, b.response(u).forces);
        EXPECT_EQ(a.stiffness(u, 0.0).values, b.stiffness(u, 0.0).values);
    }

    TEST(LockingFreeBadInput, TenNodeElementsAreRefused)
    {
        const mesh::TetMesh mesh = mesh::with_midpoints(mesh::kuhn_box(1, 1, 1, 1.0));
        ElasticBody body = make_body(mesh, verification::VerificationElement::p2, laws()[0]);
        EXPECT_THROW(body.avoid_locking(), InputError);
    }

} // namespace locking_free_test
} // namespace retractor::fem
