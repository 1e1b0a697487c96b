#include "tests/planner/session/layered_wall.h"

#include "planner/case/solver_settings.h"

namespace retractor::planner {

SurgerySetup layered_wall(const Vec3& shift)
{
    SurgerySetup setup;
    setup.wall = mesh::kuhn_box(24, 6, 24, kSlabEdgeMm);
    for (TetId t = 0; t < static_cast<TetId>(setup.wall.tet_count()); ++t) {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : setup.wall.tet(t))
            middle += 0.25 * setup.wall.vertices.row(v).transpose();
        Label& label = setup.wall.labels[static_cast<std::size_t>(t)];
        label = middle.y() < 5.0 ? kSkin : middle.y() < 15.0 ? kFat : kMuscle;
        if (middle.x() > 100.0 && middle.y() < 10.0)
            label = kBone;
    }
    for (Eigen::Index v = 0; v < setup.wall.vertices.rows(); ++v) {
        const double x = setup.wall.vertices(v, 0), z = setup.wall.vertices(v, 2);
        if (x == 0.0 || x == 120.0 || z == 0.0 || z == 120.0)
            setup.held.push_back(static_cast<VertexId>(v));
    }
    setup.wall.vertices.rowwise() += shift.transpose();
    setup.labels = { { kSkin, "skin", "skin", mesh::Role::wall }, { kFat, "fat", "fat", mesh::Role::wall },
        { kMuscle, "muscle", "muscle", mesh::Role::wall }, { kBone, "rib", "bone", mesh::Role::wall } };
    setup.materials.resize(5);
    for (const mesh::LabelInfo& info : setup.labels)
        setup.materials[info.id]
            = as_solved(fem::find_material(fem::default_materials(), info.material), ElementKind::p1);
    return setup;
}

Ray ray_down(double x, double z) { return { { x, -50.0, z }, Vec3::UnitY() }; }

SurgerySetup wall_with_planned_hooks(const HookPull& pull, double hook_depth_mm)
{
    SurgerySetup setup = layered_wall();
    setup.approach.incision = { { 30.0, 0.0, 60.0 }, { 90.0, 0.0, 60.0 } };
    setup.approach.directions.assign(2, Vec3::UnitY());
    setup.approach.depth_mm = 20.0;
    for (const int side : { 1, -1 })
        setup.approach.hooks.push_back({ .name = side > 0 ? "up" : "down",
            .side = side,
            .along_mm = 30.0,
            .depth_mm = hook_depth_mm,
            .direction = side * Vec3::UnitZ(),
            .opening_mm = pull.force_N ? 0.0 : 6.0,
            .pull = pull });
    return setup;
}
} // namespace retractor::planner
