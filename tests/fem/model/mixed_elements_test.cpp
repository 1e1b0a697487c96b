#include "fem/error_estimation/gradient_recovery.h"
#include "fem/model/elastic_body.h"
#include "fem/model/loads.h"
#include "mesh/base/error.h"
#include "tests/support/dense_matrix.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/body_force.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

// Meshes of which some elements have ten nodes, others four, and those between them some midpoints (tet_mesh.h).

namespace retractor::fem {
namespace mixed_elements_test {

    const Material kTissue = test_support::material(1.0, 0.3);

    enum class Marked { none, near_side, all };

    /// @param marked the elements that get midpoints: none, those whose middle has x below `half`, or all
    mesh::TetMesh mixed(const mesh::TetMesh& mesh, Marked marked, double half = 1.0)
    {
        std::vector<std::uint8_t> elements;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            double x = 0.0;
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                x += 0.25 * corner.x();
            elements.push_back(marked == Marked::all || (marked == Marked::near_side && x < half) ? 1 : 0);
        }
        return mesh::with_midpoints(mesh, elements);
    }

    mesh::TetMesh half_mixed() { return mixed(verification::distorted_box(2, 1.0, 0.2, 5), Marked::near_side); }

    Eigen::VectorXd random_motion(const mesh::TetMesh& mesh, double size, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> entry(-size, size);
        return Eigen::VectorXd::NullaryExpr(3 * mesh.vertices.rows(), [&] { return entry(random); });
    }

    HyperelasticTissue neo_hookean(const mesh::TetMesh& mesh)
    {
        return { { NeoHookean { lame(kTissue).mu, lame(kTissue).lambda } },
            std::vector<std::int32_t>(mesh.tet_count(), 0) };
    }

    TEST(MixedElements, HaveMidpointsOnTheEdgesOfTheMarkedElements)
    {
        const mesh::TetMesh box = verification::distorted_box(2, 1.0, 0.2, 5), some = half_mixed();
        EXPECT_GT(some.vertex_count(), box.vertex_count());
        EXPECT_LT(some.vertex_count(), mesh::with_midpoints(box).vertex_count());
        std::size_t all_straight = 0, between = 0;
        for (TetId t = 0; t < static_cast<TetId>(some.tet_count()); ++t) {
            std::size_t straight = 0;
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                straight += mesh::is_straight(some.tet(t), e) ? 1 : 0;
            all_straight += straight == 6 ? 1 : 0;
            between += straight > 0 && straight < 6 ? 1 : 0;
        }
        EXPECT_GT(all_straight, 0U);
        EXPECT_GT(between, 0U);
        const std::vector<std::uint8_t> too_few(3, 1);
        EXPECT_THROW((void)mesh::with_midpoints(box, too_few), InputError);
    }

    TEST(MixedElements, TrianglesOfAFaceCoverItAndLookOutwards)
    {
        const mesh::TetMesh some = half_mixed();
        std::array<std::size_t, 5> with_triangles {};
        for (TetId t = 0; t < static_cast<TetId>(some.tet_count()); ++t)
            for (int corner = 0; corner < 4; ++corner) {
                const mesh::TetFace face { t, corner };
                const auto area_vector = [&](const std::array<VertexId, 3>& v) -> Vec3 {
                    const Vec3 a = point_at(some.vertices, v[0]);
                    return 0.5 * (point_at(some.vertices, v[1]) - a).cross(point_at(some.vertices, v[2]) - a);
                };
                const Vec3 whole = area_vector(mesh::face_vertices(some, face));
                const auto triangles = mesh::face_triangles(some, face);
                ASSERT_LT(triangles.size(), with_triangles.size());
                ++with_triangles[triangles.size()];
                Vec3 sum = Vec3::Zero();
                for (const auto& triangle : triangles) {
                    EXPECT_GT(area_vector(triangle).dot(whole), 0.1 * whole.squaredNorm()); // a quarter is the least
                    sum += area_vector(triangle);
                }
                EXPECT_LE((sum - whole).norm(), 1e-14);
            }
        for (const std::size_t n : { 1U, 2U, 4U }) // no edge, one and all with midpoints; two are rare
            EXPECT_GT(with_triangles[n], 0U) << n;
    }

    TEST(MixedElements, AreFourNodeElementsWithoutAndTenNodeElementsWithAllMidpoints)
    {
        const mesh::TetMesh box = verification::distorted_box(2, 1.0, 0.2, 5);
        for (const auto& [marked, same] :
            { std::pair { Marked::none, box }, std::pair { Marked::all, mesh::with_midpoints(box) } }) {
            const mesh::TetMesh mesh = mixed(box, marked);
            ASSERT_EQ(mesh.vertex_count(), same.vertex_count());
            const Eigen::VectorXd u = random_motion(mesh, 0.05, 3), d = random_motion(mesh, 1.0, 4);
            ElasticBody body(mesh, Elasticity::corotational, test_support::uniform(mesh, kTissue)),
                expected(same, Elasticity::corotational, test_support::uniform(same, kTissue));
            constexpr double kRoundOff = 1e-12;
            EXPECT_NEAR(body.response(u).energy, expected.response(u).energy, kRoundOff);
            EXPECT_LE((body.response(u).forces - expected.response(u).forces).norm(), kRoundOff);
            EXPECT_LE((body.stiffness(u, 0.0).multiply(d) - expected.stiffness(u, 0.0).multiply(d)).norm(),
                kRoundOff * d.norm());
        }
    }

