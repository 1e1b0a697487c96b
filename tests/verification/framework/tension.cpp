#include "tests/verification/framework/tension.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/model/elastic_body.h"
#include "fem/model/floating_components.h"
#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

namespace retractor::verification {

namespace {

    void check_vertex(const mesh::TetMesh& mesh, VertexId v, const char* which)
    {
        if (v < 0 || static_cast<std::size_t>(v) >= mesh.vertex_count())
            throw InputError(std::string(which) + " vertex is not in the mesh", "vertex " + std::to_string(v));
    }

    std::vector<std::uint8_t> prescribed_unknowns(const mesh::TetMesh& mesh, std::span<const VertexId> held)
    {
        std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
        for (const VertexId v : held) {
            check_vertex(mesh, v, "a held");
            for (std::size_t axis = 0; axis < 3; ++axis)
                prescribed[3 * static_cast<std::size_t>(v) + axis] = 1;
        }
        return prescribed;
    }

    Points as_points(const Eigen::VectorXd& u) { return Eigen::Map<const Points>(u.data(), u.size() / 3, 3); }

    constexpr double kCentralForceRatio = 0.25; // Poisson's ratio of springs

} // namespace

ReleasedWound release_wound(const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips,
    std::span<const Mat3> stresses, std::span<const fem::Material> materials, const fem::Supports& supports,
    const Points& held_displacement, const Job& job)
{
    ReleasedWound result;
    Stopwatch watch;
    fem::check_no_floating_component(mesh, supports.fixed);
    fem::ElasticBody body(mesh, fem::Elasticity::linear, fem::element_parameters(mesh, materials));
    fem::set_springs(body, supports);
    const fem::BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 0.0);
    Eigen::VectorXd load = fem::traction_loads(mesh, fem::released_tractions(mesh, lips, stresses));
    result.assemble_seconds = watch.seconds();
    job.report("release of tension", 0.2);
    watch = {};
    fem::ConstrainedSolver solver(K.pattern, prescribed_unknowns(mesh, supports.fixed));
    solver.factorise(K);
    result.factor_seconds = watch.seconds();
    job.report("release of tension", 0.9);
    watch = {};
    solver.mask(load);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(load.size());
    if (held_displacement.rows() > 0) {
        if (held_displacement.rows() != mesh.vertices.rows())
            throw InputError("there must be one displacement per node", "held_displacement");
        for (const VertexId v : supports.fixed)
            u.segment<3>(3 * static_cast<Eigen::Index>(v)) = held_displacement.row(v).transpose();
    }
    u += solver.solve(load - K.multiply(u));
    result.solve_seconds = watch.seconds();
    Eigen::VectorXd rest = K.multiply(u) - load;
    solver.mask(rest);
    result.relative_residual = load.isZero(0.0) ? 0.0 : rest.norm() / load.norm();
    result.displacement = as_points(u);
    return result;
}

double spring_calibration(const mesh::TetMesh& mesh, std::span<const fem::Material> materials,
    std::span<const VertexId> held, const Vec3& pull, std::span<const VertexId> symmetry, const Job& job)
{
    constexpr double kStrain = 1e-4; // small enough for both models to be linear
    constexpr int kPlenty = 100000; // iterations
    if (!(pull.norm() > 0.0 && pull.allFinite()))
        throw InputError("the pull of a calibration must be a direction", "pull");
    const Vec3 along = pull.normalized();
    const auto rows = static_cast<Eigen::Index>(mesh.vertex_count());
    Eigen::VectorXd start = Eigen::VectorXd::Zero(3 * rows);
    for (Eigen::Index v = 0; v < rows; ++v)
        start.segment<3>(3 * v) = kStrain * along.dot(mesh.vertices.row(v).transpose()) * along;

    std::vector<fem::Material> central(materials.begin(), materials.end());
    for (fem::Material& material : central)
        material.poissons_ratio = kCentralForceRatio;
    fem::ElasticBody body(mesh, fem::Elasticity::linear, fem::element_parameters(mesh, central));
    const fem::BlockMatrix& K = body.stiffness(Eigen::VectorXd::Zero(3 * rows), 0.0);
    std::vector<std::uint8_t> prescribed = prescribed_unknowns(mesh, held);
    for (const VertexId v : symmetry) {
        check_vertex(mesh, v, "a symmetry");
        prescribed[3 * static_cast<std::size_t>(v) + 2] = 1;
    }
    fem::ConstrainedSolver solver(K.pattern, prescribed);
    solver.factorise(K);
    const Eigen::VectorXd u = start - solver.solve(K.multiply(start));
    const double elastic = 0.5 * u.dot(K.multiply(u));

    // The whole mesh starts stretched. The ends stay stretched while the rest comes to equilibrium.
    fem::SpringNetwork network(mesh::CutSession { mesh }, materials);
    if (!symmetry.empty())
        network.fix(symmetry, 4);
    network.set_displacement(as_points(start));
    network.fix(held);
    const fem::RelaxResult rest = fem::relax(network, { .tolerance = 1e-4, .max_iterations = kPlenty }, job);
    if (rest.status != fem::RelaxStatus::converged)
        throw SolverError("the springs did not come to rest: " + rest.message);
    const double springs = rest.energy;
    if (!(springs > 0.0 && elastic > 0.0))
        throw InputError("the held vertices do not stretch the body: there is nothing to calibrate", "held");
    return elastic / springs;
}

double SheetProblem::thickness() const { return std::numbers::pi * cut_length / around; }

