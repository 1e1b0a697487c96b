#include "fem/statics/hook.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace retractor::fem {
namespace hook_test {

    /// The faces of a box on its plane x = 0.
    std::vector<std::array<VertexId, 3>> lip_of(const mesh::TetMesh& mesh)
    {
        std::vector<std::array<VertexId, 3>> lip;
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto v = mesh::face_vertices(mesh, face);
            if (std::all_of(v.begin(), v.end(), [&](VertexId i) { return mesh.vertices(i, 0) == 0.0; }))
                lip.push_back(v);
        }
        return lip;
    }

    TEST(HookPatch, HoldsTheNodesUnderTheRectangle)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 10, 10, 2.0);
        const auto nodes = hook_patch_nodes(box, lip_of(box), { 0, 10, 12 }, Vec3::UnitY(), -Vec3::UnitZ(), 8.0, 12.0);
        EXPECT_EQ(nodes.size(), 5U * 7U);
        for (const VertexId v : nodes) {
            EXPECT_EQ(box.vertices(v, 0), 0.0);
            EXPECT_LE(std::abs(box.vertices(v, 1) - 10.0), 4.0);
            EXPECT_LE(std::abs(box.vertices(v, 2) - 12.0), 6.0);
        }
        EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end()));
    }

    TEST(HookPatch, AxesNeedBeNeitherUnitNorPerpendicular)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 10, 10, 2.0);
        const auto lip = lip_of(box);
        const Vec3 centre(0, 10, 12);
        EXPECT_EQ(hook_patch_nodes(box, lip, centre, 7 * Vec3::UnitY(), Vec3(0, 3, -5), 8.0, 12.0),
            hook_patch_nodes(box, lip, centre, Vec3::UnitY(), -Vec3::UnitZ(), 8.0, 12.0));
    }

    TEST(HookPatch, MidpointsUnderThePatchBelongToIt)
    {
        const mesh::TetMesh box = mesh::kuhn_box(1, 4, 4, 2.0), quadratic = mesh::with_midpoints(box);
        const auto nodes
            = hook_patch_nodes(quadratic, lip_of(box), { 0, 4, 4 }, Vec3::UnitY(), Vec3::UnitZ(), 4.0, 4.0);
        EXPECT_EQ(nodes.size(), 9U + 16U); // 3 x 3 corners; 12 edges of the 2 x 2 squares and 4 diagonals
    }

    TEST(HookPatch, NothingUnderItIsRefusedWithNameAndPlaceAndNearestNode)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 10, 10, 2.0);
        try {
            (void)hook_patch_nodes(box, lip_of(box), { 0, 10, 45 }, Vec3::UnitY(), Vec3::UnitZ(), 10, 15, "left 2");
            FAIL() << "accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "hook 'left 2' at (0, 10, 45) mm");
            EXPECT_NE(std::string(error.what()).find("nearest lip node"), std::string::npos);
            EXPECT_NE(std::string(error.what()).find("25 mm away"), std::string::npos) << error.what();
        }
    }

    TEST(HookPatch, APointALineAndNonsenseAreRefused)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 10, 10, 2.0);
        const auto lip = lip_of(box);
        const Vec3 centre(0, 10, 12), y = Vec3::UnitY(), z = Vec3::UnitZ();
        EXPECT_THROW((void)hook_patch_nodes(box, lip, centre, y, z, 1.0, 1.0), InputError); // one node
        EXPECT_THROW((void)hook_patch_nodes(box, lip, centre, y, z, 9.0, 1.0), InputError); // a row of them
        EXPECT_THROW((void)hook_patch_nodes(box, lip, centre, y, y), InputError);
        EXPECT_THROW((void)hook_patch_nodes(box, lip, centre, y, Vec3::Zero()), InputError);
        EXPECT_THROW((void)hook_patch_nodes(box, lip, centre, y, z, -1.0, 15.0), InputError);
        EXPECT_THROW(
            (void)hook_patch_nodes(box, lip, { 0, 0, std::numeric_limits<double>::quiet_NaN() }, y, z), InputError);
        EXPECT_THROW((void)hook_patch_nodes(box, {}, centre, y, z), InputError);
    }

} // namespace hook_test
} // namespace retractor::fem
