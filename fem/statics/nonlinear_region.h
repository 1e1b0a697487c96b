#pragma once
// Nonlinear tissue near the wound and linear tissue beyond, for dragging hooks at frame rate. The far part is condensed
// once onto the rim between the two parts (condensed_region.h); the near part is computed with large rotations and
// strains. Units mm, N, MPa; frame patient LPS.
//
// A frame starts from the last frame, moved on by the change of the frames before; where the hooks turn, the present
// factor predicts the motion. A few quasi-Newton steps follow (L-BFGS: Nocedal, Wright 2006, Numerical Optimization,
// alg. 7.4). The steps use the factor of an earlier stiffness, each with an Armijo line search on the energy.
// Hyperelastic energies are infinite where an element would turn over: no step goes there, and a motion of the hooks
// that leads there is made in shorter parts. The force that is left unbalanced is the residual of the frame; the next
// frame continues from this state. settle() continues to equilibrium and renews the factor where convergence has become
// slow.
//
// far_change() estimates the error of the linear far part. The far tissue is placed by the linear field and loads the
// body with the forces of its own law; one Newton step on the whole body, with the present factors, gives the change.
//
// With all elements near, the same method solves the fully nonlinear problem.

#include "fem/material/elasticity.h"
#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "fem/statics/hooks_apart.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// Flags the elements with a corner within `distance` (mm) of one of the points.
/// @throws InputError without points, or on a distance that is not positive
std::vector<std::uint8_t> elements_near(const mesh::TetMesh& mesh, const Points& points, double distance);

struct NonlinearRegionOptions {
    /// One of hyperelastic (the laws of the materials, hyperelastic_law()), corotational, and corotational_linear. The
    /// last is for meshes with flat elements, as cuts through patients leave them: no element stops a hook, and steps
    /// on an old factor converge.
    Elasticity elasticity = Elasticity::hyperelastic;
    int frame_iterations = 3; ///< quasi-Newton steps per frame
    double tolerance = 1e-6; ///< of settle(): largest residual force of a free node over the largest force of any node
    int max_iterations = 400; ///< largest number of iterations of settle()
    Eigen::VectorXd load {}; ///< released tension, N, three per vertex, on vertices of near elements; empty: none
};

enum class NearStatus {
    moving, ///< a frame of a drag; the residual tells the distance from equilibrium
    settled,
    not_settled,
    cancelled,
};

/// State of the body after a frame of drag(), or after settle().
struct [[nodiscard]] NearFrame {
    NearStatus status = NearStatus::moving;
    std::string message {};
    Eigen::VectorXd displacement; ///< mm, three per vertex, of the whole body
    /// Displacement of each hook, mm. A force-driven hook is where its force takes it. Other hooks may stop short of
    /// their target: where they slip, grip softly, or would turn tissue over.
    std::vector<Vec3> hook_displacements;
    bool reached = true; ///< the hooks are where their drives put them
    /// Force that the surgeon must apply to each hook, without the force between hooks that meet.
    std::vector<Vec3> hook_forces_N {};
    std::vector<bool> hook_yielded {}; ///< per hook: the force limit is reached
    std::vector<FacingHooks> meeting {}; ///< pairs of hooks that stop each other because their lips meet
    double residual = 0.0; ///< as NonlinearRegionOptions::tolerance
    int iterations = 0, factorisations = 0;
};

/// First-order estimate of the change if the far tissue followed its own law.
struct FarChange {
    bool finite = true; ///< false: far elements are turned over, where hyperelastic tissue has no law
    Eigen::VectorXd displacement {}; ///< mm, three per vertex
    std::vector<Vec3> hook_forces_N {};
};

/// The larger of two relative changes: of the displacement (root mean square, so that one loose sliver has little
/// effect) and of the largest hook force. Infinite where the change is not finite.
double relative_change(const FarChange& change, const NearFrame& frame);

class NonlinearRegion {
public:
    /// Starts at rest, with the hooks not moved.
    /// @param hooks their nodes are used, their displacement is not
    /// @param near one per element, 1 = nonlinear
    /// @throws InputError on bad meshes, materials, supports or hooks, when no element is near, when a hook holds a
    /// node of a far element, or when a load acts on a node that is not near; SolverError naming the place that is not
    /// supported
    NonlinearRegion(const mesh::TetMesh& mesh, std::span<const Material> material_of_label, const Supports& supports,
        std::vector<HookPatch> hooks, const std::vector<std::uint8_t>& near, NonlinearRegionOptions options = {});
    ~NonlinearRegion();
    NonlinearRegion(NonlinearRegion&&) noexcept;

    /// Factors the far part and, at rest, the near part. Without this call, the first function that needs the factors
    /// makes them.
    /// @return false when the job was cancelled between two parts of the work; the next call continues there
    /// @throws SolverError naming the place where the stiffness is not positive definite
    bool prepare(const Job& job = {});
    /// Continues from another answer on the same mesh, for example with fewer near elements, with a new factor.
    /// @throws InputError when the displacement is not finite or turns an element over
    void start_from(const NearFrame& frame);

    /// Computes one frame. Hooks that would pass through each other stop where their lips meet.
    /// @throws InputError on a wrong number of hooks, and on drives that check_drive() refuses
    NearFrame drag(std::span<const HookDrive> drives);
    NearFrame drag(std::span<const Vec3> hook_displacements); ///< with prescribed displacements
    /// Iterates to equilibrium, with the hooks at the target of the last drag, or at rest.
    NearFrame settle(const Job& job = {});
    /// First-order prediction of the hooks' displacements at rest, from the present forces and factor.
    /// @throws as drag()
    std::vector<Vec3> predict_hook_displacements(std::span<const HookDrive> drives);
    /// Factors the stiffness of the present state. drag() makes no factor except the first, without prepare().
    void refresh();

    /// One Newton step on the whole body, with all of the tissue nonlinear and the present factors. The residual that
    /// settle() left in the near part does not count. The state does not change.
    FarChange far_change();

    std::size_t near_elements() const;
    std::size_t rim_vertices() const;
    std::size_t bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
