#include "datasets/segmentation/image/image_filters.h"

#include "mesh/base/error.h"
#include "mesh/image/plane_holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace retractor::datasets::segmentation {
namespace image_filters_test {

    // Uneven on purpose: radii are mm, not voxels.
    const Extent kGrid { { 60, 50, 40 }, { 1.0, 1.25, 1.5 } };

    std::array<double, 3> place(const Extent& extent, std::size_t v)
    {
        const auto nx = static_cast<std::size_t>(extent.size[0]);
        const auto ny = static_cast<std::size_t>(extent.size[1]);
        return { extent.spacing[0] * static_cast<double>(v % nx), extent.spacing[1] * static_cast<double>(v / nx % ny),
            extent.spacing[2] * static_cast<double>(v / nx / ny) };
    }

    double distance(const std::array<double, 3>& a, const std::array<double, 3>& b)
    {
        return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }

    Mask ball(const Extent& extent, const std::array<double, 3>& centre, double radius)
    {
        Mask mask(extent.voxel_count());
        for (std::size_t v = 0; v < mask.size(); ++v)
            mask[v] = distance(place(extent, v), centre) <= radius ? 1 : 0;
        return mask;
    }

    std::size_t count(const Mask& mask)
    {
        return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), std::uint8_t { 1 }));
    }

    double volume(const Extent& extent, const Mask& mask)
    {
        return static_cast<double>(count(mask)) * extent.spacing[0] * extent.spacing[1] * extent.spacing[2];
    }

    Mask united(Mask a, const Mask& b)
    {
        for (std::size_t v = 0; v < a.size(); ++v)
            a[v] = static_cast<std::uint8_t>(a[v] | b[v]);
        return a;
    }

    std::size_t differing(const Mask& a, const Mask& b)
    {
        std::size_t n = 0;
        for (std::size_t v = 0; v < a.size(); ++v)
            n += a[v] != b[v] ? 1 : 0;
        return n;
    }

    TEST(ImageFilters, ThresholdKeepsBothEnds)
    {
        const std::vector<std::int16_t> values { -301, -300, 0, 200, 201 };
        EXPECT_EQ(threshold(values, -300, 200), (Mask { 0, 1, 1, 1, 0 }));
    }

    TEST(ImageFilters, DistancesAreExact)
    {
        constexpr double kSinglePrecision = 1e-4; // mm; distances are stored as float
        const Extent extent { { 17, 13, 11 }, { 1.0, 1.25, 2.0 } };
        std::mt19937 random(7);
        Mask mask(extent.voxel_count(), 0);
        std::vector<std::size_t> set;
        for (int n = 0; n < 9; ++n) {
            set.push_back(random() % mask.size());
            mask[set.back()] = 1;
        }
        const std::vector<float> found = distance_to(extent, mask);
        for (std::size_t v = 0; v < mask.size(); ++v) {
            double nearest = 1e9;
            for (const std::size_t s : set)
                nearest = std::min(nearest, distance(place(extent, v), place(extent, s)));
            ASSERT_NEAR(found[v], nearest, kSinglePrecision) << "voxel " << v;
        }
    }

    TEST(ImageFilters, DistanceToNothingIsTheDiagonal)
    {
        const Extent extent { { 3, 4, 12 }, { 1.0, 1.0, 1.0 } };
        const std::vector<float> found = distance_to(extent, Mask(extent.voxel_count(), 0));
        EXPECT_FLOAT_EQ(found.front(), 13.0F);
        EXPECT_FLOAT_EQ(found.back(), 13.0F);
    }

    TEST(ImageFilters, GrowingAPointGivesABall)
    {
        const Mask point = ball(kGrid, { 30.0, 30.0, 30.0 }, 0.1);
        ASSERT_EQ(count(point), 1U);
        for (const double radius : { 1.0, 5.0, 12.5 })
            EXPECT_EQ(differing(dilated(kGrid, point, radius), ball(kGrid, { 30.0, 30.0, 30.0 }, radius)), 0U)
                << radius;
    }

    TEST(ImageFilters, GrowingAndShrinkingChangeABallByTheRadius)
    {
        // A digital ball of 12 mm differs from the true one by less than a tenth of a voxel shell.
        constexpr double kDigital = 0.06;
        const auto true_volume = [](double r) { return 4.0 / 3.0 * std::numbers::pi * r * r * r; };
        const Mask start = ball(kGrid, { 30.0, 30.0, 30.0 }, 12.0);
        EXPECT_NEAR(volume(kGrid, dilated(kGrid, start, 6.0)) / true_volume(18.0), 1.0, kDigital);
        EXPECT_NEAR(volume(kGrid, eroded(kGrid, start, 5.0)) / true_volume(7.5), 1.0, 3.0 * kDigital);
    }

    TEST(ImageFilters, GrowingAndShrinkingAreDual)
    {
        std::mt19937 random(3);
        Mask mask(kGrid.voxel_count());
        for (auto& m : mask)
            m = random() % 50 == 0 ? 1 : 0;
        Mask inverted = mask;
        for (auto& m : inverted)
            m = m == 0 ? 1 : 0;
        Mask shrunk = eroded(kGrid, inverted, 3.0);
        for (auto& m : shrunk)
            m = m == 0 ? 1 : 0;
        EXPECT_EQ(differing(shrunk, dilated(kGrid, mask, 3.0)), 0U);
    }

    TEST(ImageFilters, ABodyCutOffByTheBorderIsNotEatenThere)
    {
        Mask slab(kGrid.voxel_count(), 0); // from face to face in x and z
        for (std::size_t v = 0; v < slab.size(); ++v) {
            const double y = place(kGrid, v)[1];
            slab[v] = y > 20.0 && y < 40.0 ? 1 : 0;
        }
        EXPECT_EQ(differing(opened(kGrid, slab, 4.0), slab), 0U);
        EXPECT_EQ(differing(closed(kGrid, slab, 4.0), slab), 0U);
        EXPECT_EQ(count(eroded(kGrid, Mask(kGrid.voxel_count(), 1), 5.0)), kGrid.voxel_count());
    }

    TEST(ImageFilters, OpeningRemovesAThinPlateAndKeepsTheBall)
    {
        const Mask body = ball(kGrid, { 30.0, 30.0, 30.0 }, 12.0);
        Mask plate(kGrid.voxel_count(), 0);
        for (std::size_t v = 0; v < plate.size(); ++v)
            plate[v] = std::abs(place(kGrid, v)[1] - 55.0) < 2.0 ? 1 : 0;
        const Mask kept = opened(kGrid, united(body, plate), 4.0);
        for (std::size_t v = 0; v < kept.size(); ++v)
            ASSERT_FALSE(kept[v] != 0 && plate[v] != 0);
        EXPECT_GT(static_cast<double>(count(kept)), 0.9 * static_cast<double>(count(body)));
    }

    TEST(ImageFilters, PiecesComeBySize)
    {
        const Mask small = ball(kGrid, { 10.0, 10.0, 10.0 }, 5.0);
        const Mask large = ball(kGrid, { 40.0, 40.0, 40.0 }, 12.0);
        const Mask middle = ball(kGrid, { 10.0, 50.0, 10.0 }, 8.0);
        const Mask all = united(united(small, large), middle);
        const Pieces pieces = connected_pieces(kGrid, all);
        EXPECT_EQ(pieces.voxels, (std::vector<std::size_t> { count(large), count(middle), count(small) }));
        for (std::size_t v = 0; v < all.size(); ++v)
            ASSERT_EQ(pieces.piece_of[v], large[v] != 0 ? 1 : middle[v] != 0 ? 2 : small[v] != 0 ? 3 : 0);
        EXPECT_EQ(differing(largest_piece(kGrid, all), large), 0U);
        EXPECT_EQ(differing(reached_from(kGrid, all, ball(kGrid, { 10.0, 10.0, 10.0 }, 1.0)), small), 0U);
        EXPECT_EQ(count(reached_from(kGrid, all, Mask(kGrid.voxel_count(), 0))), 0U);
        EXPECT_TRUE(connected_pieces(kGrid, Mask(kGrid.voxel_count(), 0)).voxels.empty());
    }

    TEST(ImageFilters, CornersDoNotConnect)
    {
        const Extent extent { { 2, 2, 2 }, { 1.0, 1.0, 1.0 } };
        EXPECT_EQ(connected_pieces(extent, { 1, 0, 0, 1, 0, 0, 0, 0 }).voxels.size(), 2U);
        EXPECT_EQ(connected_pieces(extent, { 1, 1, 0, 1, 0, 0, 0, 0 }).voxels.size(), 1U);
    }

    TEST(ImageFilters, EnclosedHolesAreFilledOpenOnesOnlyInPlanes)
    {
        const Mask body = ball(kGrid, { 30.0, 30.0, 30.0 }, 20.0);
        Mask shell = body;
        Mask pipe = body;
        for (std::size_t v = 0; v < body.size(); ++v) {
            const auto p = place(kGrid, v);
            if (distance(p, { 30.0, 30.0, 30.0 }) < 10.0)
                shell[v] = 0;
            if (std::hypot(p[0] - 30.0, p[1] - 30.0) < 5.0)
                pipe[v] = 0; // open above and below
        }
        EXPECT_EQ(differing(holes_filled(kGrid, shell), body), 0U);
        EXPECT_EQ(differing(holes_filled(kGrid, pipe), pipe), 0U);
        EXPECT_EQ(differing(mesh::holes_filled_in_planes(kGrid.size, shell, 1), body), 0U);
        EXPECT_EQ(differing(mesh::holes_filled_in_planes(kGrid.size, pipe, 0), pipe), 0U);
        EXPECT_GT(count(mesh::holes_filled_in_planes(kGrid.size, pipe, 2)), count(pipe));
        EXPECT_EQ(differing(holes_filled(kGrid, mesh::holes_filled_in_planes(kGrid.size, pipe, 2)),
                      mesh::holes_filled_in_planes(kGrid.size, pipe, 2)),
            0U);
    }

    TEST(ImageFilters, SmoothingKeepsTheSumAndSpreadsByMillimetres)
    {
        constexpr double kRounding = 0.02; // values are rounded to whole numbers
        const Extent extent { { 40, 40, 40 }, { 1.0, 1.0, 2.0 } };
        std::vector<std::int16_t> values(extent.voxel_count(), 0);
        std::size_t centre = 0;
        for (std::size_t v = 0; v < values.size(); ++v)
            if (distance(place(extent, v), { 20.0, 20.0, 40.0 }) < 0.5)
                centre = v;
        values[centre] = 30000;
        const std::vector<std::int16_t> out = smoothed(extent, values, 2.0);
        double sum = 0.0;
        double spread_x = 0.0;
        double spread_z = 0.0;
        for (std::size_t v = 0; v < out.size(); ++v) {
            const auto p = place(extent, v);
            sum += out[v];
            spread_x += out[v] * (p[0] - 20.0) * (p[0] - 20.0);
            spread_z += out[v] * (p[2] - 40.0) * (p[2] - 40.0);
        }
        EXPECT_NEAR(sum / 30000.0, 1.0, kRounding);
        constexpr double kRecursive = 0.1; // the recursive filter approximates the Gaussian
        EXPECT_NEAR(std::sqrt(spread_x / sum), 2.0, kRecursive);
        EXPECT_NEAR(std::sqrt(spread_z / sum), 2.0, kRecursive);
    }

    TEST(ImageFilters, ThreadsDoNotChangeResults)
    {
        std::mt19937 random(11);
        std::vector<std::int16_t> values(kGrid.voxel_count());
        for (auto& value : values)
            value = static_cast<std::int16_t>(random() % 2000);
        const Mask mask = threshold(values, 0, 40);
        set_filter_threads(1);
        const auto distance_one = distance_to(kGrid, mask);
        const auto smooth_one = smoothed(kGrid, values, 2.0);
        const auto pieces_one = connected_pieces(kGrid, mask);
        set_filter_threads(4);
        EXPECT_EQ(distance_to(kGrid, mask), distance_one);
        EXPECT_EQ(smoothed(kGrid, values, 2.0), smooth_one);
        EXPECT_EQ(connected_pieces(kGrid, mask).piece_of, pieces_one.piece_of);
        set_filter_threads(2);
    }

} // namespace image_filters_test
} // namespace retractor::datasets::segmentation
