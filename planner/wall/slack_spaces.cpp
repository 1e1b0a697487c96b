#include "planner/wall/slack_spaces.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/approach/divided_bones.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace retractor::planner {

namespace {

    using SideAndNumber = std::pair<bool, int>; // of a SpaceNumber, in order

    bool is_intercostal(const mesh::LabelInfo& info) { return mesh::is_wall(info) && info.material == "intercostal"; }

    bool is_muscle(const mesh::LabelInfo& info) { return mesh::is_wall(info) && info.material == "muscle"; }

    /// The label of muscle without a name of its own, or of any muscle; nullptr: there is none.
    const mesh::LabelInfo* muscle_label(const mesh::LabelTable& table)
    {
        auto found = std::ranges::find_if(
            table, [](const mesh::LabelInfo& info) { return is_muscle(info) && info.name == "muscle"; });
        if (found == table.end())
            found = std::ranges::find_if(table, is_muscle);
        return found == table.end() ? nullptr : &*found;
    }

    /// The part of a blade that lies in intercostal muscle.
    struct MusclePath {
        std::map<SideAndNumber, double> area_mm2; ///< by space
        double over_muscle_mm = 0.0, length_mm = 0.0; ///< of the line
    };

    void add_blade(MusclePath& path, const std::vector<Vec3>& line, const std::vector<Vec3>& directions,
        double depth_mm, const mesh::LabelVolume& labels, const Anatomy& anatomy)
    {
        constexpr double kStepMm = 1.0;
        RETRACTOR_ASSERT(directions.size() == line.size());
        const mesh::LabelFlags intercostal = mesh::flagged_labels(labels.table, is_intercostal);
        for (std::size_t n = 1; n < line.size(); ++n) {
            const double length = (line[n] - line[n - 1]).norm();
            const int steps = std::max(1, static_cast<int>(std::ceil(length / kStepMm)));
            const double step = length / steps;
            path.length_mm += length;
            for (int k = 0; k < steps; ++k) {
                const double share = (k + 0.5) / steps;
                const Vec3 on_line = line[n - 1] + share * (line[n] - line[n - 1]);
                const Vec3 direction = directions[n - 1] + share * (directions[n] - directions[n - 1]);
                bool met = false;
                for (double t = 0.0; t <= depth_mm; t += kStepMm) {
                    const Vec3 place = on_line + t * direction;
                    if (intercostal[mesh::label_at(labels, place)] == 0)
                        continue;
                    if (const std::optional<SpaceNumber> space = space_at(anatomy, place)) {
                        path.area_mm2[{ space->left, space->number }] += step * kStepMm;
                        met = true;
                    }
                }
                path.over_muscle_mm += met ? step : 0.0;
            }
        }
    }

    bool bears_on_bone(const Approach& approach)
    {
        return std::ranges::any_of(approach.hooks, [](const HookSpec& hook) { return !hook.bears_on.empty(); });
    }

    std::string slack_words(const std::vector<SpaceNumber>& opened)
    {
        std::string names;
        for (const SpaceNumber& space : opened)
            names += (names.empty() ? "" : " and ") + space_name(space.left, space.number);
        return "intercostal muscle of the spaces that close beside the " + names + " is taken as slack";
    }

} // namespace

std::vector<SpaceNumber> opened_spaces(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const Approach& approach)
{
    constexpr double kLeastShare = 0.1, kLeastLength = 1.0 / 3.0;
    constexpr std::size_t kMostSpaces = 2;
    const std::vector<std::string> sawn = divided_bones(labels, approach);
    if (std::ranges::find(sawn, "sternum") != sawn.end())
        return {};
    MusclePath path;
    add_blade(path, approach.incision, approach.directions, approach.depth_mm, labels, anatomy);
    if (path.over_muscle_mm < kLeastLength * path.length_mm)
        return {};
    for (const DivisionStroke& stroke : approach.division.strokes)
        add_blade(path, stroke.line, stroke.directions, stroke.depth_mm, labels, anatomy);
    double all = 0.0;
    for (const auto& [space, area] : path.area_mm2)
        all += area;
    std::vector<SpaceNumber> opened;
    for (const auto& [space, area] : path.area_mm2)
        if (area >= kLeastShare * all)
            opened.push_back({ space.first, space.second });
    return opened.size() <= kMostSpaces ? opened : std::vector<SpaceNumber> {};
}

std::size_t slacken_other_spaces(
    mesh::TetMesh& wall, const mesh::LabelTable& table, const Anatomy& anatomy, const std::vector<SpaceNumber>& opened)
{
    const mesh::LabelInfo* muscle = muscle_label(table);
    if (muscle == nullptr || opened.empty())
        return 0;
    const mesh::LabelFlags intercostal = mesh::flagged_labels(table, is_intercostal);
    std::size_t changed = 0;
    for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
        Label& label = wall.labels[static_cast<std::size_t>(t)];
        if (intercostal[label] == 0)
            continue;
        Vec3 middle = Vec3::Zero();
        for (const Vec3& corner : mesh::tet_corners(wall, t))
            middle += 0.25 * corner;
        const std::optional<SpaceNumber> space = space_at(anatomy, middle);
        if (!space)
            continue;
        const bool on_opened_side = std::ranges::find(opened, space->left, &SpaceNumber::left) != opened.end();
        const bool is_opened = std::ranges::any_of(
            opened, [&](const SpaceNumber& one) { return one.left == space->left && one.number == space->number; });
        if (!on_opened_side || is_opened)
            continue;
        label = muscle->id;
        ++changed;
    }
    return changed;
}

std::string slacken_other_spaces(mesh::TetMesh& wall, Patient& patient, const Approach& approach)
{
    const auto labels = patient.labels();
    const auto intercostal = std::ranges::find_if(labels->table, is_intercostal);
    const mesh::LabelInfo* muscle = muscle_label(labels->table);
    if (intercostal == labels->table.end() || muscle == nullptr || !bears_on_bone(approach))
        return {};
    const std::vector<fem::Material> materials = materials_as_solved(patient);
    if (materials[muscle->id].youngs_modulus_MPa >= materials[intercostal->id].youngs_modulus_MPa)
        return {};
    std::shared_ptr<const Anatomy> anatomy;
    try {
        anatomy = patient.anatomy();
    } catch (const InputError&) {
        return {}; // a part of a body
    }
    const std::vector<SpaceNumber> opened = opened_spaces(*labels, *anatomy, approach);
    return slacken_other_spaces(wall, labels->table, *anatomy, opened) > 0 ? slack_words(opened) : std::string();
}

} // namespace retractor::planner
