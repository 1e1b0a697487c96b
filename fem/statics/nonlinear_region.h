#pragma once
// Nonlinear tissue near the wound, linear tissue beyond: dragging hooks at frame rate. The far part is condensed once
// onto the rim between the two (condensed_region.h); the near part takes large strains and rotations. Units mm, N, MPa;
// frame patient LPS.
//
// A frame begins where the last one ended, moved along as the frames before it went and, where the hooks turn, as the
// factor at hand says; then come a few quasi-Newton steps [L-BFGS: Nocedal, Wright, Numerical optimization, 2006, alg.
// 7.4] on that factor of an earlier stiffness, each with an Armijo line search on the energy. Hyperelastic energies are
// infinite where an element would turn over: no step goes there, and a motion of the hooks that does is made in
// shorter parts. What is left unbalanced is the frame's residual, and the next frame goes on from it.
// settle() goes on to equilibrium, with new factors where the old one has become slow.
//
// How far a linear far field is off is told by what it leaves out: the forces of the far tissue by its own law where
// that field puts it, and one step of Newton's method on the whole body with the factors at hand (far_change()).
//
// With all elements near it is the fully nonlinear problem, solved the same way.

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

/// Flags the elements with a corner within `distance` (mm) of one of the points. @throws InputError when there is no
/// point, or the distance is not positive.
std::vector<std::uint8_t> elements_near(const mesh::TetMesh& mesh, const Points& points, double distance);

struct NonlinearRegionOptions {
    /// hyperelastic: by the materials' laws (hyperelastic_law()); corotational; bounded, which meshes with flat
    /// elements need, as cuts through patients leave them: no element stops a hook, and steps on an old factor
    /// converge. Never linear.
    Elasticity elasticity = Elasticity::hyperelastic;
    int frame_iterations = 3; ///< quasi-Newton steps of a frame
    double tolerance = 1e-6; ///< of settle(): largest residual force of a free node over the largest force of any node
    int max_iterations = 400; ///< of settle()
    Eigen::VectorXd load {}; ///< N, three per vertex, on vertices of near elements: tension set free; empty: none
};

enum class NearStatus {
    moving, ///< a frame: its residual says how far from equilibrium
    settled,
    not_settled,
    cancelled,
};

struct [[nodiscard]] NearFrame {
    NearStatus status = NearStatus::moving;
    std::string message {};
    Eigen::VectorXd displacement; ///< mm, three per vertex, the whole field
    /// Where the hooks are: where a force takes them, or short of what was asked for where they slip, grip softly or
    /// would turn tissue over.
    std::vector<Vec3> hook_displacements;
    bool reached = true; ///< they are where they should be
    /// What the surgeon must apply; where hooks meet, without what they press on each other with.
    std::vector<Vec3> hook_forces_N {};
    std::vector<bool> hook_yielded {}; ///< the force limit holds it back
    std::vector<FacingHooks> meeting {}; ///< hooks that hold each other back: their lips have met
    double residual = 0.0; ///< as NonlinearRegionOptions::tolerance
    int iterations = 0, factorisations = 0;
};

/// What the far tissue's own law would change at an answer, to first order.
struct FarChange {
    bool finite = true; ///< false: far elements are turned over, and hyperelastic tissue has no law for that
    Eigen::VectorXd displacement {}; ///< mm, three per vertex
    std::vector<Vec3> hook_forces_N {};
};

/// Larger of its shares of the displacement (root mean square: one loose sliver is no matter) and of the largest hook
/// force; infinite where there is none.
double relative_change(const FarChange& change, const NearFrame& frame);

class NonlinearRegion {
public:
    /// At rest, the hooks not moved.
    /// @param hooks their nodes; their displacement is not used.
    /// @param near one per element, 1 = nonlinear.
    /// @throws InputError on bad meshes, materials, supports, hooks, when no element is near, or a hook holds a node of
    /// a far element, or one that is not near is loaded; SolverError naming what is not held.
    NonlinearRegion(const mesh::TetMesh& mesh, std::span<const Material> material_of_label, const Supports& supports,
        std::vector<HookPatch> hooks, const std::vector<std::uint8_t>& near, NonlinearRegionOptions options = {});
    ~NonlinearRegion();
    NonlinearRegion(NonlinearRegion&&) noexcept;

    /// Factors the far part and, at rest, the near one; else what needs it first does so.
    /// @return false when the job was cancelled between two of its parts: the next call goes on from there.
    /// @throws SolverError naming the place where the stiffness is not positive definite.
    bool prepare(const Job& job = {});
    /// Goes on from another answer on the same mesh, e.g. of fewer near elements, with a new factor.
    /// @throws InputError when it is not finite or turns an element over.
    void start_from(const NearFrame& frame);

    /// One frame. Hooks that would pass through each other stop where their lips meet.
    /// @throws InputError on a wrong number of hooks, or drives that check_drive() refuses.
    NearFrame drag(std::span<const HookDrive> drives);
    NearFrame drag(std::span<const Vec3> hook_displacements); ///< these are prescribed
    /// To equilibrium, with the hooks where they are drawn to, or at rest.
    NearFrame settle(const Job& job = {});
    /// Where the hooks would rest, to first order: by the forces and the factor at hand. @throws as drag()
    std::vector<Vec3> foretold(std::span<const HookDrive> drives);
    /// A new factor where the body is now; drag() makes none but the first, where prepare() was not called.
    void refresh();

    /// One step of Newton's method on the whole body, all of it nonlinear, with the factor at hand, from the near part
    /// at rest: what settle() has left there is no part of it. Nothing moves.
    FarChange far_change();

    std::size_t near_elements() const;
    std::size_t rim_vertices() const;
    std::size_t bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
