#include "ui/scene/label_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace retractor::ui {

namespace {

    /// Organs that touch differ in hue; all colours stand out from grey.
    constexpr std::array<std::pair<std::string_view, Color>, 26> kColors { {
        { "skin", { 0.95, 0.70, 0.55 } },
        { "fat", { 0.95, 0.85, 0.25 } },
        { "muscle", { 0.80, 0.25, 0.20 } },
        { "intercostal", { 0.95, 0.45, 0.60 } },
        { "intercostal_muscle", { 0.95, 0.45, 0.60 } },
        { "sternum", { 1.00, 0.55, 0.05 } },
        { "spine", { 0.35, 0.75, 1.00 } },
        { "costal_cartilages", { 0.25, 1.00, 0.85 } },
        { "scapula_left", { 0.70, 0.40, 1.00 } },
        { "scapula_right", { 1.00, 0.40, 0.90 } },
        { "clavicle_left", { 0.20, 0.95, 0.35 } },
        { "clavicle_right", { 0.65, 0.95, 0.15 } },
        { "bone_other", { 0.95, 0.95, 0.95 } },
        { "lung_left", { 0.35, 0.50, 1.00 } },
        { "lung_right", { 0.25, 0.85, 1.00 } },
        { "trachea", { 0.75, 1.00, 0.95 } },
        { "mediastinum", { 0.75, 0.65, 0.85 } },
        { "upper_abdomen", { 0.70, 0.55, 0.30 } },
        { "liver", { 0.65, 0.40, 0.20 } },
        { "heart", { 1.00, 0.25, 0.45 } },
        { "aorta", { 1.00, 0.10, 0.10 } },
        { "aneurysm", { 0.10, 0.95, 0.30 } },
        { "aorta_true_lumen", { 1.00, 0.15, 0.10 } },
        { "aorta_false_lumen", { 0.25, 0.45, 1.00 } },
        { "pulmonary_artery", { 0.30, 0.70, 1.00 } },
        { "target", { 0.10, 0.95, 0.30 } },
    } };

    Color color_of_hue(double hue_deg, double saturation, double value)
    {
        const double sector = std::fmod(std::fmod(hue_deg, 360.0) + 360.0, 360.0) / 60.0;
        const auto channel = [&](double offset) {
            const double k = std::fmod(offset + sector, 6.0);
            return value * (1.0 - saturation * std::max(0.0, std::min({ k, 4.0 - k, 1.0 })));
        };
        return { channel(5.0), channel(3.0), channel(1.0) };
    }

    /// FNV-1a hash, which is the same on every machine, unlike std::hash.
    std::uint32_t hash_of(std::string_view text)
    {
        std::uint32_t hash = 2166136261U;
        for (const char c : text) {
            hash ^= static_cast<unsigned char>(c);
            hash *= 16777619U;
        }
        return hash;
    }

    bool is_digit(char c) { return c >= '0' && c <= '9'; }

} // namespace

std::string_view level_of(std::string_view name)
{
    const bool rib = name.starts_with("rib_");
    if (!rib && !name.starts_with("vertebra"))
        return {};
    std::size_t first = name.size();
    while (first > 0 && is_digit(name[first - 1]))
        --first;
    if (first == name.size())
        return {};
    if (!rib && first > 0 && name[first - 1] != '_')
        --first; // the letter of the part of the spine
    return name.substr(first);
}

Color label_color(std::string_view name)
{
    for (const auto& [known, color] : kColors)
        if (known == name)
            return color;
    const std::string_view level = level_of(name);
    if (!level.empty()) {
        const std::string_view row = name.substr(0, name.size() - level.size());
        int number = 0;
        for (const char c : level)
            number = is_digit(c) ? 10 * number + (c - '0') : number;
        constexpr double kStepDeg = 137.5; // the golden angle: neighbours of neighbours differ too
        return color_of_hue(kStepDeg * number + (row.find("right") != std::string_view::npos ? 70.0 : 0.0), 0.70, 1.0);
    }
    const std::uint32_t hash = hash_of(name);
    return color_of_hue(hash % 360U, 0.45 + 0.15 * ((hash >> 9) % 4U), 0.80 + 0.20 * ((hash >> 16) % 2U));
}

std::map<Label, Color> label_colors(const mesh::LabelTable& table)
{
    std::map<Label, Color> colors;
    for (const mesh::LabelInfo& info : table)
        colors[info.id] = label_color(info.name);
    return colors;
}

} // namespace retractor::ui
