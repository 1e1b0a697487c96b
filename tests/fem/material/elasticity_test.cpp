#include "fem/material/elasticity.h"

#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
namespace elasticity_test {

    constexpr double kEps = 2.220446049250313e-16;
    const Lame kSoft = lame(test_support::material(1.0, 0.4));

    double energy_density(Elasticity model, const Lame& l, const Mat3& F)
    {
        return evaluate_point(model, l, F, false).energy;
    }
    Mat3 first_piola(Elasticity model, const Lame& l, const Mat3& F)
    {
        return evaluate_point(model, l, F, false).stress;
    }

    Mat3 random_matrix(std::mt19937& random)
    {
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        return Mat3::NullaryExpr([&] { return entry(random); });
    }

    Mat3 random_rotation(std::mt19937& random)
    {
        std::normal_distribution<double> entry;
        return Eigen::Quaterniond(entry(random), entry(random), entry(random), entry(random))
            .normalized()
            .toRotationMatrix();
    }

    Mat3 with_stretches(std::mt19937& random, const Vec3& s)
    {
        return random_rotation(random) * s.asDiagonal() * random_rotation(random);
    }

    /// Deformation gradients away from the energy's kink: random, nearly degenerate, flat, inverted.
    std::vector<std::pair<std::string, Mat3>> samples()
    {
        std::mt19937 random(7);
        std::vector<std::pair<std::string, Mat3>> all { { "identity", Mat3::Identity() } };
        for (int i = 0; i < 20; ++i)
            all.emplace_back("random", Mat3::Identity() + 0.6 * random_matrix(random));
        const std::vector<std::pair<std::string, Vec3>> special { { "two equal", { 1.5, 1.5, 0.7 } },
            { "two nearly equal", { 1.5, 1.5 + 1e-9, 0.7 } }, { "all equal", { 0.8, 0.8, 0.8 } },
            { "flat", { 1.2, 0.9, 0.0 } }, { "nearly flat", { 1.2, 0.9, 1e-12 } }, { "inverted", { 1.3, 0.9, -0.4 } },
            { "inverted, two equal", { 1.1, 1.1, -0.5 } }, { "long and thin", { 30.0, 0.5, 0.1 } } };
        for (const auto& [name, s] : special)
            all.emplace_back(name, with_stretches(random, s));
        return all;
    }

    TEST(SignedSvd, ReproducesTheMatrixWithRotations)
    {
        std::mt19937 random(3);
        std::vector<Mat3> matrices { Mat3::Zero(), Mat3::Identity(), -Mat3::Identity(),
            Vec3(1, 2, 3) * Eigen::RowVector3d(1, -1, 2), 1e-30 * Mat3::Identity(), 1e30 * Mat3::Identity() };
        for (int i = 0; i < 200; ++i)
            matrices.push_back(random_matrix(random));
        for (const Vec3& s : { Vec3(1, 1, 1e-14), Vec3(1, 1e-14, 1e-15), Vec3(1, 1e-8, -1e-8), Vec3(1e8, 1, 1e-8) })
            matrices.push_back(with_stretches(random, s));
        for (const Mat3& F : matrices) {
            const SignedSvd svd = signed_svd(F);
            const double tolerance = 32 * kEps; // a few sweeps of rotations
            EXPECT_LE((svd.U * svd.sigma.asDiagonal() * svd.V.transpose() - F).norm(), 4 * tolerance * F.norm()) << F;
            for (const Mat3& Q : { svd.U, svd.V }) {
                EXPECT_LE((Q.transpose() * Q - Mat3::Identity()).norm(), tolerance) << F;
                EXPECT_GT(Q.determinant(), 0.0) << F;
            }
            EXPECT_GE(svd.sigma[0] + tolerance * F.norm(), svd.sigma[1]);
            EXPECT_GE(svd.sigma[1] + tolerance * F.norm(), std::abs(svd.sigma[2]));
        }
    }

    TEST(Elasticity, HomogeneousStretchHasTheClosedForm)
    {
        const Lame l { 2.0, 3.0 };
        const Mat3 F = Vec3(1.5, 1.0, 0.8).asDiagonal();
        const double J = 1.2;
        EXPECT_NEAR(energy_density(Elasticity::corotational, l, F), 2.0 * (0.25 + 0.04) + 1.5 * 0.04, 1e-14);
        const Mat3 P = first_piola(Elasticity::corotational, l, F);
        EXPECT_NEAR(P(0, 0), 2 * 2.0 * 0.5 + 3.0 * (J - 1) * 0.8, 1e-14);
        EXPECT_NEAR(P(2, 2), 2 * 2.0 * -0.2 + 3.0 * (J - 1) * 1.5, 1e-14);
        EXPECT_NEAR(energy_density(Elasticity::linear, l, F), 2.0 * (0.25 + 0.04) + 1.5 * 0.09, 1e-14);
    }

