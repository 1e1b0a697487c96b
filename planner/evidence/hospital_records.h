#pragma once
// Hospital records on CT examinations with contrast medium, in an SQLite database. Dates are days without a time, as
// accounting systems keep them.
//
// A folder of CSV files with a header each; the columns may stand in any order, and others are ignored:
//   examinations.csv     examination, patient, date, contrast (0 or 1), inpatient (0 or 1)
//   administrations.csv  patient, date, drug, route, examination (at whose time it was given, or empty), ordered (yes,
//                        no, or empty where there is no order entry)
//   oxygen.csv           patient, date
//   surgery.csv          patient, date
//   truth.csv            examination, complication (0 or 1); optional: what the clinical records say
// Dates are YYYY-MM-DD. The tables have the files' names without an s at the end ("examination"), and besides the
// columns `line` (of the file) and, with a date, `day` (number of days since 1970-01-01).

#include "datasets/tables/csv_reader.h"
#include "datasets/tables/sqlite_statement.h"
#include "mesh/base/job.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

struct LoadedRecords {
    std::map<std::string, std::size_t> rows; ///< by table
    datasets::BadRows bad; ///< rows that were left out
    bool has_truth = false;
};

/// Whether rows that are wrong are left out, or stop the loading.
enum class BadRowPolicy { refuse, skip };

/// Loads the folder into an empty database. A row is bad when its date is none, a number or word is not one of those
/// above, an id is missing or repeated, or its examination is unknown or another patient's.
/// @throws InputError with the first bad rows where they are refused, and on a file without one of its columns; IoError
LoadedRecords load_hospital_records(const std::filesystem::path& folder, const datasets::SqliteDatabase& database,
    BadRowPolicy policy, const Job& job = {});

/// Days since 1970-01-01 of "YYYY-MM-DD"; nothing for another text or a day that no month has.
std::optional<int> day_of(std::string_view date);
/// The date of a day.
std::string date_of(int day);

} // namespace retractor::planner
