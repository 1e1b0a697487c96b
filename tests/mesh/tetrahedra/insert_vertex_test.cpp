#include "mesh/tetrahedra/insert_vertex.h"

#include "mesh/base/triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace retractor::mesh {
namespace insert_vertex_test {

    constexpr double kSumTolerance = 1e-10; // a generous multiple of the round-off of a few hundred terms

    double volume_of(const TetMesh& mesh, Label label)
    {
        double volume = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (mesh.labels[static_cast<std::size_t>(t)] == label)
                volume += tet_volume(mesh, t);
        return volume;
    }

    double boundary_area(const TetMesh& mesh)
    {
        double area = 0.0;
        for (const TetFace& face : boundary_faces(mesh))
            area += triangle_area(mesh.vertices, face_vertices(mesh, face));
        return area;
    }

    /// A box of two labels that meet in the plane x = 2.
    TetMesh two_labels()
    {
        TetMesh box = kuhn_box(4, 2, 2, 1.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            for (const Vec3& corner : tet_corners(box, t))
                if (corner.x() > 2.0)
                    box.labels[static_cast<std::size_t>(t)] = 2;
        return box;
    }

    /// A face on the plane x = 2 between the two labels.
    std::array<VertexId, 3> face_between(const TetMesh& mesh)
    {
        for (const FaceRecord& record : sorted_faces(mesh))
            if (std::ranges::all_of(record.key, [&](VertexId v) { return mesh.vertices(v, 0) == 2.0; }))
                return record.key;
        ADD_FAILURE() << "no face lies between the labels";
        return {};
    }

    void expect_filled(const TetMesh& mesh, double area)
    {
        EXPECT_NO_THROW(check_mesh(mesh)); // no element without volume
        EXPECT_NEAR(volume_of(mesh, 1), 8.0, kSumTolerance);
        EXPECT_NEAR(volume_of(mesh, 2), 8.0, kSumTolerance);
        EXPECT_NEAR(boundary_area(mesh), area, kSumTolerance); // a vertex that one side lacks would open a hole
    }

    TEST(InsertVertex, DividesTheElementsOnBothSidesOfAFace)
    {
        TetMesh mesh = two_labels();
        const double area = boundary_area(mesh);
        const std::size_t vertices = mesh.vertex_count(), elements = mesh.tet_count();
        const std::array<VertexId, 3> face = face_between(mesh);
        const Vec3 weights(0.5, 0.3, 0.2);
        const VertexId added = insert_vertex(mesh, face, weights);
        EXPECT_EQ(static_cast<std::size_t>(added), vertices);
        EXPECT_EQ(mesh.tet_count(), elements + 4); // two elements become three each
        Vec3 expected = Vec3::Zero();
        for (int i = 0; i < 3; ++i)
            expected += weights[i] * point_at(mesh.vertices, face[static_cast<std::size_t>(i)]);
        EXPECT_LT((point_at(mesh.vertices, added) - expected).norm(), 1e-14);
        expect_filled(mesh, area);
    }

    TEST(InsertVertex, DividesAllElementsRoundAnEdgeNearWhichThePointLies)
    {
        TetMesh mesh = two_labels();
        const double area = boundary_area(mesh);
        const std::array<VertexId, 3> face = face_between(mesh);
        const VertexId added = insert_vertex(mesh, face, { 0.45, 0.45, 0.1 });
        const Vec3 middle = 0.5 * (point_at(mesh.vertices, face[0]) + point_at(mesh.vertices, face[1]));
        EXPECT_LT((point_at(mesh.vertices, added) - middle).norm(), 1e-14);
        expect_filled(mesh, area);
    }

    TEST(InsertVertex, ReturnsACornerNearWhichThePointLies)
    {
        TetMesh mesh = two_labels();
        const std::size_t vertices = mesh.vertex_count(), elements = mesh.tet_count();
        const std::array<VertexId, 3> face = face_between(mesh);
        EXPECT_EQ(insert_vertex(mesh, face, { 0.1, 0.75, 0.15 }), face[1]);
        EXPECT_EQ(mesh.vertex_count(), vertices);
        EXPECT_EQ(mesh.tet_count(), elements);
    }

    TEST(InsertVertex, KeepsAShareOfTheVolumeInEachPart)
    {
        TetMesh mesh = two_labels();
        const double whole = 1.0 / 6.0; // of every element of the box
        insert_vertex(mesh, face_between(mesh), { 0.6, 0.2, 0.2 });
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            EXPECT_GE(tet_volume(mesh, t), (kLeastInsertionWeight - 1e-12) * whole) << t;
    }

} // namespace insert_vertex_test
} // namespace retractor::mesh
