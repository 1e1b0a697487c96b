// Thick-walled tube under inner pressure, plane strain [Lame]: ri 12.5, ro 14.5, p = 16/3 kPa (a 40 mmHg pulse).

#include "fem/model/elastic_body.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <utility>

namespace retractor::fem {
namespace thick_tube_test {

    using namespace test_support;

    constexpr double kInner = 12.5, kOuter = 14.5, kLength = 1.0, kPressure = 16.0 / 3.0 * 1e-3;
    constexpr double kAngle = std::numbers::pi / 2; // a quarter of it, with symmetry planes

    double exact_at_inner_wall(double E, double nu)
    {
        return (1 + nu) / E * kPressure * kInner * kInner / (kOuter * kOuter - kInner * kInner)
            * ((1 - 2 * nu) * kInner + kOuter * kOuter / kInner);
    }

    struct Tube {
        mesh::TetMesh mesh;
        std::vector<VertexId> inner; ///< nodes on the inner wall
        std::vector<std::uint8_t> prescribed;
        Eigen::VectorXd loads;
    };

    Vec3 bend(const Vec3& p, int around, int through)
    {
        const double angle = kAngle * p.x() / around, r = kInner + (kOuter - kInner) * p.y() / through;
        return { r * std::sin(angle), r * std::cos(angle), p.z() };
    }

    /// Pressure on the inner faces, by a six-point rule exact for the products of quadratic shape functions with a
    /// quadratic normal.
    void press(Tube& tube, const mesh::TetFace& face)
    {
        const auto nodes = tube.mesh.tet(face.tet);
        const auto& corner = mesh::kTetFaces[static_cast<std::size_t>(face.corner)];
        std::vector<VertexId> on_face;
        for (const int c : corner)
            on_face.push_back(nodes[static_cast<std::size_t>(c)]);
        const bool quadratic = tube.mesh.nodes_per_tet == 10;
        for (std::size_t i = 0; quadratic && i < 3; ++i)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (std::minmax(corner[i], corner[(i + 1) % 3])
                    == std::minmax(mesh::kTetEdges[e][0], mesh::kTetEdges[e][1]))
                    on_face.push_back(nodes[4 + e]);
        constexpr double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011, wb = 0.109951743655322;
        for (const auto& [v, w] : { std::pair { a, wa }, std::pair { b, wb } })
            for (std::size_t k = 0; k < 3; ++k) {
                std::array<double, 3> l { v, v, v };
                l[k] = 1 - 2 * v;
                Eigen::VectorXd N(on_face.size()), ds(on_face.size()),
                    dt(on_face.size()); // values, derivatives by l1 and l2
                if (quadratic) {
                    N << l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1), l[2] * (2 * l[2] - 1), 4 * l[0] * l[1],
                        4 * l[1] * l[2], 4 * l[2] * l[0];
                    ds << 1 - 4 * l[0], 4 * l[1] - 1, 0, 4 * (l[0] - l[1]), 4 * l[2], -4 * l[2];
                    dt << 1 - 4 * l[0], 0, 4 * l[2] - 1, -4 * l[1], 4 * l[1], 4 * (l[0] - l[2]);
                } else {
                    N << l[0], l[1], l[2];
                    ds << -1, 1, 0;
                    dt << -1, 0, 1;
                }
                Vec3 s = Vec3::Zero(), t = Vec3::Zero();
                for (std::size_t i = 0; i < on_face.size(); ++i) {
                    s += ds[static_cast<Eigen::Index>(i)] * tube.mesh.vertices.row(on_face[i]).transpose();
                    t += dt[static_cast<Eigen::Index>(i)] * tube.mesh.vertices.row(on_face[i]).transpose();
                }
                const Vec3 force
                    = -0.5 * w * kPressure * s.cross(t); // the face looks out of the wall, the pressure into it
                for (std::size_t i = 0; i < on_face.size(); ++i)
                    tube.loads.segment<3>(3 * on_face[i]) += N[static_cast<Eigen::Index>(i)] * force;
            }
    }

