#include "planner/session/near_wound.h"

#include "fem/statics/drag_options.h"
#include "fem/statics/near_opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace retractor::planner {

namespace {

    /// Only at equilibrium, because before it the value would describe another wound.
    std::optional<double> change_beyond(fem::NonlinearRegion& field, const fem::NearFrame& frame)
    {
        if (frame.status != fem::NearStatus::settled)
            return {};
        return fem::relative_change(field.far_change(), frame);
    }

} // namespace

NearProblem near_problem(const fem::OnlineOpening& opening, std::span<const fem::Material> materials,
    std::vector<fem::HookPatch> hooks, std::span<const VertexId> wound)
{
    const fem::OnlineStiffness& K = opening.stiffness();
    NearProblem problem;
    std::vector<VertexId> compact(K.slot_count(), -1);
    for (VertexId v = 0; v < static_cast<VertexId>(compact.size()); ++v)
        if (K.alive(v)) {
            compact[static_cast<std::size_t>(v)] = static_cast<VertexId>(problem.id.size());
            problem.id.push_back(v);
        }
    const auto vertex = [&](VertexId id) { return compact[static_cast<std::size_t>(id)]; };
    const auto count = static_cast<Eigen::Index>(problem.id.size());
    problem.mesh.vertices.resize(count, 3);
    if (K.loaded())
        problem.load.resize(3 * count);
    for (VertexId v = 0; v < static_cast<VertexId>(count); ++v) {
        const VertexId id = problem.id[static_cast<std::size_t>(v)];
        problem.mesh.vertices.row(v) = K.position(id).transpose();
        if (K.loaded())
            problem.load.segment<3>(3 * v) = K.load().segment<3>(3 * static_cast<Eigen::Index>(id));
        if (opening.fixed(id))
            problem.supports.fixed.push_back(v);
        else if (K.bed(id) > 0.0)
            problem.supports.bedded.push_back({ v, K.bed(id) });
    }
    problem.supports.hinges = K.hinges();
    for (fem::Hinge& hinge : problem.supports.hinges)
        for (fem::HingeEdge& edge : hinge.edges)
            edge = { vertex(edge.a), vertex(edge.b), edge.share };
    for (TetId t = 0; t < static_cast<TetId>(K.tet_slots()); ++t)
        if (K.tet_alive(t)) {
            for (const VertexId id : K.tet(t))
                problem.mesh.nodes.push_back(vertex(id));
            problem.mesh.labels.push_back(K.label(t));
        }
    problem.wound.resize(static_cast<Eigen::Index>(wound.size()), 3);
    for (std::size_t i = 0; i < wound.size(); ++i)
        problem.wound.row(static_cast<Eigen::Index>(i)) = K.position(wound[i]).transpose();
    problem.hooks = std::move(hooks);
    for (fem::HookPatch& hook : problem.hooks)
        std::transform(hook.nodes.begin(), hook.nodes.end(), hook.nodes.begin(), vertex);
    problem.material_of_label.assign(materials.begin(), materials.end());
    return problem;
}

NearWound::~NearWound()
{
    if (build_ != nullptr)
        build_->cancel.store(true);
}

NearWound::Built NearWound::make(const NearProblem& problem, const Job& job)
{
    Built built { .field = nullptr,
        .frame = {},
        .id = problem.id,
        .drives = problem.drives,
        .within_mm = 0.0,
        .far_change = {},
        .refusal = {} };
    const fem::DragRegion zone = fem::drag_region(problem.mesh, problem.wound);
    built.within_mm = zone.within_mm;
    auto field = std::make_unique<fem::NonlinearRegion>(problem.mesh, problem.material_of_label, problem.supports,
        problem.hooks, zone.near, fem::drag_options(problem.load));
    if (!field->prepare(job))
        return built;
    // The model tolerates any motion of the hooks without new factors, and settle() makes new factors where they pay.
    (void)fem::drag_in_steps(*field, std::vector<fem::HookDrive>(built.drives.size()), built.drives,
        { .refresh_above = std::numeric_limits<double>::infinity() }, job);
    built.frame = field->settle(job);
    built.far_change = change_beyond(*field, built.frame);
    if (!job.cancelled())
        built.field = std::move(field);
    return built;
}

void NearWound::launch(NearProblem problem)
{
    auto build = std::make_unique<Build>();
    build->result = std::async(std::launch::async, [problem = std::move(problem), cancel = &build->cancel] {
        Job job;
        job.cancel = cancel;
        return make(problem, job);
    });
    build_ = std::move(build);
    stale_ = false;
}

void NearWound::begin(NearProblem problem)
{
    outdate();
    if (build_ != nullptr)
        next_ = std::move(problem);
    else
        launch(std::move(problem));
}

void NearWound::outdate()
{
    field_.reset();
    refusal_.clear();
    next_.reset();
    if (build_ == nullptr)
        return;
    build_->cancel.store(true);
    stale_ = true;
}

bool NearWound::build_ready() const
{
    return build_ != nullptr && build_->result.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

bool NearWound::take()
{
    if (!build_ready())
        return false;
    const std::unique_ptr<Build> done = std::move(build_);
    Built built;
    try {
        built = done->result.get();
    } catch (const std::exception& error) { // the tissue under the hooks cannot be solved: report the reason
        built.refusal = error.what();
    }
    if (std::exchange(stale_, false)) {
        if (next_)
            launch(*std::exchange(next_, std::nullopt));
        return false;
    }
    field_ = std::move(built.field);
    frame_ = std::move(built.frame);
    id_ = std::move(built.id);
    drives_ = std::move(built.drives);
    within_mm_ = built.within_mm;
    far_change_ = built.far_change;
    refusal_ = std::move(built.refusal);
    settled_ = frame_.status != fem::NearStatus::cancelled;
    return field_ != nullptr;
}

Eigen::VectorXd NearWound::displacement(Eigen::Index size) const
{
    RETRACTOR_ASSERT(ready());
    Eigen::VectorXd by_id = Eigen::VectorXd::Zero(size);
    for (std::size_t v = 0; v < id_.size(); ++v)
        by_id.segment<3>(3 * static_cast<Eigen::Index>(id_[v]))
            = frame_.displacement.segment<3>(3 * static_cast<Eigen::Index>(v));
    return by_id;
}

/// Runs a call; when the solution fails, drops it and keeps the reason.
template <class Call> void NearWound::guarded(const Call& call)
{
    try {
        call();
    } catch (const SolverError& error) {
        field_.reset();
        refusal_ = error.what();
    }
}

bool NearWound::drawn_to(std::span<const fem::HookDrive> drives) const
{
    return std::equal(drives.begin(), drives.end(), drives_.begin(), drives_.end());
}

void NearWound::drag(std::span<const fem::HookDrive> drives)
{
    RETRACTOR_ASSERT(ready());
    far_change_.reset();
    guarded([&] { frame_ = field_->drag(drives); });
    drives_.assign(drives.begin(), drives.end());
    settled_ = false;
}

void NearWound::settle(const Job& job)
{
    RETRACTOR_ASSERT(ready());
    guarded([&] {
        frame_ = field_->settle(job);
        far_change_ = change_beyond(*field_, frame_);
    });
    settled_ = frame_.status != fem::NearStatus::cancelled;
}

} // namespace retractor::planner