    TEST(MixedElements, HoldALinearFieldExactly)
    {
        const mesh::TetMesh mesh = mixed(verification::distorted_box(4, 2.0, 0.3, 1), Marked::near_side, 4.0);
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        const Eigen::VectorXd exact
            = verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return gradient * p; });
        ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
        std::vector<std::uint8_t> held(3 * mesh.vertex_count(), 0);
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
            for (const auto& triangle : mesh::face_triangles(mesh, face))
                for (const VertexId v : triangle)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        held[3 * static_cast<std::size_t>(v) + axis] = 1;
        const Eigen::VectorXd u = test_support::solve_linear(body, held, exact, Eigen::VectorXd::Zero(exact.size()));
        EXPECT_LE((u - exact).cwiseAbs().maxCoeff(), 1e-13); // round-off times a condition of about 1e2
        const std::vector<Lame> lame = test_support::uniform(mesh, kTissue);
        EXPECT_LE(recovered_energy(mesh, Elasticity::linear, lame, u), 1e-20);
    }

    TEST(MixedElements, TurnFreelyAndHaveSixRigidMotions)
    {
        const mesh::TetMesh mesh = half_mixed();
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        const Eigen::VectorXd u
            = verification::nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p + Vec3(5, 0, 0); });
        ElasticBody body(mesh, Elasticity::corotational, test_support::uniform(mesh, kTissue));
        EXPECT_LE(body.response(u).forces.norm(), 1e-12);
        const Eigen::MatrixXd K = test_support::dense(body.stiffness(Eigen::VectorXd::Zero(u.size()), 1.0));
        const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
        EXPECT_EQ((values.array() < 1e-12 * values.maxCoeff()).count(), 6);
    }

    TEST(MixedElements, AreDerivedRight)
    {
        const mesh::TetMesh mesh = half_mixed();
        const Eigen::VectorXd u = random_motion(mesh, 0.02, 7), d = random_motion(mesh, 1.0, 8);
        ElasticBody corotational(mesh, Elasticity::corotational, test_support::uniform(mesh, kTissue)),
            hyperelastic(mesh, neo_hookean(mesh));
        for (ElasticBody* body : { &corotational, &hyperelastic }) {
            body->set_loads({ .nodal = traction_loads(mesh, mesh::boundary_faces(mesh), Vec3(0.01, 0.02, 0.03)),
                .pressures = { FollowerPressure(
                    mesh, verification::faces_where(mesh, [](const Vec3& p) { return p.z() < 1e-9; }), 0.01) } });
            constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
            const auto plus = body->response(u + h * d), minus = body->response(u - h * d);
            EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), body->response(u).forces.dot(d), 1e-7);
            const Eigen::VectorXd Kd = body->stiffness(u, 0.0).multiply(d);
            EXPECT_LE((Kd - (plus.forces - minus.forces) / (2 * h)).norm(), 1e-6 * Kd.norm());
        }
    }

    TEST(MixedElements, TakeTractionsByTheAreaOfTheFaces)
    {
        const mesh::TetMesh mesh = mixed(mesh::kuhn_box(2, 2, 2, 1.0), Marked::near_side);
        const auto top = verification::faces_where(mesh, [](const Vec3& p) { return p.z() > 2.0 - 1e-9; });
        const Vec3 traction(0.1, -0.2, 0.3);
        const Eigen::VectorXd loads = traction_loads(mesh, top, traction),
                              force = FollowerPressure(mesh, top, 0.01).force(Eigen::VectorXd::Zero(loads.size()));
        Vec3 sum = Vec3::Zero(), pushed = Vec3::Zero();
        for (Eigen::Index i = 0; i < loads.size(); i += 3) {
            sum += loads.segment<3>(i);
            pushed += force.segment<3>(i);
        }
        EXPECT_LE((sum - 4.0 * traction).norm(), 1e-13);
        EXPECT_LE((pushed - Vec3(0, 0, -0.04)).norm(), 1e-14);
    }

    /// Twice the energy of a box that hangs by one side under its weight: the work of the weight, N mm.
    double work_of_weight(const mesh::TetMesh& mesh)
    {
        ElasticBody body(mesh, Elasticity::linear, test_support::uniform(mesh, kTissue));
        std::vector<std::uint8_t> held(3 * mesh.vertex_count(), 0);
        for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.vertices(static_cast<Eigen::Index>(v), 0) < 1e-9)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    held[3 * v + axis] = 1;
        Eigen::VectorXd load = traction_loads(
            mesh, verification::faces_where(mesh, [](const Vec3& p) { return p.z() > 2.0 - 1e-9; }), Vec3(0, 0, 0.01));
        const Eigen::VectorXd u = test_support::solve_linear(body, held, Eigen::VectorXd::Zero(load.size()), load);
        return load.dot(u);
    }

    TEST(MixedElements, AreBetweenFourNodeAndTenNodeElements)
    {
        const mesh::TetMesh box = mesh::kuhn_box(6, 2, 2, 1.0);
        const double four = work_of_weight(box), some = work_of_weight(mixed(box, Marked::near_side, 3.0)),
                     ten = work_of_weight(mesh::with_midpoints(box));
        EXPECT_GT(some, four + 0.3 * (ten - four)); // the bending is at the held side, which has ten nodes
        EXPECT_LT(some, ten);
    }

} // namespace mixed_elements_test
} // namespace retractor::fem