    Tube make_tube(int nodes_per_tet, int around, int through, int along)
    {
        Tube tube;
        tube.mesh = mesh::kuhn_box(around, through, along, 1.0);
        tube.mesh.vertices.col(2) *= kLength / along;
        if (nodes_per_tet == 10)
            tube.mesh = mesh::with_midpoints(tube.mesh); // before bending: midpoints then lie on the cylinder
        tube.prescribed.assign(3 * tube.mesh.vertex_count(), 0);
        const double far = 1e-9;
        std::set<VertexId> inner;
        for (Eigen::Index v = 0; v < tube.mesh.vertices.rows(); ++v) {
            const Vec3 p = tube.mesh.vertices.row(v).transpose();
            const auto i = static_cast<std::size_t>(3 * v);
            tube.prescribed[i] = p.x() < far; // x = 0 plane
            tube.prescribed[i + 1] = p.x() > around - far; // y = 0 plane
            tube.prescribed[i + 2] = p.z() < far || p.z() > kLength - far; // plane strain
            if (p.y() < far)
                inner.insert(static_cast<VertexId>(v));
            tube.mesh.vertices.row(v) = bend(p, around, through).transpose();
        }
        // Bending turns the parametric axes (around, out, along) into a left-handed set unless the angle runs
        // clockwise.
        mesh::check_mesh(tube.mesh);
        tube.loads = Eigen::VectorXd::Zero(3 * tube.mesh.vertices.rows());
        for (const mesh::TetFace& face : mesh::boundary_faces(tube.mesh)) {
            const auto corners = mesh::face_vertices(tube.mesh, face);
            if (inner.contains(corners[0]) && inner.contains(corners[1]) && inner.contains(corners[2]))
                press(tube, face);
        }
        tube.inner.assign(inner.begin(), inner.end());
        return tube;
    }

    /// Mean radial displacement of the inner wall.
    double inner_displacement(const Tube& tube, double E, double nu)
    {
        ElasticBody body(
            tube.mesh, Elasticity::linear, test_support::uniform(tube.mesh, test_support::material(E, nu)));
        const Eigen::VectorXd u
            = test_support::solve_linear(body, tube.prescribed, Eigen::VectorXd::Zero(tube.loads.size()), tube.loads);
        double sum = 0.0;
        for (const VertexId v : tube.inner) {
            const Eigen::Vector2d p = tube.mesh.vertices.row(v).head<2>().transpose();
            sum += p.normalized().dot(u.segment<2>(3 * v));
        }
        return sum / static_cast<double>(tube.inner.size());
    }

    double relative_error(const Tube& tube, double E, double nu)
    {
        return std::abs(inner_displacement(tube, E, nu) / exact_at_inner_wall(E, nu) - 1.0);
    }

    TEST(ThickTube, ClosedFormAgreesWithThePublishedNumbers)
    {
        constexpr double kPrinted = 5e-6; // five decimals
        for (const auto& [nu, u] : { std::pair { 0.30, 0.87549 }, std::pair { 0.45, 0.80869 },
                 std::pair { 0.49, 0.78501 }, std::pair { 0.499, 0.77934 } })
            EXPECT_NEAR(exact_at_inner_wall(0.5, nu), u, kPrinted) << nu;
        EXPECT_NEAR(exact_at_inner_wall(1.0, 0.48), 0.39558, kPrinted);
    }

    TEST(ThickTube, LinearElementsConvergeWithOrderTwo)
    {
        const double coarse = relative_error(make_tube(4, 24, 2, 1), 0.5, 0.3),
                     fine = relative_error(make_tube(4, 48, 4, 2), 0.5, 0.3),
                     finest = relative_error(make_tube(4, 96, 8, 4), 0.5, 0.3);
        constexpr double kSlack = 0.25; // not yet asymptotic
        EXPECT_NEAR(std::log2(coarse / fine), 2.0, kSlack) << coarse << " " << fine;
        EXPECT_NEAR(std::log2(fine / finest), 2.0, kSlack) << fine << " " << finest;
        EXPECT_LT(finest, 2e-3);
    }

    TEST(ThickTube, QuadraticElementsDoNotLock)
    {
        const Tube tube = make_tube(10, 24, 2, 1);
        for (const double nu : { 0.3, 0.45, 0.48, 0.499, 0.4999 })
            EXPECT_LT(relative_error(tube, 1.0, nu), 2e-3) << nu;
    }

    TEST(ThickTube, QuadraticElementsConvergeFaster)
    {
        const double coarse = relative_error(make_tube(10, 12, 2, 1), 1.0, 0.48),
                     fine = relative_error(make_tube(10, 24, 4, 2), 1.0, 0.48);
        EXPECT_GT(std::log2(coarse / fine), 2.4) << coarse << " " << fine; // beyond the order 2 of linear elements
    }

} // namespace thick_tube_test
} // namespace retractor::fem
