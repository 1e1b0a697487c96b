#pragma once
// A sweep: cases x approaches x variants, each of them one job. Plain data, read from a JSON file:
//
//   { "cases": ["a/case.json", "b/case.json"],      paths from the folder of the sweep's file
//     "approaches": ["median"],                     not given: all approaches of each case
//     "variants": { "draft": ["--draft"] },         options of retractor plan; not given: one variant without options
//     "render": true }                              pictures and a report of each job; not given: true

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// One plan of the sweep.
struct BatchJob {
    std::string name; ///< of the job's folder; unique in its sweep
    std::filesystem::path case_file; ///< absolute
    std::string approach, variant;
    std::vector<std::string> options; ///< of retractor plan
};

/// Reads a sweep and the cases that it names.
/// @throws IoError where the file cannot be read; InputError naming the place in the file on an unknown key, a case
/// that cannot be read, an approach that a case does not have, an option that the batch itself sets, and no job at all
std::vector<BatchJob> read_sweep(const std::filesystem::path& file);

} // namespace retractor::ui::cli
