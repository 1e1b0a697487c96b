#include "planner/case/approach.h"

#include "fem/statics/driven_opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kUnitTolerance = 1e-6; ///< directions are stored to the last bit, but typed to a few digits
    /// N or N/mm; a wall resists a hook with some 10 N/mm, so less is a mistaken unit.
    constexpr double kLeastPull = 1e-3;
    constexpr double kLargestMm = 1e4; ///< larger than any patient; more is a mistaken unit

    [[noreturn]] void refuse(const std::string& what, const std::string& where) { throw InputError(what, where); }

    void check_number(double value, double low, double high, const std::string& where)
    {
        if (!(value >= low && value <= high))
            refuse("must be between " + std::to_string(low) + " and " + std::to_string(high) + ", got "
                    + std::to_string(value),
                where);
    }

    void check_positive(double value, const std::string& where)
    {
        if (!(value > 0.0 && value <= kLargestMm))
            refuse(
                "must be positive and at most " + std::to_string(kLargestMm) + ", got " + std::to_string(value), where);
    }

    void check_point(const Vec3& point, const std::string& where)
    {
        if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kLargestMm)
            refuse("must be a finite point in mm", where);
    }

    void check_unit(const Vec3& direction, const std::string& where)
    {
        if (!direction.allFinite() || std::abs(direction.norm() - 1.0) > kUnitTolerance)
            refuse("must be a unit vector", where);
    }

    void check_line(const Approach& approach, const std::string& pointer)
    {
        if (approach.incision.size() < 2)
            refuse("an incision needs at least two points", pointer + "/incision_mm");
        for (std::size_t n = 0; n < approach.incision.size(); ++n) {
            const std::string where = pointer + "/incision_mm/" + std::to_string(n);
            check_point(approach.incision[n], where);
            if (n > 0 && !((approach.incision[n] - approach.incision[n - 1]).norm() > 1e-3))
                refuse("two neighbouring points of the incision are the same", where);
        }
        if (approach.directions.size() != approach.incision.size())
            refuse("needs one direction per incision point", pointer + "/directions");
        for (std::size_t n = 0; n < approach.directions.size(); ++n)
            check_unit(approach.directions[n], pointer + "/directions/" + std::to_string(n));
    }

    void check_profile(const std::vector<double>& values, std::size_t points, const std::string& where)
    {
        if (!values.empty() && values.size() != points)
            refuse("needs one value per incision point, or none", where);
        for (std::size_t n = 0; n < values.size(); ++n)
            check_number(values[n], 0.0, kLargestMm, where + "/" + std::to_string(n));
    }

    void check_hook(const HookSpec& hook, double length, const std::string& where)
    {
        if (hook.name.empty())
            refuse("a hook needs a name", where + "/name");
        if (hook.side != 1 && hook.side != -1)
            refuse("must be 1 or -1, got " + std::to_string(hook.side), where + "/side");
        check_number(hook.along_mm, 0.0, length, where + "/along_mm");
        check_number(hook.depth_mm, 0.0, kLargestMm, where + "/depth_mm");
        check_positive(hook.patch_width_mm, where + "/patch_width_mm");
        check_positive(hook.patch_height_mm, where + "/patch_height_mm");
        check_unit(hook.direction, where + "/direction");
        check_number(hook.opening_mm, 0.0, fem::kFarthestHookMm, where + "/opening_mm");
        check_pull(hook.pull, where + "/");
        if (hook.pull.force_N && hook.opening_mm != 0.0)
            refuse("a hook that pulls with a force goes as far as that takes it: leave one of the two out",
                where + "/opening_mm, " + where + "/force_N");
    }

    void check_ablation(const AblationSpec& ablation, double length, const std::string& where)
    {
        if (ablation.is_ball() || ablation.radius_mm != 0.0) {
            check_point(ablation.centre, where + "/centre_mm");
            check_positive(ablation.radius_mm, where + "/radius_mm");
            return;
        }
        if (ablation.label.empty())
            refuse("a segment needs a label", where + "/label");
        check_number(ablation.from_mm, -kLargestMm, kLargestMm, where + "/from_mm");
        check_number(ablation.to_mm, -kLargestMm, kLargestMm, where + "/to_mm");
        if (!(ablation.from_mm < ablation.to_mm))
            refuse("must be more than from_mm", where + "/to_mm");
        const double from = ablation.along_from_mm.value_or(0.0), to = ablation.along_to_mm.value_or(length);
        check_number(from, 0.0, length, where + "/along_from_mm");
        check_number(to, 0.0, length, where + "/along_to_mm");
        if (!(from < to))
            refuse("must be more than along_from_mm", where + "/along_to_mm");
    }

    constexpr std::array<std::pair<LoosePieces, std::string_view>, 3> kLoosePieces { {
        { LoosePieces::held, "held" },
        { LoosePieces::removed, "removed" },
        { LoosePieces::rigid, "rigid" },
    } };

} // namespace

