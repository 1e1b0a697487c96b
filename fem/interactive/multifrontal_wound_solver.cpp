#include "fem/interactive/multifrontal_wound_solver.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <utility>

namespace retractor::fem {

MultifrontalWoundSolver::MultifrontalWoundSolver(
    const OnlineBody& body, std::unique_ptr<MultifrontalFactor> parts, const ReferenceRows& touched)
    : body_(body)
    , parts_(std::move(parts))
{
    for (const auto& [v, row] : touched)
        parts_->touch(v, row);
    for (VertexId v = 0; v < static_cast<VertexId>(body_.K.slot_count()); ++v)
        if (body_.is_active(v) && !parts_->has(v))
            parts_->touch(v, {});
}

void MultifrontalWoundSolver::row_touched(VertexId v, const OnlineStiffness::Row& before)
{
    if (!(body_.K.row(v) == before))
        parts_->touch(v, before);
}

void MultifrontalWoundSolver::prepare(const std::vector<VertexId>& needed)
{
    parts_->open(body_.K, needed);
    if (!parts_->update(body_.K, active_vertices(body_), held_vertices(body_)))
        throw SolverError("a part of the tissue has no support (the stiffness is not positive definite)");
    ready_ = true;
}

NearAnswer MultifrontalWoundSolver::solve(const Eigen::MatrixXd& hook_displacement) const
{
    return solve_under(body_.K.loaded() ? body_.K.load() : Eigen::VectorXd(), hook_displacement);
}

Eigen::VectorXd MultifrontalWoundSolver::correction(const Eigen::VectorXd& residual) const
{
    const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(body_.hooks.size()), 1);
    return solve_under(residual, still).displacement.col(0);
}

/// @param load by vertex id; empty: none
NearAnswer MultifrontalWoundSolver::solve_under(
    const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const
{
    RETRACTOR_ASSERT(ready_);
    RETRACTOR_ASSERT(hook_displacement.rows() == 3 * static_cast<Eigen::Index>(body_.hooks.size()));
    const Eigen::Index cases = hook_displacement.cols(), rows = 3 * static_cast<Eigen::Index>(body_.K.slot_count());
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(rows, cases);
    if (load.size() != 0)
        b.colwise() += load;
    for (const HeldVertex& h : body_.held)
        for_blocks(body_.K, h.vertex, [&](VertexId v, const auto& block) {
            b.middleRows(3 * v, 3) -= block.transpose() * hook_displacement.middleRows(3 * h.hook, 3);
        });
    for (VertexId v = 0; v < static_cast<VertexId>(body_.K.slot_count()); ++v)
        if (!body_.is_active(v))
            b.middleRows(3 * v, 3).setZero();
    NearAnswer near { parts_->solve(b),
        Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(body_.hooks.size()), cases) };
    for (const HeldVertex& h : body_.held)
        near.displacement.middleRows(3 * h.vertex, 3) = hook_displacement.middleRows(3 * h.hook, 3);
    for (const HeldVertex& h : body_.held) {
        auto sum = near.hook_forces.middleRows(3 * h.hook, 3);
        for_blocks(body_.K, h.vertex,
            [&](VertexId v, const auto& block) { sum += block * near.displacement.middleRows(3 * v, 3); });
        if (load.size() != 0)
            sum.colwise() -= Vec3(load.segment<3>(3 * h.vertex));
    }
    return near;
}

} // namespace retractor::fem
