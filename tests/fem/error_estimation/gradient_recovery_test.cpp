#include "fem/error_estimation/gradient_recovery.h"

#include "fem/element/tet_element.h"
#include "mesh/base/error.h"
#include "tests/verification/framework/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

namespace retractor::fem {
namespace gradient_recovery_test {

    constexpr Elasticity kModel = Elasticity::corotational;
    constexpr Lame kTissue { 0.4, 0.7 };

    mesh::TetMesh box(int n) { return mesh::with_midpoints(verification::distorted_box(n, 1.0 / n, 0.2, 3)); }
    std::vector<Lame> parameters(const mesh::TetMesh& mesh) { return std::vector<Lame>(mesh.tet_count(), kTissue); }

    TEST(GradientRecovery, SeesNoErrorWhereGradientsAreLinear)
    {
        const mesh::TetMesh mesh = box(3);
        const Eigen::VectorXd u = verification::nodal_values(mesh, [](const Vec3& p) -> Vec3 {
            return 1e-3 * Vec3(p.x() * p.x() - p.y() * p.z(), 2.0 * p.x() + p.z() * p.z(), p.y() - p.x() * p.y());
        });
        const double energy = energy_between(mesh, kModel, parameters(mesh), Eigen::VectorXd::Zero(u.size()), u);
        constexpr double kRoundOff = 1e-20; // of squares
        EXPECT_LE(recovered_energy(mesh, kModel, parameters(mesh), u), kRoundOff * energy);
    }

    TEST(GradientRecovery, EnergyBetweenFieldsIsTheirIntegral)
    {
        const mesh::TetMesh mesh = box(2);
        const Eigen::VectorXd none = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        const Eigen::VectorXd u = verification::nodal_values(
            mesh, [](const Vec3& p) -> Vec3 { return 1e-4 * Vec3(p.x() * p.x(), 0.0, 0.0); });
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
            const mesh::TetMesh mesh = mesh::with_midpoints(mesh::kuhn_box(n, n, n, 1.0 / n));
            const Eigen::VectorXd u = verification::nodal_values(mesh, field);
            const double estimate = std::sqrt(recovered_energy(mesh, kModel, parameters(mesh), u));
            if (before > 0.0) {
                constexpr double kOrder = 2.0, kOff = 0.3;
                EXPECT_NEAR(std::log2(before / estimate), kOrder, kOff) << n;
            }
            before = estimate;
        }
    }

