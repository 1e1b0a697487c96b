#pragma once
// Wound solver on a multifrontal factor (MultifrontalFactor). The fronts that cuts touch are factored anew, and every
// answer is the whole field. Units mm, N.

#include "fem/interactive/condensed_state.h"
#include "fem/interactive/multifrontal_factor.h"
#include "fem/interactive/wound_solver.h"

#include <memory>

namespace retractor::fem {

class MultifrontalWoundSolver final : public WoundSolver {
public:
    /// @param body must live as long as the solver
    /// @param touched rows touched since `parts` was factored
    MultifrontalWoundSolver(
        const OnlineBody& body, std::unique_ptr<MultifrontalFactor> parts, const ReferenceRows& touched);

    void row_touched(VertexId v, const OnlineStiffness::Row& before) override;
    void vertex_born(VertexId v) override { parts_->touch(v, {}); }
    void hooks_changed() override { drop_answer(); }
    void drop_answer() override { ready_ = false; }
    std::vector<VertexId> corridor() const override { return parts_->open_vertices(); }
    std::vector<VertexId> changed_elsewhere() const override { return parts_->changed_but_closed(body_.K); }
    void prepare(const std::vector<VertexId>& needed) override;
    bool ready() const override { return ready_; }
    double reciprocal_condition() const override { return parts_->reciprocal_condition(); }
    NearAnswer solve(const Eigen::MatrixXd& hook_displacement) const override;
    Eigen::MatrixXd whole_field(const Eigen::MatrixXd& near) const override { return near; }
    Eigen::VectorXd correction(const Eigen::VectorXd& residual) const override;
    std::string route() const override { return "dissected"; }
    std::size_t corridor_vertices() const override { return parts_->open_count(); }
    std::size_t bytes() const override { return parts_->bytes(); }

private:
    NearAnswer solve_under(const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const;

    const OnlineBody& body_;
    std::unique_ptr<MultifrontalFactor> parts_;
    bool ready_ = false; ///< parts_ is up to date
};

} // namespace retractor::fem
