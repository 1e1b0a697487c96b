#pragma once
// The opened wound for other programs: written as a deck for CalculiX or FEBio, and solved once more by CalculiX (ccx,
// optional) to compare with our own answer: linearly, on the same mesh, with the same supports and hooks.

#include "fem/statics/elastic_problem.h"
#include "mesh/base/job.h"
#include "planner/measures/field_metrics.h"

#include <chrono>
#include <filesystem>
#include <string>

namespace retractor::ui::cli {

/// The program ccx. @throws IoError saying how to install it when there is none on the PATH.
std::filesystem::path find_calculix();

/// What a .dat file's seven digits leave room for, relative to the largest displacement.
inline constexpr double kReferenceAgreement = 1e-6;

/// Solves the problem linearly, ours and with `ccx`, and compares. ccx runs in `folder`/<name>-ccx, which is removed
/// when it answered and kept, with its output in ccx.log, when it did not. A ccx that fails, does not end within
/// `limit` or writes no whole answer is a status of the result.
/// @throws SolverError when our own solution fails or the job is cancelled, IoError when the folder cannot be written.
planner::SecondOpinion second_opinion(const fem::ElasticProblem& problem, const std::filesystem::path& ccx,
    const std::filesystem::path& folder, const std::string& name, std::chrono::milliseconds limit, const Job& job);

/// Writes <name>.inp ("ccx") or <name>.feb ("feb"). @returns the file. @throws IoError when it cannot be written.
std::filesystem::path export_problem(const fem::ElasticProblem& problem, const std::string& format,
    const std::filesystem::path& folder, const std::string& name);

} // namespace retractor::ui::cli