    TEST(Elasticity, BoundedIsLinearElasticityInTheTissuesOwnFrameUpToItsLargestPressure)
    {
        const Lame l { 2.0, 3.0 };
        const Mat3 R = Eigen::AngleAxisd(2.0, Vec3(1, 2, 2).normalized()).toRotationMatrix();
        const Mat3 S = Vec3(1.5, 1.0, 0.8).asDiagonal();
        EXPECT_NEAR(
            energy_density(Elasticity::corotational_linear, l, R * S), energy_density(Elasticity::linear, l, S), 1e-14);
        EXPECT_LE(
            (first_piola(Elasticity::corotational_linear, l, R * S) - R * first_piola(Elasticity::linear, l, S)).norm(),
            1e-14);
        // Beyond tr(S - I) = 1.8 mu / lambda = 1.2.
        const Mat3 P = first_piola(Elasticity::corotational_linear, l, Vec3(4.0, 1.0, 0.5).asDiagonal());
        EXPECT_NEAR(P(0, 0), 2 * 2.0 * 3.0 + 1.8 * 2.0, 1e-14);
        EXPECT_NEAR(P(2, 2), 2 * 2.0 * -0.5 + 1.8 * 2.0, 1e-14);
        EXPECT_NEAR(energy_density(Elasticity::corotational_linear, l, Vec3(4.0, 1.0, 0.5).asDiagonal()),
            2.0 * (9.0 + 0.25) + 1.5 * 1.2 * 1.2 + 3.6 * 1.3, 1e-13);
    }

    TEST(Elasticity, BoundedStiffnessNeverExceedsThatAtRest)
    {
        for (const auto& [name, F] : samples()) {
            const TangentMatrix C = tangent_matrix(tangent(Elasticity::corotational_linear, kSoft, F, false));
            const double largest = Eigen::SelfAdjointEigenSolver<TangentMatrix>(C).eigenvalues().maxCoeff();
            EXPECT_LE(largest, (3.0 * kSoft.lambda + 2.0 * kSoft.mu) * (1.0 + 1e-12)) << name;
        }
    }

    TEST(Elasticity, CrushedTissueIsPenalisedFromHalfItsVolumeOn)
    {
        const Lame l { 2.0, 3.0 };
        const auto without = [&](double s) { return 2.0 * (s - 1) * (s - 1) + 1.5 * (s - 1) * (s - 1); };
        const auto energy
            = [&](double s) { return energy_density(Elasticity::corotational, l, Vec3(s, 1, 1).asDiagonal()); };
        EXPECT_NEAR(energy(0.5), without(0.5), 1e-14);
        EXPECT_NEAR(energy(0.2), without(0.2) + 100.0 / 3.0 * 7.0 * 0.027, 1e-12);
        EXPECT_NEAR(energy(-0.5), without(-0.5) + 100.0 / 3.0 * 7.0, 1e-12);
    }

