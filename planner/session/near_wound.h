#pragma once
// The nonlinear answer near a wound that hooks hold open: tissue that turns and stretches far (NonlinearRegion, bounded
// corotational), where the linear answer of the whole wall swells. It takes a factorisation, which is made on a thread
// of its own, where the hooks are then drawn from rest to where they are; that comes back near equilibrium, and hooks
// are dragged in it. It is of one mesh and one set of hooks: with another it is begun anew. Used from one thread. Units
// mm, N; frame patient LPS.

#include "fem/interactive/online_opening.h"
#include "fem/statics/nonlinear_region.h"

#include <Eigen/Core>

#include <atomic>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// A copy of the wall as it is cut, and of what holds it.
struct NearProblem {
    mesh::TetMesh mesh; ///< compact
    std::vector<VertexId> id; ///< per vertex of the mesh: the session's
    std::vector<fem::Material> material_of_label;
    fem::Supports supports;
    std::vector<fem::HookPatch> hooks; ///< their displacement is not used
    std::vector<fem::HookDrive> drives; ///< one per hook
    Points wound; ///< the vertices of its lips, at rest
    Eigen::VectorXd load; ///< N, three per vertex: tension set free; empty: none
};

/// The wall as the online solver has it, with hooks that hold these vertices (ids of the session).
/// @param wound ids of the session: the vertices of its lips.
NearProblem near_problem(const fem::OnlineOpening& opening, std::span<const fem::Material> material_of_label,
    std::vector<fem::HookPatch> hooks, std::span<const VertexId> wound);

class NearWound {
public:
    ~NearWound();

    /// Solves this in the background; what is being solved for former hooks is given up, between two factorisations
    /// or steps of the hooks.
    void begin(NearProblem problem);
    /// The wall or the hooks are others now.
    void outdate();
    bool building() const { return build_ != nullptr && (!stale_ || next_.has_value()); }
    /// take() will not wait, and changes something.
    bool build_ready() const;
    /// Takes what was built; false when there is nothing yet, or it failed.
    bool take();
    bool ready() const { return field_ != nullptr; }
    /// Why there is none; empty: nothing stands against it.
    const std::string& refusal() const { return refusal_; }

    /// The frame that was shown last; valid while ready().
    const fem::NearFrame& frame() const { return frame_; }
    double within_mm() const { return within_mm_; }
    /// relative_change() of the tissue beyond, which is linear, at the equilibrium that was reached last; none on the
    /// way to the next. By the factor at hand, of tissue less stretched: a new one would make the hand wait.
    const std::optional<double>& far_change() const { return far_change_; }
    /// Three per id of the session, so many entries; zero where no vertex lives. @pre ready()
    Eigen::VectorXd displacement(Eigen::Index size) const;
    /// drag() would change nothing. @pre ready()
    bool drawn_to(std::span<const fem::HookDrive> drives) const;
    /// @pre ready(). Where it fails it is no longer, and refusal() says why; so does settle().
    void drag(std::span<const fem::HookDrive> drives);
    /// Until equilibrium, or until the job is cancelled. @pre ready()
    void settle(const Job& job);
    /// Nothing more comes of settle().
    bool settled() const { return settled_; }
    std::size_t bytes() const { return field_ != nullptr ? field_->bytes() : 0; }

private:
    struct Built {
        std::unique_ptr<fem::NonlinearRegion> field; ///< null: refused, or cancelled
        fem::NearFrame frame;
        std::vector<VertexId> id;
        std::vector<fem::HookDrive> drives;
        double within_mm = 0.0;
        std::optional<double> far_change;
        std::string refusal;
    };
    struct Build {
        std::atomic<bool> cancel { false };
        std::future<Built> result;
    };
    static Built make(const NearProblem& problem, const Job& job);
    void launch(NearProblem problem);
    template <class Call> void guarded(const Call& call);

    std::unique_ptr<fem::NonlinearRegion> field_;
    fem::NearFrame frame_;
    std::vector<VertexId> id_;
    std::vector<fem::HookDrive> drives_; ///< of the hooks, as they were dragged last
    double within_mm_ = 0.0;
    std::optional<double> far_change_;
    bool settled_ = false;
    std::string refusal_;
    std::unique_ptr<Build> build_; ///< under way; null: none
    bool stale_ = false; ///< it is of a former wall or former hooks
    std::optional<NearProblem> next_; ///< to be solved when that is out of the way
};

} // namespace retractor::planner
