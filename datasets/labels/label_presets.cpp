#include "datasets/labels/label_presets.h"

#include "mesh/base/error.h"

#include <span>

namespace retractor::datasets {

namespace {

    using Names = std::vector<std::string>;

    // Sequences of names that occur in both versions of TotalSegmentator. Sources: its class table
    // (totalsegmentator/map_to_binary.py), and the names in its images.

    void append(Names& names, std::initializer_list<const char*> more)
    {
        names.insert(names.end(), more.begin(), more.end());
    }

    void append_vertebrae(Names& names, char region, int from)
    {
        for (int level = from; level >= 1; --level)
            names.push_back(std::string("vertebrae_") + region + std::to_string(level));
    }

    /// Appends the vertebrae from the fifth lumbar vertebra to the atlas.
    void append_spine(Names& names)
    {
        append_vertebrae(names, 'L', 5);
        append_vertebrae(names, 'T', 12);
        append_vertebrae(names, 'C', 7);
    }

    void append_ribs(Names& names)
    {
        for (const char* side : { "left", "right" })
            for (int rib = 1; rib <= 12; ++rib)
                names.push_back(std::string("rib_") + side + "_" + std::to_string(rib));
    }

    void append_pairs(Names& names, std::initializer_list<const char*> structures)
    {
        for (const std::string structure : structures)
            for (const char* side : { "_left", "_right" })
                names.push_back(structure + side);
    }

    /// Names of task "total" of version 2, ids 1 to 117.
    Names totalsegmentator_v2()
    {
        Names names { "spleen", "kidney_right", "kidney_left", "gallbladder", "liver", "stomach", "pancreas",
            "adrenal_gland_right", "adrenal_gland_left", "lung_upper_lobe_left", "lung_lower_lobe_left",
            "lung_upper_lobe_right", "lung_middle_lobe_right", "lung_lower_lobe_right", "esophagus", "trachea",
            "thyroid_gland", "small_bowel", "duodenum", "colon", "urinary_bladder", "prostate", "kidney_cyst_left",
            "kidney_cyst_right", "sacrum", "vertebrae_S1" };
        append_spine(names);
        append(names,
            { "heart", "aorta", "pulmonary_vein", "brachiocephalic_trunk", "subclavian_artery_right",
                "subclavian_artery_left", "common_carotid_artery_right", "common_carotid_artery_left",
                "brachiocephalic_vein_left", "brachiocephalic_vein_right", "atrial_appendage_left",
                "superior_vena_cava", "inferior_vena_cava", "portal_vein_and_splenic_vein" });
        append_pairs(names, { "iliac_artery", "iliac_vena", "humerus", "scapula", "clavicula", "femur", "hip" });
        names.emplace_back("spinal_cord");
        append_pairs(names, { "gluteus_maximus", "gluteus_medius", "gluteus_minimus", "autochthon", "iliopsoas" });
        append(names, { "brain", "skull" });
        append_ribs(names);
        append(names, { "sternum", "costal_cartilages" });
        return names;
    }

    /// Names of version 1, ids 1 to 104.
    Names totalsegmentator_v1()
    {
        Names names { "spleen", "kidney_right", "kidney_left", "gallbladder", "liver", "stomach", "aorta",
            "inferior_vena_cava", "portal_vein_and_splenic_vein", "pancreas", "adrenal_gland_right",
            "adrenal_gland_left", "lung_upper_lobe_left", "lung_lower_lobe_left", "lung_upper_lobe_right",
            "lung_middle_lobe_right", "lung_lower_lobe_right" };
        append_spine(names);
        append(names,
            { "esophagus", "trachea", "heart_myocardium", "heart_atrium_left", "heart_ventricle_left",
                "heart_atrium_right", "heart_ventricle_right", "pulmonary_artery", "brain" });
        append_pairs(names, { "iliac_artery", "iliac_vena" });
        append(names, { "small_bowel", "duodenum", "colon" });
        append_ribs(names);
        append_pairs(names, { "humerus", "scapula", "clavicula", "femur", "hip" });
        append(names, { "sacrum", "face" });
        append_pairs(names, { "gluteus_maximus", "gluteus_medius", "gluteus_minimus", "autochthon", "iliopsoas" });
        names.emplace_back("urinary_bladder");
        return names;
    }

