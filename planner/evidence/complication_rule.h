#pragma once
// Applies a rule that identifies a complication to hospital records, and judges it where the truth is known.

#include "datasets/tables/sqlite_statement.h"
#include "mesh/base/job.h"
#include "planner/evidence/binomial_interval.h"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

struct FoundExamination {
    std::string examination, patient, date;
    std::optional<bool> complication {}; ///< what the records say; not set: not known
};

struct MonthCount {
    std::size_t examinations = 0; ///< with contrast medium
    std::size_t found = 0;
};

/// What the rule found against what the clinical records say.
struct RuleJudgement {
    std::size_t right = 0; ///< found, and a complication
    std::size_t wrong = 0; ///< found, and none
    std::size_t missed = 0; ///< a complication that was not found
    std::size_t unknown = 0; ///< found, and nothing is known of it
    ShareInterval precision, recall; ///< at 95 %; of right / (right + wrong) and right / (right + missed)
};

struct RuleResult {
    std::size_t examinations = 0; ///< with contrast medium
    std::vector<FoundExamination> found; ///< in the order of their dates
    std::size_t patients = 0; ///< that were found
    std::map<std::string, MonthCount> months; ///< "2003-04", months with an examination
    std::optional<RuleJudgement> judgement {}; ///< where there is a table of the truth
};

/// @param sql one SELECT statement with a column `examination`
/// @throws InputError on a statement that is wrong, that changes the database, or that names an unknown examination;
/// IoError. The job's cancellation ends the statement, and nothing is found.
RuleResult apply_rule(
    const datasets::SqliteDatabase& database, std::string_view sql, bool has_truth, const Job& job = {});

} // namespace retractor::planner
