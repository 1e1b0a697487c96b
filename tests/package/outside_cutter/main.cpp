#include "mesh/cutting/cut_session.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdio>

namespace rm = retractor::mesh;

int main()
{
    rm::CutSession session(rm::kuhn_box(8, 8, 24, 2.5)); // 20 x 20 x 60 mm, one corner at the origin
    // Across the bar, 1 mm above the middle of its height and so between the mesh's layers; 10 mm deep from the
    // face x = 0.
    const rm::Blade blade { .line = { { 0.0, -5.0, 31.0 }, { 0.0, 25.0, 31.0 } },
        .directions = { retractor::Vec3::UnitX() },
        .depth_mm = 10.0 };
    const rm::CutResult result = session.cut(blade);
    if (result.status != rm::CutStatus::done) {
        std::printf("%s\n", result.message.c_str());
        return 1;
    }
    // Ids are stable; session.undo() takes the cut back.
    std::printf("%zu elements gone, %zu born, %zu faces on the lips\n", result.delta.tets_gone.size(),
        result.delta.tets_born.size(), session.lips().size());
    return 0;
}