std::string ablation_text(const AblationSpec& ablation, double incision_length_mm)
{
    const std::string label = ablation.label.empty() ? "tissue" : ablation.label;
    if (ablation.is_ball())
        return label
            + formatted(" in a ball of %.1f mm at (%.0f, %.0f, %.0f)", ablation.radius_mm, ablation.centre.x(),
                ablation.centre.y(), ablation.centre.z());
    return label
        + formatted(" from %.1f to %.1f mm across and %.1f to %.1f mm along the incision", ablation.from_mm,
            ablation.to_mm, ablation.along_from_mm.value_or(0.0), ablation.along_to_mm.value_or(incision_length_mm));
}

std::string_view to_string(LoosePieces policy)
{
    return std::find_if(kLoosePieces.begin(), kLoosePieces.end(), [&](const auto& p) {
        return p.first == policy;
    })->second;
}

std::optional<LoosePieces> loose_pieces_from_string(std::string_view text)
{
    for (const auto& [policy, name] : kLoosePieces)
        if (name == text)
            return policy;
    return std::nullopt;
}

mesh::CutOptions cut_options_of(const Approach& approach, const mesh::LabelTable& table)
{
    return { .uncut_labels = mesh::label_ids(table, approach.uncut_labels) };
}

mesh::Blade blade_of(const Approach& approach)
{
    return { .line = approach.incision, .directions = approach.directions, .depth_mm = approach.depth_mm };
}

mesh::MeshSizing mesh_sizing_of(const Approach& approach, const mesh::LabelTable& table)
{
    mesh::MeshSizing sizing { .corridor = approach.incision,
        .corridor_radius_mm = approach.sizing.corridor_radius_mm,
        .corridor_edge_mm = approach.sizing.corridor_edge_mm,
        .coarse_edge_mm = approach.sizing.coarse_edge_mm,
        .region_mm = approach.sizing.region_mm,
        .whole_labels = {} };
    for (std::size_t n = approach.incision.size(); n-- > 0;)
        sizing.corridor.push_back(approach.incision[n] + 0.5 * approach.depth_mm * approach.directions[n].normalized());
    const auto& uncut = approach.uncut_labels;
    for (const mesh::LabelInfo& info : table) {
        const bool is_whole_sternum
            = info.name == "sternum" && std::find(uncut.begin(), uncut.end(), info.name) != uncut.end();
        if (info.role == mesh::Role::wall && is_skeleton(info) && !is_whole_sternum)
            sizing.whole_labels.push_back(info.id);
    }
    return sizing;
}

double incision_length(const Approach& approach)
{
    double length = 0.0;
    for (std::size_t n = 1; n < approach.incision.size(); ++n)
        length += (approach.incision[n] - approach.incision[n - 1]).norm();
    return length;
}

