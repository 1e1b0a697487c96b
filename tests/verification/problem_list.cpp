#include "tests/verification/problem_list.h"

#include "tests/verification/analytic/analytic_problems.h"
#include "tests/verification/comparison/estimates.h"
#include "tests/verification/comparison/solver_problems.h"
#include "tests/verification/reference/given_files.h"
#include "tests/verification/stability/stability_families.h"

namespace retractor::verification {

std::vector<VerificationProblem> verification_problems()
{
    return { patch_test_problem(), null_space_problem(), pressed_tube_problem(), stretched_tube_problem(),
        tube_limit_problem(), fibre_tube_problem(), gape_problem(), drawn_ball_problem(), fast_paths_problem(),
        penny_problem(), indentation_problem(), homogeneous_problem(), manufactured_problem(), cook_problem(),
        cantilever_problem(), cardiac_beam_problem(), estimate_problem(), calculix_problem(), febio_problem() };
}

std::vector<VerificationProblem> ladder_problems() { return { solver_ladder_problem() }; }

std::vector<StabilityCase> stability_cases()
{
    return { incompressible_case(), bone_beside_fat_case(), tiny_element_case(), sharp_angles_case(),
        severed_piece_case(), cut_along_grid_case(), cut_through_hook_case(), hundred_cuts_case(), far_hook_case(),
        crossing_hooks_case(), meeting_hooks_case(), inverted_start_case(), high_pressure_case(), spring_step_case(),
        strange_case() };
}

} // namespace retractor::verification
