#pragma once
// Made-up records with the counts that two studies published, and large random ones to measure time on. Nobody's data.

#include "mesh/base/job.h"

#include <cstddef>
#include <filesystem>

namespace retractor::planner {

/// Contrast examinations of the published year, 1 April 2003 to 31 March 2004 (Shinohara et al.).
inline constexpr std::size_t kPublishedExaminations = 14255;

/// Writes the files of load_hospital_records(): so many examinations with contrast medium, a tenth as many without, and
/// the patients that the study tells of. Accounting data show five: three with shock, one inpatient to whom the drug
/// was ordered, and one who was given a steroid to prevent shock, of which no order is known. Every tenth patient
/// misses one condition of the rule only: no oxygen, surgery, a drug two days before or three after, by mouth, or no
/// contrast medium.
/// @param examinations at least 5
/// @throws IoError, InputError
void write_complication_records(
    const std::filesystem::path& folder, std::size_t examinations = kPublishedExaminations, unsigned seed = 1);

/// Writes one CSV file with the marginals of the 13 published rules (Katsumura et al.): 795 records of 381 persons over
/// three years, the exposures A, B and C, and 241 findings, nine of them those of the rules. What was found in later
/// years differs from the earliest, and counts for nothing.
/// @throws IoError
void write_exposure_records(const std::filesystem::path& file, unsigned seed = 1);

/// Writes persons with independent findings, each held by a share of them. A cancelled job leaves no file.
/// @throws IoError
void write_random_findings(const std::filesystem::path& file, std::size_t persons, std::size_t findings, double share,
    unsigned seed = 1, const Job& job = {});

} // namespace retractor::planner
