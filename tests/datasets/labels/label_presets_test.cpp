#include "datasets/labels/label_presets.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>

namespace retractor::datasets {
namespace label_presets_test {

    std::string name_of(std::string_view preset, Label id) { return mesh::find_label(preset_table(preset), id)->name; }

    std::vector<std::string> presets_with_ids()
    {
        std::vector<std::string> names = label_preset_names();
        std::erase(names, "slicer");
        return names;
    }

    void expect_info(std::string_view spelled, std::string_view name, std::string_view material, mesh::Role role)
    {
        const mesh::LabelInfo info = describe_structure(spelled, 7);
        EXPECT_EQ(info.id, 7);
        EXPECT_EQ(info.name, name) << spelled;
        EXPECT_EQ(info.material, material) << spelled;
        EXPECT_EQ(to_string(info.role), to_string(role)) << spelled;
    }

    TEST(LabelPresets, TotalSegmentatorIds)
    {
        const std::string v2 = "totalsegmentator";
        EXPECT_EQ(preset_table(v2).size(), 117U);
        EXPECT_EQ(name_of(v2, 1), "spleen");
        EXPECT_EQ(name_of(v2, 10), "lung_upper_lobe_left");
        EXPECT_EQ(name_of(v2, 15), "oesophagus");
        EXPECT_EQ(name_of(v2, 26), "vertebrae_S1");
        EXPECT_EQ(name_of(v2, 32), "vertebrae_T12");
        EXPECT_EQ(name_of(v2, 43), "vertebrae_T1");
        EXPECT_EQ(name_of(v2, 50), "vertebrae_C1");
        EXPECT_EQ(name_of(v2, 51), "heart");
        EXPECT_EQ(name_of(v2, 52), "aorta");
        EXPECT_EQ(name_of(v2, 53), "pulmonary_vein");
        EXPECT_EQ(name_of(v2, 61), "atrial_appendage_left");
        EXPECT_EQ(name_of(v2, 74), "clavicle_right");
        EXPECT_EQ(name_of(v2, 79), "spinal_cord");
        EXPECT_EQ(name_of(v2, 91), "skull");
        EXPECT_EQ(name_of(v2, 92), "rib_left_1");
        EXPECT_EQ(name_of(v2, 104), "rib_right_1");
        EXPECT_EQ(name_of(v2, 115), "rib_right_12");
        EXPECT_EQ(name_of(v2, 116), "sternum");
        EXPECT_EQ(name_of(v2, 117), "costal_cartilages");
    }

    TEST(LabelPresets, TotalSegmentatorOneHasOtherIdsAndNoSternum)
    {
        const std::string v1 = "totalsegmentator-v1";
        EXPECT_EQ(preset_table(v1).size(), 104U);
        EXPECT_EQ(name_of(v1, 7), "aorta");
        EXPECT_EQ(name_of(v1, 18), "vertebrae_L5");
        EXPECT_EQ(name_of(v1, 34), "vertebrae_T1");
        EXPECT_EQ(name_of(v1, 44), "heart_myocardium");
        EXPECT_EQ(name_of(v1, 45), "heart_atrium_left");
        EXPECT_EQ(name_of(v1, 49), "pulmonary_artery");
        EXPECT_EQ(name_of(v1, 58), "rib_left_1");
        EXPECT_EQ(name_of(v1, 81), "rib_right_12");
        EXPECT_EQ(name_of(v1, 86), "clavicle_left");
        EXPECT_EQ(name_of(v1, 93), "face");
        EXPECT_EQ(name_of(v1, 104), "urinary_bladder");
        EXPECT_EQ(mesh::find_label(preset_table(v1), "sternum"), nullptr);
        EXPECT_EQ(mesh::find_label(preset_table(v1), "costal_cartilages"), nullptr);
    }

