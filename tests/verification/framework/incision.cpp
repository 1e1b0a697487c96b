#include "tests/verification/framework/incision.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/hook.h"
#include "mesh/base/error.h"
#include "tests/support/cutting/cut_mesh.h"

#include <array>
#include <cmath>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kOnGrid = 1e-6; // mm

    std::vector<VertexId> lip_patch(const IncisedBlock& block, const Incision& incision, int side)
    {
        std::vector<std::array<VertexId, 3>> faces;
        for (const mesh::LipFace& lip : incision.lips)
            if (lip.side == side)
                faces.push_back(mesh::face_vertices(incision.mesh, lip.face));
        const Vec3 centre(0.5 * block.size.x(), 0.5 * block.size.y(), block.size.z() - 0.5 * block.hook_height);
        return fem::hook_patch_nodes(
            incision.mesh, faces, centre, Vec3::UnitX(), -Vec3::UnitZ(), block.hook_width, block.hook_height);
    }

} // namespace

mesh::TetMesh uncut_block(const IncisedBlock& block)
{
    const auto cells = [&](double length) { return static_cast<int>(std::lround(length / block.cell)); };
    return mesh::kuhn_box(cells(block.size.x()), cells(block.size.y()), cells(block.size.z()), block.cell);
}

mesh::Blade incision_blade(const IncisedBlock& block)
{
    const Vec3 middle(0.5 * block.size.x(), 0.5 * block.size.y(), block.size.z());
    const Vec3 half = 0.5 * block.length * Vec3::UnitX();
    return { .line = { middle - half, middle + half }, .directions = { -Vec3::UnitZ() }, .depth_mm = block.depth };
}

Incision incise(const mesh::TetMesh& mesh, const mesh::Blade& blade, const mesh::CutOptions& options)
{
    test_support::CutMesh cut = test_support::cut(mesh, blade, options);
    if (cut.status != mesh::CutStatus::done)
        throw SolverError("the incision was not made: " + cut.message);
    return { std::move(cut.mesh), std::move(cut.lips), cut.report };
}

fem::ElasticProblem hooked_open(const IncisedBlock& block, const Incision& incision, const fem::Material& tissue,
    const Vec3& pull, int nodes_per_tet)
{
    fem::ElasticProblem problem { incision.mesh, { tissue, tissue }, {}, {} };
    for (VertexId v = 0; v < static_cast<VertexId>(incision.mesh.vertex_count()); ++v)
        if (incision.mesh.vertices(v, 2) < kOnGrid)
            problem.supports.fixed.push_back(v);
    for (const int side : { -1, 1 })
        problem.hooks.push_back({ .name = side < 0 ? "right" : "left",
            .side = side,
            .nodes = lip_patch(block, incision, side),
            .displacement = side < 0 ? Vec3(pull.x(), -pull.y(), pull.z()) : pull });
    return nodes_per_tet == 10 ? with_midpoints(problem) : problem;
}

fem::ElasticProblem problem_now(const mesh::CutSession& session, const std::vector<fem::Material>& material_of_label,
    const fem::Supports& supports, const std::vector<fem::OnlineHook>& hooks)
{
    mesh::SlotMap map;
    fem::ElasticProblem problem { session.compact_mesh(&map), material_of_label, {}, {} };
    const auto compact = [&](VertexId v) { return map.compact_vertex[static_cast<std::size_t>(v)]; };
    for (const VertexId v : supports.fixed)
        if (session.has_vertex(v))
            problem.supports.fixed.push_back(compact(v));
    for (const fem::BeddedVertex& bed : supports.bedded)
        if (session.has_vertex(bed.vertex))
            problem.supports.bedded.push_back({ compact(bed.vertex), bed.stiffness });
    for (const fem::OnlineHook& hook : hooks) {
        if (hook.drive.force_N)
            continue;
        problem.hooks.push_back({ hook.name, hook.side, {}, hook.drive.displacement });
        for (const VertexId v : hook.nodes)
            if (session.has_vertex(v))
                problem.hooks.back().nodes.push_back(compact(v));
    }
    return problem;
}

std::vector<int> sides_of_cut(const IncisedBlock& block, const mesh::TetMesh& mesh)
{
    std::vector<std::array<bool, 2>> met(mesh.vertex_count(), { false, false });
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        double y = 0.0;
        for (std::size_t a = 0; a < 4; ++a)
            y += 0.25 * mesh.vertices(mesh.tet(t)[a], 1);
        for (const VertexId v : mesh.tet(t))
            met[static_cast<std::size_t>(v)][y > 0.5 * block.size.y() ? 1 : 0] = true;
    }
    std::vector<int> side(mesh.vertex_count(), 0);
    for (std::size_t v = 0; v < side.size(); ++v)
        if (std::abs(mesh.vertices(static_cast<Eigen::Index>(v), 1) - 0.5 * block.size.y()) < kOnGrid
            && met[v][0] != met[v][1])
            side[v] = met[v][1] ? 1 : -1;
    return side;
}

} // namespace retractor::verification
