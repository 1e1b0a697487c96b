#include "fem/element/corotational_elements.h"

#include "fem/linear_algebra/parallel.h"
#include "fem/model/elastic_body.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <random>

namespace retractor::fem {
namespace corotational_elements_test {

    using namespace test_support;

    constexpr double kRoundOff = 1e-12; // of the largest force or of the energy

    struct Bodies {
        mesh::TetMesh mesh = mesh::kuhn_box(3, 2, 2, 4.0); // 72 elements; one less: the last pack is not full
        std::vector<Lame> lame;
        Eigen::VectorXd u;

        Bodies()
        {
            mesh.labels.pop_back();
            mesh.nodes.resize(mesh.nodes.size() - 4);
            for (std::size_t t = 0; t < mesh.tet_count(); ++t)
                lame.push_back({ 0.01 * static_cast<double>(t + 1), 0.03 * static_cast<double>(t % 5) });
            u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        }
        /// x -> A x and noise of this size, mm.
        void deform(const Mat3& A, double noise)
        {
            std::mt19937 random(7);
            std::uniform_real_distribution<double> at(-noise, noise);
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
                const Vec3 p = mesh.vertices.row(v);
                u.segment<3>(3 * v) = A * p - p + Vec3(at(random), at(random), at(random));
            }
        }
        /// Element by element, by the singular values.
        ElasticBody::Response reference() const
        {
            ElasticBody::Response sum { 0.0, Eigen::VectorXd::Zero(u.size()) };
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
                const auto nodes = mesh.tet(t);
                Mat3 rest, now;
                for (int a = 0; a < 3; ++a) {
                    const auto edge = [&](const auto& place) {
                        return Vec3(place(nodes[static_cast<std::size_t>(a) + 1]) - place(nodes[0]));
                    };
                    rest.col(a) = edge([&](VertexId v) { return Vec3(mesh.vertices.row(v)); });
                    now.col(a) = edge(
                        [&](VertexId v) { return Vec3(mesh.vertices.row(v).transpose() + u.segment<3>(3 * v)); });
                }
                const double volume = std::abs(rest.determinant()) / 6.0;
                const PointResponse point = evaluate_point(
                    Elasticity::corotational_linear, lame[static_cast<std::size_t>(t)], now * rest.inverse(), false);
                sum.energy += volume * point.energy;
                const Mat3 f = volume * point.stress * rest.inverse().transpose();
                for (int a = 0; a < 3; ++a) {
                    sum.forces.segment<3>(3 * nodes[static_cast<std::size_t>(a) + 1]) += f.col(a);
                    sum.forces.segment<3>(3 * nodes[0]) -= f.col(a);
                }
            }
            return sum;
        }
        ElasticBody body() const { return { mesh, Elasticity::corotational_linear, lame }; }
        void expect_reference(const char* what) const
        {
            const ElasticBody::Response right = reference(), fast = body().response(u);
            EXPECT_NEAR(fast.energy, right.energy, kRoundOff * right.energy) << what;
            EXPECT_LT((fast.forces - right.forces).lpNorm<Eigen::Infinity>(),
                kRoundOff * right.forces.lpNorm<Eigen::Infinity>())
                << what;
        }
    };

    TEST(CorotationalElements, AreTheModelOfSingularValuesWhateverTheShape)
    {
        Bodies b;
        const Mat3 turned = Eigen::AngleAxisd(2.5, Vec3(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
        b.deform(turned * Vec3(1.3, 0.8, 1.1).asDiagonal(), 0.3);
        b.expect_reference("stretched and turned");
        b.deform(Vec3(6.0, 0.9, 1.0).asDiagonal(), 0.3);
        b.expect_reference("beyond the largest pressure");
        b.deform(turned, 3.0);
        b.expect_reference("some turned over");
        b.deform(Vec3(1.0, 1.0, -0.7).asDiagonal(), 0.2);
        b.expect_reference("all turned over");
        b.deform(Vec3(1.0, 0.9, 1e-4).asDiagonal(), 0.0);
        b.expect_reference("flat");
        b.deform(Vec3(1.0, 0.9, 1e-9).asDiagonal(), 0.0);
        b.expect_reference("as flat as can be");
        b.deform(Vec3(1.0, 1e-3, 1e-3).asDiagonal(), 0.0);
        b.expect_reference("a thread");
    }

    TEST(CorotationalElements, RestIsWithoutForceAlsoWhereItIsTurned)
    {
        Bodies b;
        const ElasticBody body = b.body();
        EXPECT_EQ(body.response(b.u).energy, 0.0);
        EXPECT_EQ(body.response(b.u).forces.lpNorm<Eigen::Infinity>(), 0.0);
        b.deform(Eigen::AngleAxisd(3.0, Vec3(0.2, -1.0, 0.4).normalized()).toRotationMatrix(), 0.0);
        constexpr double kTurned = 1e-13; // MPa mm^2 of round-off, of moduli up to 0.7
        EXPECT_LT(body.response(b.u).forces.lpNorm<Eigen::Infinity>(), 100.0 * kTurned);
    }

    TEST(CorotationalElements, ForcesAreTheDerivativeOfTheEnergyAndStiffnessThatOfTheForces)
    {
        Bodies b;
        b.deform(Eigen::AngleAxisd(1.0, Vec3::UnitY()).toRotationMatrix() * Vec3(1.4, 0.8, 1.1).asDiagonal(), 0.3);
        ElasticBody body = b.body();
        const ElasticBody::Response at = body.response(b.u);
        const BlockMatrix& K = body.stiffness(b.u, 0.0);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        Eigen::VectorXd way(b.u.size());
        for (double& x : way)
            x = any(random);
        constexpr double kStep = 1e-5, kSecondOrder = 1e-7; // central differences: the step's square and round-off
        const ElasticBody::Response on = body.response(b.u + kStep * way), back = body.response(b.u - kStep * way);
        EXPECT_NEAR((on.energy - back.energy) / (2.0 * kStep), at.forces.dot(way),
            kSecondOrder * at.forces.norm() * way.norm());
        const Eigen::VectorXd slope = (on.forces - back.forces) / (2.0 * kStep), exact = K.multiply(way);
        EXPECT_LT((slope - exact).norm(), kSecondOrder * exact.norm());
    }

    TEST(CorotationalElements, GiveTheSameOnOneThreadAndTwo)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(20, 20, 5, 4.0); // 12,000 elements: two threads where there are two
        const ElasticBody body(
            mesh, Elasticity::corotational_linear, std::vector<Lame>(mesh.tet_count(), Lame { 0.01, 0.05 }));
        Eigen::VectorXd u(3 * mesh.vertices.rows());
        for (Eigen::Index i = 0; i < u.size(); ++i)
            u[i] = std::sin(static_cast<double>(i));
        set_solver_threads(1);
        const ElasticBody::Response one = body.response(u);
        set_solver_threads(2);
        const ElasticBody::Response two = body.response(u);
        EXPECT_EQ(one.energy, two.energy);
        EXPECT_EQ(one.forces, two.forces);
    }

} // namespace corotational_elements_test
} // namespace retractor::fem
