#include "planner/approach/hook_mesh.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

namespace retractor::planner {
namespace hook_mesh_test {

    constexpr double kRoundOff = 1e-9;

    double signed_volume(const TriMesh& mesh)
    {
        double sum = 0.0;
        for (const auto& t : mesh.triangles)
            sum += Vec3(mesh.vertices.row(t[0])).dot(Vec3(mesh.vertices.row(t[1])).cross(Vec3(mesh.vertices.row(t[2]))))
                / 6.0;
        return sum;
    }

    void expect_closed(const TriMesh& mesh)
    {
        std::map<std::pair<VertexId, VertexId>, int> directed;
        for (const auto& t : mesh.triangles)
            for (std::size_t e = 0; e < 3; ++e)
                ++directed[{ t[e], t[(e + 1) % 3] }];
        for (const auto& [edge, count] : directed) {
            EXPECT_EQ(count, 1);
            EXPECT_TRUE(directed.contains({ edge.second, edge.first }));
        }
    }

    TEST(HookMesh, IsClosedOrientedOutwardsAndHasItsPatchAtTheGivenPlace)
    {
        const HookShape hook { .name = "h", .position = { 5, 6, 7 }, .pull = { 2, 0, 0 }, .outward = { 0, -3, 0 } };
        const TriMesh mesh = hook_mesh(hook);
        EXPECT_GT(signed_volume(mesh), 0.0);
        expect_closed(mesh);
        // The lip's side of the patch is the plane through the position, and the steel lies on the wound's side of it.
        double nearest = 1e9;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            if (mesh.vertices(v, 1) > hook.position.y()) {
                EXPECT_LE(mesh.vertices(v, 0), hook.position.x() + kRoundOff);
                nearest = std::min(nearest, std::abs(mesh.vertices(v, 0) - hook.position.x()));
            }
        EXPECT_NEAR(nearest, 0.0, kRoundOff);
    }

    TEST(HookMesh, TheRackLiesOverTheSkinBeyondTheBlades)
    {
        for (const double half_mm : { 0.0, 25.0 }) { // closed, and open
            const HookShape right {
                .position = { half_mm, 0, 0 }, .pull = { 1, 0, 0 }, .width_mm = 48.0, .depth_mm = 65.0
            };
            HookShape left = right;
            left.position.x() = -half_mm;
            left.pull.x() = -1.0;
            const TriMesh mesh = rack_mesh(right, left);
            expect_closed(mesh);
            // Two arms and the rack, 8 mm thick.
            const double arm_mm = 48.0 + 35.0, rack_mm = 2.0 * (half_mm + 10.0) + 24.0;
            EXPECT_NEAR(signed_volume(mesh), 64.0 * (2.0 * arm_mm + rack_mm), 1e-6);
            EXPECT_LT(mesh.vertices.col(1).maxCoeff(), -0.5 * 65.0) << "outside the body, which is at y > 0";
        }
    }

    TEST(HookMesh, ShapesThatCannotBeAreRefused)
    {
        const HookShape good { .name = "upper blade" };
        const auto message = [](const HookShape& shape) {
            try {
                (void)hook_mesh(shape);
            } catch (const InputError& error) {
                EXPECT_EQ(error.where(), "hook upper blade");
                return std::string(error.what());
            }
            return std::string();
        };
        EXPECT_EQ(message(good), "");
        HookShape bad = good;
        bad.pull = bad.outward;
        EXPECT_EQ(message(bad), "a hook's pull must be a direction and not lie along its outward direction");
        bad = good;
        bad.width_mm = 0.0;
        EXPECT_EQ(message(bad), "a hook's sizes must be positive");
        bad = good;
        bad.position.x() = std::numeric_limits<double>::quiet_NaN();
        EXPECT_EQ(message(bad), "a hook is not finite");
    }

} // namespace hook_mesh_test
} // namespace retractor::planner
