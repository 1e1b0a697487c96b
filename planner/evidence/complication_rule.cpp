#include "planner/evidence/complication_rule.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <memory>
#include <set>

namespace retractor::planner {

namespace {

    constexpr const char* kWhere = "rule";

    /// Ends statements while it lives when the job is cancelled.
    class CancelledByJob {
    public:
        CancelledByJob(const datasets::SqliteDatabase& database, const Job& job)
            : database_(database)
        {
            constexpr int kInstructions = 100'000; // between two questions whether the job is cancelled
            sqlite3_progress_handler(
                database.handle.get(), kInstructions,
                [](void* asked) { return static_cast<const Job*>(asked)->cancelled() ? 1 : 0; },
                const_cast<Job*>(&job)); // the handler only reads
        }
        ~CancelledByJob() { sqlite3_progress_handler(database_.handle.get(), 0, nullptr, nullptr); }
        CancelledByJob(const CancelledByJob&) = delete;
        CancelledByJob& operator=(const CancelledByJob&) = delete;

    private:
        const datasets::SqliteDatabase& database_;
    };

    /// The examinations that the rule gives. @throws InputError as apply_rule()
    std::set<std::string> found_by(const datasets::SqliteDatabase& database, std::string_view sql, const Job& job)
    {
        const CancelledByJob cancelled(database, job);
        sqlite3_stmt* handle = nullptr;
        const char* tail = nullptr;
        const int prepared
            = sqlite3_prepare_v2(database.handle.get(), sql.data(), static_cast<int>(sql.size()), &handle, &tail);
        const std::unique_ptr<sqlite3_stmt, datasets::CloseSqlite> statement(handle);
        if (prepared != SQLITE_OK)
            throw InputError(std::string("is wrong: ") + sqlite3_errmsg(database.handle.get()), kWhere);
        if (!statement)
            throw InputError("holds no statement", kWhere);
        if (sqlite3_stmt_readonly(handle) == 0)
            throw InputError("changes the database; a rule is one SELECT statement", kWhere);
        sqlite3_stmt* second = nullptr; // nothing where only spaces and comments follow
        const int rest = sqlite3_prepare_v2(
            database.handle.get(), tail, static_cast<int>(sql.data() + sql.size() - tail), &second, nullptr);
        const std::unique_ptr<sqlite3_stmt, datasets::CloseSqlite> other(second);
        if (rest != SQLITE_OK || other)
            throw InputError("holds more than one statement", kWhere);
        int column = -1;
        for (int c = 0; c < sqlite3_column_count(handle); ++c)
            if (std::string_view(sqlite3_column_name(handle, c)) == "examination")
                column = c;
        if (column < 0)
            throw InputError("gives no column \"examination\"", kWhere);
        std::set<std::string> found;
        int result = SQLITE_ROW;
        while ((result = sqlite3_step(handle)) == SQLITE_ROW) {
            const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle, column));
            if (text == nullptr)
                throw InputError("gives a row without an examination", kWhere);
            found.insert(text);
        }
        if (result == SQLITE_INTERRUPT)
            return {};
        if (result != SQLITE_DONE)
            throw InputError(std::string("cannot be carried out: ") + sqlite3_errmsg(database.handle.get()), kWhere);
        return found;
    }

    RuleJudgement judged(const RuleResult& result, std::size_t complications)
    {
        RuleJudgement judgement;
        for (const FoundExamination& found : result.found)
            ++(!found.complication ? judgement.unknown : *found.complication ? judgement.right : judgement.wrong);
        judgement.missed = complications - judgement.right;
        judgement.precision = clopper_pearson_interval(judgement.right, judgement.right + judgement.wrong);
        judgement.recall = clopper_pearson_interval(judgement.right, complications);
        return judgement;
    }

} // namespace

RuleResult apply_rule(const datasets::SqliteDatabase& database, std::string_view sql, bool has_truth, const Job& job)
{
    RuleResult result;
    datasets::SqliteStatement months(
        database, "SELECT substr(date, 1, 7), count(*) FROM examination WHERE contrast = 1 GROUP BY 1 ORDER BY 1");
    while (months.step()) {
        const auto count = static_cast<std::size_t>(months.integer(1));
        result.months[months.text(0)].examinations = count;
        result.examinations += count;
    }
    datasets::SqliteStatement details(database,
        has_truth ? "SELECT e.patient, e.date, t.complication FROM examination AS e LEFT JOIN truth AS t "
                    "ON t.examination = e.examination WHERE e.examination = ?"
                  : "SELECT patient, date, NULL FROM examination WHERE examination = ?");
    std::set<std::string> patients;
    for (const std::string& examination : found_by(database, sql, job)) {
        details.reset();
        details.bind(std::string_view(examination));
        if (!details.step())
            throw InputError("gives the examination \"" + examination + "\", which there is none", kWhere);
        FoundExamination found { .examination = examination, .patient = details.text(0), .date = details.text(1) };
        if (sqlite3_column_type(details.handle(), 2) != SQLITE_NULL)
            found.complication = details.integer(2) != 0;
        ++result.months[found.date.substr(0, 7)].found;
        patients.insert(found.patient);
        result.found.push_back(std::move(found));
    }
    std::ranges::stable_sort(result.found, {}, &FoundExamination::date);
    result.patients = patients.size();
    if (has_truth) {
        datasets::SqliteStatement count(database, "SELECT count(*) FROM truth WHERE complication = 1");
        count.step();
        result.judgement = judged(result, static_cast<std::size_t>(count.integer(0)));
    }
    return result;
}

} // namespace retractor::planner
