#pragma once
// Error estimate of an answer on four-node elements: the difference from ten-node elements on the same mesh,
// linearised at the answer. Units mm, N; frame patient LPS.
//
// The estimate is one Newton step of the quadratic problem from the answer, by conjugate gradients on the
// hierarchical splitting into linear functions and edge functions [Bank, Smith 1993; Deuflhard, Leinen, Yserentant
// 1989]. The preconditioner solves the linear part by its factor and the edge functions by their diagonal blocks;
// edge functions in contact are solved together (two_level_preconditioner.h). No ten-node system is factorised. The
// number of iterations does not grow with the mesh, but grows to several hundred with the flatness of the elements.
// The step includes the algebraic residual of the answer.
//
// The estimate covers the discretisation within the given model (materials, supports, and patches as the mesh
// represents them), to first order at the answer. The answer may come from any solver with these nodes, for example
// from locking-free elements or from a model that is linear far from the wound. The step then leads from that answer
// to ten-node elements with the whole elasticity; energy_error and algebraic_error do not refer to the equations that
// were solved. Blades in contact touch the same samples in both elements; the step is linearised at those that touch
// in the answer. For smooth fields the step is nearly the whole error. Along the rims of patches and at the ends of
// cuts stress has no bound. There doubling the degree removes three quarters of the error in energy [Babuska, Szabo,
// Katz 1981: twice the rate of mesh refinement]; kErrorShare accounts for the rest.

#include "fem/error_estimation/body_estimate.h"
#include "fem/material/elasticity.h"
#include "fem/model/contact.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/base/job.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// Share of the error that ten-node elements remove where stress is singular like one over the root of the distance.
inline constexpr double kErrorShare = 0.75;
/// Factor of safety on the error of ten-node elements by recovered gradients (gradient_recovery.h), which miss part
/// of the error at the ends of cuts and the rims of patches. With this factor the bars of forces of cut sheets,
/// blocks under patches and clamped bars are 0.5 to 2.2 times the error at nu 0.3 to 0.49, and up to 3.5 times where
/// elements are as large as the patch at nu 0.49.
inline constexpr double kRecoverySafety = 1.2;
/// Largest valid result of ten_node_share(). Ten-node elements whose remaining error exceeds the change that they
/// make tell nothing about their error.
inline constexpr double kMostShare = 1.0;
/// Largest valid result of ten_node_share() where only a part of the elements has ten nodes. The others have an error
/// too, which does not change; it may be larger than the change that the ten-node elements make. The phantom's median
/// sternotomy has a share of 2.8, and its bar contains the answer of finer meshes. Beyond four nothing was compared.
inline constexpr double kMostShareOfMixed = 4.0;
/// Least remaining share for an opening. An opening is not an energy, and the ends of the cut influence an opening
/// more. Ten-node elements are therefore taken to lack at least this share of the difference, as at a singularity.
inline constexpr double kLeastOpeningShare = (1.0 - kErrorShare) / kErrorShare;

struct [[nodiscard]] ErrorEstimate {
    EstimateStatus status = EstimateStatus::done;
    std::string message;
    Points displacement; ///< n x 3, mm: the answer plus the change by ten-node elements, at the vertices of the mesh
    std::vector<Vec3> hook_forces_N; ///< forces of the hooks in the ten-node model, N
    Eigen::VectorXd ten_node; ///< that displacement at all nodes of with_midpoints(), mm, three per node
    /// n x 3, mm: displacement of plain four-node elements, to first order; equals an answer by plain four-node
    /// elements
    Points plain;
    /// forces of the hooks for `plain`, N
    std::vector<Vec3> plain_forces_N;
    double energy_error = 0.0; ///< energy norm of the step, relative to the energy norm of the answer
    double algebraic_error = 0.0; ///< the part of energy_error from equations that the answer left unsolved
    int iterations = 0;
};

/// Estimates the error of an answer on four-node elements.
/// @param problem four-node elements.
/// @param elasticity elasticity of the answer.
/// @param displacement the answer, n x 3, mm; must satisfy supports and hooks.
/// @param contact contact of the answer; the errors in energy norm then include the error of the penalty.
/// @throws InputError on ten-node elements, and on a displacement that is not finite or violates supports or hooks.
/// @throws SolverError when the stiffness is not positive definite.
ErrorEstimate estimate_error(const ElasticProblem& problem, Elasticity elasticity, const Points& displacement,
    const Job& job = {}, const std::optional<ContactOptions>& contact = {});

/// Remaining error of a ten-node result, relative to the difference between plain four-node elements and ten-node
/// elements on the same mesh: share_left() of gradient_recovery.h times kRecoverySafety. The error of an answer by
/// other four-node elements is its difference from the ten-node answer plus this remaining error. A result above
/// kMostShare (kMostShareOfMixed), or one that is not finite, is not an estimate: the elements are too large or too
/// flat.
/// @param ten_node three per node of problem.mesh, mm.
/// @param plain n x 3 at the corners, mm.
double ten_node_share(
    const ElasticProblem& problem, Elasticity elasticity, const Eigen::VectorXd& ten_node, const Points& plain);

/// The same problem with ten-node elements. A midpoint is held where one hook, or the supports, hold a whole boundary
/// face or a whole element.
/// @param elements as with_midpoints() of tet_mesh.h
ElasticProblem with_midpoints(const ElasticProblem& problem, std::span<const std::uint8_t> elements = {});

/// The same problem with four-node elements at the corners of ten-node elements.
/// @pre corners come first, then the nodes of blades, midpoints last
ElasticProblem without_midpoints(const ElasticProblem& problem);

} // namespace retractor::fem
