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
    constexpr double kFinePlacesMm = 10.0; ///< spacing of the fine places of the mesh along a patch
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
            refuse("a hook takes either a force or an opening, not both: remove one",
                where + "/opening_mm, " + where + "/force_N");
    }

    /// The hooks can open a wound no farther than its lips are long and can be stretched.
    void check_reach(double opening_mm, const Approach& approach, const std::string& where)
    {
        constexpr double kTearingStretch = 1.71; // skin fails at a strain of 54 +- 17 % [arXiv 1302.3022]
        const double length = incision_length(approach);
        if (opening_mm > kTearingStretch * length)
            refuse(formatted("not attainable: hooks open %.0f mm, but the skin of an incision of %.0f mm tears before "
                             "%.0f mm: open less, "
                             "or make the incision longer",
                       opening_mm, length, kTearingStretch * length),
                where);
    }

    void check_openings(const Approach& approach, const std::string& pointer)
    {
        double left = 0.0, right = 0.0;
        for (const HookSpec& hook : approach.hooks)
            (hook.side > 0 ? left : right) = std::max(hook.side > 0 ? left : right, hook.opening_mm);
        check_reach(left + right, approach, pointer + "/hooks");
    }

    void check_retractor(const RetractorSpec& retractor, const Approach& approach, const std::string& where)
    {
        if (!approach.hooks.empty())
            refuse("an approach has either hooks or a retractor, not both: remove one", where);
        if (retractor.kind.empty())
            refuse("a retractor needs the name of its kind", where + "/kind");
        if (retractor.force_N && retractor.opening_mm != 0.0)
            refuse("a retractor takes either a force or an opening, not both: remove one",
                where + "/opening_mm, " + where + "/force_N");
        if (retractor.force_N) {
            check_positive(*retractor.force_N, where + "/force_N");
            if (*retractor.force_N < kLeastPull)
                refuse("must be at least 0.001: a retractor with less holds no tissue", where + "/force_N");
        }
        const double length = incision_length(approach);
        check_number(retractor.along_mm, 0.0, length, where + "/along_mm");
        check_positive(retractor.blade_width_mm, where + "/blade_width_mm");
        if (retractor.blade_width_mm > length)
            refuse(formatted("a blade of %.0f mm does not fit into an incision of %.0f mm: take another retractor, or "
                             "make the incision longer",
                       retractor.blade_width_mm, length),
                where + "/blade_width_mm");
        check_positive(retractor.blade_depth_mm, where + "/blade_depth_mm");
        check_number(retractor.play_deg, 0.0, 90.0, where + "/play_deg");
        check_number(retractor.greatest_opening_mm, 0.0, 2.0 * fem::kFarthestHookMm, where + "/greatest_opening_mm");
        if (!(retractor.opening_mm >= 0.0 && retractor.opening_mm <= retractor.greatest_opening_mm))
            refuse(formatted("this retractor opens at most %.0f mm, not %.0f mm", retractor.greatest_opening_mm,
                       retractor.opening_mm),
                where + "/opening_mm");
        check_reach(retractor.opening_mm, approach, where + "/opening_mm");
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

    /// Edges along the divided space, relative to those at the incision: nobody looks in there, and no hook pulls
    /// there.
    constexpr double kDividedEdge = 1.5;

    /// The path along the divided space. The corridor ends half way down the blade at the incision's start: the path
    /// goes out and back along a stroke that begins there, then along the incision, and out along the other stroke.
    std::vector<Vec3> divided_path(const Approach& approach)
    {
        if (approach.division.strokes.empty())
            return {};
        std::vector<Vec3> path;
        const auto add_stroke = [&](bool at_start) {
            for (const DivisionStroke& stroke : approach.division.strokes) {
                RETRACTOR_ASSERT(!stroke.line.empty() && stroke.directions.size() == stroke.line.size());
                const Vec3& from = stroke.line.front();
                if (((from - approach.incision.front()).norm() <= (from - approach.incision.back()).norm()) != at_start)
                    continue;
                const std::size_t first = path.size();
                for (std::size_t n = 0; n < stroke.line.size(); ++n)
                    path.push_back(stroke.line[n] + 0.5 * stroke.depth_mm * stroke.directions[n]);
                for (std::size_t n = path.size(); at_start && n-- > first + 1;)
                    path.push_back(Vec3(path[n - 1]));
            }
        };
        add_stroke(true);
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            path.push_back(approach.incision[n] + 0.5 * approach.depth_mm * approach.directions[n]);
        add_stroke(false);
        return path;
    }

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

std::string_view to_string(HookHold hold) { return hold == HookHold::fixed ? "fixed" : "contact"; }

std::optional<HookHold> hook_hold_from_string(std::string_view text)
{
    for (const HookHold hold : { HookHold::fixed, HookHold::contact })
        if (to_string(hold) == text)
            return hold;
    return std::nullopt;
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

std::string instrument_name(const std::string& kind)
{
    if (kind == "finochietto")
        return "Finochietto rib spreader";
    if (kind == "sternal")
        return "sternal spreader";
    if (kind == "midcab")
        return "MIDCAB retractor";
    const bool says_what = kind.ends_with("retractor") || kind.ends_with("spreader");
    return says_what ? kind : kind + " retractor";
}

std::string target_name(const TargetSpec& target)
{
    if (target.is_sphere())
        return "sphere";
    return target.is_site() ? target.site + " on " + target.label : target.label;
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
        .fine_edge_mm = approach.sizing.patch_edge_mm,
        .coarse_path = divided_path(approach),
        .coarse_path_edge_mm
        = std::min(kDividedEdge * approach.sizing.corridor_edge_mm, approach.sizing.coarse_edge_mm),
        .region_mm = approach.sizing.region_mm.value_or(kFirstRegionMm),
        .coarse_beyond_mm = approach.sizing.coarse_beyond_mm,
        .whole_labels = {},
        .seed = approach.sizing.mesh_seed };
    for (std::size_t n = approach.incision.size(); n-- > 0;)
        sizing.corridor.push_back(approach.incision[n] + 0.5 * approach.depth_mm * approach.directions[n].normalized());
    for (const HookSpec& hook : approach.hooks) {
        const PatchPlace patch = patch_place(approach, hook);
        const int count = std::max(1, static_cast<int>(std::lround(hook.patch_width_mm / kFinePlacesMm)));
        for (int n = 0; n < count; ++n)
            sizing.fine_places.push_back(patch.centre + hook.patch_width_mm * ((n + 0.5) / count - 0.5) * patch.along);
    }
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

PatchPlace patch_place(const Approach& approach, const HookSpec& hook)
{
    const IncisionPlace place = incision_place(approach, hook.along_mm);
    const Vec3 depth = place.of(approach.directions).normalized();
    const Vec3 step = approach.incision[place.segment + 1] - approach.incision[place.segment];
    // A blade is straight and square to its rack; a hook lies along its piece of the incision.
    const Vec3 along = approach.retractor ? depth.cross(hook.side * hook.direction) : step;
    return { place.of(approach.incision) + hook.depth_mm * depth, along.normalized(), depth };
}

SizingSpec with_scaled_edges(SizingSpec sizing, double factor)
{
    RETRACTOR_ASSERT(factor > 0.0);
    sizing.corridor_edge_mm *= factor;
    sizing.coarse_edge_mm *= factor;
    sizing.patch_edge_mm *= factor;
    return sizing;
}

SizingSpec found_sizing(SizingSpec sizing, double region_mm)
{
    sizing.region_mm = region_mm;
    sizing.coarse_beyond_mm = region_mm > kFirstRegionMm ? kCoarseBeyondMm : 0.0;
    return sizing;
}

void check_sizing(const SizingSpec& sizing, const std::string& pointer)
{
    check_positive(sizing.corridor_radius_mm, pointer + "/corridor_radius_mm");
    check_positive(sizing.corridor_edge_mm, pointer + "/corridor_edge_mm");
    check_positive(sizing.coarse_edge_mm, pointer + "/coarse_edge_mm");
    if (sizing.coarse_edge_mm < sizing.corridor_edge_mm)
        refuse("must not be finer than the corridor", pointer + "/coarse_edge_mm");
    if (sizing.region_mm)
        check_number(*sizing.region_mm, 0.0, kLargestMm, pointer + "/region_mm");
    check_number(sizing.coarse_beyond_mm, 0.0, kLargestMm, pointer + "/coarse_beyond_mm");
}

void check_pull(const HookPull& pull, const std::string& where)
{
    const std::pair<const std::optional<double>*, const char*> numbers[] = { { &pull.force_N, "force_N" },
        { &pull.force_limit_N, "force_limit_N" }, { &pull.grip_N_per_mm, "grip_N_per_mm" } };
    for (const auto& [number, key] : numbers)
        if (*number) {
            check_positive(**number, where + key);
            if (**number < kLeastPull)
                refuse("must be at least 0.001: a hook with less holds no tissue", where + key);
        }
    if (pull.force_N && pull.force_limit_N)
        refuse("a hook takes either a force or a force limit, not both: remove one",
            where + "force_N, " + where + "force_limit_N");
    if (pull.force_N && pull.grip_N_per_mm)
        refuse("a hook takes either a force or a soft grip, not both: remove one",
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
    for (const char c : approach.title)
        if (static_cast<unsigned char>(c) < 0x20)
            refuse("a title must not hold control characters", pointer + "/title");
    if (!approach.title.empty() && approach.title.find_first_not_of(' ') == std::string::npos)
        refuse("a title must not be blank", pointer + "/title");
    check_line(approach, pointer);
    check_positive(approach.depth_mm, pointer + "/depth_mm");
    check_profile(approach.wall_thickness_mm, approach.incision.size(), pointer + "/wall_thickness_mm");
    check_profile(approach.hook_depth_mm, approach.incision.size(), pointer + "/hook_depth_mm");
    if (approach.target.is_site())
        for (const char c : approach.target.site)
            if (static_cast<unsigned char>(c) < 0x20)
                refuse("the words for a site must not hold control characters", pointer + "/target/site");
    if (approach.target.normal) {
        check_point(*approach.target.normal, pointer + "/target/normal");
        if (!(approach.target.normal->norm() > 0.0))
            refuse("must not be zero", pointer + "/target/normal");
        if (!approach.target.is_site())
            refuse("only a site has a normal", pointer + "/target/normal");
    }
    if (approach.target.is_sphere() || approach.target.is_site()) {
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
    check_openings(approach, pointer);
    check_division(approach.division, pointer + "/division");
    if (approach.retractor)
        check_retractor(*approach.retractor, approach, pointer + "/retractor");
    if (approach.opening_protocol)
        check_opening_protocol(*approach.opening_protocol, pointer + "/opening_protocol");
    for (std::size_t n = 0; n < approach.ablations.size(); ++n)
        check_ablation(approach.ablations[n], incision_length(approach), pointer + "/ablations/" + std::to_string(n));
    check_sizing(approach.sizing, pointer + "/sizing");
    check_positive(approach.view.eye_distance_mm, pointer + "/view/eye_distance_mm");
    check_number(approach.view.half_angle_deg, 0.0, 89.0, pointer + "/view/half_angle_deg");
    if (approach.view.eye_count < 1 || approach.view.eye_count > 100000)
        refuse("must be between 1 and 100000", pointer + "/view/eye_count");
}

} // namespace retractor::planner
