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

Look organ_look(std::string_view organ)
{
    for (const auto& [name, look] : kLooks)
        if (name == organ)
            return look;
    for (const std::string_view hollow : { "stomach", "bowel", "colon", "esophagus", "duodenum" })
        if (organ.find(hollow) != std::string_view::npos)
            return kHollowOrgan;
    for (const auto& [part, material] : kOrgans)
        if (organ.find(part) != std::string_view::npos)
            return tissue_look(material);
    return tissue_look(organ);
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

Color target_color() { return { 0.10, 0.95, 0.30 }; }
Color incision_color() { return { 0.20, 0.10, 0.75 }; }

} // namespace retractor::ui
