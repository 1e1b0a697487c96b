#pragma once
// What OnlineOpening asks of a way to solve a body again after every cut: SchurWoundSolver on the corridor's dense
// system, MultifrontalWoundSolver part by part. Vertices by the session's ids. Units mm, N.

#include "fem/interactive/online_body.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace retractor::fem {

/// One column per case.
struct NearAnswer {
    Eigen::MatrixXd displacement; ///< by vertex id: near the wound and the hooks, elsewhere zero until it is completed
    Eigen::MatrixXd hook_forces; ///< three rows per hook: what it must apply
};

class WoundSolver {
public:
    virtual ~WoundSolver() = default;

    // A delta, in this order; the body's stiffness and supports have followed it after the first. Its hooks follow
    // last, see hooks_changed(); then drop_answer() is called.
    virtual void before_delta() { }
    /// Also called for rows that turn out not to have changed.
    virtual void row_touched(VertexId v, const OnlineStiffness::Row& before) = 0;
    virtual void vertex_born(VertexId v) = 0;
    virtual void vertex_gone(VertexId) { }

    virtual void hooks_changed() = 0; ///< others hold, or hold other vertices
    virtual void drop_answer() = 0; ///< what prepare() made is of an earlier state

    /// A hook that has been attached to a body solved just now. @return false: hooks_changed() is needed.
    [[nodiscard]] virtual bool take_appended(HookId) { return false; }

    virtual std::vector<VertexId> corridor() const = 0; ///< where cuts have been made or are planned; also dead ones
    /// Vertices whose rows cuts have changed and that are condensed away: they must be among those of prepare().
    virtual std::vector<VertexId> changed_elsewhere() const = 0;
    /// A new factorisation with these in its corridor is cheaper than to prepare them.
    virtual bool outgrown(const std::vector<VertexId>&) const { return false; }
    /// @param needed changed_elsewhere() and what hooks hold. @throws SolverError when the body does not stand.
    virtual void prepare(const std::vector<VertexId>& needed) = 0;
    virtual bool ready() const = 0;

    // The next four: @pre ready().
    virtual double reciprocal_condition() const = 0; ///< estimate for what was solved anew; 0: not positive definite
    /// Under the body's own load. @param hook_displacement three rows per hook, one column per case.
    virtual NearAnswer solve(const Eigen::MatrixXd& hook_displacement) const = 0;
    virtual Eigen::MatrixXd whole_field(const Eigen::MatrixXd& near) const = 0;
    /// What takes this residual off: the whole field, or most of it, the hooks held still.
    virtual Eigen::VectorXd correction(const Eigen::VectorXd& residual) const = 0;

    virtual std::string route() const = 0;
    virtual bool is_updated() const { return false; }
    virtual std::size_t dropped_vertices() const { return 0; }
    virtual std::size_t corridor_vertices() const = 0;
    virtual double factor_entries() const = 0;
    virtual std::size_t bytes() const = 0;
};

} // namespace retractor::fem
