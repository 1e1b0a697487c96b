#pragma once
// Interface between OnlineOpening and the ways to solve a body again after every cut: SchurWoundSolver on the dense
// system of the corridor, MultifrontalWoundSolver front by front. Vertices have the ids of the session. Units mm, N.

#include "fem/interactive/online_body.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace retractor::fem {

/// Displacements near the wound and hook forces, one column per case.
struct NearAnswer {
    Eigen::MatrixXd displacement; ///< by vertex id: near the wound and the hooks; zero elsewhere until whole_field()
    Eigen::MatrixXd hook_forces; ///< force that each hook must apply, three rows per hook
};

class WoundSolver {
public:
    virtual ~WoundSolver() = default;

    // A delta is followed by these calls, in this order. The body's stiffness and supports follow the delta after
    // before_delta(); its hooks follow last (hooks_changed()); then drop_answer() is called.
    virtual void before_delta() { }
    /// May also be called for rows that did not change.
    virtual void row_touched(VertexId v, const OnlineStiffness::Row& before) = 0;
    virtual void vertex_born(VertexId v) = 0;
    virtual void vertex_gone(VertexId) { }

    virtual void hooks_changed() = 0; ///< hooks were attached or detached, or hold other vertices
    virtual void drop_answer() = 0; ///< the results of prepare() belong to an earlier state

    /// Takes in a hook that was attached to a body just solved. @return false when hooks_changed() must be called
    [[nodiscard]] virtual bool take_appended(HookId) { return false; }

    /// Vertices where cuts have been made or are planned, also dead ones.
    virtual std::vector<VertexId> corridor() const = 0;
    /// Eliminated vertices whose rows cuts have changed. These must be among the vertices of prepare().
    virtual std::vector<VertexId> changed_elsewhere() const = 0;
    /// Whether a new factorisation with these vertices in its corridor is cheaper than prepare() with them.
    virtual bool outgrown(const std::vector<VertexId>&) const { return false; }
    /// Brings the solver up to date.
    /// @param needed changed_elsewhere() and held vertices
    /// @throws SolverError when the body is not supported
    virtual void prepare(const std::vector<VertexId>& needed) = 0;
    virtual bool ready() const = 0;

    // The next four functions have @pre ready().
    /// Estimate for the system that was solved anew; 0: not positive definite.
    virtual double reciprocal_condition() const = 0;
    /// Solves under the body's own load. @param hook_displacement three rows per hook, one column per case
    virtual NearAnswer solve(const Eigen::MatrixXd& hook_displacement) const = 0;
    virtual Eigen::MatrixXd whole_field(const Eigen::MatrixXd& near) const = 0;
    /// Correction of the displacement for this residual, of the whole field or most of it, while the hooks do not move.
    virtual Eigen::VectorXd correction(const Eigen::VectorXd& residual) const = 0;

    virtual std::string route() const = 0;
    virtual bool is_updated() const { return false; }
    virtual std::size_t dropped_vertices() const { return 0; }
    virtual std::size_t corridor_vertices() const = 0;
    virtual std::size_t bytes() const = 0;
};

} // namespace retractor::fem
