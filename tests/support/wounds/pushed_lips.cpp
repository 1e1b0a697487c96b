#include "tests/support/wounds/pushed_lips.h"

#include "mesh/cutting/cut_session.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::test_support {

PushedLips lips_pushed(double each_side)
{
    const mesh::TetMesh box = mesh::kuhn_box(12, 8, 3, 4.0);
    mesh::CutSession session(box);
    // Round the middle x = 24, y from 6 to 26; upright.
    const mesh::Blade blade {
        .line = { Vec3(24.0, 6.0, 12.0), Vec3(24.0, 26.0, 12.0) }, .directions = { -Vec3::UnitZ() }, .depth_mm = 8.0
    };
    EXPECT_EQ(session.cut(blade).status, mesh::CutStatus::done);
    mesh::SlotMap map;
    PushedLips lips;
    fem::ElasticProblem& p = lips.problem;
    p.mesh = session.compact_mesh(&map);
    p.material_of_label = { {}, material(0.02, 0.4) };
    p.hooks = { { "left", -1, {}, Vec3(each_side, 0.0, 0.0) }, { "right", 1, {}, Vec3(-each_side, 0.0, 0.0) } };
    for (VertexId v = 0; v < p.mesh.vertices.rows(); ++v) {
        const Vec3 x = p.mesh.vertices.row(v).transpose();
        if (x.z() == 0.0)
            p.supports.fixed.push_back(v);
        else if (x.z() == 12.0 && std::abs(x.y() - 16.0) < 7.0 && std::abs(x.x() - 24.0) > 6.0
            && std::abs(x.x() - 24.0) < 14.0)
            p.hooks[x.x() < 24.0 ? 0 : 1].nodes.push_back(v);
        for (VertexId w = 0; w < v; ++w)
            if (p.mesh.vertices.row(w) == p.mesh.vertices.row(v))
                lips.pairs.emplace_back(w, v);
    }
    return lips;
}

} // namespace retractor::test_support