IncisionPlace incision_place(const Approach& approach, double along_mm)
{
    const auto& line = approach.incision;
    RETRACTOR_ASSERT(line.size() >= 2);
    for (std::size_t n = 0;; ++n) {
        const double length = (line[n + 1] - line[n]).norm();
        if (along_mm <= length || n + 2 == line.size())
            return { n, std::clamp(along_mm / length, 0.0, 1.0) };
        along_mm -= length;
    }
}

void check_sizing(const SizingSpec& sizing, const std::string& pointer)
{
    check_positive(sizing.corridor_radius_mm, pointer + "/corridor_radius_mm");
    check_positive(sizing.corridor_edge_mm, pointer + "/corridor_edge_mm");
    check_positive(sizing.coarse_edge_mm, pointer + "/coarse_edge_mm");
    if (sizing.coarse_edge_mm < sizing.corridor_edge_mm)
        refuse("must not be finer than the corridor", pointer + "/coarse_edge_mm");
    check_number(sizing.region_mm, 0.0, kLargestMm, pointer + "/region_mm");
}

void check_pull(const HookPull& pull, const std::string& where)
{
    const std::pair<const std::optional<double>*, const char*> numbers[] = { { &pull.force_N, "force_N" },
        { &pull.force_limit_N, "force_limit_N" }, { &pull.grip_N_per_mm, "grip_N_per_mm" } };
    for (const auto& [number, key] : numbers)
        if (*number) {
            check_positive(**number, where + key);
            if (**number < kLeastPull)
                refuse("a hook that pulls with less than a thousandth holds nothing: leave it out", where + key);
        }
    if (pull.force_N && pull.force_limit_N)
        refuse("a hook that pulls with a force does not yield: leave one of the two out",
            where + "force_N, " + where + "force_limit_N");
    if (pull.force_N && pull.grip_N_per_mm)
        refuse("a hook that pulls with a force moves the lip by it, however it grips: leave one of the two out",
            where + "force_N, " + where + "grip_N_per_mm");
}

void check_approach(const Approach& approach, const std::string& pointer)
{
    if (approach.name.empty())
        refuse("an approach needs a name", pointer + "/name");
    for (const char c : approach.name) // names become names of files
        if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20)
            refuse("a name must not hold slashes or control characters", pointer + "/name");
    if (approach.name.front() == '.')
        refuse("a name must not begin with a dot", pointer + "/name");
    check_line(approach, pointer);
    check_positive(approach.depth_mm, pointer + "/depth_mm");
    check_profile(approach.wall_thickness_mm, approach.incision.size(), pointer + "/wall_thickness_mm");
    check_profile(approach.hook_depth_mm, approach.incision.size(), pointer + "/hook_depth_mm");
    if (approach.target.is_sphere()) {
        check_point(approach.target.centre, pointer + "/target/centre_mm");
        check_positive(approach.target.radius_mm, pointer + "/target/radius_mm");
    }
    for (std::size_t h = 0; h < approach.hooks.size(); ++h) {
        const std::string where = pointer + "/hooks/" + std::to_string(h);
        check_hook(approach.hooks[h], incision_length(approach), where);
        for (std::size_t other = 0; other < h; ++other)
            if (approach.hooks[other].name == approach.hooks[h].name)
                refuse("two hooks are named \"" + approach.hooks[h].name + "\"", where + "/name");
    }
    for (std::size_t n = 0; n < approach.ablations.size(); ++n)
        check_ablation(approach.ablations[n], incision_length(approach), pointer + "/ablations/" + std::to_string(n));
    check_sizing(approach.sizing, pointer + "/sizing");
    check_positive(approach.view.eye_distance_mm, pointer + "/view/eye_distance_mm");
    check_number(approach.view.half_angle_deg, 0.0, 89.0, pointer + "/view/half_angle_deg");
    if (approach.view.eye_count < 1 || approach.view.eye_count > 100000)
        refuse("must be between 1 and 100000", pointer + "/view/eye_count");
}

} // namespace retractor::planner
