#include "ui/scene/vtk/live_surface.h"

#include "mesh/base/error.h"
#include "ui/scene/vtk/simplify_surface.h"

#include <gtest/gtest.h>

#include <vtkProp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace retractor::ui {
namespace live_surface_test {

    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

    /// Height n x n squares of a rolling field.
    TriMesh hills(int n)
    {
        TriMesh mesh;
        mesh.vertices.resize((n + 1) * (n + 1), 3);
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i)
                mesh.vertices.row(j * (n + 1) + i)
                    = Eigen::RowVector3d(i, j, 5.0 * std::sin(0.1 * i) * std::cos(0.1 * j));
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const VertexId a = j * (n + 1) + i, b = a + n + 1;
                mesh.triangles.push_back({ a, a + 1, b + 1 });
                mesh.triangles.push_back({ a, b + 1, b });
            }
        return mesh;
    }

    LiveTopology square()
    {
        LiveTopology topology;
        topology.rest = Points::Zero(5, 3); // the last vertex is not used
        topology.rest.topRows(4) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
        topology.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        topology.looks = { {}, {} };
        topology.look_of = { 0, 1 };
        return topology;
    }

    TEST(LiveSurface, KeepsItsPropsWhileItIsCut)
    {
        LiveSurface surface;
        surface.set_topology(square());
        const std::vector<vtkProp*> props = surface.props();
        ASSERT_EQ(props.size(), 6U) << "two looks, steel, rims, an outline, a line";
        LiveTopology cut = square();
        cut.triangles.pop_back();
        cut.look_of.pop_back();
        cut.rims = { { 0, 2 } };
        surface.set_topology(cut);
        EXPECT_EQ(surface.props(), props) << "a renderer need not be told";
        EXPECT_EQ(props[1]->GetVisibility(), 0) << "nothing has the second look now";
        EXPECT_EQ(props[2]->GetVisibility(), 0) << "no hook stands in it";
        EXPECT_EQ(props[3]->GetVisibility(), 1);
        EXPECT_EQ(props[4]->GetVisibility(), 0);
        EXPECT_EQ(props[5]->GetVisibility(), 0);
        surface.set_line({ { 0, 0, 0 }, { 1, 0, 0 } }, {}, 2.0);
        EXPECT_EQ(props[4]->GetVisibility(), 0);
        EXPECT_EQ(props[5]->GetVisibility(), 1);
        const double* box = props[0]->GetBounds();
        EXPECT_EQ(box[1], 1.0);
        Points moved = cut.rest;
        moved.col(0).array() += 2.0;
        surface.set_positions(moved);
        EXPECT_EQ(props[0]->GetBounds()[1], 3.0);
    }

    TEST(LiveSurface, RefusesWhatCannotBeDrawn)
    {
        LiveSurface surface;
        LiveTopology bad = square();
        bad.triangles[1][2] = 7;
        EXPECT_THROW(surface.set_topology(bad), InputError);
        bad = square();
        bad.look_of[0] = 2;
        EXPECT_THROW(surface.set_topology(bad), InputError);
        bad = square();
        bad.look_of.pop_back();
        EXPECT_THROW(surface.set_topology(bad), InputError);
        surface.set_topology(square());
        EXPECT_THROW(surface.set_positions(Points::Zero(3, 3)), InputError);
        Points positions = square().rest;
        positions(2, 1) = kNaN;
        EXPECT_THROW(surface.set_positions(positions), InputError);
        positions = square().rest;
        positions(4, 0) = kNaN; // of a vertex that nothing uses
        EXPECT_NO_THROW(surface.set_positions(positions));
    }

    TEST(SimplifySurface, KeepsTheShapeWithFewerTriangles)
    {
        const TriMesh fine = hills(60);
        const TriMesh few = simplified(fine, 0.2);
        EXPECT_LE(few.triangles.size(), fine.triangles.size() / 4);
        EXPECT_GE(few.triangles.size(), fine.triangles.size() / 10);
        // Vertices lie on the hills: within a twentieth of their height.
        double off = 0.0;
        for (Eigen::Index v = 0; v < few.vertices.rows(); ++v)
            off = std::max(off,
                std::abs(few.vertices(v, 2)
                    - 5.0 * std::sin(0.1 * few.vertices(v, 0)) * std::cos(0.1 * few.vertices(v, 1))));
        EXPECT_LT(off, 0.5);
        EXPECT_EQ(simplified(fine, 1.0).triangles, fine.triangles);
        EXPECT_TRUE(simplified({}, 0.5).triangles.empty());
    }

    TEST(SimplifySurface, LongEdgesAreDividedAlikeOnBothSides)
    {
        TriMesh square;
        square.vertices.resize(4, 3);
        square.vertices << 0, 0, 0, 100, 0, 0, 100, 60, 0, 0, 60, 0;
        square.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        constexpr double kLongest = 8.0;
        const TriMesh fine = with_edges_at_most(square, kLongest);
        double area = 0.0;
        std::map<std::pair<VertexId, VertexId>, int> faces_of_edge;
        for (const auto& triangle : fine.triangles) {
            const Vec3 a = fine.vertices.row(triangle[0]), b = fine.vertices.row(triangle[1]),
                       c = fine.vertices.row(triangle[2]);
            area += 0.5 * (b - a).cross(c - a).z();
            EXPECT_LE(std::max({ (a - b).norm(), (b - c).norm(), (c - a).norm() }), kLongest);
            for (std::size_t i = 0; i < 3; ++i)
                ++faces_of_edge[std::minmax(triangle[i], triangle[(i + 1) % 3])];
        }
        EXPECT_NEAR(area, 6000.0, 1e-6);
        for (const auto& [edge, faces] : faces_of_edge) {
            const Vec3 middle = 0.5 * (fine.vertices.row(edge.first) + fine.vertices.row(edge.second)).transpose();
            const bool rim = std::min({ middle.x(), middle.y(), 100.0 - middle.x(), 60.0 - middle.y() }) < 1e-6;
            EXPECT_EQ(faces, rim ? 1 : 2);
        }
    }

    TEST(SimplifySurface, RefusesBadInput)
    {
        const TriMesh fine = hills(4);
        for (const double longest : { 0.0, -1.0, kNaN })
            EXPECT_THROW((void)with_edges_at_most(fine, longest), InputError);
        for (const double share : { 0.0, -1.0, 1.5, kNaN })
            EXPECT_THROW((void)simplified(fine, share), InputError);
        TriMesh bad = fine;
        bad.triangles[0][1] = -1;
        EXPECT_THROW((void)simplified(bad, 0.5), InputError);
        bad = fine;
        bad.vertices(3, 2) = kNaN;
        EXPECT_THROW((void)simplified(bad, 0.5), InputError);
    }

} // namespace live_surface_test
} // namespace retractor::ui
