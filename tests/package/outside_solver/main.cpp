// Cuts a bar of tetrahedra (20 x 20 x 60 mm) half through and pulls it 1 mm longer: a program that links the cutter and
// the solver, and no library that draws, reads images or meshes. The cut bar must resist less than the whole one.
#include "fem/statics/opening.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdio>
#include <vector>

namespace {

/// Force (N) that pulls the top of the bar by 1 mm while its bottom is held.
double pulling_force(const retractor::mesh::TetMesh& bar)
{
    retractor::fem::Supports supports;
    retractor::fem::HookPatch hook { .name = "top", .side = 1, .nodes = {}, .displacement = { 0.0, 0.0, 1.0 } };
    for (retractor::VertexId v = 0; v < bar.vertices.rows(); ++v) {
        if (bar.vertices(v, 2) < 1.0)
            supports.fixed.push_back(v);
        if (bar.vertices(v, 2) > 59.0)
            hook.nodes.push_back(v);
    }
    const std::vector<retractor::fem::Material> materials(2, { "rubber", 1.0, 0.3, 1e-9, "an example" });
    retractor::fem::Opening opening(bar, materials, supports, { .elasticity = retractor::fem::Elasticity::linear });
    return opening.open(std::vector { hook }).hook_forces_N.at(0).norm();
}

} // namespace

int main()
{
    const retractor::mesh::TetMesh bar = retractor::mesh::kuhn_box(8, 8, 24, 2.5);
    // Across the bar at half its height, 10 mm deep from the face x = 0.
    const retractor::mesh::Blade blade { .line = { { 0.0, -5.0, 31.0 }, { 0.0, 25.0, 31.0 } },
        .directions = { retractor::Vec3::UnitX() },
        .depth_mm = 10.0 };
    retractor::mesh::CutSession session(bar);
    if (session.cut(blade).status != retractor::mesh::CutStatus::done)
        return 1;
    const retractor::mesh::TetMesh cut = session.compact_mesh();
    const double whole = pulling_force(bar), halved = pulling_force(cut);
    std::printf("%zu tetrahedra, %.3f N; cut half through %zu tetrahedra, %.3f N\n", bar.tet_count(), whole,
        cut.tet_count(), halved);
    return halved > 0.0 && halved < 0.9 * whole ? 0 : 1;
}
