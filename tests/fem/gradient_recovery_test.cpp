#include "fem/gradient_recovery.h"

#include "fem/verification/meshes.h"
#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace retractor {
namespace {

    constexpr Elasticity kModel = Elasticity::corotational;
    constexpr Lame kTissue { 0.4, 0.7 };

    TetMesh box(int n) { return with_midpoints(distorted_box(n, 1.0 / n, 0.2, 3)); }
    std::vector<Lame> parameters(const TetMesh& mesh) { return std::vector<Lame>(mesh.tet_count(), kTissue); }

    TEST(GradientRecovery, SeesNoErrorWhereGradientsAreLinear)
    {
        const TetMesh mesh = box(3);
        const Eigen::VectorXd u = nodal_values(mesh, [](const Vec3& p) -> Vec3 {
            return 1e-3 * Vec3(p.x() * p.x() - p.y() * p.z(), 2.0 * p.x() + p.z() * p.z(), p.y() - p.x() * p.y());
        });
        const double energy = energy_between(mesh, kModel, parameters(mesh), Eigen::VectorXd::Zero(u.size()), u);
        constexpr double kRoundOff = 1e-20; // of squares
        EXPECT_LE(recovered_energy(mesh, kModel, parameters(mesh), u), kRoundOff * energy);
    }

    TEST(GradientRecovery, EnergyBetweenFieldsIsTheirIntegral)
    {
        const TetMesh mesh = box(2);
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        const Eigen::VectorXd u
            = nodal_values(mesh, [](const Vec3& p) -> Vec3 { return 1e-4 * Vec3(p.x() * p.x(), 0.0, 0.0); });
        // Strain 2e-4 x, a third of it of volume: 2 mu 2/3 4e-8 x^2 over the unit cube.
        EXPECT_NEAR(energy_between(mesh, kModel, parameters(mesh), none, u),
            2.0 * kTissue.mu * (2.0 / 3.0) * 4e-8 / 3.0, 1e-16);
    }

    TEST(GradientRecovery, IsTheErrorOfSmoothFieldsOnFineMeshes)
    {
        const auto field = [](const Vec3& p) -> Vec3 {
            return 1e-3 * Vec3(std::sin(2.0 * p.x() + p.y()), std::cos(1.5 * p.z()), std::exp(p.x() * p.z()));
        };
        // The best that ten-node elements can do is about their interpolation; what they miss is seen one mesh down.
        double before = 0.0;
        for (const int n : { 2, 4, 8 }) {
            const TetMesh mesh = with_midpoints(kuhn_box(n, n, n, 1.0 / n));
            const Eigen::VectorXd u = nodal_values(mesh, field);
            const double estimate = std::sqrt(recovered_energy(mesh, kModel, parameters(mesh), u));
            if (before > 0.0) {
                constexpr double kOrder = 2.0, kOff = 0.3;
                EXPECT_NEAR(std::log2(before / estimate), kOrder, kOff) << n;
            }
            before = estimate;
        }
    }

    TEST(GradientRecovery, DoesNotSmoothAcrossTissues)
    {
        // Bent at the border of two tissues, and straight in each: right as it is.
        const auto bent = [](const Vec3& p) -> Vec3 { return { 0.0, 0.0, 1e-3 * std::max(p.x() - 0.5, 0.0) }; };
        TetMesh straight = with_midpoints(kuhn_box(4, 4, 4, 0.25));
        const Eigen::VectorXd u = nodal_values(straight, bent);
        const double smoothed = recovered_energy(straight, kModel, parameters(straight), u);
        for (std::size_t t = 0; t < straight.tet_count(); ++t) {
            double x = 0.0;
            for (const VertexId v : straight.tet(static_cast<TetId>(t)).first(4))
                x += 0.25 * straight.vertices(v, 0);
            straight.labels[t] = x < 0.5 ? 1 : 2;
        }
        EXPECT_LE(recovered_energy(straight, kModel, parameters(straight), u), 1e-20 * smoothed);
    }

    TEST(GradientRecovery, TurnedFieldsHaveTheSameErrors)
    {
        const TetMesh mesh = box(3);
        const Eigen::VectorXd u = nodal_values(
            mesh, [](const Vec3& p) -> Vec3 { return 0.1 * Vec3(p.x() * p.x() * p.y(), std::sin(p.z()), 0.0); });
        Mat3 turn;
        turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        Eigen::VectorXd turned(u.size());
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const Vec3 x = mesh.vertices.row(v).transpose();
            turned.segment<3>(3 * v) = turn * (x + u.segment<3>(3 * v)) - x;
        }
        const double straight = recovered_energy(mesh, kModel, parameters(mesh), u);
        EXPECT_NEAR(recovered_energy(mesh, kModel, parameters(mesh), turned), straight, 1e-9 * straight);
    }

    TEST(GradientRecovery, RefusesWhatItCannotRead)
    {
        const TetMesh mesh = box(2), corners = kuhn_box(1, 1, 1, 1.0);
        const Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        Eigen::VectorXd bad = u;
        bad[4] = std::nan("");
        const auto refused = [](const TetMesh& m, const std::vector<Lame>& lame, const Eigen::VectorXd& values) {
            try {
                (void)recovered_energy(m, kModel, lame, values);
            } catch (const InputError& error) {
                return error.where();
            }
            return std::string("accepted");
        };
        EXPECT_EQ(refused(corners, parameters(corners), Eigen::VectorXd::Zero(24)), "nodes_per_tet");
        EXPECT_EQ(refused(mesh, {}, u), "lame");
        EXPECT_EQ(refused(mesh, parameters(mesh), u.head(6)), "displacement");
        EXPECT_EQ(refused(mesh, parameters(mesh), bad), "displacement");
    }

} // namespace
} // namespace retractor
