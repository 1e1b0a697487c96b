#include "mesh/generation/close_slits.h"

#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/support/label_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace retractor::mesh {
namespace close_slits_test {

    constexpr double kFlatDeg = 4.0; // as the mesher asks
    const Vec3 kMiddle(20.0, 20.0, 20.0);

    /// Tissue where the predicate says, in a box of 40 mm.
    template <class Is> LabelField field_where(const Is& is_tissue)
    {
        const LabelVolume labels = test_support::sampled_labels({ 41, 41, 41 }, Vec3::Ones(),
            test_support::chest_table(), [&](const Vec3& p) -> Label { return is_tissue(p) ? 1 : 0; });
        const Region everywhere {};
        return { wall_voxels(labels, everywhere), everywhere };
    }

    bool within_10_mm(const Vec3& p) { return (p - kMiddle).norm() < 10.0; }

    /// Elements round an edge like slices of an orange, of which the first are missing; each is 360 / slices degrees wide.
    LocalMesh orange(int slices, int missing)
    {
        LocalMesh mesh;
        mesh.vertices = { kMiddle - Vec3(0.0, 0.0, 6.0), kMiddle + Vec3(0.0, 0.0, 6.0) };
        for (int n = 0; n < slices; ++n) {
            const double angle = 2.0 * std::numbers::pi * n / slices;
            mesh.vertices.push_back(kMiddle + 6.0 * Vec3(std::cos(angle), std::sin(angle), 0.0));
        }
        for (int n = missing; n < slices; ++n) {
            std::array<VertexId, 4> tet { 0, 1, 2 + n, 2 + (n + 1) % slices };
            if (tet_volume(mesh.vertices[0], mesh.vertices[1], mesh.vertices[static_cast<std::size_t>(tet[2])],
                    mesh.vertices[static_cast<std::size_t>(tet[3])])
                < 0.0)
                std::swap(tet[2], tet[3]);
            mesh.tets.push_back(tet);
            mesh.labels.push_back(1);
        }
        return mesh;
    }

    double smallest_volume(const LocalMesh& mesh)
    {
        double least = 1e9;
        for (const auto& t : mesh.tets) {
            const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
            least = std::min(least, tet_volume(at(0), at(1), at(2), at(3)));
        }
        return least;
    }

    TEST(CloseSlits, ANarrowSlitIsClosedWithTheLabelOfTheField)
    {
        LocalMesh mesh = orange(6, 1);
        EXPECT_EQ(close_slits(mesh, field_where(within_10_mm), kFlatDeg), 1U);
        EXPECT_EQ(mesh.tets.size(), 6U);
        EXPECT_EQ(mesh.labels.back(), 1);
        EXPECT_GT(smallest_volume(mesh), 0.0);
        EXPECT_EQ(close_slits(mesh, field_where(within_10_mm), kFlatDeg), 0U) << "nothing is left to close";
    }

    TEST(CloseSlits, AWideSlitAndOneWithoutTissueStay)
    {
        LocalMesh wide = orange(6, 2); // 120 degrees
        EXPECT_EQ(close_slits(wide, field_where(within_10_mm), kFlatDeg), 0U);
        LocalMesh empty = orange(6, 1);
        const auto not_there = [](const Vec3& p) {
            const double angle = std::atan2(p.y() - kMiddle.y(), p.x() - kMiddle.x());
            return within_10_mm(p) && !(angle > 0.0 && angle < std::numbers::pi / 3.0);
        };
        EXPECT_EQ(close_slits(empty, field_where(not_there), kFlatDeg), 0U);
        LocalMesh narrow = orange(120, 1); // 3 degrees
        EXPECT_EQ(close_slits(narrow, field_where(within_10_mm), kFlatDeg), 0U) << "the element would be too flat";
    }

    TEST(CloseSlits, ASlitThatHoldsOtherElementsStays)
    {
        LocalMesh mesh = orange(6, 1);
        // An element that grows into the slit from the first slice's outer edge, past the middle of the slit.
        const auto inside = static_cast<VertexId>(mesh.vertices.size());
        mesh.vertices.push_back(kMiddle + 2.5 * Vec3(std::cos(0.5), std::sin(0.5), 0.0));
        mesh.vertices.push_back(kMiddle + 2.5 * Vec3(std::cos(0.3), std::sin(0.3), 0.4));
        std::array<VertexId, 4> grown { 0, 1, inside, inside + 1 };
        if (tet_volume(mesh.vertices[0], mesh.vertices[1], mesh.vertices[static_cast<std::size_t>(inside)],
                mesh.vertices[static_cast<std::size_t>(inside) + 1])
            < 0.0)
            std::swap(grown[2], grown[3]);
        mesh.tets.push_back(grown);
        mesh.labels.push_back(1);
        EXPECT_EQ(close_slits(mesh, field_where(within_10_mm), kFlatDeg), 0U);
    }

    /// A whole orange with an element on one of its upper faces, of which the free corner lies this high above the
    /// face.
    LocalMesh with_fin(double height_mm)
    {
        LocalMesh mesh = orange(6, 0);
        const Vec3 &top = mesh.vertices[1], &a = mesh.vertices[2], &b = mesh.vertices[3];
        const Vec3 outwards = (a - top).cross(b - top).normalized();
        const auto tip = static_cast<VertexId>(mesh.vertices.size());
        mesh.vertices.push_back(Vec3(a + b - top) + height_mm * (outwards.z() > 0.0 ? outwards : Vec3(-outwards)));
        std::array<VertexId, 4> fin { 1, 2, 3, tip };
        if (tet_volume(mesh.vertices[1], mesh.vertices[2], mesh.vertices[3], mesh.vertices.back()) < 0.0)
            std::swap(fin[1], fin[2]);
        mesh.tets.push_back(fin);
        mesh.labels.push_back(1);
        // The last element at a vertex stays: another one holds the tip.
        const auto far = static_cast<VertexId>(mesh.vertices.size());
        for (const Vec3& p : { Vec3(30.0, 0.0, 0.0), Vec3(0.0, 30.0, 0.0), Vec3(0.0, 0.0, 30.0) })
            mesh.vertices.push_back(mesh.vertices[static_cast<std::size_t>(tip)] + p);
        mesh.tets.push_back({ tip, far, far + 1, far + 2 });
        mesh.labels.push_back(1);
        return mesh;
    }

    TEST(CloseSlits, AFlatFinIsTrimmedAndAThickOneOfTissueStays)
    {
        const auto everywhere = [](const Vec3&) { return true; };
        LocalMesh flat = with_fin(0.3);
        EXPECT_EQ(trim_fins(flat, field_where(everywhere)), 1U);
        EXPECT_EQ(flat.tets.size(), 7U);
        EXPECT_EQ(flat.labels.size(), 7U);
        LocalMesh thick = with_fin(5.0);
        EXPECT_EQ(trim_fins(thick, field_where(everywhere)), 0U);
    }

    TEST(CloseSlits, ACancelledJobChangesNothing)
    {
        LocalMesh mesh = orange(6, 1);
        const std::atomic<bool> cancel { true };
        EXPECT_EQ(close_slits(mesh, field_where(within_10_mm), kFlatDeg, { .on_progress = {}, .cancel = &cancel }), 0U);
        EXPECT_EQ(mesh.tets.size(), 5U);
    }

} // namespace close_slits_test
} // namespace retractor::mesh