    TEST(LabelPresets, ChestImagingPlatformRegions)
    {
        EXPECT_EQ(preset_table("cip").size(), 68U);
        EXPECT_EQ(name_of("cip", 1), "lungs");
        EXPECT_EQ(name_of("cip", 2), "lung_right");
        EXPECT_EQ(name_of("cip", 3), "lung_left");
        EXPECT_EQ(name_of("cip", 4), "lung_upper_lobe_right");
        EXPECT_EQ(name_of("cip", 8), "lung_lower_lobe_left");
        EXPECT_EQ(name_of("cip", 16), "heart");
        EXPECT_EQ(name_of("cip", 32), "sternum");
        EXPECT_EQ(name_of("cip", 51), "spine");
        EXPECT_EQ(name_of("cip", 54), "heart_atrium_left");
        EXPECT_EQ(name_of("cip", 58), "trachea");
        EXPECT_EQ(name_of("cip", 68), "spinal_cord");
    }

    TEST(LabelPresets, NamesAreUniqueAndMaterialsKnown)
    {
        // The materials of fem/material/material.h; "soft_tissue" is none of them and never cut.
        const std::set<std::string> materials { "skin", "fat", "muscle", "intercostal", "bone", "cartilage", "vessel",
            "vessel_sclerotic", "heart", "lung", "liver" };
        for (const std::string& preset : presets_with_ids()) {
            std::set<std::string> names;
            std::set<Label> ids;
            for (const mesh::LabelInfo& info : preset_table(preset)) {
                EXPECT_TRUE(names.insert(info.name).second) << preset << ": " << info.name;
                EXPECT_TRUE(ids.insert(info.id).second) << preset << ": " << info.id;
                EXPECT_TRUE(materials.contains(info.material)
                    || (info.material == "soft_tissue" && info.role != mesh::Role::wall))
                    << preset << ": " << info.name << " is " << info.material;
            }
        }
    }

    TEST(LabelPresets, ThePlannersNamesStayAsTheyAre)
    {
        for (const std::string& preset : presets_with_ids())
            for (const mesh::LabelInfo& info : preset_table(preset)) {
                const mesh::LabelInfo again = describe_structure(info.name, info.id);
                EXPECT_EQ(again.name, info.name);
                EXPECT_EQ(again.material, info.material) << info.name;
                EXPECT_EQ(again.role, info.role) << info.name;
            }
    }

    TEST(LabelPresets, ThePhantomsStructuresAreKnown)
    {
        ThoraxParameters coarse;
        coarse.spacing_mm = Vec3::Constant(6.0);
        for (const mesh::LabelInfo& info : make_thorax_phantom(coarse).labels.table)
            expect_info(info.name, info.name, info.material, info.role);
    }

    TEST(LabelPresets, RolesAndMaterials)
    {
        expect_info("rib_left_5", "rib_left_5", "bone", mesh::Role::wall);
        expect_info("sternum", "sternum", "bone", mesh::Role::wall);
        expect_info("costal_cartilages", "costal_cartilages", "cartilage", mesh::Role::wall);
        expect_info("clavicula_left", "clavicle_left", "bone", mesh::Role::wall);
        expect_info("subcutaneous_fat", "fat", "fat", mesh::Role::wall);
        expect_info("skeletal_muscle", "muscle", "muscle", mesh::Role::wall);
        expect_info("autochthon_left", "autochthon_left", "muscle", mesh::Role::wall);
        expect_info("skin", "skin", "skin", mesh::Role::wall);
        expect_info("torso_fat", "torso_fat", "fat", mesh::Role::voxel);
        expect_info("body_trunc", "body_trunc", "soft_tissue", mesh::Role::voxel);
        expect_info("heart", "heart", "heart", mesh::Role::at_risk);
        expect_info("aorta", "aorta", "vessel", mesh::Role::at_risk);
        expect_info("coronary_arteries", "coronary_arteries", "vessel", mesh::Role::at_risk);
        expect_info("pulmonary_artery", "pulmonary_artery", "vessel", mesh::Role::at_risk);
        expect_info("liver", "liver", "liver", mesh::Role::voxel);
        expect_info("lung_upper_lobe_left", "lung_upper_lobe_left", "lung", mesh::Role::voxel);
        expect_info("aorta_false_lumen", "aorta_false_lumen", "vessel", mesh::Role::target);
        expect_info("Aneurysm", "aneurysm", "vessel", mesh::Role::target);
        expect_info("lung_nodules", "lung_nodules", "lung", mesh::Role::target);
        expect_info("Tumor", "tumor", "soft_tissue", mesh::Role::target);
    }

