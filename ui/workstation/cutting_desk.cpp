#include "ui/workstation/cutting_desk.h"

#include "mesh/base/error.h"
#include "mesh/skeleton.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor {

namespace {

    /// A line shorter than this is a click, not a cut.
    constexpr double kShortestCutMm = 1.0;
    /// Through the wall means a little beyond it: the wall is uneven.
    constexpr double kBeyondWallMm = 3.0;
    /// Where the line leaves the skin and comes back, it is bridged up to this length, no further.
    constexpr double kLongestGapMm = 25.0;
    /// How much of the knife's former direction a step keeps: a hand does not turn the blade at every bump.
    constexpr double kSteadiness = 0.5;

    std::vector<Label> skeleton_labels(const LabelTable& table)
    {
        std::vector<Label> labels;
        for (const LabelInfo& info : table)
            if (is_skeleton(info))
                labels.push_back(info.id);
        return labels;
    }

    std::string label_name(const LabelTable& table, Label label)
    {
        const LabelInfo* info = find_label(table, label);
        return info == nullptr ? "nothing" : info->name;
    }

    CutSession open_session(TetMesh wall, const Job& job)
    {
        const Stopwatch watch;
        const std::size_t bytes = static_cast<std::size_t>(wall.vertices.size()) * sizeof(double)
            + wall.nodes.size() * sizeof(VertexId) + wall.labels.size() * sizeof(Label);
        CutSession session(std::move(wall));
        record_part(job, "cutting session", watch, bytes);
        return session;
    }

    WallSurface surface_of(const CutSession& session)
    {
        SlotMap map;
        const TetMesh mesh = session.compact_mesh(&map);
        WallSurface surface;
        surface.rest = Points::Zero(static_cast<Eigen::Index>(map.compact_vertex.size()), 3);
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
            surface.rest.row(map.vertex_slot[v]) = mesh.vertices.row(static_cast<Eigen::Index>(v));
        std::vector<std::array<bool, 4>> lip(map.compact_tet.size());
        for (const LipFace& face : session.lips())
            lip[static_cast<std::size_t>(face.face.tet)][static_cast<std::size_t>(face.face.corner)] = true;
        for (const TetFace& face : boundary_faces(mesh)) {
            auto corner = face_vertices(mesh, face);
            for (VertexId& v : corner)
                v = map.vertex_slot[static_cast<std::size_t>(v)];
            surface.triangles.push_back(corner);
            surface.labels.push_back(mesh.labels[static_cast<std::size_t>(face.tet)]);
            const auto slot = static_cast<std::size_t>(map.tet_slot[static_cast<std::size_t>(face.tet)]);
            surface.is_lip.push_back(lip[slot][static_cast<std::size_t>(face.corner)] ? 1 : 0);
        }
        return surface;
    }

} // namespace

struct CuttingDesk::Stroke {
    Touch begin;
    KnifeSettings settings;
    Blade blade; ///< line and directions: what was accepted, the first point included
    CutOptions options;
    Vec3 tip = Vec3::Zero(); ///< the last point drawn, cut or not
    Vec3 tip_direction = Vec3::UnitY();
    std::string left_out; ///< why some of the line was not cut; empty: all was
};

CuttingDesk::CuttingDesk(OperatingTable table, const Job& job)
    : labels_(std::move(table.labels))
    , skeleton_(skeleton_labels(labels_))
    , session_(open_session(std::move(table.wall), job))
{
}

bool CuttingDesk::is_skeleton_label(Label label) const
{
    return std::find(skeleton_.begin(), skeleton_.end(), label) != skeleton_.end();
}

KnifeAnswer CuttingDesk::begin_stroke(const Touch& at, const KnifeSettings& settings)
{
    if (stroke_open())
        throw InputError("a stroke is open: finish it first");
    if (!settings.through_wall && !(std::isfinite(settings.depth_mm) && settings.depth_mm > 0.0))
        throw InputError("the depth must be positive", "depth_mm");
    if (at.on_lip)
        return { false, "the knife is in a wound: begin on the skin" };
    if (!settings.cuts_bone && is_skeleton_label(at.label))
        return { false, label_name(labels_, at.label) + " lies bare here: the knife does not cut it" };
    double depth = settings.depth_mm;
    if (settings.through_wall) {
        const auto thickness = thickness_near(*picture()->surface, at);
        if (!thickness)
            return { false, "the wall has no far side here: give a depth" };
        depth = *thickness + kBeyondWallMm;
    }
    stroke_ = std::make_shared<Stroke>();
    stroke_->begin = at;
    stroke_->settings = settings;
    stroke_->tip = at.rest;
    stroke_->tip_direction = at.inward;
    stroke_->blade.line = { at.rest };
    stroke_->blade.directions = { at.inward };
    stroke_->blade.depth_mm = depth;
    if (!settings.cuts_bone)
        stroke_->options.uncut_labels = skeleton_;
    return { true, {} };
}

