#include "planner/wall/image_end.h"

#include "mesh/base/triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace retractor::planner {
namespace image_end_test {

    constexpr int kSize = 20;

    /// A tube along k with 3 x 2 x 2 mm voxels: labelled where 4 <= i < 12 and 5 <= j < 15, hollow in the middle.
    mesh::LabelVolume tube(int from_k, int to_k)
    {
        mesh::LabelVolume labels;
        labels.grid = { .size = { kSize, kSize, kSize }, .spacing = { 3, 2, 2 }, .origin = { 1, 2, 3 } };
        labels.table = { { 1, "muscle", "muscle", mesh::Role::wall } };
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (int k = from_k; k < to_k; ++k)
            for (int j = 5; j < 15; ++j)
                for (int i = 4; i < 12; ++i)
                    if (i < 6 || i >= 10 || j < 7 || j >= 13)
                        labels.voxels[labels.grid.offset(i, j, k)] = 1;
        return labels;
    }

    double area(const TriMesh& mesh)
    {
        double sum = 0.0;
        for (const auto& triangle : mesh.triangles)
            sum += triangle_area(mesh.vertices, triangle);
        return sum;
    }

    TEST(ImageEnd, ClosesTheBodyWithItsCavityWhereTheImageEnds)
    {
        const double section = (8 * 3.0) * (10 * 2.0); // with the cavity
        constexpr double kRounded = 3.0 * 2.0; // at each of four corners, mm2: less than a voxel
        const TriMesh both = image_end_faces(tube(0, kSize));
        EXPECT_NEAR(area(both), 2.0 * section, 8.0 * kRounded);
        double low = 1e9, high = -1e9;
        for (Eigen::Index v = 0; v < both.vertices.rows(); ++v) {
            low = std::min(low, both.vertices(v, 2));
            high = std::max(high, both.vertices(v, 2));
        }
        EXPECT_NEAR(low, 3.0 - 2.0, 1e-9); // a voxel outside
        EXPECT_NEAR(high, 3.0 + 2.0 * kSize, 1e-9);
        EXPECT_NEAR(area(image_end_faces(tube(2, kSize - 5))), section, 4.0 * kRounded)
            << "two empty slices are a margin";
        EXPECT_TRUE(image_end_faces(tube(5, kSize - 5)).triangles.empty()) << "the body ends inside the image";
    }

    TEST(ImageEnd, ItsOutlineIsNoStaircase)
    {
        mesh::LabelVolume rod = tube(0, 0); // a round one
        constexpr double kRadiusMm = 15.0;
        const Vec3 middle = rod.grid.world(Vec3(9.5, 9.5, 0.0));
        for (int k = 0; k < kSize; ++k)
            for (int j = 0; j < kSize; ++j)
                for (int i = 0; i < kSize; ++i)
                    if ((rod.grid.world(Vec3(i, j, k)) - middle).head<2>().norm() < kRadiusMm)
                        rod.voxels[rod.grid.offset(i, j, k)] = 1;
        const TriMesh faces = image_end_faces(rod);
        double farthest = 0.0;
        for (Eigen::Index v = 0; v < faces.vertices.rows(); ++v)
            farthest = std::max(farthest, (Vec3(faces.vertices.row(v)) - middle).head<2>().norm());
        constexpr double kWithinMm = 1.2; // voxels of 3 x 2 mm: a corner of one lies up to 1.8 mm outside
        EXPECT_NEAR(farthest, kRadiusMm, kWithinMm);
        const double voxels
            = 6.0 * static_cast<double>(std::count(rod.voxels.begin(), rod.voxels.end(), 1)) / kSize; // mm2 of a slice
        EXPECT_NEAR(area(faces), 2.0 * voxels, 0.04 * 2.0 * voxels);
    }

    TEST(ImageEnd, WhatIsPushedOutThereIsDrawnBehindIt)
    {
        const mesh::LabelVolume labels = tube(2, kSize); // two empty slices before it, none behind it
        Points places(4, 3);
        const std::vector<Vec3> indices { { 5.0, 5.0, -4.0 }, { 5.0, 5.0, 5.0 }, { 5.0, 5.0, kSize + 3.0 },
            { -3.0, 5.0, 5.0 } };
        for (std::size_t n = 0; n < indices.size(); ++n)
            places.row(static_cast<Eigen::Index>(n)) = labels.grid.world(indices[n]).transpose();
        keep_within_image(places, labels.grid, image_ends(labels));
        const auto index = [&](Eigen::Index row) { return labels.grid.index(places.row(row).transpose()); };
        EXPECT_LT((index(0) - Vec3(5.0, 5.0, 1.2)).norm(), 1e-9) << "the outermost slice is 2, the face 1";
        EXPECT_LT((index(1) - indices[1]).norm(), 1e-9);
        EXPECT_LT((index(2) - Vec3(5.0, 5.0, kSize - 0.2)).norm(), 1e-9);
        EXPECT_LT((index(3) - indices[3]).norm(), 1e-9) << "the body ends there by itself";
    }

    TEST(ImageEnd, LeavesABodyOpenThatEndsByItselfNearTheBorder)
    {
        mesh::LabelVolume ball = tube(0, 0);
        const Vec3 middle = ball.grid.world(Vec3(9.5, 9.5, 9.5));
        for (int k = 0; k < kSize; ++k)
            for (int j = 0; j < kSize; ++j)
                for (int i = 0; i < kSize; ++i)
                    if ((ball.grid.world(Vec3(i, j, k)) - middle).norm() < 18.0) // a voxel of air along j and k
                        ball.voxels[ball.grid.offset(i, j, k)] = 1;
        EXPECT_TRUE(image_end_faces(ball).triangles.empty());
    }

} // namespace image_end_test
} // namespace retractor::planner
