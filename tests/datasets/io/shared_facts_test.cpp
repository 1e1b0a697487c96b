// What is known of the third-party images (the README of the shared data), asserted: it fails when a reader shifts,
// scales, mirrors or reorders them.

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

namespace retractor::datasets {
namespace shared_facts_test {

    namespace fs = std::filesystem;

    constexpr double kSinglePrecision_mm = 1e-3; // NIfTI stores its matrix as float

    struct Region {
        std::size_t voxels = 0;
        double mean_hu = 0.0; ///< of those inside the CT
        std::size_t inside = 0;
        Vec3 least = Vec3::Constant(1e9); ///< world box, mm
        Vec3 most = Vec3::Constant(-1e9);
    };

    /// Every labelled voxel's centre looked up in the CT by its place in the world.
    std::map<Label, Region> regions_in(const mesh::LabelVolume& labels, const mesh::Volume& ct)
    {
        std::map<Label, Region> regions;
        std::size_t v = 0;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i, ++v) {
                    if (labels.voxels[v] == 0)
                        continue;
                    Region& region = regions[labels.voxels[v]];
                    const Vec3 world = labels.grid.world(Vec3(i, j, k));
                    const Eigen::Vector3i n = ct.grid.index(world).array().round().cast<int>();
                    ++region.voxels;
                    region.least = region.least.cwiseMin(world);
                    region.most = region.most.cwiseMax(world);
                    if (!ct.grid.contains(n.x(), n.y(), n.z()))
                        continue;
                    ++region.inside;
                    region.mean_hu += ct.voxels[ct.grid.offset(n.x(), n.y(), n.z())];
                }
        for (auto& [label, region] : regions)
            region.mean_hu /= std::max<double>(1.0, static_cast<double>(region.inside));
        return regions;
    }

    std::size_t count(const std::vector<Label>& voxels, Label label)
    {
        return static_cast<std::size_t>(std::count(voxels.begin(), voxels.end(), label));
    }

