#pragma once
// Plans with many values of stiffness, a few processes at a time. A process plans several samples of one
// approach, which share the cut wall and begin at one opening (planner::plan_samples()).

#include "mesh/base/job.h"
#include "planner/case/stiffness_factors.h"
#include "ui/cli/batch/run_batch.h"
#include "ui/cli/batch/sweep.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// A plan of one approach with one set of stiffness.
struct SamplePlan {
    BatchJob job; ///< name, folder and identity; without error bars and in the region that is found
    planner::StiffnessFactors factors; ///< empty: those of the case
};

/// As run_batch(), for plans of one case.
/// @param words arguments of this program by which a process calls plan_samples_here() for plans of one approach
BatchRun run_sample_plans(const std::vector<SamplePlan>& plans, const std::filesystem::path& folder,
    const BatchSettings& settings, const std::function<std::vector<std::string>(std::span<const std::size_t>)>& words,
    const Job& job);

/// Plans samples of one approach one after the other in this process, and writes numbers and status of each.
/// @param draft plans a draft of the case (planner::make_draft())
/// @throws as planner::plan_samples()
void plan_samples_here(
    const std::vector<SamplePlan>& plans, bool draft, const std::filesystem::path& folder, const Job& job);

} // namespace retractor::ui::cli
