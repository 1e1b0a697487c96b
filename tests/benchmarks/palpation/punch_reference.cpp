#include "tests/benchmarks/palpation/punch_reference.h"

#include "fem/statics/equilibrium.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cstdint>

namespace retractor::benchmarks {

namespace {

    /// Also marks the midpoints of edges with two marked ends.
    std::vector<std::uint8_t> with_midpoint_marks(const mesh::TetMesh& mesh, std::vector<std::uint8_t> marked)
    {
        marked.resize(mesh.vertex_count(), 0);
        if (mesh.nodes_per_tet != 10)
            return marked;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto nodes = mesh.tet(t);
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (marked[static_cast<std::size_t>(nodes[static_cast<std::size_t>(mesh::kTetEdges[e][0])])] != 0
                    && marked[static_cast<std::size_t>(nodes[static_cast<std::size_t>(mesh::kTetEdges[e][1])])] != 0)
                    marked[static_cast<std::size_t>(nodes[4 + e])] = 1;
        }
        return marked;
    }

    std::vector<std::uint8_t> marks(std::size_t count, std::span<const VertexId> vertices)
    {
        std::vector<std::uint8_t> marked(count, 0);
        for (const VertexId v : vertices)
            marked[static_cast<std::size_t>(v)] = 1;
        return marked;
    }

} // namespace

std::vector<VertexId> punch_patch(const PunchProblem& problem)
{
    std::vector<VertexId> patch;
    for (const mesh::TetFace& face : mesh::boundary_faces(problem.mesh))
        for (const VertexId v : mesh::face_vertices(problem.mesh, face))
            if ((problem.mesh.vertices.row(v).transpose() - problem.centre).norm() <= problem.radius)
                patch.push_back(v);
    std::sort(patch.begin(), patch.end());
    patch.erase(std::unique(patch.begin(), patch.end()), patch.end());
    if (patch.empty())
        throw InputError("the punch meets no vertex of the surface");
    return patch;
}

PunchAnswer punch_by_elements(const PunchProblem& problem, bool quadratic, const Job& job)
{
    const Stopwatch watch;
    const std::vector<VertexId> patch = punch_patch(problem);
    const mesh::TetMesh mesh = quadratic ? mesh::with_midpoints(problem.mesh) : problem.mesh;
    const auto pressed = with_midpoint_marks(mesh, marks(problem.mesh.vertex_count(), patch));
    const auto fixed = with_midpoint_marks(mesh, marks(problem.mesh.vertex_count(), problem.fixed));
    const auto unknowns = static_cast<Eigen::Index>(3 * mesh.vertex_count());
    std::vector<std::uint8_t> prescribed(3 * mesh.vertex_count(), 0);
    Eigen::VectorXd target = Eigen::VectorXd::Zero(unknowns);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
        for (std::size_t i = 0; i < 3; ++i)
            if (pressed[v] != 0 || fixed[v] != 0) {
                prescribed[3 * v + i] = 1;
                if (pressed[v] != 0)
                    target(static_cast<Eigen::Index>(3 * v + i)) = problem.press(static_cast<Eigen::Index>(i));
            }
    fem::ElasticBody body(
        mesh, fem::Elasticity::linear, std::vector<fem::Lame>(mesh.tet_count(), fem::lame(problem.material)));
    fem::EquilibriumSolver solver;
    const fem::Equilibrium answer
        = solver.solve(body, prescribed, target, Eigen::VectorXd::Zero(unknowns), fem::EquilibriumOptions {}, job);
    PunchAnswer result { .nodes = mesh.vertex_count(), .patch = patch.size(), .seconds = watch.seconds() };
    Vec3 force = Vec3::Zero();
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
        if (pressed[v] != 0)
            force += answer.forces.segment<3>(static_cast<Eigen::Index>(3 * v));
    result.force = force.dot(problem.press.normalized());
    return result;
}

PunchProblem punched_block(int across, int high, double spacing, double depth, const fem::Material& material)
{
    PunchProblem problem;
    problem.mesh = mesh::kuhn_box(across, across, high, spacing);
    problem.material = material;
    for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v)
        if (problem.mesh.vertices(v, 2) == 0.0)
            problem.fixed.push_back(v);
    problem.centre = Vec3(0.5 * across * spacing, 0.5 * across * spacing, high * spacing);
    problem.press = Vec3(0.0, 0.0, -depth);
    return problem;
}

} // namespace retractor::benchmarks
