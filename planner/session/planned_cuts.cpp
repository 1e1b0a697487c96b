#include "planner/session/planned_cuts.h"

#include "mesh/base/error.h"
#include "planner/wall/division_cut.h"
#include "planner/wall/wall_cut.h"

#include <cstddef>
#include <optional>

namespace retractor::planner {

namespace {

    /// The last cut of the session, as a restored session reads it.
    mesh::MeshDelta last_delta(mesh::CutSession& session)
    {
        (void)session.undo();
        return session.redo();
    }

    /// Makes one stroke of the division; nothing: it cannot be made, and the session is as before.
    std::optional<DividedTissue> divide_one(mesh::CutSession& session, Approach approach, const DivisionStroke& stroke,
        const mesh::LabelTable& labels, const Job& job)
    {
        approach.division.strokes = { stroke };
        const std::size_t cuts = session.cut_count();
        try {
            return divide_beyond_skin(session, approach, labels, job).divided;
        } catch (const SolverError&) {
            while (session.cut_count() > cuts) // a stroke that severed nothing
                (void)session.undo();
            return std::nullopt;
        }
    }

} // namespace

CutEntry entry_of(const mesh::Blade& blade, const mesh::CutReport& report)
{
    CutEntry entry { .depth_mm = blade.depth_mm, .report = report };
    for (std::size_t i = 1; i < blade.line.size(); ++i)
        entry.length_mm += (blade.line[i] - blade.line[i - 1]).norm();
    entry.blade = blade;
    return entry;
}

CutEntry entry_of(const DivisionStroke& stroke, const DividedTissue& divided)
{
    CutEntry entry { .length_mm = stroke.length_mm, .depth_mm = stroke.depth_mm, .divides = stroke.way };
    entry.report.lip_area_mm2 = divided.severed_mm2;
    return entry;
}

std::vector<CutEntry> recognise_planned_cuts(const mesh::TetMesh& wall, const Approach& approach,
    const mesh::LabelTable& labels, std::span<const mesh::MeshDelta> cuts, const Job& job)
{
    std::vector<CutEntry> planned;
    if (cuts.empty() || approach.incision.size() < 2)
        return planned;
    try {
        mesh::CutSession session(wall);
        const mesh::Blade blade = blade_of(approach);
        const mesh::CutResult made = session.cut(blade, cut_options_of(approach, labels), job);
        if (made.status != mesh::CutStatus::done || last_delta(session) != cuts.front())
            return planned;
        planned.push_back(entry_of(blade, made.report));
        planned.back().as_planned = true;
        for (const DivisionStroke& stroke : approach.division.strokes) {
            if (planned.size() == cuts.size())
                break;
            const std::optional<DividedTissue> divided = divide_one(session, approach, stroke, labels, job);
            if (!divided) // this way could not be divided when the cuts were made either
                continue;
            if (last_delta(session) != cuts[planned.size()])
                break;
            planned.push_back(entry_of(stroke, *divided));
        }
    } catch (const Error&) { // the next one cannot be made, so it was not; those before were
    }
    return planned;
}

} // namespace retractor::planner
