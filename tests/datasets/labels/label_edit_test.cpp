#include "datasets/labels/label_edit.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace retractor::datasets {
namespace label_edit_test {

    constexpr Label kMuscle = 1, kBone = 2, kLung = 3;
    const mesh::LabelFlags kNothingKept(mesh::kLabelCount, 0);

    /// 40 x 36 x 30 voxels of 1 x 1.2 x 2 mm, turned and moved: muscle, and lung for i >= 30.
    mesh::LabelVolume image()
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 40, 36, 30 };
        labels.grid.spacing = Vec3(1.0, 1.2, 2.0);
        labels.grid.origin = Vec3(-20.0, 15.0, 100.0);
        labels.grid.direction = Eigen::AngleAxisd(0.3, Vec3(0.1, 0.2, 1.0).normalized()).toRotationMatrix();
        labels.table = { { kMuscle, "muscle", "muscle", mesh::Role::wall }, { kBone, "rib", "bone", mesh::Role::wall },
            { kLung, "lung", "lung", mesh::Role::voxel } };
        labels.voxels.assign(labels.grid.voxel_count(), kMuscle);
        for (int k = 0; k < 30; ++k)
            for (int j = 0; j < 36; ++j)
                for (int i = 30; i < 40; ++i)
                    labels.voxels[labels.grid.offset(i, j, k)] = kLung;
        return labels;
    }

    Vec3 at(const mesh::LabelVolume& labels, double i, double j, double k) { return labels.grid.world(Vec3(i, j, k)); }

    std::size_t count(const mesh::LabelVolume& labels, Label label)
    {
        return static_cast<std::size_t>(std::ranges::count(labels.voxels, label));
    }

    /// A ball of bone of 7 mm.
    mesh::LabelVolume with_ball()
    {
        mesh::LabelVolume labels = image();
        make_edit(
            labels, painted(labels, { .path = { at(labels, 15, 15, 14) }, .radius_mm = 7.0 }, kBone, kNothingKept));
        return labels;
    }

    TEST(LabelEdit, ABallPaintsItsVolume)
    {
        const mesh::LabelVolume labels = with_ball();
        const double volume = static_cast<double>(count(labels, kBone)) * labels.grid.voxel_volume();
        EXPECT_NEAR(volume, 4.0 / 3.0 * std::numbers::pi * 343.0, 0.03 * volume);
    }

    TEST(LabelEdit, ADiscPaintsOneSliceOnly)
    {
        for (int axis = 0; axis < 3; ++axis) {
            mesh::LabelVolume labels = image();
            const Vec3 normal = labels.grid.direction.col(axis);
            // Between two layers one of them is painted, and not both.
            for (const double off : { 0.0, 0.3, 0.5 }) {
                Vec3 index(14, 14, 14);
                index[axis] += off;
                const LabelEdit edit = painted(labels,
                    { .path = { labels.grid.world(index) }, .radius_mm = 6.0, .normal = normal }, kBone, kNothingKept);
                ASSERT_FALSE(edit.empty());
                std::vector<int> layers;
                for (const std::size_t voxel : edit.voxels) {
                    const std::size_t nx = 40, ny = 36;
                    layers.push_back(static_cast<int>(axis == 0 ? voxel % nx
                            : axis == 1                         ? voxel / nx % ny
                                                                : voxel / (nx * ny)));
                }
                EXPECT_EQ(std::ranges::min(layers), std::ranges::max(layers)) << axis << " " << off;
                const double area
                    = static_cast<double>(edit.voxels.size()) * labels.grid.voxel_volume() / labels.grid.spacing[axis];
                EXPECT_NEAR(area, std::numbers::pi * 36.0, 0.1 * area);
            }
        }
    }

    TEST(LabelEdit, AStrokePaintsItsWayWithoutGaps)
    {
        mesh::LabelVolume labels = image();
        const Vec3 a = at(labels, 5, 5, 10), b = at(labels, 25, 5, 10);
        const LabelEdit edit = painted(labels,
            { .path = { a, b }, .radius_mm = 2.0, .normal = labels.grid.direction.col(2) }, kBone, kNothingKept);
        const double area = static_cast<double>(edit.voxels.size()) * 1.0 * 1.2;
        EXPECT_NEAR(area, 20.0 * 4.0 + std::numbers::pi * 4.0, 0.15 * area);
        make_edit(labels, edit);
        for (int i = 5; i <= 25; ++i)
            EXPECT_EQ(labels.voxels[labels.grid.offset(i, 5, 10)], kBone);
    }

    TEST(LabelEdit, WhatIsKeptIsNotPaintedOver)
    {
        const mesh::LabelVolume labels = image();
        mesh::LabelFlags kept = kNothingKept;
        kept[kLung] = 1;
        const LabelEdit edit = painted(labels, { .path = { at(labels, 30, 15, 14) }, .radius_mm = 5.0 }, kBone, kept);
        EXPECT_FALSE(edit.empty());
        EXPECT_EQ(std::ranges::count(edit.before, kLung), 0);
    }

    TEST(LabelEdit, TakenBackItIsAsBefore)
    {
        const mesh::LabelVolume before = with_ball();
        const Vec3 normal = before.grid.direction.col(2), middle = at(before, 15, 15, 14);
        mesh::LabelFlags kept = kNothingKept;
        for (const LabelEdit& edit : { painted(before, { .path = { middle }, .radius_mm = 9.0 }, kLung, kept),
                 erased(before, { .path = { middle }, .radius_mm = 4.0 }, kBone),
                 region_filled(before, middle, normal, kLung), smoothed(before, kBone, 1, kept),
                 joined(before, kBone, kMuscle) }) {
            mesh::LabelVolume labels = before;
            make_edit(labels, edit);
            EXPECT_NE(labels.voxels, before.voxels) << edit.what;
            take_back(labels, edit);
            EXPECT_EQ(labels.voxels, before.voxels) << edit.what;
        }
    }

    TEST(LabelEdit, ErasedVoxelsGetTheLabelBesideThem)
    {
        mesh::LabelVolume labels = image();
        // Bone over the border of muscle and lung: erased, the halves come back.
        const mesh::LabelVolume before = labels;
        make_edit(
            labels, painted(labels, { .path = { at(labels, 29.5, 15, 14) }, .radius_mm = 6.0 }, kBone, kNothingKept));
        make_edit(labels, erased(labels, { .path = { at(labels, 29.5, 15, 14) }, .radius_mm = 12.0 }, kBone));
        EXPECT_EQ(count(labels, kBone), 0U);
        std::size_t wrong = 0;
        for (std::size_t v = 0; v < labels.voxels.size(); ++v)
            wrong += labels.voxels[v] != before.voxels[v] ? 1 : 0;
        EXPECT_LT(static_cast<double>(wrong) * labels.grid.voxel_volume(), 0.1 * 4.0 / 3.0 * std::numbers::pi * 216.0)
            << "the border is straight up to corners";
    }

    TEST(LabelEdit, ErasedInsideItsLabelAVoxelHasNone)
    {
        const mesh::LabelVolume labels = image();
        const LabelEdit edit = erased(labels, { .path = { at(labels, 10, 10, 10) }, .radius_mm = 0.1 }, kMuscle);
        ASSERT_EQ(edit.voxels.size(), 1U) << "the voxel under the brush";
        EXPECT_EQ(edit.after.front(), 0);
    }

    TEST(LabelEdit, ARegionIsFilledInItsSliceOnly)
    {
        mesh::LabelVolume labels = with_ball();
        const LabelEdit edit = region_filled(labels, at(labels, 15, 15, 14), labels.grid.direction.col(2), kLung);
        std::size_t in_slice = 0;
        for (int j = 0; j < 36; ++j)
            for (int i = 0; i < 40; ++i)
                in_slice += labels.voxels[labels.grid.offset(i, j, 14)] == kBone ? 1 : 0;
        EXPECT_EQ(edit.voxels.size(), in_slice);
        EXPECT_THROW(region_filled(labels, Vec3(1e4, 0, 0), Vec3::UnitZ(), kLung), InputError);
        EXPECT_THROW(region_filled(labels, Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0), Vec3::UnitZ(), kLung),
            InputError);
    }

    TEST(LabelEdit, SmoothingTakesSpikesAndKeepsTheBall)
    {
        mesh::LabelVolume labels = with_ball();
        const std::size_t ball = count(labels, kBone);
        for (int i = 22; i < 29; ++i) // a spike of one voxel
            labels.voxels[labels.grid.offset(i, 15, 14)] = kBone;
        make_edit(labels, smoothed(labels, kBone, 1, kNothingKept));
        for (int i = 24; i < 29; ++i)
            EXPECT_EQ(labels.voxels[labels.grid.offset(i, 15, 14)], kMuscle) << i;
        EXPECT_NEAR(
            static_cast<double>(count(labels, kBone)), static_cast<double>(ball), 0.1 * static_cast<double>(ball))
            << "the filter takes a little of a small ball";
        EXPECT_THROW(smoothed(labels, kBone, 0, kNothingKept), InputError);
    }

    TEST(LabelEdit, IslandsGoAndTheLargestPieceStays)
    {
        mesh::LabelVolume labels = with_ball();
        const std::size_t ball = count(labels, kBone);
        make_edit(
            labels, painted(labels, { .path = { at(labels, 34, 30, 25) }, .radius_mm = 2.5 }, kBone, kNothingKept));
        make_edit(labels, without_islands(labels, kBone));
        EXPECT_EQ(count(labels, kBone), ball);
        EXPECT_EQ(labels.voxels[labels.grid.offset(34, 30, 25)], kLung) << "as around the island";
        EXPECT_TRUE(without_islands(labels, kBone).empty());
    }

    TEST(LabelEdit, BetweenTwoDiscsInterpolationMakesACone)
    {
        mesh::LabelVolume labels = image();
        const auto disc = [&](double k, double radius) {
            make_edit(labels,
                painted(labels,
                    { .path = { at(labels, 14, 15, k) }, .radius_mm = radius, .normal = labels.grid.direction.col(2) },
                    kBone, kNothingKept));
        };
        disc(5, 4.0);
        disc(15, 10.0);
        make_edit(labels, interpolated(labels, kBone, 2, kNothingKept));
        for (int k = 5; k <= 15; ++k) {
            const double radius = 4.0 + 6.0 * (k - 5) / 10.0;
            double area = 0.0;
            for (int j = 0; j < 36; ++j)
                for (int i = 0; i < 40; ++i)
                    area += labels.voxels[labels.grid.offset(i, j, k)] == kBone ? 1.2 : 0.0;
            EXPECT_NEAR(std::sqrt(area / std::numbers::pi), radius, 0.6) << k; // half a voxel
        }
        EXPECT_TRUE(interpolated(labels, kBone, 2, kNothingKept).empty()) << "no slice is left out now";
    }

    TEST(LabelEdit, JoiningMovesAllVoxels)
    {
        mesh::LabelVolume labels = with_ball();
        const std::size_t sum = count(labels, kBone) + count(labels, kMuscle);
        make_edit(labels, joined(labels, kBone, kMuscle));
        EXPECT_EQ(count(labels, kBone), 0U);
        EXPECT_EQ(count(labels, kMuscle), sum);
        EXPECT_THROW(joined(labels, 0, kMuscle), InputError);
        EXPECT_THROW(joined(labels, 77, kMuscle), InputError);
    }

    TEST(LabelEdit, BadStrokesAreNamed)
    {
        const mesh::LabelVolume labels = image();
        EXPECT_THROW(voxels_under(labels.grid, { .path = {}, .radius_mm = 1.0 }), InputError);
        EXPECT_THROW(voxels_under(labels.grid, { .path = { Vec3::Zero() }, .radius_mm = 0.0 }), InputError);
        EXPECT_THROW(voxels_under(labels.grid,
                         { .path = { Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0) }, .radius_mm = 1.0 }),
            InputError);
        EXPECT_THROW(voxels_under(labels.grid,
                         { .path = { at(labels, 5, 5, 5), at(labels, 5, 5, 8) },
                             .radius_mm = 3.0,
                             .normal = labels.grid.direction.col(2) }),
            InputError)
            << "a disc lies in one slice";
        EXPECT_TRUE(voxels_under(labels.grid, { .path = { Vec3(1e6, 0, 0) }, .radius_mm = 5.0 }).empty())
            << "outside the image there is nothing to paint";
    }

} // namespace label_edit_test
} // namespace retractor::datasets
