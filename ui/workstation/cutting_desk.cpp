#include "ui/workstation/cutting_desk.h"

#include "fem/edge_springs.h"
#include "fem/pre_strain.h"
#include "fem/spring_relaxation.h"
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

    /// Out of the body, per element: the normal of the skin over it, carried inwards ring by ring; zero where no skin
    /// is joined to it.
    std::vector<Vec3> skin_normals(const TetMesh& mesh, const LabelTable& table)
    {
        std::vector<Vec3> sum(mesh.tet_count(), Vec3::Zero());
        for (const TetFace& face : boundary_faces(mesh)) {
            const LabelInfo* info = find_label(table, mesh.labels[static_cast<std::size_t>(face.tet)]);
            if (info == nullptr || info->material != "skin")
                continue;
            const auto v = face_vertices(mesh, face);
            const Vec3 a = mesh.vertices.row(v[0]), b = mesh.vertices.row(v[1]), c = mesh.vertices.row(v[2]);
            sum[static_cast<std::size_t>(face.tet)] += (b - a).cross(c - a);
        }
        std::vector<std::vector<TetId>> around(mesh.vertex_count());
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const VertexId v : mesh.tet(t))
                around[static_cast<std::size_t>(v)].push_back(t);
        std::vector<bool> known(mesh.tet_count());
        std::vector<TetId> front;
        for (std::size_t t = 0; t < sum.size(); ++t)
            if (sum[t].norm() > 0.0) {
                known[t] = true;
                front.push_back(static_cast<TetId>(t));
                sum[t].normalize();
            }
        while (!front.empty()) {
            std::vector<TetId> next;
            for (const TetId t : front)
                for (const VertexId v : mesh.tet(t))
                    for (const TetId other : around[static_cast<std::size_t>(v)]) {
                        const auto o = static_cast<std::size_t>(other);
                        if (known[o])
                            continue;
                        if (sum[o].isZero())
                            next.push_back(other);
                        sum[o] += sum[static_cast<std::size_t>(t)];
                    }
            std::sort(next.begin(), next.end());
            next.erase(std::unique(next.begin(), next.end()), next.end());
            for (const TetId t : next) {
                known[static_cast<std::size_t>(t)] = true;
                if (Vec3& s = sum[static_cast<std::size_t>(t)]; s.norm() > 0.0)
                    s.normalize();
            }
            front = std::move(next);
        }
        return sum;
    }

    std::string label_name(const LabelTable& table, Label label)
    {
        const LabelInfo* info = find_label(table, label);
        return info == nullptr ? "nothing" : info->name;
    }

    CutSession open_session(const TetMesh& wall, const Job& job)
    {
        const Stopwatch watch;
        const std::size_t bytes = static_cast<std::size_t>(wall.vertices.size()) * sizeof(double)
            + wall.nodes.size() * sizeof(VertexId) + wall.labels.size() * sizeof(Label);
        CutSession session(wall);
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
    , materials_(std::move(table.materials))
    , outward_(table.outward)
    , first_(std::make_shared<const TetMesh>(std::move(table.wall)))
    , skeleton_(skeleton_labels(labels_))
    , session_(open_session(*first_, job))
    , held_(first_->vertex_count(), 0)
{
    job_.ledger = job.ledger;
    for (const VertexId v : table.held)
        held_.at(static_cast<std::size_t>(v)) = 1;
}

CuttingDesk::~CuttingDesk() = default;
CuttingDesk::CuttingDesk(CuttingDesk&&) noexcept = default;
CuttingDesk& CuttingDesk::operator=(CuttingDesk&&) noexcept = default;

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
        follow(result.delta);
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
    follow(result.delta);
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
    follow(session_.abandon_stroke());
}

void CuttingDesk::undo()
{
    follow(session_.undo());
    cuts_[session_.cut_count()].in_force = false;
}

void CuttingDesk::redo()
{
    follow(session_.redo());
    cuts_[session_.cut_count() - 1].in_force = true;
}