    TEST(LabelPresets, SpellingCaseAndSideAreTolerated)
    {
        expect_info("Left lung", "lung_left", "lung", mesh::Role::voxel);
        expect_info("RightLung", "lung_right", "lung", mesh::Role::voxel);
        expect_info("superior lobe of left lung", "lung_upper_lobe_left", "lung", mesh::Role::voxel);
        expect_info("right rib 5", "rib_right_5", "bone", mesh::Role::wall);
        expect_info("Rib L5", "rib_left_5", "bone", mesh::Role::wall);
        expect_info("Rib_5L", "rib_left_5", "bone", mesh::Role::wall);
        expect_info("Left fifth rib", "rib_left_5", "bone", mesh::Role::wall);
        expect_info("11th rib (right)", "rib_right_11", "bone", mesh::Role::wall);
        expect_info("T5 vertebra", "vertebrae_T5", "bone", mesh::Role::wall);
        expect_info("Vertebra T12", "vertebrae_T12", "bone", mesh::Role::wall);
        expect_info("L3", "vertebrae_L3", "bone", mesh::Role::wall);
        expect_info("Fifth thoracic vertebra", "vertebrae_T5", "bone", mesh::Role::wall);
        expect_info("Vertebrae", "spine", "bone", mesh::Role::wall);
        expect_info("Sternum", "sternum", "bone", mesh::Role::wall);
        expect_info("Vena cava superior", "superior_vena_cava", "vessel", mesh::Role::at_risk);
        expect_info("Left Atrium", "heart_atrium_left", "heart", mesh::Role::at_risk);
        expect_info("LEFT SCAPULA BONE", "scapula_left", "bone", mesh::Role::wall);
        expect_info("Oesophagus", "oesophagus", "muscle", mesh::Role::voxel);
        expect_info("Costal cartilage", "costal_cartilages", "cartilage", mesh::Role::wall);
    }

    TEST(LabelPresets, MeaningsOfCodedTermsAreKnown)
    {
        expect_info("Fifth rib Left", "rib_left_5", "bone", mesh::Role::wall);
        expect_info("Twelfth rib Right", "rib_right_12", "bone", mesh::Role::wall);
        expect_info("Left ventricle of heart", "heart_ventricle_left", "heart", mesh::Role::at_risk);
        expect_info("Lower lobe of lung Left", "lung_lower_lobe_left", "lung", mesh::Role::voxel);
        expect_info("Middle lobe of right lung", "lung_middle_lobe_right", "lung", mesh::Role::voxel);
        expect_info("Vena cava Superior", "superior_vena_cava", "vessel", mesh::Role::at_risk);
        expect_info("Brachiocephalic artery", "brachiocephalic_trunk", "vessel", mesh::Role::at_risk);
        expect_info("Entire atrial appendage Left", "atrial_appendage_left", "heart", mesh::Role::at_risk);
        expect_info("Deep muscle of back Right", "autochthon_right", "muscle", mesh::Role::wall);
        expect_info("Common iliac vein Left", "iliac_vena_left", "vessel", mesh::Role::at_risk);
        expect_info("Subcutaneous fatty tissue", "fat", "fat", mesh::Role::wall);
        expect_info("Fat Trunk", "torso_fat", "fat", mesh::Role::voxel);
        expect_info("Cyst Kidney Left", "kidney_cyst_left", "soft_tissue", mesh::Role::voxel);
        expect_info("Vertebra Thoracic spine", "vertebrae_thoracic", "bone", mesh::Role::wall);
        expect_info("Coronary artery", "coronary_arteries", "vessel", mesh::Role::at_risk);
        expect_info("Gluteus maximus muscle Left", "gluteus_maximus_left", "muscle", mesh::Role::wall);
    }

