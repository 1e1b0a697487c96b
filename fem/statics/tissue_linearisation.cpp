#include "fem/statics/tissue_linearisation.h"

#include "fem/statics/lifted_factor.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace retractor::fem {

namespace {

    /// The hooks at rest: equal displacements, as hooks that share nodes require.
    std::vector<HookPatch> still(std::vector<HookPatch> hooks)
    {
        for (HookPatch& hook : hooks) {
            hook.displacement.setZero();
            hook.rotation.setIdentity();
        }
        return hooks;
    }

} // namespace

TissueLinearisation::TissueLinearisation(const ElasticProblem& problem, const TissueModel& model,
    const Points& displacement, const std::optional<ContactOptions>& contact)
    : state_(Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size()))
    , held_(prescribe(problem.mesh, problem.supports, still(problem.hooks)))
    , body_(tissue_body(problem.mesh, problem.material_of_label, model))
{
    RETRACTOR_ASSERT(displacement.rows() == problem.mesh.vertices.rows());
    set_springs(body_, problem.supports);
    ExternalLoads loads = external_loads(problem);
    const bool at_rest = model.elasticity == Elasticity::linear; // linear tissue receives the pressure at rest
    load_ = at_rest ? nodal_loads(problem) : loads.nodal;
    if (!at_rest)
        for (const FollowerPressure& pressure : loads.pressures)
            load_ = (load_.size() == 0 ? Eigen::VectorXd(Eigen::VectorXd::Zero(state_.size())) : load_)
                + pressure.force(state_);
    if (!loads.pressures.empty()) { // dead loads have no stiffness, follower loads have
        body_.set_loads(std::move(loads));
        (void)body_.renew_follower_loads(state_);
    }
    if (contact) {
        body_.set_contact(Contact(problem.mesh, element_parameters(problem.mesh, problem.material_of_label), *contact));
        (void)body_.find_contact(state_);
    }
    if (!problem.blades.empty()) {
        body_.set_blades(BladeContact(problem.mesh, problem.blades));
        body_.renew_blades(state_);
        body_.prepare_blade_search(state_);
    }
    (void)body_.stiffness(state_, 0.0);
    solver_.emplace(body_.last_stiffness().pattern, held_.flag);
    factorise_least_lifted(body_, state_, *solver_);
}

HookResponse TissueLinearisation::response(const Eigen::MatrixXd& motions)
{
    RETRACTOR_ASSERT(motions.rows() == state_.size());
    Eigen::MatrixXd follow = motions + solve(-forces_of(motions));
    const Eigen::MatrixXd R = follow.transpose() * forces_of(follow);
    HookResponse response { 0.5 * (R + R.transpose()), std::move(follow) };
    if (load_.size() != 0)
        response.of_loads = -response.displacement.transpose() * load_;
    return response;
}

Eigen::MatrixXd TissueLinearisation::forces_of(const Eigen::MatrixXd& displacement) const
{
    Eigen::MatrixXd forces(displacement.rows(), displacement.cols());
    for (Eigen::Index c = 0; c < displacement.cols(); ++c)
        forces.col(c) = body_.last_stiffness().multiply(displacement.col(c));
    return forces;
}

} // namespace retractor::fem