mesh::TetMesh sheet_mesh(const SheetProblem& s)
{
    const double a = 0.5 * s.cut_length;
    if (!(a > 0.0 && s.radius > a && std::isfinite(s.radius)))
        throw InputError("a sheet needs a cut shorter than itself", "sheet");
    if (s.around < 8 || s.around % 4 != 0)
        throw InputError("a sheet needs a multiple of four cells round its cut, at least eight", "around");
    const int n = s.around;
    const double cell = 2.0 * std::numbers::pi / n, reach = std::acosh(s.radius / a);
    const int rings = std::max(2, static_cast<int>(std::lround(reach / (cell * std::sqrt(0.75)))));
    std::vector<std::vector<VertexId>> id(static_cast<std::size_t>(rings) + 1);
    std::vector<Vec3> flat;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < n; ++j) {
            auto& row = id[static_cast<std::size_t>(i)];
            if (i == 0 && j > n / 2) { // both sides of the cut share their vertices
                row.push_back(row[static_cast<std::size_t>(n - j)]);
                continue;
            }
            row.push_back(static_cast<VertexId>(flat.size()));
            const double xi = reach * i / rings, eta = cell * (j + (i % 2 == 0 ? 0.0 : 0.5));
            // Sets the tips and the line between the tips exactly.
            const double x = i == 0 && 4 * j == n ? 0.0 : a * std::cosh(xi) * std::cos(eta);
            flat.emplace_back(x, i == 0 ? 0.0 : a * std::sinh(xi) * std::sin(eta), 0.0);
        }
    mesh::TetMesh mesh;
    const auto count = static_cast<VertexId>(flat.size());
    mesh.vertices.resize(2 * static_cast<Eigen::Index>(count), 3);
    for (VertexId v = 0; v < count; ++v) {
        mesh.vertices.row(v) = flat[static_cast<std::size_t>(v)].transpose();
        mesh.vertices.row(v + count) = (flat[static_cast<std::size_t>(v)] + Vec3(0.0, 0.0, s.thickness())).transpose();
    }
    const auto add = [&](std::array<VertexId, 4> t) {
        const auto p = [&](std::size_t i) { return Vec3(mesh.vertices.row(t[i])); };
        if (mesh::tet_volume(p(0), p(1), p(2), p(3)) < 0.0)
            std::swap(t[2], t[3]);
        mesh.nodes.insert(mesh.nodes.end(), t.begin(), t.end());
        mesh.labels.push_back(1);
    };
    const auto prism = [&](std::array<VertexId, 3> t) {
        std::sort(t.begin(), t.end());
        const auto [p, q, r] = t;
        add({ p, q, r, r + count });
        add({ p, q, q + count, r + count });
        add({ p, p + count, q + count, r + count });
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < n; ++j) {
            const auto& low = id[static_cast<std::size_t>(i)];
            const auto& high = id[static_cast<std::size_t>(i) + 1];
            const auto here = static_cast<std::size_t>(j), next = static_cast<std::size_t>((j + 1) % n);
            if (i % 2 == 0) {
                prism({ low[here], low[next], high[here] });
                prism({ high[here], low[next], high[next] });
            } else {
                prism({ low[here], low[next], high[next] });
                prism({ low[here], high[next], high[here] });
            }
        }
    mesh::check_mesh(mesh);
    return mesh;
}

mesh::Blade sheet_blade(const SheetProblem& s)
{
    const double a = 0.5 * s.cut_length;
    return { .line = { Vec3(-a, 0.0, s.thickness()), Vec3(a, 0.0, s.thickness()) },
        .directions = { -Vec3::UnitZ() },
        .depth_mm = 2.0 * s.thickness() };
}

std::vector<VertexId> sheet_rim(const SheetProblem& s, const mesh::TetMesh& mesh)
{
    const double a = 0.5 * s.cut_length, b = std::sqrt(s.radius * s.radius - a * a);
    constexpr double kOnRim = 1e-6;
    std::vector<VertexId> rim;
    for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
        const double x = mesh.vertices(v, 0) / s.radius, y = mesh.vertices(v, 1) / b;
        if (std::abs(x * x + y * y - 1.0) < kOnRim)
            rim.push_back(v);
    }
    return rim;
}

std::vector<VertexId> sheet_middle_plane(const mesh::TetMesh& mesh)
{
    std::vector<VertexId> middle;
    for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
        if (mesh.vertices(v, 2) == 0.0)
            middle.push_back(v);
    return middle;
}

Vec3 sheet_displacement(double length, double stress, double E, double nu, const Vec3& at)
{
    const double a = 0.5 * length, mu = E / (2.0 * (1.0 + nu)), kappa = (3.0 - nu) / (1.0 + nu);
    const std::complex<double> z(at.x(), at.y());
    // With this product of roots the branch cut lies on the cut of the sheet.
    const std::complex<double> root = std::sqrt(z - a) * std::sqrt(z + a);
    const std::complex<double> Z = stress * (z / root - 1.0), integral = stress * (root - z);
    return { (0.5 * (kappa - 1.0) * integral.real() - at.y() * Z.imag()) / (2.0 * mu),
        (0.5 * (kappa + 1.0) * integral.imag() - at.y() * Z.real()) / (2.0 * mu), 0.0 };
}

double sheet_gape(fem::PreStrainKind kind, double e, double length, double nu, double along_cut)
{
    switch (kind) {
    case fem::PreStrainKind::uniaxial_stress:
        return 2.0 * e * length;
    case fem::PreStrainKind::held_width:
        return 2.0 * e * length / (1.0 - nu * nu);
    case fem::PreStrainKind::biaxial:
        return 2.0 * (e + nu * along_cut) * length / (1.0 - nu * nu);
    case fem::PreStrainKind::equibiaxial:
        return 2.0 * e * length / (1.0 - nu);
    default:
        throw InputError("there is no closed form for a sheet under this kind of tension", "pre-strain");
    }
}

} // namespace retractor::verification
