#include "planner/wall/parted_bones.h"

#include "mesh/tetrahedra/tet_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <vector>

namespace retractor::planner {
namespace parted_bones_test {

    constexpr Label kMuscle = 1, kRib = 2, kNextRib = 3, kSpine = 4, kCartilage = 5;

    mesh::LabelTable table()
    {
        using mesh::Role;
        return { { kMuscle, "muscle", "muscle", Role::wall }, { kRib, "rib_left_4", "bone", Role::wall },
            { kNextRib, "rib_left_5", "bone", Role::wall }, { kSpine, "spine", "bone", Role::wall },
            { kCartilage, "costal_cartilages", "cartilage", Role::wall } };
    }

    /// Cubes of 10 mm, labelled by the middles of their elements.
    mesh::TetMesh labelled(const std::function<Label(const Vec3&)>& label)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(6, 3, 3, 10.0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& corner : mesh::tet_corners(mesh, t))
                middle += 0.25 * corner;
            mesh.labels[static_cast<std::size_t>(t)] = label(middle);
        }
        return mesh;
    }

    std::set<VertexId> vertices_of(const mesh::TetMesh& mesh, Label label)
    {
        std::set<VertexId> vertices;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (mesh.labels[static_cast<std::size_t>(t)] == label)
                vertices.insert(mesh.tet(t).begin(), mesh.tet(t).end());
        return vertices;
    }

    std::size_t shared(const mesh::TetMesh& mesh, Label a, Label b)
    {
        const std::set<VertexId> of_a = vertices_of(mesh, a), of_b = vertices_of(mesh, b);
        return static_cast<std::size_t>(std::ranges::count_if(of_a, [&](VertexId v) { return of_b.contains(v); }));
    }

    /// A rib along the middle of the box from x = 20 mm on, with another bone behind it.
    Label rib_before(Label other, const Vec3& p)
    {
        const bool in_bar = p.y() > 10.0 && p.y() < 20.0 && p.z() > 10.0 && p.z() < 20.0;
        if (p.x() < 20.0)
            return other;
        return in_bar ? kRib : kMuscle;
    }

    TEST(PartedBones, ASpineThatARibTouchesGivesWay)
    {
        mesh::TetMesh mesh = labelled([](const Vec3& p) { return rib_before(kSpine, p); });
        const mesh::TetMesh before = mesh;
        ASSERT_EQ(shared(mesh, kRib, kSpine), 4U); // a weld
        const std::size_t changed = part_ribs_from_other_bones(mesh, table());
        EXPECT_GT(changed, 0U);
        EXPECT_EQ(shared(mesh, kRib, kSpine), 0U);
        EXPECT_FALSE(vertices_of(mesh, kSpine).empty());
        std::size_t differ = 0;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t)
            if (mesh.labels[t] != before.labels[t]) {
                ++differ;
                EXPECT_EQ(before.labels[t], kSpine);
                EXPECT_EQ(mesh.labels[t], kMuscle);
            }
        EXPECT_EQ(differ, changed);
        EXPECT_EQ(part_ribs_from_other_bones(mesh, table()), 0U);
    }

    TEST(PartedBones, CartilageAndOtherRibsStay)
    {
        for (const Label other : { kCartilage, kNextRib }) {
            mesh::TetMesh mesh = labelled([&](const Vec3& p) { return rib_before(other, p); });
            const std::vector<Label> before = mesh.labels;
            EXPECT_EQ(part_ribs_from_other_bones(mesh, table()), 0U);
            EXPECT_EQ(mesh.labels, before);
        }
    }

    TEST(PartedBones, WithoutSoftTissueRoundTheRibNothingChanges)
    {
        mesh::TetMesh mesh = labelled([](const Vec3& p) { return p.x() < 20.0 ? kSpine : kRib; });
        EXPECT_EQ(part_ribs_from_other_bones(mesh, table()), 0U);
    }

} // namespace parted_bones_test
} // namespace retractor::planner
