#include "fem/model/hinge.h"

#include "fem/interactive/online_stiffness.h"
#include "fem/model/elastic_body.h"
#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/random_entries.h"
#include "tests/support/reference_problems.h"
#include "tests/support/refusals.h"
#include "tests/verification/framework/meshes.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {
namespace hinge_test {

    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr double kRoundOff = 1e-12;

    Hinge rib_hinge(const Vec3& axis)
    {
        return { .name = "rib_left_5",
            .axis = axis.normalized(),
            .stiffness = 868.0,
            .range = 6.6 * kDegree,
            .stop_stiffness = 17360.0,
            .toe = kDegree };
    }

    /// All edges of the mesh that are seen along the axis with most of their length, with equal shares.
    Hinge with_edges(Hinge hinge, const mesh::TetMesh& mesh)
    {
        std::set<std::pair<VertexId, VertexId>> edges;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto nodes = mesh.tet(t);
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t j = 0; j < i; ++j) {
                    const Vec3 d = point_at(mesh.vertices, nodes[i]) - point_at(mesh.vertices, nodes[j]);
                    if (hinge.axis.cross(d).norm() > 0.5 * d.norm())
                        edges.emplace(std::min(nodes[i], nodes[j]), std::max(nodes[i], nodes[j]));
                }
        }
        for (const auto& [a, b] : edges)
            hinge.edges.push_back({ a, b, 1.0 / static_cast<double>(edges.size()) });
        return hinge;
    }

    Eigen::VectorXd moved(const mesh::TetMesh& mesh, const Eigen::Isometry3d& motion)
    {
        return verification::nodal_values(mesh, [&](const Vec3& p) { return Vec3(motion * p - p); });
    }

    TEST(Hinge, HasItsTorqueWithinTheRangeAndStiffensSmoothlyBeyond)
    {
        const Hinge hinge = rib_hinge(Vec3::UnitX());
        EXPECT_NEAR(hinge_torque(hinge, 6.6 * kDegree).torque, 99.99, 0.01); // 0.1 N m
        EXPECT_NEAR(hinge_torque(hinge, -6.6 * kDegree).torque, -99.99, 0.01);
        EXPECT_DOUBLE_EQ(hinge_torque(hinge, 3.0 * kDegree).stiffness, 868.0);
        // The toe: K phi^2 / (4 l) at phi = l, and K (phi - l) at phi = 3 l.
        EXPECT_NEAR(hinge_torque(hinge, 7.6 * kDegree).torque, 868.0 * 7.6 * kDegree + 17360.0 * kDegree / 4.0, 1e-9);
        EXPECT_NEAR(hinge_torque(hinge, 9.6 * kDegree).torque, 868.0 * 9.6 * kDegree + 17360.0 * 2.0 * kDegree, 1e-9);
        for (const double sign : { 1.0, -1.0 })
            for (const double at : { 0.0, 6.6, 7.0, 8.6, 20.0 }) { // with the joins of the pieces
                constexpr double kStep = 1e-6; // rad
                const auto here = hinge_torque(hinge, sign * at * kDegree);
                const auto before = hinge_torque(hinge, sign * at * kDegree - kStep);
                const auto after = hinge_torque(hinge, sign * at * kDegree + kStep);
                EXPECT_NEAR(
                    (after.energy - before.energy) / (2.0 * kStep), here.torque, 1e-3 * (1.0 + std::abs(here.torque)));
                EXPECT_NEAR((after.torque - before.torque) / (2.0 * kStep), here.stiffness, 0.3) << sign * at;
            }
    }

    TEST(Hinge, ABodyThatTurnsAsAWholeBearsTheTorqueWhereverItTurns)
    {
        for (const unsigned seed : { 1U, 2U, 3U }) {
            const mesh::TetMesh mesh = verification::distorted_box(3, 4.0, 0.2, seed);
            const Vec3 axis = Vec3(1.0, 0.3 * seed, -0.5);
            const Hinge hinge = with_edges(rib_hinge(axis), mesh);
            for (const double degrees : { 4.0, -8.0, 20.0, 75.0 }) {
                Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
                motion.translate(Vec3(30.0, -7.0, 2.0 * seed));
                motion.rotate(Eigen::AngleAxisd(degrees * kDegree, hinge.axis));
                motion.translate(Vec3(-3.0, 40.0, 11.0));
                const Eigen::VectorXd u = moved(mesh, motion);
                Eigen::VectorXd forces = Eigen::VectorXd::Zero(u.size());
                const double energy = add_hinge_response(mesh, hinge, HingeAngle::swept, u, forces);
                const HingeTorque expected = hinge_torque(hinge, degrees * kDegree);
                EXPECT_NEAR(energy, expected.energy, 1e-9 * expected.energy) << degrees;
                EXPECT_NEAR(hinge_turn(mesh, hinge, u), degrees * kDegree, 1e-9) << degrees;
                Vec3 sum = Vec3::Zero(), couple = Vec3::Zero();
                for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
                    const Vec3 f = forces.segment<3>(3 * static_cast<Eigen::Index>(v));
                    sum += f;
                    couple += Vec3(motion * point_at(mesh.vertices, v)).cross(f);
                }
                EXPECT_LT(sum.norm(), 1e-9 * forces.norm());
                EXPECT_NEAR(couple.dot(hinge.axis), expected.torque, 1e-9 * std::abs(expected.torque)) << degrees;
            }
        }
    }

    TEST(Hinge, ForcesAreTheDerivativeOfTheEnergyAndStiffnessThatOfTheForces)
    {
        constexpr double kStep = 1e-5; // mm
        for (const int nodes_per_tet : { 4, 10 })
            for (const Elasticity model : { Elasticity::corotational, Elasticity::linear })
                for (const double size : { 0.02, 0.5 }) { // mm: within the range, and beyond the stop
                    mesh::TetMesh mesh = verification::distorted_box(2, 4.0, 0.2, 5);
                    const Hinge hinge = with_edges(rib_hinge({ 1.0, 2.0, 0.5 }), mesh);
                    if (nodes_per_tet == 10)
                        mesh = mesh::with_midpoints(mesh);
                    const Material soft = test_support::material(0.01, 0.3);
                    ElasticBody body(mesh, model, test_support::uniform(mesh, soft));
                    body.set_hinges({ hinge });
                    const Eigen::Index n = 3 * mesh.vertices.rows();
                    const Eigen::VectorXd u = size * test_support::random_entries(n, 1, 3);
                    const Eigen::VectorXd direction = test_support::random_entries(n, 1, 4);
                    const auto before = body.response(u - kStep * direction);
                    const auto here = body.response(u);
                    const auto after = body.response(u + kStep * direction);
                    const double slope = (after.energy - before.energy) / (2.0 * kStep);
                    EXPECT_NEAR(slope, here.forces.dot(direction), 1e-5 * here.forces.norm() * direction.norm());
                    const Eigen::VectorXd change = (after.forces - before.forces) / (2.0 * kStep);
                    const Eigen::VectorXd tangent = body.stiffness(u, 0.0).multiply(direction);
                    // The stiffness of the stop has a corner where its toe ends; few edges lie there.
                    EXPECT_LT((change - tangent).norm(), 1e-3 * tangent.norm()) << nodes_per_tet << " " << size;
                }
    }

    TEST(Hinge, ProjectedStiffnessHasNoNegativeEigenvalues)
    {
        const mesh::TetMesh mesh = verification::distorted_box(2, 4.0, 0.2, 9);
        const Hinge hinge = with_edges(rib_hinge(Vec3::UnitZ()), mesh);
        const Eigen::VectorXd u = test_support::random_entries(3 * mesh.vertices.rows(), 1, 8);
        const auto lowest = [&](double projected) {
            BlockMatrix K { block_pattern(mesh), {} };
            K.values.assign(9 * K.pattern.block_count(), 0.0);
            add_hinge_stiffness(mesh, hinge, HingeAngle::swept, u, projected, K);
            const Eigen::VectorXd values
                = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(test_support::dense(K)).eigenvalues();
            return values.minCoeff() / values.maxCoeff();
        };
        EXPECT_LT(lowest(0.0), -1e-3);
        EXPECT_GT(lowest(1.0), -kRoundOff);
    }

    TEST(Hinge, LiveStiffnessIsThatOfTheLinearBodyAndFollowsCuts)
    {
        const mesh::TetMesh box = mesh::kuhn_box(4, 4, 4, 4.0);
        const Material tissue = test_support::material(0.05, 0.3);
        const std::vector<Material> tissues { tissue, tissue };
        const Hinge hinge = with_edges(rib_hinge({ 0.2, 1.0, 0.4 }), box);
        mesh::CutSession session(box);
        OnlineStiffness online(session, tissues);
        online.set_hinges({ hinge });
        ElasticBody body(box, Elasticity::linear, test_support::uniform(box, tissue));
        body.set_hinges({ hinge });
        const Eigen::VectorXd x = test_support::random_entries(3 * box.vertices.rows(), 1, 2);
        const Eigen::VectorXd expected = body.stiffness(Eigen::VectorXd::Zero(x.size()), 0.0).multiply(x);
        EXPECT_LT((online.multiply(x) - expected).norm(), kRoundOff * expected.norm());

        const Eigen::VectorXd uncut = online.multiply(x);
        const mesh::Blade blade {
            .line = { { 10.0, -1.0, 17.0 }, { 10.0, 17.0, 17.0 } }, .directions = { -Vec3::UnitZ() }, .depth_mm = 9.0
        };
        const mesh::CutResult cut = session.cut(blade);
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        online.apply(cut.delta);
        const std::vector<Hinge> left = online.hinges();
        ASSERT_EQ(left.size(), 1U);
        EXPECT_LT(left[0].edges.size(), hinge.edges.size());
        EXPECT_GT(left[0].edges.size(), hinge.edges.size() / 2);
        OnlineStiffness fresh(session, tissues);
        fresh.set_hinges(left);
        const Eigen::VectorXd y
            = test_support::random_entries(3 * static_cast<Eigen::Index>(online.slot_count()), 1, 6);
        const Eigen::VectorXd of_fresh = fresh.multiply(y);
        EXPECT_LT((online.multiply(y) - of_fresh).norm(), kRoundOff * of_fresh.norm());
        online.apply(session.undo());
        EXPECT_EQ(online.hinges()[0].edges.size(), hinge.edges.size());
        Eigen::VectorXd again = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(online.slot_count()));
        again.head(x.size()) = x;
        EXPECT_EQ(Eigen::VectorXd(online.multiply(again).head(x.size())), uncut); // to the last bit
    }

    TEST(Hinge, KeepsItsTorqueOnTheEdgesThatACutLeaves)
    {
        const mesh::TetMesh box = mesh::kuhn_box(3, 3, 3, 4.0);
        const Hinge hinge = with_edges(rib_hinge(Vec3::UnitX()), box);
        mesh::TetMesh part = box; // the elements of the lower half, with all vertices
        part.nodes.clear();
        part.labels.clear();
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            if (box.vertices(box.tet(t)[0], 2) + box.vertices(box.tet(t)[3], 2) < 10.0) {
                part.nodes.insert(part.nodes.end(), box.tet(t).begin(), box.tet(t).end());
                part.labels.push_back(1);
            }
        const auto sum = [](const std::vector<Hinge>& hinges) {
            double shares = 0.0;
            for (const HingeEdge& edge : hinges.at(0).edges)
                shares += edge.share;
            return shares;
        };
        EXPECT_NEAR(sum(joined_hinges(part, { hinge })), 1.0, kRoundOff);
        const double kept = sum(hinges_within(part, { hinge }));
        EXPECT_GT(kept, 0.3);
        EXPECT_LT(kept, 0.9);
        EXPECT_THROW(check_hinges(part, std::vector { hinge }), InputError);
        EXPECT_NO_THROW(check_hinges(part, joined_hinges(part, { hinge })));
        part.nodes.resize(4); // nearly nothing is left
        part.labels.resize(1);
        Hinge far = hinge;
        std::erase_if(far.edges, [&](const HingeEdge& edge) {
            return std::ranges::find(part.nodes, edge.a) != part.nodes.end()
                || std::ranges::find(part.nodes, edge.b) != part.nodes.end();
        });
        EXPECT_TRUE(joined_hinges(part, { far }).empty());
    }

    TEST(Hinge, BadHingesAreRefusedByName)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 2, 2, 4.0);
        const Hinge good = with_edges(rib_hinge(Vec3::UnitX()), box);
        const auto check = [&](const std::function<void(Hinge&)>& spoil) {
            return [&box, good, spoil] {
                Hinge hinge = good;
                spoil(hinge);
                check_hinges(box, std::vector { hinge });
            };
        };
        test_support::expect_all_refused({
            .spoilt = { check([](Hinge& h) { h.axis *= 2.0; }), check([](Hinge& h) { h.axis.x() = std::nan(""); }),
                check([](Hinge& h) { h.stiffness = -1.0; }),
                check([](Hinge& h) { h.stop_stiffness = std::numeric_limits<double>::infinity(); }),
                check([](Hinge& h) { h.toe = 0.0; }), check([](Hinge& h) { h.edges[0].share = 0.0; }),
                check([](Hinge& h) { h.edges[0].share = 1.0; }), check([](Hinge& h) { h.edges[0].b = 1000; }),
                check([](Hinge& h) { h.edges[0].a = -1; }), check([](Hinge& h) { h.edges[0].b = h.edges[0].a; }),
                check([](Hinge& h) {
                    h.edges[0] = { 0, 26, h.edges[0].share };
                }), // opposite corners
                check([](Hinge& h) {
                    h.edges[0] = { 0, 1, h.edges[0].share };
                }) }, // along x
            .sound = { check([](Hinge&) {}) },
        });
        try {
            check([](Hinge& h) { h.toe = 0.0; })();
            FAIL();
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "hinge of rib_left_5");
        }
    }

} // namespace hinge_test
} // namespace retractor::fem
