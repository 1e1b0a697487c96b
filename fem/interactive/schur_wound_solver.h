#pragma once
// Wound solver on a body that is condensed once onto the vertices where it is cut and held (CondensedBody). Cuts change
// a small dense system on these vertices (CutChange, LocalSystem). The system is set up against the body as it was
// factored, or against an updated state of the stroke (CondensedState), whichever costs less. Exact. Units mm, N.

#include "fem/interactive/condensed_body.h"
#include "fem/interactive/condensed_state.h"
#include "fem/interactive/cut_change.h"
#include "fem/interactive/local_system.h"
#include "fem/interactive/low_rank_update.h"
#include "fem/interactive/online_options.h"
#include "fem/interactive/wound_solver.h"

#include <future>
#include <memory>
#include <optional>
#include <set>

namespace retractor::fem {

class SchurWoundSolver final : public WoundSolver {
public:
    /// @param body, options must live as long as the solver
    /// @param touched rows touched since `condensed` was factored, with their values at that time
    /// @param load loads of the body at that time
    SchurWoundSolver(const OnlineBody& body, std::unique_ptr<CondensedBody> condensed, ReferenceRows touched,
        Eigen::VectorXd load, const OnlineOptions& options);

    void before_delta() override;
    void row_touched(VertexId v, const OnlineStiffness::Row& before) override;
    void vertex_born(VertexId v) override;
    void vertex_gone(VertexId v) override { added_.erase(v); }
    void hooks_changed() override;
    void drop_answer() override;
    bool take_appended(HookId hook) override;
    std::vector<VertexId> corridor() const override;
    std::vector<VertexId> changed_elsewhere() const override;
    bool outgrown(const std::vector<VertexId>& needed) const override;
    void prepare(const std::vector<VertexId>& needed) override;
    bool ready() const override { return local_.has_value(); }
    double reciprocal_condition() const override { return local_->reciprocal_condition(); }
    NearAnswer solve(const Eigen::MatrixXd& hook_displacement) const override;
    Eigen::MatrixXd whole_field(const Eigen::MatrixXd& near) const override;
    Eigen::VectorXd correction(const Eigen::VectorXd& residual) const override;
    std::string route() const override;
    bool is_updated() const override { return local_ && updated_ && state_ == &*updated_; }
    std::size_t dropped_vertices() const override { return is_updated() ? updated_->dropped.size() : 0; }
    std::size_t corridor_vertices() const override { return condensed_->kept().size(); }
    std::size_t bytes() const override;

private:
    /// An update with the changes of a stroke, which runs on its own thread.
    struct PendingUpdate {
        std::shared_ptr<const UpdateSource> source;
        std::future<CondensedState> result;
        ReferenceRows reference; ///< rows touched since the update was started
        std::vector<AddedVertices> added; ///< vertices retained in addition since then
        int deltas_left;
    };
    /// Loads near the wound, one column per case.
    struct NearLoads {
        Eigen::MatrixXd kept, added;
        std::optional<LoadOnDropped> on_dropped;
    };

    bool is_update_worthwhile() const;
    void start_update();
    void swap_updated_in();
    void drop_updated_state();
    void drop_updated();

    std::vector<VertexId> missing_of(const std::vector<VertexId>& vertices) const;
    void keep_also_here(const std::vector<VertexId>& missing);
    void make_local();
    const CondensedState& cheapest_state(double work_from_base);
    HookCompliance& compliance_of_hooks();

    bool changed_since(const CondensedState& state, VertexId v) const;
    std::vector<VertexId> wanted_back() const;
    bool updated_state_holds() const;

    NearLoads near_loads(const Eigen::VectorXd& load, Eigen::Index cases) const;
    Eigen::VectorXd felt_beside_eliminated_added(const Eigen::VectorXd& load) const;
    void find_dropped(const Eigen::MatrixXd& kept_forces, const NearLoads& loads, Eigen::MatrixXd& x) const;
    void find_eliminated_added(const Eigen::VectorXd& load, Eigen::MatrixXd& x) const;
    Eigen::MatrixXd forces_of_hooks(
        const LocalSystem::Solution& solution, const Eigen::VectorXd& load, const Eigen::MatrixXd& x) const;
    NearAnswer solve_under(const Eigen::VectorXd& load, const Eigen::MatrixXd& hook_displacement) const;
    Eigen::VectorXd held_back(Eigen::VectorXd load, const Eigen::VectorXd& field) const;
    Eigen::MatrixXd extended(const Eigen::MatrixXd& near, const Eigen::VectorXd& field) const;
    Eigen::VectorXd grown(const Eigen::VectorXd& by_id) const;

    const OnlineBody& body_;
    const OnlineOptions& options_;
    std::unique_ptr<CondensedBody> condensed_;
    /// Loads of the body when it was condensed, and its field under these loads.
    Eigen::VectorXd base_load_, base_field_;
    CondensedState base_; ///< the body as it was condensed
    bool leaving_ = true; ///< vertices behind the knife may be dropped from the updated state
    std::optional<CondensedState> updated_; ///< contains the changes of the stroke up to its last update
    std::optional<PendingUpdate> pending_update_;
    std::set<VertexId> added_; ///< added vertices: alive and free, but not in the body as it was condensed

    // Made by prepare(); dropped when their inputs change.
    std::optional<HookCompliance> base_compliance_, updated_compliance_;
    const CondensedState* state_ = nullptr; ///< state against which change_ and local_ are set up
    std::optional<CutChange> change_;
    std::optional<LocalSystem> local_;
};

} // namespace retractor::fem
