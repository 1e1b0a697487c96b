#include "datasets/labels/label_repair.h"

#include "datasets/labels/label_import.h"
#include "datasets/labels/label_presets.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <random>

namespace retractor::datasets {
namespace label_repair_test {

    using Index = std::array<int, 3>;

    mesh::LabelVolume make_labels(Index size, const std::vector<std::string>& names)
    {
        mesh::LabelVolume labels;
        labels.grid.size = size;
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        for (const std::string& name : names)
            labels.table.push_back(describe_structure(name, static_cast<Label>(labels.table.size() + 1)));
        return labels;
    }

    /// Sets the voxels from `low` to `high`, both inclusive.
    void set_box(mesh::LabelVolume& labels, Index low, Index high, Label value)
    {
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i)
                    labels.voxels[labels.grid.offset(i, j, k)] = value;
    }

    std::size_t count(const mesh::LabelVolume& labels, Label id)
    {
        return static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), id));
    }

    void expect_fragments(const LabelFragments& found, std::string_view name, std::size_t voxels, std::size_t pieces,
        std::size_t stray, std::size_t holes)
    {
        EXPECT_EQ(found.name, name);
        EXPECT_EQ(found.voxels, voxels) << name;
        EXPECT_EQ(found.pieces, pieces) << name;
        EXPECT_EQ(found.stray_voxels, stray) << name;
        EXPECT_EQ(found.hole_voxels, holes) << name;
    }

    TEST(LabelRepair, PiecesTouchOverCorners)
    {
        mesh::LabelVolume labels = make_labels({ 6, 6, 6 }, { "heart" });
        set_box(labels, { 0, 0, 0 }, { 1, 1, 1 }, 1);
        set_box(labels, { 2, 2, 2 }, { 3, 3, 3 }, 1);
        EXPECT_TRUE(find_fragments(labels).empty());
        set_box(labels, { 5, 5, 5 }, { 5, 5, 5 }, 1);
        const auto found = find_fragments(labels);
        ASSERT_EQ(found.size(), 1U);
        expect_fragments(found[0], "heart", 17, 2, 1, 0);
    }

    TEST(LabelRepair, EveryDirectionConnects)
    {
        for (int n = 0; n < 27; ++n) {
            if (n == 13)
                continue; // the voxel itself
            mesh::LabelVolume labels = make_labels({ 3, 3, 3 }, { "heart" });
            labels.voxels[labels.grid.offset(1, 1, 1)] = 1;
            labels.voxels[static_cast<std::size_t>(n)] = 1;
            EXPECT_TRUE(find_fragments(labels).empty()) << n;
        }
    }

    TEST(LabelRepair, HolesAreEnclosedByOneLabelAlone)
    {
        mesh::LabelVolume labels = make_labels({ 20, 10, 10 }, { "heart", "liver", "skin" });
        set_box(labels, { 1, 1, 1 }, { 6, 8, 8 }, 1);
        set_box(labels, { 3, 3, 3 }, { 4, 4, 4 }, 0); // a hole of 8
        set_box(labels, { 7, 1, 1 }, { 12, 8, 8 }, 2);
        set_box(labels, { 6, 6, 6 }, { 7, 6, 6 }, 0); // between both: of neither
        set_box(labels, { 10, 4, 4 }, { 12, 4, 4 }, 0); // open to the outside
        set_box(labels, { 14, 1, 1 }, { 18, 8, 8 }, 3);
        set_box(labels, { 15, 2, 2 }, { 17, 7, 7 }, 0); // what skin encloses is the body
        const auto found = find_fragments(labels);
        ASSERT_EQ(found.size(), 1U);
        expect_fragments(found[0], "heart", 384 - 8 - 1, 1, 0, 8);
    }

    TEST(LabelRepair, ABackgroundPieceThatTouchesOnlyOverAnEdgeIsStillAHole)
    {
        mesh::LabelVolume labels = make_labels({ 5, 5, 5 }, { "heart" });
        set_box(labels, { 0, 0, 0 }, { 4, 4, 4 }, 1);
        labels.voxels[labels.grid.offset(1, 1, 2)] = 0;
        set_box(labels, { 0, 0, 0 }, { 0, 0, 4 }, 0); // outside, one edge away
        EXPECT_EQ(find_fragments(labels).at(0).hole_voxels, 1U);
        labels.voxels[labels.grid.offset(1, 0, 2)] = 0; // now open
        EXPECT_TRUE(find_fragments(labels).empty());
    }

    TEST(LabelRepair, StraysGoAndTheHolesTheyLeaveAreFilled)
    {
        mesh::LabelVolume labels = make_labels({ 24, 12, 12 }, { "lung_left", "heart" });
        set_box(labels, { 1, 1, 1 }, { 10, 10, 10 }, 1);
        set_box(labels, { 4, 4, 4 }, { 5, 5, 5 }, 2); // a piece of heart in the lung
        set_box(labels, { 14, 2, 2 }, { 19, 7, 7 }, 2);
        set_box(labels, { 16, 4, 4 }, { 17, 5, 5 }, 0); // a hole in the heart
        set_box(labels, { 22, 1, 1 }, { 22, 1, 3 }, 1); // a piece of lung outside
        const auto changed = repair_labels(labels);
        ASSERT_EQ(changed.size(), 2U);
        expect_fragments(changed[0], "lung_left", 1000 - 8 + 3, 2, 3, 8);
        expect_fragments(changed[1], "heart", 216 - 8 + 8, 2, 8, 8);
        EXPECT_EQ(count(labels, 1), 1000U);
        EXPECT_EQ(count(labels, 2), 216U);
        EXPECT_TRUE(find_fragments(labels).empty());
        EXPECT_TRUE(repair_labels(labels).empty());
    }

    TEST(LabelRepair, WhatComesInPiecesKeepsThem)
    {
        mesh::LabelVolume labels = make_labels({ 40, 12, 12 }, { "costal_cartilages", "rib_left_5" });
        set_box(labels, { 0, 0, 0 }, { 9, 9, 0 }, 1); // 100
        set_box(labels, { 12, 0, 0 }, { 14, 0, 0 }, 1); // 3 % of it
        set_box(labels, { 18, 0, 0 }, { 18, 0, 0 }, 1); // 1 %
        set_box(labels, { 0, 0, 5 }, { 19, 0, 5 }, 2); // a rib in two pieces
        set_box(labels, { 22, 0, 5 }, { 32, 0, 5 }, 2);
        const auto found = find_fragments(labels);
        ASSERT_EQ(found.size(), 2U);
        expect_fragments(found[0], "costal_cartilages", 104, 3, 4, 0);
        expect_fragments(found[1], "rib_left_5", 31, 2, 11, 0);
        mesh::LabelVolume strict = labels;
        const auto changed = repair_labels(labels);
        ASSERT_EQ(changed.size(), 2U);
        expect_fragments(changed[0], "costal_cartilages", 104, 3, 1, 0);
        expect_fragments(changed[1], "rib_left_5", 31, 2, 11, 0);
        EXPECT_EQ(count(labels, 1), 103U);
        EXPECT_EQ(count(labels, 2), 20U);
        repair_labels(strict, 0.05);
        EXPECT_EQ(count(strict, 1), 100U);
    }

    /// A second way to the same answer: flood fill, voxel by voxel.
    std::size_t pieces_by_flooding(const mesh::LabelVolume& labels, Label label)
    {
        std::vector<bool> seen(labels.voxels.size(), false);
        std::size_t pieces = 0;
        for (std::size_t start = 0; start < seen.size(); ++start) {
            if (seen[start] || labels.voxels[start] != label)
                continue;
            ++pieces;
            std::vector<std::size_t> front { start };
            seen[start] = true;
            while (!front.empty()) {
                const auto at = static_cast<int>(front.back());
                front.pop_back();
                const int nx = labels.grid.size[0], ny = labels.grid.size[1];
                for (int n = 0; n < 27; ++n) {
                    const int i = at % nx + n % 3 - 1, j = at / nx % ny + n / 3 % 3 - 1, k = at / nx / ny + n / 9 - 1;
                    if (!labels.grid.contains(i, j, k))
                        continue;
                    const std::size_t next = labels.grid.offset(i, j, k);
                    if (!seen[next] && labels.voxels[next] == label) {
                        seen[next] = true;
                        front.push_back(next);
                    }
                }
            }
        }
        return pieces;
    }

    TEST(LabelRepair, AgreesWithFloodFillOnNoise)
    {
        for (const unsigned seed : { 1U, 2U, 3U }) {
            mesh::LabelVolume labels = make_labels({ 31, 23, 17 }, { "heart", "liver" });
            std::mt19937 random(seed);
            for (Label& voxel : labels.voxels) {
                const auto roll = random() % 100;
                voxel = roll < 5 ? Label { 1 } : roll < 8 ? Label { 2 } : Label { 0 };
            }
            const auto found = find_fragments(labels);
            ASSERT_EQ(found.size(), 2U);
            for (const Label label : { Label { 1 }, Label { 2 } }) {
                EXPECT_EQ(found[label - 1U].pieces, pieces_by_flooding(labels, label));
                EXPECT_GT(found[label - 1U].pieces, 50U);
            }
            repair_labels(labels);
            EXPECT_EQ(pieces_by_flooding(labels, 1), 1U);
            EXPECT_EQ(pieces_by_flooding(labels, 2), 1U);
        }
    }

    TEST(LabelRepair, RealRibsAreLookedAt)
    {
        const auto path = test_support::shared_data("labels/ts_abdomen/example_seg_fast.nii.gz");
        if (!std::filesystem::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        mesh::LabelVolume labels = import_labels(path).labels;
        for (const LabelFragments& found : find_fragments(labels))
            EXPECT_EQ(found.pieces, pieces_by_flooding(labels, mesh::find_label(labels.table, found.name)->id))
                << found.name;
        repair_labels(labels);
        for (const mesh::LabelInfo& info : labels.table)
            if (info.name.starts_with("rib_") || info.name == "liver") {
                EXPECT_EQ(pieces_by_flooding(labels, info.id), 1U) << info.name;
            }
    }

    TEST(LabelRepair, CancelledChangesNothing)
    {
        mesh::LabelVolume labels = make_labels({ 6, 1, 1 }, { "heart" });
        set_box(labels, { 0, 0, 0 }, { 1, 0, 0 }, 1);
        set_box(labels, { 4, 0, 0 }, { 4, 0, 0 }, 1);
        const auto before = labels.voxels;
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(repair_labels(labels, 0.02, job).empty());
        EXPECT_EQ(labels.voxels, before);
    }

    TEST(LabelRepair, BadInputIsRefused)
    {
        mesh::LabelVolume labels = make_labels({ 4, 4, 4 }, { "heart" });
        test_support::expect_refused<InputError>([&] { repair_labels(labels, -0.1); }, "between 0 and 1, got -0.1");
        test_support::expect_refused<InputError>(
            [&] { repair_labels(labels, std::numeric_limits<double>::quiet_NaN()); }, "keep_fraction");
        labels.voxels[3] = 9;
        test_support::expect_refused<InputError>([&] { find_fragments(labels); }, "does not name: 9");
        labels.voxels.pop_back();
        test_support::expect_refused<InputError>(
            [&] { find_fragments(labels); }, "the labels have 63 voxels, their grid 64");
    }

} // namespace label_repair_test
} // namespace retractor::datasets
