#include "planner/approach/divided_bones.h"

#include "mesh/base/text_format.h"
#include "planner/anatomy/rib_name.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

namespace retractor::planner {

namespace {

    /// The area of the blade in each label, mm2, with the blade moved aside by `aside_mm`.
    std::map<Label, double> blade_areas(const mesh::LabelVolume& labels, const Approach& approach, double aside_mm)
    {
        constexpr double kStepMm = 1.0;
        std::map<Label, double> met_mm2;
        for (std::size_t n = 0; n + 1 < approach.incision.size(); ++n) {
            const Vec3 step = approach.incision[n + 1] - approach.incision[n];
            const double length = step.norm();
            const int along = std::max(1, static_cast<int>(std::ceil(length / kStepMm)));
            const int down = std::max(1, static_cast<int>(std::ceil(approach.depth_mm / kStepMm)));
            for (int i = 0; i < along; ++i) {
                const IncisionPlace place { n, (i + 0.5) / along };
                const Vec3 direction = place.of(approach.directions).normalized();
                const Vec3 skin = place.of(approach.incision) + aside_mm * step.cross(direction).normalized();
                for (int j = 0; j < down; ++j)
                    met_mm2[mesh::label_at(labels, skin + (j + 0.5) / down * approach.depth_mm * direction)]
                        += length / along * approach.depth_mm / down;
            }
        }
        return met_mm2;
    }

    /// The smaller area of each label; 0 where one map alone has it.
    std::map<Label, double> smaller(std::map<Label, double> areas, const std::map<Label, double>& others)
    {
        for (auto& [label, area] : areas) {
            const auto other = others.find(label);
            area = other == others.end() ? 0.0 : std::min(area, other->second);
        }
        return areas;
    }

    /// The areas that remain when the blade is moved to either side: those of what it crosses and does not graze.
    std::map<Label, double> crossed_areas(const mesh::LabelVolume& labels, const Approach& approach)
    {
        constexpr double kAsideMm = 3.0; // half of a rib's thickness
        std::map<Label, double> areas = blade_areas(labels, approach, 0.0);
        for (const double aside : { -kAsideMm, kAsideMm })
            areas = smaller(std::move(areas), blade_areas(labels, approach, aside));
        return areas;
    }

    /// The wall's labels of a material that the blade meets, those that it severs or those that it leaves whole.
    std::vector<std::string> labels_met(const mesh::LabelVolume& labels, const Approach& approach,
        const std::map<Label, double>& met_mm2, std::string_view material, bool severed, double least_mm2)
    {
        std::vector<std::string> names;
        for (const mesh::LabelInfo& info : labels.table) {
            const auto met = met_mm2.find(info.id);
            const bool kept = std::ranges::find(approach.uncut_labels, info.name) != approach.uncut_labels.end();
            if (info.material == material && mesh::is_wall(info) && kept != severed && met != met_mm2.end()
                && met->second >= least_mm2)
                names.push_back(info.name);
        }
        return names;
    }

} // namespace

std::vector<std::string> divided_bones(const mesh::LabelVolume& labels, const Approach& approach, double least_mm2)
{
    return labels_met(labels, approach, blade_areas(labels, approach, 0.0), "bone", true, least_mm2);
}

std::vector<std::string> crossed_bones(const mesh::LabelVolume& labels, const Approach& approach, double least_mm2)
{
    return labels_met(labels, approach, crossed_areas(labels, approach), "bone", false, least_mm2);
}

std::vector<std::string> divided_cartilages(const mesh::LabelVolume& labels, const Approach& approach, double least_mm2)
{
    return labels_met(labels, approach, crossed_areas(labels, approach), "cartilage", true, least_mm2);
}

namespace {

    /// "begin name, name." Empty without names.
    std::string sentence(const char* begin, std::span<const std::string> names)
    {
        std::vector<std::string> words;
        for (const std::string& name : names) {
            const std::optional<RibName> rib = rib_name(name);
            words.push_back(rib ? rib_in_words(*rib) : readable(name));
        }
        return words.empty() ? std::string() : begin + joined(words) + ".";
    }

} // namespace

std::string crossed_bones_text(std::span<const std::string> bones)
{
    return sentence("The incision crosses bone that stays whole: ", bones);
}

std::string divided_cartilages_text(std::span<const std::string> cartilages)
{
    return sentence("The incision divides cartilage: ", cartilages);
}

std::string name_crossed_skeleton(Approach& approach, const mesh::LabelVolume& labels)
{
    std::string text = crossed_bones_text(crossed_bones(labels, approach));
    const std::string divided = divided_cartilages_text(divided_cartilages(labels, approach));
    if (!divided.empty())
        text += (text.empty() ? "" : " ") + divided;
    if (!text.empty())
        approach.rationale = text + " " + approach.rationale;
    return text;
}

} // namespace retractor::planner
