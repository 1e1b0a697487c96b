#include "tests/support/reference_problems.h"

#include "fem/linear_algebra/constrained_solver.h"

namespace retractor::test_support {

fem::Material material(double youngs_modulus_MPa, double poissons_ratio)
{
    return { "test", youngs_modulus_MPa, poissons_ratio, 1e-9, "test" };
}

std::vector<fem::Lame> uniform(const mesh::TetMesh& mesh, const fem::Material& m)
{
    return std::vector<fem::Lame>(mesh.tet_count(), fem::lame(m));
}

std::vector<std::uint8_t> boundary_unknowns(const mesh::TetMesh& mesh)
{
    return verification::hold_boundary(mesh, [](const Vec3&) { return Vec3(Vec3::Zero()); }).prescribed;
}

Eigen::VectorXd solve_linear(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& values, const Eigen::VectorXd& loads)
{
    const fem::BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(values.size()), false);
    fem::ConstrainedSolver solver(K.pattern, prescribed);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(values.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        if (prescribed[i] != 0)
            u[static_cast<Eigen::Index>(i)] = values[static_cast<Eigen::Index>(i)];
    solver.factorise(K);
    return u + solver.solve(loads - K.multiply(u));
}

} // namespace retractor::test_support
