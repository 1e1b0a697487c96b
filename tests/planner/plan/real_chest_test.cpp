// A whole chest CT of a real patient, without labels and without contrast: segmented, and its landmarks and approaches
// found by themselves.
#include "planner/anatomy/anatomy.h"
#include "planner/anatomy/bone_stiffness.h"
#include "planner/approach/approach_templates.h"
#include "planner/case/import_case.h"
#include "planner/wall/joint_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <vector>

namespace retractor::planner {
namespace real_chest_test {

    std::filesystem::path chest_file()
    {
        const char* folder = std::getenv("RETRACTOR_SHARED_DATA");
        return std::filesystem::path(folder != nullptr ? folder : RETRACTOR_SHARED_DATA_DEFAULT)
            / "ct/chest_half/ricord_chest_half.nii.gz";
    }

    /// Segmented once for all tests.
    class RealChest : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            if (!std::filesystem::exists(chest_file()))
                return;
            ImportRequest request;
            request.ct = chest_file();
            request.autosegment = true;
            chest = new ImportedCase(read_import(request));
        }
        static void TearDownTestSuite()
        {
            delete chest;
            chest = nullptr;
        }
        void SetUp() override
        {
            if (chest == nullptr) {
                std::cout << "SKIPPED: no " << chest_file() << "; set RETRACTOR_SHARED_DATA\n";
                GTEST_SKIP();
            }
        }
        static double volume_ml(std::string_view name)
        {
            for (const LabelSize& size : label_sizes(*chest->labels))
                if (size.info.name == name)
                    return size.volume_ml;
            return 0.0;
        }
        static inline ImportedCase* chest = nullptr;
    };

    TEST_F(RealChest, HasThePartsOfAChest)
    {
        // Adult values, with room for breath and build: lungs at half inspiration, sternum 40 to 120 ml.
        for (const char* lung : { "lung_left", "lung_right" }) {
            EXPECT_GT(volume_ml(lung), 1000.0) << lung;
            EXPECT_LT(volume_ml(lung), 2500.0) << lung;
        }
        EXPECT_GT(volume_ml("sternum"), 40.0);
        EXPECT_LT(volume_ml("sternum"), 120.0);
        EXPECT_GT(volume_ml("spine"), 300.0);
        for (const char* side : { "left", "right" })
            for (int number = 1; number <= 10; ++number) {
                const std::string rib = std::string("rib_") + side + "_" + std::to_string(number);
                EXPECT_GT(volume_ml(rib), 5.0) << rib;
                EXPECT_LT(volume_ml(rib), 60.0) << rib;
            }
    }

    TEST_F(RealChest, EveryRibWithATubercleHasAnAxisAndMostShowTheirOwn)
    {
        const mesh::LabelVolume& labels = *chest->labels;
        const std::vector<Label> spine { mesh::label_named(labels.table, "spine").id };
        int ribs = 0, with_axis = 0, own = 0;
        for (const JointPlaces& joint : joint_places(labels, spine))
            if (const std::string& name = mesh::find_label(labels.table, joint.label)->name; name.starts_with("rib_")) {
                ++ribs;
                if (name.ends_with("_11") || name.ends_with("_12"))
                    continue;
                with_axis += joint.tubercle ? 1 : 0;
                own += joint.tubercle && !joint.axis_of_neighbour ? 1 : 0;
            }
        EXPECT_EQ(ribs, 24);
        EXPECT_EQ(with_axis, 20);
        EXPECT_GT(own, 10); // 13 by the present segmentation
    }

    TEST_F(RealChest, RoughPartsSayThatTheyAreRough)
    {
        const auto rough = [&](std::string_view name) {
            return std::any_of(chest->structures.begin(), chest->structures.end(),
                [&](const datasets::FoundStructure& s) { return s.name == name && s.rough; });
        };
        EXPECT_TRUE(rough("aorta")); // no contrast
        EXPECT_TRUE(rough("heart"));
        EXPECT_FALSE(rough("lung_left"));
        EXPECT_FALSE(rough("rib_left_5"));
        EXPECT_TRUE(std::any_of(chest->warnings.begin(), chest->warnings.end(),
            [](const std::string& text) { return text.find("contrast") != std::string::npos; }));
    }

    TEST_F(RealChest, TheWallIsClosed)
    {
        // No voxel of lung touches the air outside.
        const mesh::LabelVolume& labels = *chest->labels;
        const auto is_lung = [&](Label id) {
            const mesh::LabelInfo* info = mesh::find_label(labels.table, id);
            return info != nullptr && info->name.starts_with("lung");
        };
        const auto& n = labels.grid.size;
        std::size_t bare = 0;
        for (int k = 1; k + 1 < n[2]; ++k)
            for (int j = 1; j + 1 < n[1]; ++j)
                for (int i = 1; i + 1 < n[0]; ++i)
                    if (is_lung(labels.voxels[labels.grid.offset(i, j, k)]))
                        for (const auto& [di, dj] : { std::pair { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } })
                            bare += labels.voxels[labels.grid.offset(i + di, j + dj, k)] == 0 ? 1 : 0;
        EXPECT_EQ(bare, 0u);
    }

    TEST_F(RealChest, RibsHaveTheStiffnessOfTestedRibs)
    {
        const std::vector<BoneStiffness> bones
            = find_bone_stiffness(*chest->labels, chest->ct.get(), fem::default_materials());
        std::vector<double> ribs;
        std::size_t cut_off = 0;
        for (const BoneStiffness& bone : bones) {
            std::cout << bone.name << ": " << std::lround(bone.modulus_MPa) << " MPa (" << std::lround(bone.low_MPa)
                      << " to " << std::lround(bone.high_MPa) << "), " << bone.words << "\n";
            if (bone.material != "bone") {
                EXPECT_GE(bone.modulus_MPa, cartilage_modulus_MPa(0.0));
                EXPECT_LE(bone.modulus_MPa, kMostStiffening * cartilage_modulus_MPa(0.0));
                continue;
            }
            EXPECT_GE(bone.modulus_MPa, kSoftestRibMPa);
            EXPECT_LE(bone.modulus_MPa, kStiffestRibMPa);
            if (bone.origin == StiffnessOrigin::image)
                ribs.push_back(bone.modulus_MPa);
            cut_off += bone.cut_off_MPa ? 1U : 0U;
        }
        ASSERT_GE(ribs.size(), 18U); // the CT tells about nearly all of them
        EXPECT_LE(cut_off, ribs.size() / 4);
    }

    TEST_F(RealChest, TemplatesFindSternumAndRibs)
    {
        const Anatomy anatomy = find_anatomy(*chest->labels);
        EXPECT_GT(anatomy.frame.superior.z(), 0.9); // supine, head first
        EXPECT_LT(anatomy.frame.anterior.y(), -0.9);
        const double sternum = (anatomy.sternum.top - anatomy.sternum.bottom).norm();
        EXPECT_GT(sternum, 140.0);
        EXPECT_LT(sternum, 240.0);
        // Ribs descend at the side of the chest (the lowest two end behind it), and left and right meet the spine at
        // one height, to less than a vertebra.
        const auto side_height = [&](bool left, int number) {
            constexpr double kLateral = 90.0; // degrees round the chest
            return point_at_angle(find_rib(anatomy, left, number), kLateral).z();
        };
        for (int number = 1; number < 9; ++number)
            for (const bool left : { true, false })
                EXPECT_GT(side_height(left, number), side_height(left, number + 1)) << "rib " << number;
        for (int number = 1; number <= 10; ++number)
            EXPECT_NEAR(find_rib(anatomy, true, number).points.front().z(),
                find_rib(anatomy, false, number).points.front().z(), 15.0)
                << "rib " << number;

        ApproachRequest request;
        request.target = TargetSpec { .label = "", .centre = Vec3(25, -10, 190), .radius_mm = 20.0 };
        for (const char* name : { "median", "intercostal:3", "intercostal:4", "intercostal:5", "intercostal:6" }) {
            request.template_name = name;
            const Approach approach = approach_from_template(*chest->labels, anatomy, request);
            EXPECT_GE(approach.incision.size(), 5u) << name;
            EXPECT_GT(approach.depth_mm, 10.0) << name;
            EXPECT_LT(approach.depth_mm, 100.0) << name;
        }
    }

} // namespace real_chest_test
} // namespace retractor::planner
