#pragma once
// How far an answer on four-node elements is from what a finer discretisation would say: the same wound with ten-node
// elements on the same mesh, linearised at the answer. Units mm, N; frame patient LPS.
//
// One Newton step of the quadratic problem from the answer, by conjugate gradients on the hierarchical splitting into
// linear and edge functions [Bank, Smith 1993; Deuflhard, Leinen, Yserentant 1989]: the linear part by its factor, the
// edge functions by their diagonal blocks, those in contact together (two_level_preconditioner.h). No ten-node system
// is factorised. The number of iterations does not grow with the mesh, but with how flat its elements are: to some
// hundreds. What the answer left unsolved (the algebraic residual) is part of the step.
//
// What it holds for: the discretisation, in the model as it is (materials, supports, patches as the mesh holds them),
// and to first order at the answer. The answer may come from anything with these nodes: of locking-free elements, or
// linear far from the wound; the step is then the way from there to ten-node elements of the whole elasticity, and the
// errors in energy norm and of equations left unsolved are not those of the equations that were solved. Exact where
// quadratic elements are: for smooth fields it is nearly the whole error. Along the rims of patches and the ends of
// cuts, where stress has no bound, halving the size of an element by degree removes three quarters of the error in
// energy [Babuska, Szabo, Katz 1981: twice the rate of refinement], which kErrorShare makes up for.

#include "fem/error_estimation/body_estimate.h"
#include "fem/material/elasticity.h"
#include "fem/model/contact.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/base/job.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::fem {

/// Share of the error that ten-node elements remove where the field is singular like the root of the distance.
inline constexpr double kErrorShare = 0.75;
/// On what recovered gradients say of ten-node elements' own errors (gradient_recovery.h): at the ends of cuts and the
/// rims of patches they see less than all. With it forces of cut sheets, blocks under patches and clamped bars have 0.5
/// to 2.2 times their error, nu 0.3 to 0.49; up to 3.5 where elements are as large as the patch at nu 0.49.
inline constexpr double kRecoverySafety = 1.2;
/// Ten-node elements that lack more of a number than they add to it say nothing of their error.
inline constexpr double kMostShare = 1.0;
/// An opening is no energy, and the ends of the cut weigh more upon it: ten-node elements lack at least this share of
/// the difference, as they do where the field is singular.
inline constexpr double kLeastOpeningShare = (1.0 - kErrorShare) / kErrorShare;

struct [[nodiscard]] ErrorEstimate {
    EstimateStatus status = EstimateStatus::done;
    std::string message;
    Points displacement; ///< n x 3, mm: the answer with what finer elements would add, at the vertices of the mesh
    std::vector<Vec3> hook_forces_N; ///< in the finer model
    Eigen::VectorXd ten_node; ///< that displacement at all nodes of with_midpoints(), three each
    Points
        plain; ///< n x 3, mm: what plain four-node elements say, to first order; the answer itself where it is theirs
    std::vector<Vec3> plain_forces_N;
    double energy_error = 0.0; ///< energy norm of the step over that of the answer
    double algebraic_error = 0.0; ///< the part of it that lies in the space of the answer: equations left unsolved
    int iterations = 0;
};

/// @param problem four-node elements. @param elasticity of the answer. @param displacement the answer, n x 3, mm; at
/// rest it must satisfy supports and hooks.
/// @param contact what the answer was found with; its errors in energy norm then contain the penalty's.
/// @throws InputError on ten-node elements, a displacement that is not finite or that supports or hooks do not
/// prescribe; SolverError when the stiffness is not positive definite.
ErrorEstimate estimate_error(const ElasticProblem& problem, Elasticity elasticity, const Points& displacement,
    const Job& job = {}, const std::optional<ContactOptions>& contact = {});

/// What ten-node elements still lack of a number, over the difference between plain four-node elements and them on the
/// same mesh: share_left() of gradient_recovery.h with kRecoverySafety. An answer by other four-node elements is off by
/// its difference from the ten-node one and this together.
/// Above kMostShare, or not finite, it is no estimate: elements are too large or too flat to tell by.
/// @param ten_node three per node of problem.mesh. @param plain n x 3 at the corners.
double ten_node_share(
    const ElasticProblem& problem, Elasticity elasticity, const Eigen::VectorXd& ten_node, const Points& plain);

/// The same problem with ten-node elements: midpoints are held where a whole boundary face or a whole element is held
/// by one hook, or by the supports.
ElasticProblem with_midpoints(const ElasticProblem& problem);

/// The other way: four-node elements with the corners of ten-node ones. @pre corners come first, midpoints last.
ElasticProblem without_midpoints(const ElasticProblem& problem);

} // namespace retractor::fem