    TEST(LabelPresets, OthersKeepTheirName)
    {
        expect_info("Segment_1", "segment_1", "soft_tissue", mesh::Role::voxel);
        expect_info("Liver segment 4", "liver_segment_4", "liver", mesh::Role::voxel);
        expect_info("left internal mammary artery", "left_internal_mammary_artery", "vessel", mesh::Role::at_risk);
        expect_info("rib plate left 5", "rib_plate_left_5", "bone", mesh::Role::wall);
        expect_info("\xe8\x82\xba", "\xe8\x82\xba", "soft_tissue", mesh::Role::voxel); // not a name we know, but one
        expect_info(" -- ", "label_7", "soft_tissue", mesh::Role::voxel);
        expect_info("", "label_7", "soft_tissue", mesh::Role::voxel);
        expect_info("S1", "s1", "soft_tissue", mesh::Role::voxel);
        expect_info("T99 vertebra", "t99_vertebra", "bone", mesh::Role::wall);
    }

    TEST(LabelPresets, AnyBytesGiveAName)
    {
        const std::vector<std::string> pieces { "rib", "Left", "5", " ", "_", "~", "^", "T12", "vertebra", "th", "L",
            "of", "lung", "TerminologyEntry:", "|", "99999999999", "\xe8\x82\xba", "\xff", "-", "target",
            std::string(1, '\0') };
        std::mt19937 random(5);
        for (int n = 0; n < 20000; ++n) {
            std::string text;
            for (auto length = random() % 9; length > 0; --length)
                text += pieces[random() % pieces.size()];
            const mesh::LabelInfo info = describe_structure(text, 3);
            ASSERT_FALSE(info.name.empty());
            ASSERT_EQ(info.name.find_first_of(std::string(" ~^|-:\0", 7)), std::string::npos) << info.name;
            ASSERT_TRUE(info.role != mesh::Role::wall || info.material != "soft_tissue") << info.name;
            EXPECT_EQ(describe_structure(info.name, 3).role, info.role) << text << " -> " << info.name;
            structure_from_terminology(text);
        }
    }

    TEST(LabelPresets, CodedTermsOfASegment)
    {
        EXPECT_EQ(
            structure_from_terminology("Segmentation.Status:inprogress|TerminologyEntry:General Anatomy list~SCT^"
                                       "123037004^Anatomical Structure~SCT^39607008^Lung~SCT^7771000^Left~Anatomic "
                                       "codes~^^~^^|"),
            "Lung Left");
        EXPECT_EQ(
            structure_from_terminology("List~SCT^1^Anatomical Structure~SCT^56873002^Sternum~^^~x~^^~^^"), "Sternum");
        EXPECT_EQ(structure_from_terminology("List~SCT^85756007^Tissue~SCT^85756007^Tissue~^^~x~^^~^^"), "");
        EXPECT_EQ(
            structure_from_terminology("List~SCT^1^Tissue~SCT^55603005^Fat~^^~x~SCT^22943007^Trunk~^^"), "Fat Trunk");
        EXPECT_EQ(structure_from_terminology("List~a^b^c~SCT^367643001^Cyst~^^~x~SCT^64033007^Kidney~SCT^7771000^Left"),
            "Cyst Kidney Left");
        EXPECT_EQ(structure_from_terminology(""), "");
        EXPECT_EQ(structure_from_terminology("TerminologyEntry:~~^~"), "");
    }

    TEST(LabelPresets, NamesOfTheStatisticsFileAreThoseOfThePreset)
    {
        std::ifstream file(test_support::shared_data("labels/ts_abdomen/example_seg_fast_statistics.json"));
        if (!file)
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const auto statistics = nlohmann::ordered_json::parse(file); // in the order of the ids
        const mesh::LabelTable table = preset_table("totalsegmentator");
        ASSERT_EQ(statistics.size(), table.size());
        std::size_t n = 0;
        for (const auto& [name, values] : statistics.items())
            EXPECT_EQ(describe_structure(name, 1).name, table[n++].name);
    }

    TEST(LabelPresets, UnknownPresetsAreRefused)
    {
        test_support::expect_refused<InputError>(
            [] { preset_table("totalsegmentor"); }, "known are: totalsegmentator,");
        test_support::expect_refused<InputError>([] { preset_table("totalsegmentor"); }, "preset 'totalsegmentor'");
        test_support::expect_refused<InputError>([] { preset_table("slicer"); }, "takes the names from the file");
    }

} // namespace label_presets_test
} // namespace retractor::datasets
