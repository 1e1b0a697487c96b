#include "fem/material/hyperelasticity.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
namespace hyperelasticity_test {

    constexpr double kMu = 0.05, kBulk = 2.0; // MPa
    /// Almost incompressible: closed forms hold for K -> infinity, with an error of order mu / K.
    constexpr double kFirmBulk = 1e5;
    constexpr double kIncompressible = 5e-6; // relative, a few mu / K

    std::vector<std::pair<std::string, Hyperelastic>> laws(double bulk)
    {
        return { { "neo-Hookean", NeoHookean { kMu, bulk - 2.0 / 3.0 * kMu } },
            { "Mooney-Rivlin", MooneyRivlin { 0.4 * kMu, 0.1 * kMu, bulk } },
            { "fibres", HolzapfelGasserOgden { kMu, 0.08, 3.0, 0.1, bulk } },
            { "fibres without spread", HolzapfelGasserOgden { kMu, 0.08, 3.0, 0.0, bulk } },
            { "Guccione", Guccione { 0.002, 8.0, 2.0, 4.0, bulk } } };
    }

    const FibreDirections kFibres { Vec3(1, 2, 2).normalized(), Vec3(2, 1, -2).normalized() };

    /// Where fibres begin to be stretched the tangent jumps: at rest such laws have no derivative to compare with.
    bool at_a_jump(const Hyperelastic& law, const Mat3& F)
    {
        return std::holds_alternative<HolzapfelGasserOgden>(law) && F.isIdentity();
    }

