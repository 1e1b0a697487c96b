#include "ui/scene/tissue_colors.h"

#include <array>
#include <utility>

namespace retractor::ui {

namespace {

    // Chosen by eye from photographs of open thoracic surgery, lit by a white lamp.
    const std::array<std::pair<std::string_view, Look>, 10> kLooks { {
        { "skin", { { 0.86, 0.65, 0.53 }, Finish::skin, 0.6 } },
        { "fat", { { 0.93, 0.77, 0.36 }, Finish::wet, 0.8 } },
        { "muscle", { { 0.55, 0.13, 0.12 }, Finish::wet, 0.8 } },
        { "intercostal", { { 0.66, 0.22, 0.19 }, Finish::wet, 0.8 } },
        { "bone", { { 0.93, 0.88, 0.75 }, Finish::bone, 0.5 } },
        { "cartilage", { { 0.80, 0.87, 0.92 }, Finish::wet, 0.3 } },
        { "vessel", { { 0.78, 0.20, 0.20 }, Finish::wet, 0.4 } },
        { "heart", { { 0.62, 0.20, 0.18 }, Finish::wet, 0.8 } },
        { "lung", { { 0.85, 0.60, 0.60 }, Finish::wet, 0.6 } },
        { "liver", { { 0.42, 0.15, 0.11 }, Finish::wet, 0.4 } },
    } };

    // Colours of surgical atlases: blue for vessels whose blood lacks oxygen, yellow-white for the sac of the heart.
    constexpr Look kVein { { 0.33, 0.38, 0.66 }, Finish::wet, 0.3 };
    constexpr Look kPulmonaryArtery { { 0.45, 0.42, 0.68 }, Finish::wet, 0.3 };
    constexpr Look kPericardium { { 0.88, 0.76, 0.62 }, Finish::wet, 0.4 };
    constexpr Look kDiaphragm { { 0.62, 0.30, 0.22 }, Finish::wet, 0.6 };

    constexpr Look kHollowOrgan { { 0.87, 0.62, 0.55 }, Finish::wet, 0.3 };

    /// Parts of organ names and the tissue of each look. The first match counts.
    constexpr std::array<std::pair<std::string_view, std::string_view>, 22> kOrgans { {
        { "cartilage", "cartilage" },
        { "trachea", "cartilage" },
        { "lung", "lung" },
        { "heart", "heart" },
        { "liver", "liver" },
        { "aorta", "vessel" },
        { "arter", "vessel" },
        { "vein", "vessel" },
        { "vena_cava", "vessel" },
        { "vessel", "vessel" },
        { "trunk", "vessel" },
        { "aneurysm", "vessel" },
        { "rib_", "bone" },
        { "sternum", "bone" },
        { "spine", "bone" },
        { "vertebra", "bone" },
        { "scapula", "bone" },
        { "clavicula", "bone" },
        { "clavicle", "bone" },
        { "bone", "bone" },
        { "mediastinum", "fat" },
        { "abdomen", "skin" },
    } };

} // namespace

Look organ_look(std::string_view organ, std::string_view material)
{
    for (const auto& [name, look] : kLooks)
        if (name == organ)
            return look;
    const std::array<std::pair<std::string_view, Look>, 7> own { { { "pulmonary_vein", tissue_look("vessel") },
        { "pulmonary_artery", kPulmonaryArtery }, { "pulmonary_trunk", kPulmonaryArtery }, { "vein", kVein },
        { "vena_cava", kVein }, { "pericardium", kPericardium }, { "diaphragm", kDiaphragm } } };
    for (const auto& [part, look] : own)
        if (organ.find(part) != std::string_view::npos)
            return look;
    for (const std::string_view hollow : { "stomach", "bowel", "colon", "esophagus", "duodenum" })
        if (organ.find(hollow) != std::string_view::npos)
            return kHollowOrgan;
    for (const auto& [part, tissue] : kOrgans)
        if (organ.find(part) != std::string_view::npos)
            return tissue_look(tissue);
    return tissue_look(material.empty() ? organ : material);
}

Look tissue_look(std::string_view material)
{
    for (const auto& [name, look] : kLooks)
        if (name == material)
            return look;
    return { { 0.75, 0.62, 0.58 }, Finish::matte, 0.3 };
}

std::map<Label, Look> tissue_looks(const mesh::LabelTable& table)
{
    std::map<Label, Look> looks;
    for (const mesh::LabelInfo& info : table)
        looks[info.id] = tissue_look(info.material);
    return looks;
}

Look steel_look() { return { { 0.72, 0.74, 0.77 }, Finish::metal, 0.0 }; }

Color target_color() { return { 0.10, 0.95, 0.30 }; }
Color incision_color() { return { 0.20, 0.10, 0.75 }; }

} // namespace retractor::ui