    TEST(SharedFacts, ChestHalf)
    {
        const fs::path path = test_support::shared_data("ct/chest_half/ricord_chest_half.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        const mesh::Volume ct = import_volume(path).volume;
        EXPECT_EQ(ct.grid.size, (std::array<int, 3> { 256, 256, 124 }));
        EXPECT_LT((ct.grid.spacing - Vec3(1.40625, 1.40625, 2.5)).norm(), kSinglePrecision_mm);
        EXPECT_LT((ct.grid.direction - Mat3::Identity()).norm(), kSinglePrecision_mm);
        EXPECT_LT((ct.grid.origin - Vec3(-171.6484, -156.1484, -19.875)).norm(), kSinglePrecision_mm);
        EXPECT_EQ(*std::min_element(ct.voxels.begin(), ct.voxels.end()), -1024); // outside the circle of the scan
        EXPECT_EQ(ct.voxels.front(), -1024);

        const mesh::LabelVolume labels
            = read_label_voxels(test_support::shared_data("labels/ricord_half_hu_labels.nii.gz"));
        EXPECT_EQ(labels.grid.size, ct.grid.size);
        EXPECT_LT((labels.grid.origin - ct.grid.origin).norm(), kSinglePrecision_mm);
        const auto regions = regions_in(labels, ct);
        ASSERT_EQ(regions.size(), 3U);
        EXPECT_LT(std::abs(regions.at(1).mean_hu), 100.0); // body: fat and muscle
        EXPECT_LT(regions.at(2).mean_hu, -600.0); // lung and air
        EXPECT_GT(regions.at(3).mean_hu, 180.0); // bone by its threshold
        std::size_t soft_bone = 0;
        for (std::size_t v = 0; v < ct.voxels.size(); ++v)
            soft_bone += labels.voxels[v] == 3 && ct.voxels[v] <= 180 ? 1 : 0;
        // The threshold was taken on the finer scan; halving it blurs a rim, a shift would blur nearly all.
        EXPECT_LT(soft_bone, regions.at(3).voxels / 5);
    }

    TEST(SharedFacts, ThoraxCta)
    {
        const fs::path path = test_support::shared_data("ct/ts_thorax_cta/ct_aorta_crop.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        const mesh::Volume ct = import_volume(path).volume;
        EXPECT_EQ(ct.grid.size, (std::array<int, 3> { 120, 126, 164 }));
        EXPECT_LT((ct.grid.spacing - Vec3::Constant(1.5)).norm(), kSinglePrecision_mm);
        const fs::path labels = test_support::shared_data("labels/ts_thorax_cta");
        const auto mask = [&](const char* name) { return read_label_voxels(labels / (std::string(name) + ".nii.gz")); };

        EXPECT_EQ(count(mask("aorta_true_lumen").voxels, 1), 37595U);
        EXPECT_EQ(count(mask("aorta_false_lumen").voxels, 1), 36170U);
        constexpr double kMean_HU = 15.0; // the README gives the means as "about"
        EXPECT_NEAR(regions_in(mask("aorta"), ct).at(1).mean_hu, 350.0, kMean_HU);

        const mesh::LabelVolume heart = mask("heart");
        EXPECT_EQ(heart.grid.size, (std::array<int, 3> { 233, 167, 191 }));
        const Region region = regions_in(heart, ct).at(1);
        EXPECT_EQ(region.voxels, 198176U);
        EXPECT_EQ(region.inside, region.voxels); // the whole heart lies inside the crop, by world coordinates
        EXPECT_NEAR(region.mean_hu, 405.0, kMean_HU);
        const mesh::LabelVolume on_ct = resample_labels_to(heart, ct.grid);
        EXPECT_EQ(count(on_ct.voxels, 1), 198176U); // both grids are one lattice
        // A heart lies before the spine and to the left of it: the frame is LPS.
        const Region spine = regions_in(mask("vertebrae_T12"), ct).at(1);
        EXPECT_LT(0.5 * (region.least + region.most).y(), spine.least.y());
        EXPECT_GT(0.5 * (region.least + region.most).x(), 0.5 * (spine.least + spine.most).x());
        EXPECT_GT(0.5 * (region.least + region.most).z(), spine.most.z());
    }

    TEST(SharedFacts, ThoraxMultilabelEqualsItsMasks)
    {
        const fs::path path = test_support::shared_data("labels/ts_thorax_multilabel.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        const mesh::LabelVolume all = read_label_voxels(path);
        std::vector<bool> marked(all.voxels.size(), false);
        std::ifstream table(test_support::shared_data("labels/ts_thorax_multilabel.txt"));
        int id = 0;
        for (std::string name; table >> id >> name;) {
            SCOPED_TRACE(name);
            const mesh::LabelVolume mask = resample_labels_to(
                read_label_voxels(test_support::shared_data("labels/ts_thorax_cta/" + name + ".nii.gz")), all.grid);
            std::size_t outside = 0;
            for (std::size_t v = 0; v < all.voxels.size(); ++v) {
                outside += all.voxels[v] == id && mask.voxels[v] == 0 ? 1 : 0;
                marked[v] = marked[v] || mask.voxels[v] != 0;
            }
            EXPECT_EQ(outside, 0U);
            EXPECT_GT(count(all.voxels, static_cast<Label>(id)), 0U);
        }
        EXPECT_EQ(id, 10);
        // Where masks overlap one of them has the voxel; none is lost.
        EXPECT_EQ(static_cast<std::size_t>(std::count(marked.begin(), marked.end(), true)),
            all.voxels.size() - count(all.voxels, 0));
    }

    TEST(SharedFacts, AbdomenVolumesAgreeWithTheStatistics)
    {
        const fs::path path = test_support::shared_data("ct/ts_abdomen/example_ct_sm.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        const mesh::Volume ct = import_volume(path).volume;
        const mesh::LabelVolume labels
            = read_label_voxels(test_support::shared_data("labels/ts_abdomen/example_seg_fast.nii.gz"));
        EXPECT_EQ(labels.grid.size, ct.grid.size);
        EXPECT_LT((labels.grid.origin - ct.grid.origin).norm(), kSinglePrecision_mm);
        const auto statistics = nlohmann::json::parse(
            std::ifstream(test_support::shared_data("labels/ts_abdomen/example_seg_fast_statistics.json")));
        // Ids of TotalSegmentator v2.
        const std::map<Label, std::string> names { { 1, "spleen" }, { 2, "kidney_right" }, { 3, "kidney_left" },
            { 5, "liver" }, { 6, "stomach" }, { 7, "pancreas" }, { 52, "aorta" }, { 63, "inferior_vena_cava" } };
        const auto regions = regions_in(labels, ct);
        constexpr double kRelative = 1e-6;
        constexpr double kWindow_HU = 0.75; // the statistics' mean, and ours of rounded values
        int found = 0;
        for (const auto& [id, name] : names) {
            const auto region = regions.find(id);
            const double volume = statistics.at(name).at("volume").get<double>();
            if (region == regions.end()) {
                EXPECT_EQ(volume, 0.0) << name;
                continue;
            }
            ++found;
            EXPECT_NEAR(
                static_cast<double>(region->second.voxels) * labels.grid.voxel_volume(), volume, kRelative * volume)
                << name;
            EXPECT_NEAR(region->second.mean_hu, statistics.at(name).at("intensity").get<double>(), kWindow_HU) << name;
        }
        EXPECT_GE(found, 5);
        const mesh::LabelVolume larger
            = read_label_voxels(test_support::shared_data("labels/ts_abdomen/example_seg.nii.gz"));
        EXPECT_EQ(larger.grid.size, ct.grid.size);
    }

    TEST(SharedFacts, ChestImagingPlatform)
    {
        const fs::path path = test_support::shared_data("ct/cip_thorax/ct-64.nrrd");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        const mesh::Volume ct = import_volume(path).volume;
        EXPECT_EQ(ct.grid.size, (std::array<int, 3> { 64, 64, 79 }));
        EXPECT_LT((ct.grid.spacing - Vec3(4.171872, 4.171872, 3.987341772)).norm(), 1e-8);
        const mesh::Volume other = import_volume(test_support::shared_data("ct/cip_thorax/TestInput.nrrd")).volume;
        EXPECT_EQ(other.grid.size, (std::array<int, 3> { 64, 64, 50 }));
        // The series was written from the NRRD, in whole numbers of rescaled pixels.
        const mesh::Volume series = import_volume(test_support::shared_data("ct/cip_thorax/ct-64Dicom")).volume;
        test_support::expect_same_in_world(ct, series, kSinglePrecision_mm);

        // Region in the low byte, type in the high one; the lungs are the regions that wholeLung-64 marks.
        const mesh::LabelVolume packed = read_label_voxels(test_support::shared_data("labels/cip_thorax/lm-64.nrrd"));
        EXPECT_EQ(packed.grid.size, ct.grid.size);
        std::set<int> types;
        for (const Label voxel : packed.voxels)
            types.insert(voxel >> 8);
        EXPECT_GT(types.size(), 1U);
        const mesh::LabelVolume lung
            = read_label_voxels(test_support::shared_data("labels/cip_thorax/wholeLung-64.nrrd"));
        mesh::LabelVolume marked = lung;
        for (Label& voxel : marked.voxels)
            voxel = (voxel & 0xff) != 0 ? 1 : 0;
        EXPECT_LT(regions_in(marked, ct).at(1).mean_hu, -700.0);
    }

    TEST(SharedFacts, AFileWithoutAnySpacingIsRefused)
    {
        const fs::path path = test_support::shared_data("ct/cip_thorax/simple_ct.nrrd");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data at " << path;
        test_support::expect_refused<InputError>(
            [&] { import_volume(path); }, "neither \"space directions\" nor \"spacings\"");
    }

} // namespace shared_facts_test
} // namespace retractor::datasets
