#include "planner/wall/division_cut.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/cutting/store/blade.h"
#include "planner/case/division.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    /// Distances by which the tried strokes begin inside the incision. The first stroke meets the wound in its end
    /// line, and needs no element twice; the others lie in the wound for a short way.
    constexpr double kInsetsMm[] = { 0.0, 1.5, 3.0 };

    /// The stroke's blade, begun on the blade of the skin cut at a distance before the incision's end.
    mesh::Blade begun_inside(const DivisionStroke& stroke, const Approach& approach, double inset_mm)
    {
        mesh::Blade blade = blade_of(stroke);
        if (inset_mm == 0.0)
            return blade;
        const mesh::SweptBlade skin_cut(blade_of(approach));
        const Vec3& from = stroke.line.front();
        const bool at_start = (from - approach.incision.front()).norm() <= (from - approach.incision.back()).norm();
        const Vec3& end = at_start ? approach.incision.front() : approach.incision.back();
        const double inset = std::min(inset_mm, 0.5 * skin_cut.length());
        const double along = at_start ? inset : skin_cut.length() - inset;
        const Vec3 skin = skin_cut.at(along, 0.0);
        const Vec3 inward = (skin_cut.at(along, skin_cut.depth()) - skin).normalized();
        // As deep below the skin as the stroke begins on the ray of the incision's end.
        blade.line.insert(blade.line.begin(), skin - (from - end).dot(stroke.directions.front()) * inward);
        blade.directions.insert(blade.directions.begin(), -inward);
        return blade;
    }

    [[noreturn]] void refuse(const DivisionStroke& stroke, const std::string& why)
    {
        const std::string way(to_string(stroke.way));
        const bool sternum = stroke.way == StrokeWay::right || stroke.way == StrokeWay::left;
        throw SolverError(sternum ? "the sternum could not be sawn across to the " + way + ": " + why
                    + "; move the incision's lower end, or divide no more than the skin"
                                  : "intercostal muscle and pleura could not be divided " + way + ": " + why
                    + "; give a shorter distance (" + way + "_mm of the division), or divide at skin length",
            "division/" + way);
    }

    double& length_of(DividedTissue& divided, StrokeWay way)
    {
        switch (way) {
        case StrokeWay::forwards:
            return divided.forwards_mm;
        case StrokeWay::backwards:
            return divided.backwards_mm;
        case StrokeWay::right:
            return divided.right_mm;
        case StrokeWay::left:
            break;
        }
        return divided.left_mm;
    }

    /// Makes one stroke. @returns a result with the status done or cancelled
    mesh::CutResult make_stroke(mesh::CutSession& session, const Approach& approach, const DivisionStroke& stroke,
        const mesh::CutOptions& options, const Job& job)
    {
        std::string why;
        for (const double inset : kInsetsMm)
            try {
                mesh::CutResult result = session.cut(begun_inside(stroke, approach, inset), options, job);
                if (result.status != mesh::CutStatus::missed_body)
                    return result;
                why = result.message;
                // An IoError does not come from the cutter and is not caught.
            } catch (const InputError& error) {
                why = error.what();
            } catch (const SolverError& error) {
                why = error.what();
            }
        refuse(stroke, why);
    }

} // namespace

mesh::CutOptions division_options(const Approach& approach, const DivisionStroke& stroke, const mesh::LabelTable& table)
{
    mesh::CutOptions options;
    for (const mesh::LabelInfo& info : table)
        if (std::find(stroke.severs.begin(), stroke.severs.end(), info.name) == stroke.severs.end()
            || std::find(approach.uncut_labels.begin(), approach.uncut_labels.end(), info.name)
                != approach.uncut_labels.end())
            options.uncut_labels.push_back(info.id);
    return options;
}

DivisionCut divide_beyond_skin(
    mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table, const Job& job)
{
    DivisionCut cut;
    if (approach.division.strokes.empty())
        return cut;
    DividedTissue divided { .labels = approach.division.strokes.front().severs,
        .length_mm = incision_length(approach) };
    for (const DivisionStroke& stroke : approach.division.strokes) {
        RETRACTOR_ASSERT(stroke.line.size() >= 2 && stroke.directions.size() == stroke.line.size());
        mesh::CutResult result = make_stroke(session, approach, stroke, division_options(approach, stroke, table), job);
        cut.status = result.status;
        if (cut.status != mesh::CutStatus::done)
            return cut;
        cut.deltas.push_back(std::move(result.delta));
        if (!(result.report.lip_area_mm2 > 0.0))
            refuse(stroke, "the blade severs none of this tissue");
        divided.severed_mm2 += result.report.lip_area_mm2;
        length_of(divided, stroke.way) += stroke.length_mm;
        divided.length_mm += stroke.length_mm;
    }
    divided.words = approach.division.words;
    cut.divided = std::move(divided);
    return cut;
}

} // namespace retractor::planner