    TEST(Elasticity, RotationCostsNothingInCorotationalAndDoesInLinear)
    {
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 2, 2).normalized()).toRotationMatrix();
        EXPECT_LE(energy_density(Elasticity::corotational, kSoft, R), 1e-28);
        EXPECT_LE(first_piola(Elasticity::corotational, kSoft, R).norm(), 1e-14);
        EXPECT_GT(energy_density(Elasticity::linear, kSoft, R), kSoft.mu);
    }

    TEST(Elasticity, RotatingTheBodyRotatesTheStress)
    {
        std::mt19937 random(5);
        for (const auto& [name, F] : samples()) {
            const Mat3 Q = random_rotation(random);
            const Mat3 P = first_piola(Elasticity::corotational, kSoft, F);
            EXPECT_LE((first_piola(Elasticity::corotational, kSoft, Q * F) - Q * P).norm(),
                1e-12 * (1.0 + P.norm() * F.norm()))
                << name;
        }
    }

    TEST(Elasticity, EnergyAndStressAreThoseOfTheSingularValues)
    {
        // With the tangent they are computed from the singular values, without it from the rotation alone.
        std::mt19937 random(11);
        std::vector<std::pair<std::string, Mat3>> all = samples();
        for (int i = 0; i < 200; ++i)
            all.emplace_back("rotated", random_rotation(random) * (Mat3::Identity() + 0.9 * random_matrix(random)));
        for (const Elasticity model : { Elasticity::corotational, Elasticity::corotational_linear })
            for (const auto& [name, F] : all) {
                const PointResponse from_values = evaluate_point(model, kSoft, F, true),
                                    from_rotation = evaluate_point(model, kSoft, F, false);
                constexpr double kRoundOff = 1e-11; // nearly singular F amplify it
                const double size = 1.0 + F.squaredNorm();
                EXPECT_NEAR(from_rotation.energy, from_values.energy, kRoundOff * size * size * size) << name;
                EXPECT_LT((from_rotation.stress - from_values.stress).norm(), kRoundOff * size * size * size) << name;
            }
    }

    TEST(Elasticity, StressIsTheDerivativeOfTheEnergy)
    {
        constexpr double h = 1e-5; // truncation h^2 meets round-off eps / h
        for (const Elasticity model : { Elasticity::linear, Elasticity::corotational, Elasticity::corotational_linear })
            for (const auto& [name, F] : samples()) {
                const Mat3 P = first_piola(model, kSoft, F);
                Mat3 difference;
                for (int i = 0; i < 9; ++i) {
                    Mat3 step = Mat3::Zero();
                    step(i / 3, i % 3) = h * F.norm();
                    difference(i / 3, i % 3)
                        = (energy_density(model, kSoft, F + step) - energy_density(model, kSoft, F - step))
                        / (2 * h * F.norm());
                }
                EXPECT_LE((difference - P).norm(), 1e-7 * (1.0 + P.norm())) << name;
            }
    }

    TEST(Elasticity, TangentIsTheDerivativeOfTheStress)
    {
        constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
        for (const Elasticity model : { Elasticity::linear, Elasticity::corotational, Elasticity::corotational_linear })
            for (const auto& [name, F] : samples()) {
                const TangentMatrix C = tangent_matrix(tangent(model, kSoft, F, false));
                TangentMatrix difference;
                for (int c = 0; c < 9; ++c) {
                    Mat3 step = Mat3::Zero();
                    step(c / 3, c % 3) = h;
                    const Mat3 dP
                        = (first_piola(model, kSoft, F + step) - first_piola(model, kSoft, F - step)) / (2 * h);
                    for (int r = 0; r < 9; ++r)
                        difference(r, c) = dP(r / 3, r % 3);
                }
                EXPECT_LE((difference - C).norm(), 1e-6 * C.norm()) << name;
            }
    }

    TEST(Elasticity, ProjectedTangentIsTheNearestSemidefiniteOne)
    {
        for (const Elasticity model : { Elasticity::corotational, Elasticity::corotational_linear })
            for (const auto& [name, F] : samples()) {
                const TangentMatrix C = tangent_matrix(tangent(model, kSoft, F, false));
                const TangentMatrix projected = tangent_matrix(tangent(model, kSoft, F, true));
                const Eigen::SelfAdjointEigenSolver<TangentMatrix> eigen(C);
                const TangentMatrix expected = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal()
                    * eigen.eigenvectors().transpose();
                EXPECT_LE((projected - expected).norm(), 1e-12 * C.norm()) << name;
                EXPECT_GE(
                    Eigen::SelfAdjointEigenSolver<TangentMatrix>(projected).eigenvalues().minCoeff(), -1e-13 * C.norm())
                    << name;
            }
    }

    TEST(Elasticity, OnlyExtremesAreRaised)
    {
        std::mt19937 random(13);
        const Elasticity model = Elasticity::corotational;
        for (const Vec3& s : { Vec3(1.9, 0.8, 0.6), Vec3(1.0, 0.9, 0.55) }) {
            const Mat3 F = with_stretches(random, s);
            EXPECT_EQ(tangent_matrix(tangent_raised_at_extremes(model, kSoft, F, 0.0)),
                tangent_matrix(tangent(model, kSoft, F, 0.0)));
        }
        for (const Vec3& s : { Vec3(2.1, 0.8, 0.7), Vec3(1.0, 0.9, 0.45), Vec3(1.0, 0.9, -0.3) }) {
            const Mat3 F = with_stretches(random, s);
            EXPECT_EQ(tangent_matrix(tangent_raised_at_extremes(model, kSoft, F, 0.0)),
                tangent_matrix(tangent(model, kSoft, F, 1.0)));
        }
        EXPECT_EQ(tangent_matrix(tangent_raised_at_extremes(Elasticity::linear, kSoft, 3.0 * Mat3::Identity(), 0.0)),
            tangent_matrix(tangent(Elasticity::linear, kSoft, Mat3::Identity(), 0.0)));
    }

    TEST(Elasticity, TangentAtRestIsLinearElasticity)
    {
        const TangentMatrix linear = tangent_matrix(tangent(Elasticity::linear, kSoft, Mat3::Identity(), false));
        for (const bool projected : { false, true })
            EXPECT_LE(
                (tangent_matrix(tangent(Elasticity::corotational, kSoft, Mat3::Identity(), projected)) - linear).norm(),
                1e-14 * linear.norm());
    }

    TEST(Elasticity, NothingIsNaNOnTheKink)
    {
        std::mt19937 random(11);
        for (const Vec3& s : { Vec3(1, 0.5, -0.5), Vec3(0, 0, 0), Vec3(1, 0, 0) })
            for (const bool projected : { false, true }) {
                const Mat3 F = with_stretches(random, s);
                EXPECT_TRUE(tangent_matrix(tangent(Elasticity::corotational, kSoft, F, projected)).allFinite());
                EXPECT_TRUE(first_piola(Elasticity::corotational, kSoft, F).allFinite());
            }
    }

} // namespace elasticity_test
} // namespace retractor::fem
