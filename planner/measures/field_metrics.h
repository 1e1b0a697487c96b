#pragma once
// The numbers of one planned surgical field, as plain data: what metrics.json, the report and the legends show.
// Units mm, N; fractions 0 to 1. Definitions: README, "What the numbers mean".

#include "fem/material/tissue_tension.h"
#include "mesh/base/geometry.h"
#include "planner/case/approach.h"
#include "planner/case/solver_settings.h"
#include "planner/wall/removed_tissue.h"
#include "planner/wall/wall_pressure.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// A structure between the eyes and the target, with the share of sight lines it is the first to block.
struct SightBlocker {
    std::string name;
    double share = 0.0;
    bool bone = false;
};

struct HookForce {
    std::string name;
    int side = 0; ///< +1 or -1: the lip it pulls
    double force_N = 0.0;
    bool pushes = false; ///< holds the lip back, which would go farther without it: no part of the side's sum
    double moved_mm = 0.0; ///< the tissue under it
    double asked_mm = 0.0; ///< of the hook; nothing where it pulls with a force
    HookPull pull {};
    bool yielded = false; ///< its limit holds it back
};

/// The same wound with all of the wall solved as the part near it was: what linearising the rest changed.
struct WholeMetrics {
    std::string message {}; ///< why it has no numbers; empty: it has
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0, hook_force_N = 0.0;
    double lips_difference = 0.0; ///< largest distance between the lips' places, over the largest displacement
    double seconds = 0.0;
};

/// What became of the linear tissue far from the lips.
struct FarFieldMetrics {
    bool linear = true; ///< false: it was off by too much, and all of the wall is nonlinear
    double linear_share = 1.0; ///< not linear: of the hooks' way that was made with it
    std::string message {}; ///< linear: why how far that is off is not told; empty: it is
    /// Linear: what the tissue's own law would change there, to first order (OpeningOptions::far_tolerance).
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0, hook_force_N = 0.0;
};

/// Tension that tissue was under before the cut, and what it does to the wound by itself.
struct TensionMetrics {
    std::vector<std::pair<std::string, fem::PreStrain>> tissues; ///< materials of the wall, with the pre-strain of each
    std::string message {}; ///< why there is no gape; empty: there is
    double gape_mm = 0.0, gape_area_mm2 = 0.0; ///< opening width and area before any hook pulls
    double seconds = 0.0; ///< that it took
};

/// How the wound was solved.
struct SolutionMetrics {
    SolverSettings choice {};
    std::size_t nodes = 0; ///< of the wall, midpoints too
    std::vector<std::pair<std::string, std::string>> laws {}; ///< of hyperelastic tissue: material and law
    std::size_t near_tets = 0; ///< nonlinear ones, where the rest is linear
    std::optional<FarFieldMetrics> far {}; ///< where there was one, and an equilibrium
    std::optional<WholeMetrics> whole {}; ///< all of it nonlinear, when that was asked for
};

/// Of an answer by plain four-node elements, all of one elasticity.
struct EnergyBars {
    double energy_error = 0.0; ///< in energy norm, relative
    double algebraic_error = 0.0; ///< the part of it that comes from equations left unsolved
};

/// How far the numbers of the mechanics may be off, by what ten-node elements on the same mesh would add to the answer.
/// Of the discretisation only, to first order at the answer (fem/error_estimate.h): the model, its materials and its
/// supports may be off by more. Driven hooks are let go in that answer (hook_equilibrium_correction.h).
struct ErrorBars {
    std::string message; ///< why there is no estimate; empty: there is one
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0;
    std::vector<double> hook_forces_N; ///< in the order of the hooks; 0 where the force is what was asked for
    std::vector<double> hook_moved_mm; ///< 0 where the hook is told its place
    double side_forces_N[2] = { 0.0, 0.0 }; ///< sides +1 and -1
    double hook_force_N = 0.0; ///< of the larger side
    std::optional<EnergyBars> energy; ///< where it is known
    double seconds = 0.0;
};

/// The opened wound solved once more by another program: the same mesh, element, supports and hooks, linearly.
struct SecondOpinion {
    std::string program;
    std::string status; ///< "agrees", "differs", "failed"
    std::string message; ///< why it failed, and what to do
    double displacement_difference = 0.0; ///< largest, over the largest displacement
    double force_difference = 0.0; ///< largest of a hook, over the largest hook force
    double largest_displacement_mm = 0.0;
    std::vector<double> hook_forces_N, own_hook_forces_N; ///< linear, in the order of the hooks
    double seconds = 0.0, own_seconds = 0.0;
};

/// Where surfaces hold each other off, when that was asked for.
struct ContactMetrics {
    std::size_t touching = 0; ///< points
    double largest_penetration_mm = 0.0;
    double force_N = 0.0; ///< sum of the points' forces' sizes
    double overlap_at_rest_mm = 0.0; ///< the deepest of surfaces that overlapped before: kept, without a force
};

struct FieldMetrics {
    std::string name; ///< of the approach
    std::string target;

    double visible_fraction = 0.0; ///< of the target's area, seen from at least one eye of the cone
    double visible_fraction_mean_eye = 0.0; ///< mean over the eyes of the cone
    double visible_fraction_central_eye = 0.0;
    double visible_fraction_wall_removed = 0.0; ///< upper bound: the same cone with no wall in the way
    double eye_distance_mm = 0.0, cone_half_angle_deg = 0.0;
    int eyes = 0, target_samples = 0;
    std::vector<SightBlocker> blockers; ///< largest share first
    std::vector<std::string> bone_in_sight;
    std::vector<std::string> retracted; ///< organs held aside in this approach

    double opening_area_mm2 = 0.0;
    double opening_width_mm = 0.0;
    double working_distance_mm = 0.0;
    double incision_length_mm = 0.0;
    double cut_depth_mm = 0.0;

    std::vector<HookForce> hooks;
    double hook_force_N = 0.0; ///< sum of the larger side
    double strain_p99 = 0.0;
    std::optional<Vec3> strain_p99_at; ///< at rest, mm: middle of the element that has it
    int inverted_elements = 0;
    double max_volume_ratio = 1.0;
    double residual = 0.0; ///< of the mechanical equilibrium, relative
    std::string mechanics_status; ///< "converged", or what happened instead
    SolutionMetrics solution;

    std::vector<RemovedTissue> removed; ///< by ablations and as loose pieces
    double removed_skin_mm2 = 0.0; ///< area, at rest, of the skin on it: no part of the opening, which the lips bound
    std::vector<std::string> loose_pieces; ///< what the cut left without support, and what became of it

    std::size_t tets = 0;
    std::vector<std::pair<std::string, double>> seconds; ///< per stage, in order

    std::optional<ContactMetrics> contact;
    std::vector<PressureMetrics> pressures; ///< on the wall
    std::optional<TensionMetrics> tension; ///< where tissue of the wall is under some
    std::optional<ErrorBars> error;
    std::optional<SecondOpinion> second_opinion; ///< when it was asked for

    std::string explanation; ///< why the field is as it is, in words
};

} // namespace retractor::planner