    /// Regions of the Chest Imaging Platform (Common/cipChestConventions.h), ids 1 to 68.
    Names chest_imaging_platform()
    {
        return { "WholeLung", "RightLung", "LeftLung", "RightSuperiorLobe", "RightMiddleLobe", "RightInferiorLobe",
            "LeftSuperiorLobe", "LeftInferiorLobe", "LeftUpperThird", "LeftMiddleThird", "LeftLowerThird",
            "RightUpperThird", "RightMiddleThird", "RightLowerThird", "Mediastinum", "WholeHeart", "Aorta",
            "PulmonaryArtery", "PulmonaryVein", "UpperThird", "MiddleThird", "LowerThird", "LeftHalf", "RightHalf",
            "Liver", "Spleen", "Abdomen", "Paravertebral", "OutsideLung", "OutsideBody", "Skeleton", "Sternum",
            "Humeri", "LeftHumerus", "RightHumerus", "Scapulae", "LeftScapula", "RightScapula", "Hilum", "LeftHilum",
            "RightHilum", "Kidneys", "LeftKidney", "RightKidney", "AscendingAorta", "TransversalAorta",
            "DescendingAorta", "LeftSubclavian", "RightSubclavian", "LeftCoronaryArtery", "Spine", "LeftVentricle",
            "RightVentricle", "LeftAtrium", "RightAtrium", "LeftPectoralis", "RightPectoralis", "Trachea",
            "LeftMainBronchus", "RightMainBronchus", "Esophagus", "LeftChestWall", "RightChestWall", "LeftDiaphragm",
            "RightDiaphragm", "Hiatus", "Pectoralis", "SpinalCord" };
    }

    struct Preset {
        const char* name;
        Names (*structures)(); ///< names of the ids from 1; null when the file has the names
    };

    std::span<const Preset> presets()
    {
        static const std::vector<Preset> kPresets {
            { "totalsegmentator", totalsegmentator_v2 },
            { "totalsegmentator-v1", totalsegmentator_v1 },
            { "totalsegmentator-heartchambers_highres",
                [] {
                    return Names { "heart_myocardium", "heart_atrium_left", "heart_ventricle_left",
                        "heart_atrium_right", "heart_ventricle_right", "aorta", "pulmonary_artery" };
                } },
            { "totalsegmentator-coronary_arteries", [] { return Names { "coronary_arteries" }; } },
            { "totalsegmentator-tissue_types",
                [] {
                    return Names { "subcutaneous_fat", "torso_fat", "skeletal_muscle" };
                } },
            { "totalsegmentator-tissue_4_types",
                [] {
                    return Names { "subcutaneous_fat", "torso_fat", "skeletal_muscle", "intermuscular_fat" };
                } },
            { "totalsegmentator-body",
                [] {
                    return Names { "body_trunc", "body_extremities" };
                } },
            { "totalsegmentator-lung_vessels",
                [] {
                    return Names { "lung_vessels", "lung_trachea_bronchia" };
                } },
            { "cip", chest_imaging_platform },
            { "slicer", nullptr },
        };
        return kPresets;
    }

} // namespace

std::vector<std::string> label_preset_names()
{
    std::vector<std::string> names;
    for (const Preset& preset : presets())
        names.emplace_back(preset.name);
    return names;
}

mesh::LabelTable preset_table(std::string_view wanted)
{
    std::string known;
    for (const Preset& preset : presets()) {
        known += (known.empty() ? "" : ", ") + std::string(preset.name);
        if (preset.name != wanted)
            continue;
        if (preset.structures == nullptr)
            throw InputError("this preset takes the names from the file (.seg.nrrd), it has no ids of its own",
                "preset '" + std::string(wanted) + "'");
        mesh::LabelTable table;
        for (const std::string& name : preset.structures())
            table.push_back(describe_structure(name, static_cast<Label>(table.size() + 1)));
        return table;
    }
    throw InputError("there is no preset of this name; known are: " + known, "preset '" + std::string(wanted) + "'");
}

} // namespace retractor::datasets
