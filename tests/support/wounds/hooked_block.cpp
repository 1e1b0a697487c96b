#include "tests/support/wounds/hooked_block.h"

#include "fem/statics/nonlinear_region.h"

#include <cmath>

namespace retractor::test_support {

namespace {

    constexpr double kLength = 60.0, kWidth = 40.0, kHeight = 20.0;
    constexpr double kRoundOff = 1e-6; // mm, round-off of grid planes

    fem::Material tissue(double youngs_modulus_MPa, double poissons_ratio)
    {
        return { "tissue", youngs_modulus_MPa, poissons_ratio, 1e-9, "test" };
    }

    bool is_at(double value, double plane) { return std::abs(value - plane) < kRoundOff; }
    bool is_within(double value, double low, double high)
    {
        return value > low - kRoundOff && value < high + kRoundOff;
    }

} // namespace

fem::ElasticProblem hooked_block(int fineness, int nodes_per_tet)
{
    const double spacing = 20.0 / fineness;
    fem::ElasticProblem problem;
    problem.mesh = mesh::kuhn_box(3 * fineness, 2 * fineness, fineness, spacing);
    for (std::size_t t = 0; t < problem.mesh.tet_count(); ++t) {
        double middle = 0.0;
        for (const VertexId v : problem.mesh.tet(static_cast<TetId>(t)))
            middle += 0.25 * problem.mesh.vertices(v, 2);
        problem.mesh.labels[t] = middle < 0.5 * kHeight ? 1 : 2;
    }
    if (nodes_per_tet == 10)
        problem.mesh = mesh::with_midpoints(problem.mesh);
    problem.material_of_label = { {}, tissue(0.04, 0.45), tissue(0.2, 0.30) };
    problem.hooks.resize(2);
    problem.hooks[0]
        = { .name = "left & \"low\"", .side = -1, .nodes = {}, .displacement = Vec3(-3.0, 0.0, 1.0 / 3.0) };
    problem.hooks[1] = { .name = "right", .side = 1, .nodes = {}, .displacement = Vec3(4.0, 0.1, 0.0) };
    for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v) {
        const Vec3 p = problem.mesh.vertices.row(v).transpose();
        if (is_at(p.z(), 0.0))
            problem.supports.fixed.push_back(v);
        else if (is_at(p.x(), 0.0) || is_at(p.x(), kLength))
            problem.supports.bedded.push_back({ v, is_at(p.x(), 0.0) ? 0.013 : 0.002 });
        else if (is_at(p.z(), kHeight) && is_within(p.y(), 10.0, kWidth - 10.0)) {
            if (is_within(p.x(), 10.0, 20.0))
                problem.hooks[0].nodes.push_back(v);
            else if (is_within(p.x(), 40.0, 50.0))
                problem.hooks[1].nodes.push_back(v);
        }
    }
    return problem;
}

std::vector<std::uint8_t> near_hooks(const fem::ElasticProblem& problem)
{
    Points points(0, 3);
    for (const fem::HookPatch& hook : problem.hooks)
        for (const VertexId v : hook.nodes) {
            points.conservativeResize(points.rows() + 1, 3);
            points.row(points.rows() - 1) = problem.mesh.vertices.row(v);
        }
    return fem::elements_near(problem.mesh, points, 9.0);
}

} // namespace retractor::test_support
