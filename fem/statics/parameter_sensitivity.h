#pragma once
// How forces and displacements of an opened wound change with the stiffness of its tissues and springs: the derivative
// at a solution, to first order and exactly, from one factorisation.
//
// The forces of a tissue on the nodes, f_i(u), are in proportion to its moduli; so are the forces of springs, and the
// loads that its tension releases. In equilibrium their sum, less other loads, is zero at free nodes. A relative change
// of tissue i by d(ln E_i) therefore moves free nodes by du with K du = -f_i, where hooks and supports stand still, and
// changes the forces on the held nodes by f_i + K du. This is the direct method of design sensitivity analysis
// (Haftka, Gurdal 1992, Elements of Structural Optimization, 7.2).
//
// Where all stiffnesses grow alike, no node moves, and the forces of hooks that are held in place grow by the same
// share: the derivatives of ln F by all ln E_i, springs included, add up to 1, with any law. Two things do not take
// part, and the sum differs from 1 where they act: pressure of the surroundings, and the penalty of contact.
//
// Hooks that do not stand still follow their equilibrium: hooks that are driven by forces, grips or limits
// (hook_drive.h), and the frame of a retractor (blade_frame.h). Units mm, N, MPa.

#include "fem/statics/blade_frame.h"
#include "fem/statics/driven_opening.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/hook_drive.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// A stiffness that may be other than it is: of tissue, springs or hinges. The moduli of all its members change alike.
struct StiffnessParameter {
    std::string name; ///< for messages
    std::vector<Label> labels {}; ///< tissue with these labels
    std::vector<std::size_t> springs {}; ///< indices into Supports::bedded
    std::vector<std::size_t> hinges {}; ///< indices into Supports::hinges
};

/// Derivatives by the natural logarithms of the parameters, one column per parameter.
struct ParameterSensitivity {
    HookResponse response; ///< to the motions of the held nodes that were asked
    Eigen::MatrixXd displacement; ///< of all nodes, mm, three rows per node, with the hooks where they are
    Eigen::MatrixXd nodal_forces_N; ///< forces on the nodes of hooks, three rows per node; zero at other nodes
};

/// Differentiates a solution.
/// @param displacement n x 3, mm, in equilibrium
/// @param motions of the hooks (hook_motions(), or blade_motions() of a retractor), for ParameterSensitivity::response
/// @throws InputError naming the parameter with a label that another parameter has or that is not in the mesh, a spring
/// or hinge that another parameter has or that is out of range, or no member; on a displacement or motions of the wrong
/// size; as TissueLinearisation
ParameterSensitivity parameter_sensitivity(const ElasticProblem& problem, const TissueModel& model,
    const Points& displacement, std::span<const StiffnessParameter> parameters, const Eigen::MatrixXd& motions,
    const std::optional<ContactOptions>& contact = {});

/// The change of a solution in which the hooks have followed their equilibrium, one column per parameter.
struct EquilibriumSensitivity {
    Eigen::MatrixXd displacement; ///< of all nodes, mm, three rows per node
    Eigen::MatrixXd hook_forces_N; ///< three rows per hook
};

/// Hooks that stand still.
EquilibriumSensitivity with_held_hooks(const ElasticProblem& problem, const ParameterSensitivity& sensitivity);

/// Hooks with drives.
/// @param sensitivity with hook_motions()
/// @param at, forces displacement of the hooks and forces on the hooks in the solution, three per hook
/// @return nothing when the hooks have no equilibrium in the linearised tissue
std::optional<EquilibriumSensitivity> with_driven_hooks(const ElasticProblem& problem,
    const ParameterSensitivity& sensitivity, const Eigen::VectorXd& at, const Eigen::VectorXd& forces,
    const std::vector<HookDrive>& drives);

/// The retractor of a solution in balance.
struct BalancedFrame {
    BladeFrame frame;
    FrameState state;
    std::array<BladeLoad, 2> loads; ///< that the retractor applies to the tissue
    bool driven_by_force = false; ///< the rack is driven by force, and its distance changes
    bool direction_is_held = false; ///< as FrameOpening::direction_is_held: the frame does not tilt
};

/// A retractor that finds its balance again. A blade at the end of its play stays there.
/// @param problem its two hooks are the blades, at their places
/// @param sensitivity with blade_motions()
EquilibriumSensitivity with_balanced_frame(
    const ElasticProblem& problem, const ParameterSensitivity& sensitivity, const BalancedFrame& retractor);

} // namespace retractor::fem
