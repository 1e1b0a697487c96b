#include "ui/workstation/near_wound.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

namespace retractor {

namespace {

    /// What is nonlinear, where that is not more elements than can be dragged; else what lies nearer.
    struct Reach {
        double mm;
        std::size_t most;
    };
    constexpr std::array kReaches { Reach { NearWound::kNearMm, 60'000 }, Reach { 30.0, 60'000 },
        Reach { 20.0, 100'000 } };
    /// Of a frame while the hand moves; the rest comes when it is still.
    constexpr int kFrameIterations = 3;

    std::vector<std::uint8_t> near_elements(const NearProblem& problem, double& within_mm)
    {
        std::size_t count = 0;
        for (const Reach& reach : kReaches) {
            std::vector<std::uint8_t> near = elements_near(problem.mesh, problem.wound, reach.mm);
            count = static_cast<std::size_t>(std::count(near.begin(), near.end(), std::uint8_t { 1 }));
            within_mm = reach.mm;
            if (count <= reach.most)
                return near;
        }
        throw InputError(std::to_string(count) + " elements lie near the wound: too many to be dragged", "near field");
    }

    /// In steps, as a hand would: the answer does not depend on what was shown before, and tissue that has more than
    /// one rest comes to the one on the way.
    void drag_from_rest(NearField& field, const std::vector<HookPatch>& hooks, const Job& job)
    {
        double farthest = 0.0;
        for (const HookPatch& hook : hooks)
            farthest = std::max(farthest, hook.displacement.norm());
        const int steps = static_cast<int>(std::ceil(farthest / NearWound::kStepMm));
        for (int step = 1; step <= steps && !job.cancelled(); ++step) {
            std::vector<Vec3> at;
            for (const HookPatch& hook : hooks)
                at.push_back(hook.displacement * step / steps);
            (void)field.drag(at);
        }
    }

} // namespace

NearProblem near_problem(const OnlineOpening& opening, std::span<const Material> materials,
    std::vector<HookPatch> hooks, std::span<const VertexId> wound)
{
    const OnlineStiffness& K = opening.stiffness();
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
    for (HookPatch& hook : problem.hooks)
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
    Built built { .field = nullptr, .frame = {}, .id = problem.id, .within_mm = 0.0, .refusal = {} };
    const std::vector<std::uint8_t> near = near_elements(problem, built.within_mm);
    auto field
        = std::make_unique<NearField>(problem.mesh, problem.material_of_label, problem.supports, problem.hooks, near,
            NearFieldOptions {
                .elasticity = Elasticity::bounded, .frame_iterations = kFrameIterations, .load = problem.load });
    drag_from_rest(*field, problem.hooks, job);
    built.frame = field->settle(job);
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
    } catch (const std::exception& error) { // what the hooks hold cannot be solved so: it is said
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
    within_mm_ = built.within_mm;
    refusal_ = std::move(built.refusal);
    settled_ = frame_.status != NearStatus::cancelled;
    return field_ != nullptr;
}

Eigen::VectorXd NearWound::displacement(Eigen::Index size) const
{
    Eigen::VectorXd by_id = Eigen::VectorXd::Zero(size);
    for (std::size_t v = 0; v < id_.size(); ++v)
        by_id.segment<3>(3 * static_cast<Eigen::Index>(id_[v]))
            = frame_.displacement.segment<3>(3 * static_cast<Eigen::Index>(v));
    return by_id;
}

/// What cannot be solved any more is let go; it is said why.
template <class Call> void NearWound::guarded(const Call& call)
{
    try {
        call();
    } catch (const SolverError& error) {
        field_.reset();
        refusal_ = error.what();
    }
}

void NearWound::drag(std::span<const Vec3> hooks)
{
    guarded([&] { frame_ = field_->drag(hooks); });
    settled_ = false;
}

void NearWound::settle(const Job& job)
{
    guarded([&] { frame_ = field_->settle(job); });
    settled_ = frame_.status != NearStatus::cancelled;
}

} // namespace retractor
