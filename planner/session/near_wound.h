#pragma once
// The nonlinear solution near a wound that hooks hold open (NonlinearRegion, corotational with bounded pressure). It is
// valid for large rotations and stretches, where the linear solution of the whole wall swells. A background thread
// factors the region and pulls the hooks from rest to their present places. The solution then arrives near equilibrium,
// and follows the hooks when they are dragged. A solution belongs to one mesh and one set of hooks; another mesh or set
// needs a new begin(). Used from one thread. Units mm, N; frame patient LPS.

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

/// A copy of the cut wall with its supports, hooks and loads.
struct NearProblem {
    mesh::TetMesh mesh; ///< with compact numbering
    std::vector<VertexId> id; ///< the session's id of each vertex of `mesh`
    std::vector<fem::Material> material_of_label;
    fem::Supports supports;
    std::vector<fem::HookPatch> hooks; ///< patches of the hooks; their displacement is not used
    std::vector<fem::HookDrive> drives; ///< one per hook
    Points wound; ///< vertices of the lips, at rest
    Eigen::VectorXd load; ///< released tension, N, three numbers per vertex; empty: none
};

/// Copies the wall of the interactive solver.
/// @param hooks patches with vertex ids of the session
/// @param wound vertices of the lips, ids of the session
NearProblem near_problem(const fem::OnlineOpening& opening, std::span<const fem::Material> material_of_label,
    std::vector<fem::HookPatch> hooks, std::span<const VertexId> wound);

class NearWound {
public:
    ~NearWound();

    /// Starts to solve a problem in the background. A solution for former hooks is cancelled between two factorisations
    /// or hook steps.
    void begin(NearProblem problem);
    /// Tells that the wall or the hooks have changed.
    void outdate();
    bool building() const { return build_ != nullptr && (!stale_ || next_.has_value()); }
    /// Whether take() would return at once and change something.
    bool build_ready() const;
    /// Takes the finished solution. Returns false when there is none yet, or when it failed.
    bool take();
    bool ready() const { return field_ != nullptr; }
    /// The reason why there is no solution; empty when a solution is possible.
    const std::string& refusal() const { return refusal_; }

    /// The frame that was shown last. @pre ready()
    const fem::NearFrame& frame() const { return frame_; }
    /// Distance from the wound within which the solution is nonlinear, mm.
    double within_mm() const { return within_mm_; }
    /// relative_change() of the linear tissue outside the nonlinear region, at the last equilibrium; none on the way to
    /// the next equilibrium. The value uses the existing factor, of less stretched tissue, because a new factor would
    /// make the hand wait.
    const std::optional<double>& far_change() const { return far_change_; }
    /// Displacement, three numbers per vertex id of the session, mm; zero for ids without a vertex.
    /// @param size number of entries.
    /// @pre ready()
    Eigen::VectorXd displacement(Eigen::Index size) const;
    /// Whether drag() to these drives would change nothing. @pre ready()
    bool drawn_to(std::span<const fem::HookDrive> drives) const;
    /// Moves the hooks to these drives. After a failure, ready() is false and refusal() gives the reason; the same
    /// holds for settle().
    /// @pre ready()
    void drag(std::span<const fem::HookDrive> drives);
    /// Iterates until equilibrium or until the job is cancelled. @pre ready()
    void settle(const Job& job);
    /// Whether settle() would change nothing more.
    bool settled() const { return settled_; }
    std::size_t bytes() const { return field_ != nullptr ? field_->bytes() : 0; }

private:
    struct Built {
        std::unique_ptr<fem::NonlinearRegion> field; ///< null: refused or cancelled
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
    std::vector<fem::HookDrive> drives_; ///< of the hooks at the last drag
    double within_mm_ = 0.0;
    std::optional<double> far_change_;
    bool settled_ = false;
    std::string refusal_;
    std::unique_ptr<Build> build_; ///< in progress; null: none
    bool stale_ = false; ///< the running build belongs to a former wall or former hooks
    std::optional<NearProblem> next_; ///< problem to solve after the running build
};

} // namespace retractor::planner