    std::vector<Mat3> samples()
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> entry(-1.0, 1.0);
        std::vector<Mat3> all { Mat3::Identity(), Vec3(1.5, 0.9, 0.8).asDiagonal(), Vec3(0.6, 1.0, 1.0).asDiagonal() };
        while (all.size() < 20) {
            const Mat3 F = Mat3::Identity() + 0.4 * Mat3::NullaryExpr([&] { return entry(random); });
            if (F.determinant() > 0.2)
                all.push_back(F);
        }
        return all;
    }

    Mat3 stress(const Hyperelastic& law, const Mat3& F) { return evaluate_point(law, kFibres, F, false).stress; }

    TEST(Hyperelasticity, StressIsTheDerivativeOfTheEnergy)
    {
        constexpr double h = 1e-5; // truncation h^2 meets round-off eps / h
        for (const auto& [name, law] : laws(kBulk))
            for (const Mat3& F : samples()) {
                if (at_a_jump(law, F))
                    continue;
                Mat3 difference;
                for (int i = 0; i < 9; ++i) {
                    Mat3 step = Mat3::Zero();
                    step(i / 3, i % 3) = h;
                    difference(i / 3, i % 3) = (evaluate_point(law, kFibres, F + step, false).energy
                                                   - evaluate_point(law, kFibres, F - step, false).energy)
                        / (2 * h);
                }
                const Mat3 P = stress(law, F);
                EXPECT_LE((difference - P).norm(), 1e-7 * (kBulk + P.norm())) << name << '\n' << F;
            }
    }

    TEST(Hyperelasticity, TangentIsTheDerivativeOfTheStress)
    {
        constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
        for (const auto& [name, law] : laws(kBulk))
            for (const Mat3& F : samples()) {
                if (at_a_jump(law, F))
                    continue;
                const TangentMatrix C = evaluate_point(law, kFibres, F, true).tangent;
                TangentMatrix difference;
                for (int c = 0; c < 9; ++c) {
                    Mat3 step = Mat3::Zero();
                    step(c / 3, c % 3) = h;
                    const Mat3 dP = (stress(law, F + step) - stress(law, F - step)) / (2 * h);
                    for (int r = 0; r < 9; ++r)
                        difference(r, c) = dP(r / 3, r % 3);
                }
                EXPECT_LE((difference - C).norm(), 1e-6 * C.norm()) << name << '\n' << F;
                EXPECT_LE((C - C.transpose()).norm(), 1e-13 * C.norm()) << name;
            }
    }

    TEST(Hyperelasticity, RotationCostsNothingAndTurnsTheStress)
    {
        const Mat3 Q = Eigen::AngleAxisd(1.2, Vec3(1, 2, 2).normalized()).toRotationMatrix();
        for (const auto& [name, law] : laws(kBulk)) {
            EXPECT_LE(evaluate_point(law, kFibres, Q, false).energy, 1e-14) << name;
            EXPECT_LE(stress(law, Q).norm(), 1e-13) << name;
            for (const Mat3& F : samples())
                EXPECT_LE((stress(law, Q * F) - Q * stress(law, F)).norm(), 1e-12 * (kBulk + stress(law, F).norm()))
                    << name;
        }
    }

    TEST(Hyperelasticity, TangentAtRestIsLinearElasticity)
    {
        for (const auto& [name, law] : laws(kBulk)) {
            if (name.starts_with("fibres") || name == "Guccione")
                continue; // stiffer along the fibres: below
            const TangentMatrix linear
                = tangent_matrix(tangent(Elasticity::linear, small_strain_moduli(law), Mat3::Identity(), 0.0));
            EXPECT_LE(
                (evaluate_point(law, kFibres, Mat3::Identity(), true).tangent - linear).norm(), 1e-14 * linear.norm())
                << name;
        }
        // Alike in all directions, Guccione's law is isotropic.
        const Hyperelastic isotropic = Guccione { 0.002, 5.0, 5.0, 5.0, kBulk };
        const TangentMatrix linear
            = tangent_matrix(tangent(Elasticity::linear, small_strain_moduli(isotropic), Mat3::Identity(), 0.0));
        EXPECT_LE((evaluate_point(isotropic, kFibres, Mat3::Identity(), true).tangent - linear).norm(),
            1e-14 * linear.norm());
    }

    /// Cauchy stress along x where the sides, alike, are free: their stretch is found by bisection.
    double uniaxial_stress(const Hyperelastic& law, double stretch)
    {
        const auto at = [&](double side) {
            const Mat3 F = Vec3(stretch, side, side).asDiagonal();
            const HyperelasticPoint point = evaluate_point(law, kFibres, F, false);
            return Mat3(point.stress * F.transpose() / point.volume_ratio);
        };
        double low = 0.5 / std::sqrt(stretch), high = 2.0 / std::sqrt(stretch);
        for (int i = 0; i < 200; ++i) {
            const double middle = 0.5 * (low + high);
            (at(middle)(1, 1) < 0.0 ? low : high) = middle;
        }
        return at(0.5 * (low + high))(0, 0);
    }

    TEST(Hyperelasticity, NeoHookeanStretchHasTheClosedForm)
    {
        for (const Hyperelastic& law :
            { Hyperelastic(NeoHookean { kMu, kFirmBulk }), Hyperelastic(MooneyRivlin { 0.5 * kMu, 0.0, kFirmBulk }) })
            for (const double l : { 0.7, 1.1, 1.5, 2.0 }) {
                const double exact = kMu * (l * l - 1.0 / l);
                EXPECT_NEAR(uniaxial_stress(law, l), exact, kIncompressible * std::abs(exact));
            }
    }

    TEST(Hyperelasticity, MooneyRivlinStretchHasTheClosedForm)
    {
        const Hyperelastic law = MooneyRivlin { 0.02, 0.005, kFirmBulk };
        for (const double l : { 0.7, 1.1, 1.5, 2.0 }) { // 2 (l^2 - 1/l) (c10 + c01 / l)
            const double exact = 2.0 * (l * l - 1.0 / l) * (0.02 + 0.005 / l);
            EXPECT_NEAR(uniaxial_stress(law, l), exact, kIncompressible * std::abs(exact));
        }
    }

    TEST(Hyperelasticity, EquibiaxialStretchAndShearHaveTheClosedForm)
    {
        const Hyperelastic law = MooneyRivlin { 0.5 * kMu, 0.0, kBulk };
        for (const double l : { 0.8, 1.2, 1.5 }) { // thickness as of an incompressible sheet: the pressure drops out
            const Mat3 F = Vec3(l, l, 1.0 / (l * l)).asDiagonal();
            const Mat3 cauchy = stress(law, F) * F.transpose();
            EXPECT_NEAR(cauchy(0, 0) - cauchy(2, 2), kMu * (l * l - std::pow(l, -4)), 1e-14);
        }
        Mat3 F = Mat3::Identity();
        F(0, 1) = 0.4;
        EXPECT_NEAR((stress(law, F) * F.transpose())(0, 1), kMu * 0.4, 1e-15);
    }

    TEST(Hyperelasticity, FibresActOnlyWhenStretched)
    {
        const HolzapfelGasserOgden fibres { kMu, 0.08, 3.0, 0.0, kBulk };
        const FibreDirections along_x { Vec3::UnitX(), Vec3::UnitX() };
        const auto axial = [&](double k1, double l) {
            HolzapfelGasserOgden law = fibres;
            law.k1 = k1;
            const Mat3 F = Vec3(l, 1.0 / std::sqrt(l), 1.0 / std::sqrt(l)).asDiagonal();
            return evaluate_point(law, along_x, F, false).stress(0, 0);
        };
        EXPECT_DOUBLE_EQ(axial(0.08, 0.9), axial(0.0, 0.9));
        // Two families, e = l^2 - 1: distortional energy k1/k2 (exp(k2 e^2) - 1); its slope by l at constant volume.
        const double l = 1.2, e = l * l - 1.0;
        const Mat3 F = Vec3(l, 1.0 / std::sqrt(l), 1.0 / std::sqrt(l)).asDiagonal();
        Mat3 rate = Mat3::Zero(); // d F / d l
        rate.diagonal() << 1.0, -0.5 * std::pow(l, -1.5), -0.5 * std::pow(l, -1.5);
        const double work = evaluate_point(fibres, along_x, F, false).stress.cwiseProduct(rate).sum();
        const double matrix = kMu * (l - 1.0 / (l * l));
        EXPECT_NEAR(work, matrix + 2.0 * 0.08 * e * std::exp(3.0 * e * e) * 2.0 * l, 1e-14);
    }

    TEST(Hyperelasticity, GuccioneIsStiffestAlongItsFibres)
    {
        const Hyperelastic law = Guccione { 0.002, 8.0, 2.0, 4.0, kBulk };
        const FibreDirections along_x { Vec3::UnitX(), Vec3::UnitX() };
        const auto energy = [&](int axis) {
            Vec3 stretch = Vec3::Constant(1.0 / std::sqrt(1.1));
            stretch[axis] = 1.1;
            return evaluate_point(law, along_x, stretch.asDiagonal(), false).energy;
        };
        // E = ((1.21 - 1), (1/1.1 - 1), (1/1.1 - 1)) / 2, the first along the stretch.
        const double a = 0.105, b = 0.5 * (1.0 / 1.1 - 1.0);
        EXPECT_NEAR(energy(0), 0.001 * (std::exp(8.0 * a * a + 4.0 * b * b) - 1.0), 1e-16);
        EXPECT_NEAR(energy(1), 0.001 * (std::exp(8.0 * b * b + 2.0 * (a * a + b * b)) - 1.0), 1e-16);
    }

    TEST(Hyperelasticity, TurnedOverTissueHasInfiniteEnergy)
    {
        for (const auto& [name, law] : laws(kBulk))
            for (const double j : { 0.0, -0.5 })
                EXPECT_EQ(evaluate_point(law, kFibres, Vec3(1.0, 1.0, j).asDiagonal(), true).energy,
                    std::numeric_limits<double>::infinity())
                    << name;
    }

    TEST(Hyperelasticity, LiftedTangentIsTheNearestSemidefiniteOne)
    {
        const Hyperelastic law = MooneyRivlin { 0.5 * kMu, 0.0, kBulk };
        TangentMatrix C = evaluate_point(law, kFibres, Vec3(0.5, 0.8, 0.9).asDiagonal(), true).tangent;
        const Eigen::SelfAdjointEigenSolver<TangentMatrix> before(C);
        ASSERT_LT(before.eigenvalues()[0], 0.0);
        lift_negative(C, 1.0);
        const Eigen::SelfAdjointEigenSolver<TangentMatrix> after(C);
        EXPECT_LE((after.eigenvalues() - before.eigenvalues().cwiseMax(0.0)).norm(), 1e-12 * C.norm());
    }

    TEST(Hyperelasticity, RefusesParametersOutOfRange)
    {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const std::vector<std::pair<Hyperelastic, std::string>> bad { { NeoHookean { 0.0, 1.0 }, "mu" },
            { NeoHookean { 1.0, -0.7 }, "lambda" }, { MooneyRivlin { 1.0, -0.1, 1.0 }, "c01" },
            { MooneyRivlin { 1.0, 0.0, nan }, "bulk" }, { HolzapfelGasserOgden { 1.0, -1.0, 1.0, 0.0, 1.0 }, "k1" },
            { HolzapfelGasserOgden { 1.0, 1.0, 1.0, 0.4, 1.0 }, "dispersion" },
            { Guccione { 1.0, 8.0, 0.0, 4.0, 1.0 }, "bt" } };
        for (const auto& [law, parameter] : bad)
            try {
                check_hyperelastic(law);
                ADD_FAILURE() << parameter << " was taken";
            } catch (const InputError& error) {
                EXPECT_NE(std::string(error.what()).find("parameter " + parameter + " ="), std::string::npos)
                    << error.what();
            }
        for (const auto& [name, law] : laws(kBulk))
            EXPECT_NO_THROW(check_hyperelastic(law)) << name;
    }

} // namespace hyperelasticity_test
} // namespace retractor::fem
