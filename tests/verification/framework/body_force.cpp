#include "tests/verification/framework/body_force.h"

#include "fem/element/tet_element.h"

#include <array>
#include <cstddef>
#include <vector>

namespace retractor::verification {

namespace {

    /// Keast's rule with 15 points [Keast 1986], exact for degree 5.
    std::vector<fem::QuadraturePoint> fine_rule()
    {
        std::vector<fem::QuadraturePoint> rule { { { 0.25, 0.25, 0.25, 0.25 }, 0.030283678097089 * 6.0 } };
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

} // namespace

void integrate(const mesh::TetMesh& mesh,
    const std::function<void(std::span<const VertexId>, const Eigen::VectorXd&, const Vec3&, double)>& f)
{
    const std::vector<fem::QuadraturePoint> rule = fine_rule();
    fem::NodeGradients rest(mesh.nodes_per_tet, 3);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto nodes = mesh.tet(t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
        for (const fem::QuadraturePoint& point : rule) {
            const Eigen::VectorXd values = fem::shape_values(mesh.nodes_per_tet, point.barycentric);
            f(nodes, values, rest.transpose() * values, fem::shape_gradients(rest, point).volume);
        }
    }
}

Eigen::VectorXd body_force_loads(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& force)
{
    Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
    integrate(mesh, [&](auto nodes, const Eigen::VectorXd& values, const Vec3& position, double weight) {
        const Vec3 f = weight * force(position);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            loads.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += values[static_cast<Eigen::Index>(a)] * f;
    });
    return loads;
}

} // namespace retractor::verification
