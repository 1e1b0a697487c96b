#pragma once
// Draft plans with many values of stiffness, a few processes at a time. A process plans several samples of one
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

/// A draft plan of one approach with one set of stiffness.
struct SampleDraft {
    BatchJob job; ///< as run_batch() would plan it
    planner::StiffnessFactors factors; ///< empty: those of the case
};

/// As run_batch(), for drafts of one case.
/// @param words arguments of this program by which a process calls plan_drafts_here() for drafts of one approach
BatchRun run_sample_drafts(const std::vector<SampleDraft>& drafts, const std::filesystem::path& folder,
    const BatchSettings& settings, const std::function<std::vector<std::string>(std::span<const std::size_t>)>& words,
    const Job& job);

/// Plans drafts of one approach one after the other in this process, and writes numbers and status of each.
/// @throws as planner::plan_samples()
void plan_drafts_here(const std::vector<SampleDraft>& drafts, const std::filesystem::path& folder, const Job& job);

} // namespace retractor::ui::cli
