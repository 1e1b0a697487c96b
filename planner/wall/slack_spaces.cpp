#include "planner/wall/slack_spaces.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

namespace retractor::planner {

namespace {

    using SideAndNumber = std::pair<bool, int>;

    const mesh::LabelInfo* wall_label_of(const mesh::LabelTable& table, std::string_view material)
    {
        const auto found = std::ranges::find_if(
            table, [&](const mesh::LabelInfo& info) { return mesh::is_wall(info) && info.material == material; });
        return found == table.end() ? nullptr : &*found;
    }

    mesh::LabelFlags intercostal_labels(const mesh::LabelTable& table)
    {
        return mesh::flagged_labels(
            table, [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && info.material == "intercostal"; });
    }

    /// Counts the places of a blade that lie in intercostal muscle, by space.
    /// @return the share of the line's points with such places
    double count_places(std::map<SideAndNumber, int>& count, const std::vector<Vec3>& line,
        const std::vector<Vec3>& directions, double depth_mm, const mesh::LabelVolume& labels, const Anatomy& anatomy)
    {
        constexpr double kStepMm = 1.0;
        const mesh::LabelFlags intercostal = intercostal_labels(labels.table);
        std::size_t over_muscle = 0;
        for (std::size_t n = 0; n < line.size(); ++n) {
            bool met = false;
            for (double t = 0.0; t <= depth_mm; t += kStepMm) {
                const Vec3 place = line[n] + t * directions[n];
                if (intercostal[mesh::label_at(labels, place)] == 0)
                    continue;
                if (const std::optional<SpaceNumber> space = space_at(anatomy, place)) {
                    ++count[{ space->left, space->number }];
                    met = true;
                }
            }
            over_muscle += met ? 1 : 0;
        }
        return line.empty() ? 0.0 : static_cast<double>(over_muscle) / static_cast<double>(line.size());
    }

} // namespace

std::vector<SpaceNumber> opened_spaces(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const Approach& approach)
{
    constexpr double kLeastShare = 0.1, kLeastLength = 1.0 / 3.0;
    std::map<SideAndNumber, int> count;
    const double over_muscle
        = count_places(count, approach.incision, approach.directions, approach.depth_mm, labels, anatomy);
    if (over_muscle < kLeastLength)
        return {};
    for (const DivisionStroke& stroke : approach.division.strokes)
        count_places(count, stroke.line, stroke.directions, stroke.depth_mm, labels, anatomy);
    int all = 0;
    for (const auto& [space, places] : count)
        all += places;
    std::vector<SpaceNumber> opened;
    for (const auto& [space, places] : count)
        if (places >= kLeastShare * all)
            opened.push_back({ space.first, space.second });
    return opened;
}

std::size_t slacken_other_spaces(
    mesh::TetMesh& wall, const mesh::LabelTable& table, const Anatomy& anatomy, const std::vector<SpaceNumber>& opened)
{
    const mesh::LabelInfo* muscle = wall_label_of(table, "muscle");
    if (muscle == nullptr || opened.empty())
        return 0;
    const mesh::LabelFlags intercostal = intercostal_labels(table);
    std::size_t changed = 0;
    for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
        Label& label = wall.labels[static_cast<std::size_t>(t)];
        if (intercostal[label] == 0)
            continue;
        Vec3 middle = Vec3::Zero();
        for (const Vec3& corner : mesh::tet_corners(wall, t))
            middle += 0.25 * corner;
        const std::optional<SpaceNumber> space = space_at(anatomy, middle);
        const auto is_here = [&](const SpaceNumber& other) {
            return space && other.left == space->left && other.number == space->number;
        };
        const auto same_side = [&](const SpaceNumber& other) { return space && other.left == space->left; };
        if (std::ranges::none_of(opened, same_side) || std::ranges::any_of(opened, is_here))
            continue;
        label = muscle->id;
        ++changed;
    }
    return changed;
}

std::size_t slacken_other_spaces(mesh::TetMesh& wall, Patient& patient, const Approach& approach)
{
    const auto labels = patient.labels();
    if (wall_label_of(labels->table, "intercostal") == nullptr)
        return 0;
    std::shared_ptr<const Anatomy> anatomy;
    try {
        anatomy = patient.anatomy();
    } catch (const InputError&) {
        return 0; // no landmarks: a block, or a part of a body
    }
    return slacken_other_spaces(wall, labels->table, *anatomy, opened_spaces(*labels, *anatomy, approach));
}

} // namespace retractor::planner