KnifeAnswer CuttingDesk::draw_to(const Touch& at)
{
    if (!stroke_open())
        throw InputError("there is no stroke to draw on");
    if (at.on_lip) // across an earlier wound: the line goes on where the skin does
        return { true, {} };
    Stroke& stroke = *stroke_;
    if ((at.rest - stroke.tip).norm() > kLongestGapMm) {
        stroke.left_out = "the line jumps: draw on the skin";
        return { false, stroke.left_out };
    }
    stroke.tip = at.rest;
    stroke.tip_direction = at.inward;
    const Vec3 from = stroke.blade.line.back();
    const Vec3 way = at.rest - from;
    const auto steps = static_cast<int>(std::floor(way.norm() / kStepMm));
    if (steps < 1)
        return { true, {} };
    std::vector<Vec3> points, directions;
    Vec3 direction = stroke.blade.directions.back();
    for (int i = 1; i <= steps; ++i) {
        points.push_back(from + i * kStepMm / way.norm() * way);
        direction = (kSteadiness * direction + (1.0 - kSteadiness) * at.inward).normalized();
        directions.push_back(direction);
    }
    return cut_to(std::move(points), std::move(directions));
}

KnifeAnswer CuttingDesk::cut_to(std::vector<Vec3> points, std::vector<Vec3> directions)
{
    Stroke& stroke = *stroke_;
    Blade longer = stroke.blade;
    longer.line.insert(longer.line.end(), points.begin(), points.end());
    longer.directions.insert(longer.directions.end(), directions.begin(), directions.end());
    const Stopwatch watch;
    try {
        const CutResult result = session_.extend_stroke(longer, stroke.options);
        if (result.status != CutStatus::done)
            return { false, result.message };
        stroke.blade = std::move(longer);
        step_ms_ = 1e3 * watch.seconds();
        picture_.reset();
        return { true, {} };
    } catch (const InputError& error) {
        stroke.left_out = error.what();
        return { false, stroke.left_out };
    }
}

KnifeAnswer CuttingDesk::finish_stroke()
{
    if (!stroke_open())
        throw InputError("there is no stroke to finish");
    Stroke& stroke = *stroke_;
    if ((stroke.tip - stroke.blade.line.back()).norm() >= kShortestCutMm)
        (void)cut_to({ stroke.tip }, { (stroke.blade.directions.back() + stroke.tip_direction).normalized() });
    if (!session_.stroke_open()) {
        const std::string reason = stroke.left_out.empty() ? "the knife did not move: draw a line on the skin"
                                                           : "nothing was cut: " + stroke.left_out;
        stroke_.reset();
        return { false, reason };
    }
    const Stopwatch watch;
    const std::shared_ptr<Stroke> ended = std::exchange(stroke_, nullptr);
    const CutResult result = session_.finish_stroke();
    step_ms_ = 1e3 * watch.seconds();
    picture_.reset();
    if (result.status != CutStatus::done)
        return { false, result.message };
    std::erase_if(cuts_, [](const CutEntry& cut) { return !cut.in_force; });
    CutEntry entry {
        .number = static_cast<int>(cuts_.size()) + 1, .depth_mm = ended->blade.depth_mm, .report = result.report
    };
    for (std::size_t i = 1; i < ended->blade.line.size(); ++i)
        entry.length_mm += (ended->blade.line[i] - ended->blade.line[i - 1]).norm();
    cuts_.push_back(entry);
    return { true, ended->left_out.empty() ? std::string {} : "a part of the line was left out: " + ended->left_out };
}

void CuttingDesk::abandon_stroke()
{
    if (!stroke_open())
        return;
    stroke_.reset();
    if (!session_.stroke_open())
        return;
    (void)session_.abandon_stroke();
    picture_.reset();
}

void CuttingDesk::undo()
{
    (void)session_.undo();
    cuts_[session_.cut_count()].in_force = false;
    picture_.reset();
}

void CuttingDesk::redo()
{
    (void)session_.redo();
    cuts_[session_.cut_count() - 1].in_force = true;
    picture_.reset();
}

std::shared_ptr<const WallPicture> CuttingDesk::picture()
{
    if (picture_ == nullptr) {
        auto made = std::make_shared<WallPicture>();
        auto surface = std::make_shared<const WallSurface>(surface_of(session_));
        made->shown = surface->rest;
        made->surface = std::move(surface);
        picture_ = std::move(made);
    }
    return picture_;
}

} // namespace retractor
