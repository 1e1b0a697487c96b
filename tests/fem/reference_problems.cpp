#include "reference_problems.h"

#include "fem/constrained_solver.h"
#include "fem/tet_element.h"

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <random>

namespace retractor::testing {

namespace {

    struct WeightedPoint {
        std::array<double, 4> barycentric;
        double weight;
    };

    /// Keast's rule with 15 points [Keast 1986], exact for degree 5: finer than what is measured with it.
    std::vector<WeightedPoint> fine_rule()
    {
        std::vector<WeightedPoint> rule { { { 0.25, 0.25, 0.25, 0.25 }, 0.030283678097089 * 6.0 } };
        const auto corner = [&](double a, double w) {
            for (std::size_t i = 0; i < 4; ++i) {
                std::array<double, 4> b { a, a, a, a };
                b[i] = 1.0 - 3.0 * a;
                rule.push_back({ b, 6.0 * w });
            }
        };
        corner(1.0 / 3.0, 0.006026785714286);
        corner(1.0 / 11.0, 0.011645249086029);
        const double a = 0.066550153573664, b = 0.5 - a;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j) {
                std::array<double, 4> at { b, b, b, b };
                at[i] = at[j] = a;
                rule.push_back({ at, 6.0 * 0.010949141561386 });
            }
        return rule;
    }

    /// Calls f(element, shape values, position, weight in mm^3) at every point of the fine rule.
    template <class F> void integrate(const TetMesh& mesh, const F& f)
    {
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto nodes = mesh.tet(t);
            NodeGradients rest(mesh.nodes_per_tet, 3);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
            for (const WeightedPoint& point : fine_rule()) {
                const Eigen::VectorXd values = shape_values(mesh.nodes_per_tet, point.barycentric);
                const Vec3 position = rest.transpose() * values;
                f(nodes, values, position, shape_gradients(rest, { point.barycentric, point.weight }).volume);
            }
        }
    }

} // namespace

Material material(double youngs_modulus_MPa, double poissons_ratio)
{
    return { "test", youngs_modulus_MPa, poissons_ratio, 1e-9, "test" };
}

std::vector<Lame> uniform(const TetMesh& mesh, const Material& m)
{
    return std::vector<Lame>(mesh.tet_count(), lame(m));
}

TetMesh distorted_box(int n, double spacing, double share, unsigned seed)
{
    TetMesh mesh = kuhn_box(n, n, n, spacing);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> move(-share * spacing, share * spacing);
    const double size = n * spacing;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        const auto p = mesh.vertices.row(v);
        if (p.minCoeff() > 0.0 && p.maxCoeff() < size)
            mesh.vertices.row(v) += Eigen::RowVector3d(move(random), move(random), move(random));
    }
    check_mesh(mesh);
    return mesh;
}

Eigen::MatrixXd dense(const BlockMatrix& K)
{
    const auto n = static_cast<Eigen::Index>(3 * K.pattern.row_count());
    Eigen::MatrixXd matrix(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        matrix.col(i) = K.multiply(Eigen::VectorXd::Unit(n, i));
    return matrix;
}

Eigen::VectorXd nodal(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field)
{
    Eigen::VectorXd u(3 * mesh.vertices.rows());
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        u.segment<3>(3 * v) = field(mesh.vertices.row(v).transpose());
    return u;
}

std::vector<std::uint8_t> boundary_unknowns(const TetMesh& mesh)
{
    std::vector<std::uint8_t> flag(3 * mesh.vertex_count(), 0);
    const auto set = [&](VertexId v) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            flag[3 * static_cast<std::size_t>(v) + axis] = 1;
    };
    for (const TetFace& face : boundary_faces(mesh)) {
        for (const VertexId v : face_vertices(mesh, face))
            set(v);
        if (mesh.nodes_per_tet == 10)
            for (std::size_t e = 0; e < kTetEdges.size(); ++e)
                if (kTetEdges[e][0] != face.corner && kTetEdges[e][1] != face.corner)
                    set(mesh.tet(face.tet)[4 + e]);
    }
    return flag;
}

Eigen::VectorXd solve_linear(ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads)
{
    const BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(values.size()), false);
    ConstrainedSolver solver(K.pattern, prescribed);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(values.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        if (prescribed[i] != 0)
            u[static_cast<Eigen::Index>(i)] = values[static_cast<Eigen::Index>(i)];
    solver.factorise(K);
    return u + solver.solve(loads - K.multiply(u));
}

Eigen::VectorXd body_loads(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& force)
{
    Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
    integrate(mesh, [&](auto nodes, const Eigen::VectorXd& values, const Vec3& position, double weight) {
        const Vec3 f = weight * force(position);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            loads.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += values[static_cast<Eigen::Index>(a)] * f;
    });
    return loads;
}

double l2_error(const TetMesh& mesh, const Eigen::VectorXd& u_h, const std::function<Vec3(const Vec3&)>& u)
{
    double sum = 0.0;
    integrate(mesh, [&](auto nodes, const Eigen::VectorXd& values, const Vec3& position, double weight) {
        Vec3 difference = -u(position);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            difference
                += values[static_cast<Eigen::Index>(a)] * u_h.segment<3>(3 * static_cast<Eigen::Index>(nodes[a]));
        sum += weight * difference.squaredNorm();
    });
    return std::sqrt(sum);
}

} // namespace retractor::testing
