#include "planner/approach/sternum_division.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"
#include "planner/anatomy/body_probe.h"
#include "planner/case/division.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kSampleMm = 0.5; ///< along the blade's rays
    constexpr double kStepMm = 1.0; ///< across the sternum
    constexpr double kPointSpacingMm = 6.0; ///< between points of a stroke's line
    /// A gap in the bone that is wider than this is its edge.
    constexpr double kGapMm = 4.0;
    constexpr double kWidestMm = 80.0; ///< no sternum reaches farther from its midline
    constexpr double kBehindBoneMm = 60.0; ///< the bone lies within this distance below the skin
    /// Distance of the blade's line from the inner side of the wall. The line must lie in the chest.
    constexpr double kInsideMm = 4.0;
    constexpr double kBeyondBoneMm = 2.0; ///< distance of the blade's end beyond the bone's outer side

    /// Depths below the skin between which something lies.
    struct Layer {
        double from_mm = 0.0, to_mm = 0.0;
    };

    /// Where the incision ends, and the directions across the sternum.
    struct LowerEnd {
        Vec3 skin, inward, right;
    };

    LowerEnd lower_end(const Approach& approach, const Anatomy& anatomy)
    {
        const Vec3& up = anatomy.sternum.axis;
        const bool last = approach.incision.back().dot(up) < approach.incision.front().dot(up);
        LowerEnd end { .skin = last ? approach.incision.back() : approach.incision.front(),
            .inward = (last ? approach.directions.back() : approach.directions.front()).normalized(),
            .right = Vec3::Zero() };
        const Vec3 across = up.cross(end.inward).normalized();
        end.right = across.dot(anatomy.frame.left) < 0.0 ? across : Vec3(-across);
        return end;
    }

    /// The sternum below a point, along the blade's direction.
    std::optional<Layer> sternum_below(
        const mesh::LabelVolume& labels, Label sternum, const Vec3& from, const Vec3& inward)
    {
        std::optional<Layer> found;
        for (double t = 0.0; t <= kBehindBoneMm; t += kSampleMm)
            if (mesh::label_at(labels, from + t * inward) == sternum) {
                if (!found)
                    found = Layer { .from_mm = t };
                found->to_mm = t;
            }
        return found;
    }

    /// Where a stroke passes through the wall, as depths below a plane through the end of the incision.
    struct Passage {
        double across_mm = 0.0;
        Layer wall; ///< from the bone's outer side to the inner side of the wall
    };

    /// The inner side of the wall behind a place, at least behind the bone.
    double inner_side(const BodyProbe& probe, const Vec3& from, const Vec3& inward, const Layer& bone)
    {
        const Vec3 middle = from + 0.5 * (bone.from_mm + bone.to_mm) * inward;
        const std::optional<double> skin = probe.first_skin_along(middle, -inward);
        if (!skin)
            return bone.to_mm;
        const Vec3 above = middle - *skin * inward;
        const std::optional<double> wall = probe.wall_thickness(above, inward);
        return wall ? std::max(bone.to_mm, (above + *wall * inward - from).dot(inward)) : bone.to_mm;
    }

    /// From the incision to beyond the sternum's edge; empty where no sternum lies under the incision's end.
    std::vector<Passage> passages_across(
        const BodyProbe& probe, Label sternum, const LowerEnd& end, const Vec3& direction)
    {
        std::vector<Passage> passages;
        Layer bone;
        double edge = -1.0;
        for (double across = 0.0; across <= kWidestMm; across += kStepMm) {
            const Vec3 from = end.skin + across * direction;
            if (const auto below = sternum_below(probe.labels(), sternum, from, end.inward)) {
                bone = *below;
                edge = across;
            } else if (edge < 0.0 || across - edge > std::max(kGapMm, kBeyondSternumEdgeMm))
                break;
            passages.push_back({ .across_mm = across,
                .wall = { .from_mm = bone.from_mm, .to_mm = inner_side(probe, from, end.inward, bone) } });
        }
        std::erase_if(
            passages, [&](const Passage& passage) { return passage.across_mm > edge + kBeyondSternumEdgeMm + 1e-9; });
        return passages;
    }

    DivisionStroke stroke_of(const std::vector<Passage>& passages, const LowerEnd& end, StrokeWay way)
    {
        const Vec3 direction = way == StrokeWay::right ? end.right : Vec3(-end.right);
        DivisionStroke stroke { .way = way, .length_mm = passages.back().across_mm };
        for (const Passage& passage : passages)
            stroke.depth_mm
                = std::max(stroke.depth_mm, passage.wall.to_mm - passage.wall.from_mm + kInsideMm + kBeyondBoneMm);
        const int count = std::max(1, static_cast<int>(std::ceil(stroke.length_mm / kPointSpacingMm - 0.0123)));
        for (int n = 0; n <= count; ++n) {
            const std::size_t i = static_cast<std::size_t>(n) * (passages.size() - 1) / static_cast<std::size_t>(count);
            const Passage& passage = passages[i];
            // The blade ends beyond the bone's outer side everywhere.
            stroke.line.push_back(end.skin + passage.across_mm * direction
                + (passage.wall.from_mm - kBeyondBoneMm + stroke.depth_mm) * end.inward);
            stroke.directions.push_back(-end.inward);
        }
        return stroke;
    }

    bool is_uncut(const Approach& approach, const std::string& label)
    {
        return std::ranges::find(approach.uncut_labels, label) != approach.uncut_labels.end();
    }

    /// What the saw severs: the sternum, and the soft tissue of the wall but its skin.
    std::vector<std::string> severed_names(const mesh::LabelTable& table, const Approach& approach)
    {
        std::vector<std::string> names;
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_wall(info) && info.material != "skin" && (info.name == "sternum" || !mesh::is_skeleton(info))
                && !is_uncut(approach, info.name))
                names.push_back(info.name);
        return names;
    }

} // namespace

void find_sternum_division(Approach& approach, const mesh::LabelVolume& labels, const Anatomy& anatomy)
{
    Division& division = approach.division;
    division.strokes.clear();
    division.words.clear();
    if (!divides_sternum(division.extent))
        return;
    if (is_uncut(approach, "sternum")) {
        division.words = "this approach leaves the sternum whole: nothing is divided beyond the skin";
        return;
    }
    const mesh::LabelInfo* sternum = mesh::find_label(labels.table, "sternum");
    const LowerEnd end = lower_end(approach, anatomy);
    const BodyProbe probe(labels);
    std::string ways;
    for (const StrokeWay way : { StrokeWay::right, StrokeWay::left }) {
        if (division.extent == (way == StrokeWay::right ? DivisionExtent::sternum_left : DivisionExtent::sternum_right))
            continue;
        const std::vector<Passage> passages = sternum == nullptr
            ? std::vector<Passage>()
            : passages_across(probe, sternum->id, end, way == StrokeWay::right ? end.right : Vec3(-end.right));
        if (passages.size() < 2) {
            division.strokes.clear();
            division.words = "no sternum lies under the incision's lower end: nothing is divided beyond the skin";
            return;
        }
        division.strokes.push_back(stroke_of(passages, end, way));
        division.strokes.back().severs = severed_names(labels.table, approach);
        ways += formatted("%s to %.0f mm beyond its %s edge (%.0f mm)", ways.empty() ? "" : " and",
            kBeyondSternumEdgeMm, std::string(to_string(way)).c_str(), division.strokes.back().length_mm);
    }
    division.words = "under intact skin the sternum is sawn across from the lower end of the incision" + ways;
}

} // namespace retractor::planner