    /// Twice the energy of shape between the field and its values at nodes, by three Gauss points each way.
    template <class Gradient>
    double true_energy(const mesh::TetMesh& mesh, const Eigen::VectorXd& u, const Gradient& gradient_at)
    {
        const double off = std::sqrt(0.15);
        const double at[] = { 0.5 - off, 0.5, 0.5 + off }, weight[] = { 5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0 };
        double sum = 0.0;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            const auto nodes = mesh.tet(static_cast<TetId>(t));
            NodeGradients x(static_cast<Eigen::Index>(nodes.size()), 3);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                x.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    for (int k = 0; k < 3; ++k) { // the cube collapsed onto the element
                        const double r = at[i], s = at[j] * (1.0 - r), w = at[k] * (1.0 - r - s);
                        const QuadraturePoint q { { r, s, w, 1.0 - r - s - w },
                            6.0 * weight[i] * weight[j] * weight[k] * (1.0 - r) * (1.0 - r - s) };
                        const ShapeGradients shape = shape_gradients(x, q);
                        Mat3 H = Mat3::Zero();
                        for (std::size_t a = 0; a < nodes.size(); ++a)
                            H += u.segment<3>(3 * nodes[a]) * shape.gradients.row(static_cast<Eigen::Index>(a));
                        const Vec3 p = x.transpose() * shape_values(10, q.barycentric);
                        const Mat3 lost = gradient_at(p) - H, strain = 0.5 * (lost + lost.transpose());
                        sum += shape.volume * 2.0 * kTissue.mu
                            * (strain.squaredNorm() - strain.trace() * strain.trace() / 3.0);
                    }
        }
        return sum;
    }

    TEST(GradientRecovery, IsTheTrueErrorWithinAFactorOfTwo)
    {
        // What is interpolated differs from the best by less than the estimate may.
        const auto field = [](const Vec3& p) -> Vec3 {
            return 1e-3 * Vec3(std::sin(2.0 * p.x() + p.y()), std::cos(1.5 * p.z()), std::exp(p.x() * p.z()));
        };
        const auto gradient_at = [](const Vec3& p) {
            const double along = std::cos(2.0 * p.x() + p.y()), grown = std::exp(p.x() * p.z());
            Mat3 H;
            H << 2.0 * along, along, 0.0, 0.0, 0.0, -1.5 * std::sin(1.5 * p.z()), p.z() * grown, 0.0, p.x() * grown;
            return Mat3(1e-3 * H);
        };
        // Cubes cut alike, vertices moved about, one sliver, and layers of elements a twentieth as thick as wide.
        mesh::TetMesh layers = mesh::kuhn_box(4, 4, 4, 0.25);
        for (Eigen::Index v = 0; v < layers.vertices.rows(); ++v)
            layers.vertices(v, 2) *= 0.05;
        mesh::TetMesh sliver = verification::box_with_sliver(1e-3);
        sliver.vertices /= 3.0;
        const struct {
            mesh::TetMesh mesh;
            const char* what;
        } cases[] = { { mesh::kuhn_box(4, 4, 4, 0.25), "structured" },
            { verification::distorted_box(4, 0.25, 0.2, 5), "distorted" },
            { verification::distorted_box(8, 0.125, 0.2, 5), "distorted, finer" }, { sliver, "a sliver" },
            { layers, "thin layers" } };
        constexpr double kFactor = 2.0; // in energy norm
        for (const auto& c : cases) {
            const mesh::TetMesh mesh = mesh::with_midpoints(c.mesh);
            const Eigen::VectorXd u = verification::nodal_values(mesh, field);
            const double ratio = std::sqrt(
                recovered_energy(mesh, Elasticity::linear, parameters(mesh), u) / true_energy(mesh, u, gradient_at));
            RecordProperty(c.what, std::to_string(ratio));
            EXPECT_GT(ratio, 1.0 / kFactor) << c.what;
            EXPECT_LT(ratio, kFactor) << c.what;
        }
    }

    TEST(GradientRecovery, IsBoundedByTheSamplesHoweverFlatTheElements)
    {
        // Noise at the nodes, which nothing smooth fits: at single elements, flat ones and layers of one.
        constexpr double kMost = 250.0; // of the noise's own energy: (1 + 12 weights)^2 and room
        for (const double flat : { 1.0, 1e-2, 1e-4 })
            for (const int layers : { 1, 2 }) {
                mesh::TetMesh mesh = mesh::kuhn_box(3, 3, layers, 1.0);
                for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
                    mesh.vertices(v, 2) *= flat;
                mesh = mesh::with_midpoints(mesh);
                std::mt19937 random(7);
                Eigen::VectorXd u(3 * mesh.vertices.rows());
                for (double& value : u)
                    value = 1e-6 * (static_cast<double>(random()) / 4294967295.0 - 0.5);
                const auto lame = parameters(mesh);
                const double noise = energy_between(mesh, Elasticity::linear, lame, Eigen::VectorXd::Zero(u.size()), u);
                EXPECT_LT(recovered_energy(mesh, Elasticity::linear, lame, u), kMost * noise)
                    << flat << ", layers " << layers;
            }
    }

    TEST(GradientRecovery, ASharePastAllBoundsIsSaidSo)
    {
        const mesh::TetMesh mesh = box(2);
        const auto corners = static_cast<Eigen::Index>(3 * mesh::kuhn_box(2, 2, 2, 0.5).vertex_count());
        const auto lame = parameters(mesh);
        const Eigen::VectorXd still = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        EXPECT_EQ(share_left(mesh, kModel, lame, still, still.head(corners)), 0.0);
        const mesh::TetMesh straight = mesh::with_midpoints(mesh::kuhn_box(2, 2, 2, 0.5));
        // Bent along edges only: ten-node elements have nothing that plain ones do not, and stresses still jump.
        const Eigen::VectorXd kinked = verification::nodal_values(straight, [](const Vec3& p) -> Vec3 {
            return { 1e-3 * std::max(0.0, p.x() - 0.5), 0.0, 0.0 };
        });
        EXPECT_EQ(
            share_left(straight, kModel, lame, kinked, kinked.head(corners)), std::numeric_limits<double>::infinity());
        const auto refused = [&](const Eigen::VectorXd& four_node) {
            try {
                (void)share_left(mesh, kModel, lame, still, four_node);
            } catch (const InputError& error) {
                return error.where();
            }
            return std::string("accepted");
        };
        EXPECT_EQ(refused(still.head(corners - 3)), "four_node");
        EXPECT_EQ(refused(still), "four_node");
        EXPECT_EQ(refused(Eigen::VectorXd::Constant(corners, std::nan(""))), "four_node");
    }

    TEST(GradientRecovery, DoesNotSmoothAcrossTissues)
    {
        // Bent at the border of two tissues, and straight in each: right as it is.
        const auto bent = [](const Vec3& p) -> Vec3 { return { 0.0, 0.0, 1e-3 * std::max(p.x() - 0.5, 0.0) }; };
        mesh::TetMesh straight = mesh::with_midpoints(mesh::kuhn_box(4, 4, 4, 0.25));
        const Eigen::VectorXd u = verification::nodal_values(straight, bent);
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
        const mesh::TetMesh mesh = box(3);
        const Eigen::VectorXd u = verification::nodal_values(
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
        const mesh::TetMesh mesh = box(2), corners = mesh::kuhn_box(1, 1, 1, 1.0);
        const Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        Eigen::VectorXd bad = u;
        bad[4] = std::nan("");
        const auto refused = [](const mesh::TetMesh& m, const std::vector<Lame>& lame, const Eigen::VectorXd& values) {
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

} // namespace gradient_recovery_test
} // namespace retractor::fem
