#pragma once
// Passes the opened wound to other programs. The problem is written as a deck for CalculiX or FEBio. CalculiX (ccx,
// optional) solves the problem again for comparison: linearly, on the same mesh, with the same supports and hooks.

#include "fem/statics/elastic_problem.h"
#include "mesh/base/job.h"
#include "planner/measures/field_metrics.h"

#include <chrono>
#include <filesystem>
#include <string>

namespace retractor::ui::cli {

/// The program ccx. @throws IoError with the way to install it when there is none on the PATH
std::filesystem::path find_calculix();

/// Largest difference relative to the largest displacement that counts as agreement; a .dat file has seven digits.
inline constexpr double kReferenceAgreement = 1e-6;

/// Solves the problem linearly with our solver and with `ccx`, and compares the solutions.
/// ccx runs in `folder`/<name>-ccx. This folder is removed after a complete answer. Otherwise the folder stays, with
/// the output of ccx in ccx.log. A ccx that fails, exceeds `limit` or writes an incomplete answer becomes a status of
/// the result.
/// @throws SolverError when our own solution fails or the job is cancelled; IoError when the folder cannot be written
planner::SecondOpinion second_opinion(const fem::ElasticProblem& problem, const std::filesystem::path& ccx,
    const std::filesystem::path& folder, const std::string& name, std::chrono::milliseconds limit, const Job& job);

/// Writes <name>.inp ("ccx") or <name>.feb ("feb").
/// @returns the file
/// @throws IoError when the file cannot be written
std::filesystem::path export_problem(const fem::ElasticProblem& problem, const std::string& format,
    const std::filesystem::path& folder, const std::string& name);

} // namespace retractor::ui::cli