void CuttingDesk::follow(const MeshDelta& delta)
{
    surface_.reset();
    picture_.reset();
    for (const MeshDelta::VertexBorn& born : delta.vertices_born) {
        const auto id = static_cast<std::size_t>(born.id);
        held_.resize(std::max(held_.size(), id + 1), 0);
        held_[id] = held_[static_cast<std::size_t>(born.a)] != 0 && held_[static_cast<std::size_t>(born.b)] != 0;
        if (born.a == born.b && born.a != born.id)
            parted_.emplace_back(born.a, born.id);
    }
    for (const MeshDelta::VertexBorn& gone : delta.vertices_gone)
        std::erase_if(parted_, [&](const auto& pair) { return pair.first == gone.id || pair.second == gone.id; });
    if (springs_ == nullptr)
        return;
    springs_->apply(delta);
    springs_->set_wound(session_.lips());
    moving_ = session_.cut_count() > 0 || session_.stroke_open();
    if (!moving_) // the wall is whole again: it lies as it lay
        springs_->set_displacement(Points::Zero(springs_->displacement().rows(), 3));
}

void CuttingDesk::set_tension(double strain)
{
    if (!(strain >= 0.0 && strain <= kLargestPreStrain))
        throw InputError("the tension must lie between 0 and " + std::to_string(kLargestPreStrain), "tension");
    if (strain == tension_)
        return;
    tension_ = strain;
    picture_.reset();
    moving_ = false;
    Points was;
    if (springs_ != nullptr)
        was = springs_->displacement();
    springs_.reset();
    if (tension_ == 0.0)
        return;
    make_springs();
    if (was.rows() == springs_->displacement().rows()) // goes on from where the wound stands
        springs_->set_displacement(was);
}

void CuttingDesk::make_springs()
{
    const Stopwatch watch;
    const std::vector<Vec3> normals = skin_normals(*first_, labels_);
    const PreStrain tension { .kind = PreStrainKind::equibiaxial, .strain = tension_ };
    std::vector<Mat3> stresses;
    stresses.reserve(normals.size());
    for (std::size_t t = 0; t < normals.size(); ++t) {
        const Label label = first_->labels[t];
        if (label >= materials_.size())
            throw InputError("there is no material for it", "label " + std::to_string(label));
        stresses.push_back(is_skeleton_label(label)
                ? Mat3(Mat3::Zero())
                : pre_stress(tension, materials_[label], normals[t].isZero() ? outward_ : normals[t]));
    }
    springs_ = std::make_unique<SpringNetwork>(session_, materials_, stresses);
    std::vector<VertexId> held;
    for (VertexId v = 0; v < static_cast<VertexId>(held_.size()); ++v)
        if (held_[static_cast<std::size_t>(v)] != 0 && session_.has_vertex(v))
            held.push_back(v);
    springs_->fix(held);
    springs_->set_wound(session_.lips());
    moving_ = session_.cut_count() > 0 || session_.stroke_open();
    record_part(job_, "springs", watch, springs_->bytes());
}

void CuttingDesk::relax(double milliseconds)
{
    if (!moving_)
        return;
    RelaxOptions options;
    options.max_iterations = std::max(1, static_cast<int>(milliseconds * iterations_per_ms_));
    const RelaxResult result = retractor::relax(*springs_, options);
    if (result.iterations > 0 && result.seconds > 0.0)
        iterations_per_ms_ = static_cast<double>(result.iterations) / (1e3 * result.seconds);
    // Where the springs cannot get any lower they are as much at rest as they will be.
    moving_ = result.status == RelaxStatus::out_of_iterations;
    picture_.reset();
}

double CuttingDesk::gape_mm() const
{
    if (springs_ == nullptr)
        return 0.0;
    double widest = 0.0;
    for (const auto& [a, b] : parted_)
        widest = std::max(widest, (springs_->displacement().row(a) - springs_->displacement().row(b)).norm());
    return widest;
}

std::shared_ptr<const WallPicture> CuttingDesk::picture()
{
    if (picture_ != nullptr)
        return picture_;
    if (surface_ == nullptr)
        surface_ = std::make_shared<const WallSurface>(surface_of(session_));
    auto made = std::make_shared<WallPicture>();
    made->surface = surface_;
    made->shown = surface_->rest;
    if (springs_ != nullptr) {
        const Eigen::Index rows = std::min(made->shown.rows(), springs_->displacement().rows());
        made->shown.topRows(rows) += springs_->displacement().topRows(rows);
    }
    picture_ = std::move(made);
    return picture_;
}

} // namespace retractor
