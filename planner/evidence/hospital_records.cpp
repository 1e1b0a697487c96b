#include "planner/evidence/hospital_records.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <span>
#include <vector>

namespace retractor::planner {

namespace {

    namespace fs = std::filesystem;

    enum class ColumnKind {
        id, ///< text that is not empty
        optional_id,
        date,
        flag, ///< 0 or 1
        drug,
        route,
        ordered,
    };

    struct Column {
        const char* name;
        ColumnKind kind;
    };

    struct Table {
        const char* name;
        const char* file;
        std::span<const Column> columns;
        bool has_key = false; ///< the first column occurs once
        bool required = true;
    };

    constexpr Column kExaminations[] = { { "examination", ColumnKind::id }, { "patient", ColumnKind::id },
        { "date", ColumnKind::date }, { "contrast", ColumnKind::flag }, { "inpatient", ColumnKind::flag } };
    constexpr Column kAdministrations[] = { { "patient", ColumnKind::id }, { "date", ColumnKind::date },
        { "drug", ColumnKind::drug }, { "route", ColumnKind::route }, { "examination", ColumnKind::optional_id },
        { "ordered", ColumnKind::ordered } };
    constexpr Column kPatientDays[] = { { "patient", ColumnKind::id }, { "date", ColumnKind::date } };
    constexpr Column kTruth[] = { { "examination", ColumnKind::id }, { "complication", ColumnKind::flag } };

    constexpr std::array kTables {
        Table { "examination", "examinations.csv", kExaminations, true },
        Table { "administration", "administrations.csv", kAdministrations },
        Table { "oxygen", "oxygen.csv", kPatientDays },
        Table { "surgery", "surgery.csv", kPatientDays },
        Table { "truth", "truth.csv", kTruth, true, false },
    };

    constexpr std::string_view kDrugs[] = { "antihistamine", "steroid", "other" };
    constexpr std::string_view kRoutes[] = { "iv", "im", "oral", "other" };
    constexpr std::string_view kOrders[] = { "yes", "no", "" };

    bool is_one_of(const std::string& text, std::span<const std::string_view> words)
    {
        return std::ranges::find(words, text) != words.end();
    }

    std::string listed(std::span<const std::string_view> words)
    {
        std::string text;
        for (const std::string_view word : words)
            text += (text.empty() ? "" : ", ") + (word.empty() ? "empty" : std::string(word));
        return text;
    }

    /// Reason why a field is wrong; empty: it is right.
    std::string fault(const Column& column, const std::string& text)
    {
        const auto unlike = [&](const std::string& expected) {
            return std::string(column.name) + " is \"" + text + "\", expected " + expected;
        };
        switch (column.kind) {
        case ColumnKind::id:
            return text.empty() ? std::string(column.name) + " is missing" : std::string();
        case ColumnKind::optional_id:
            return {};
        case ColumnKind::date:
            return day_of(text) ? std::string() : unlike("a date such as 2003-04-01");
        case ColumnKind::flag:
            return text == "0" || text == "1" ? std::string() : unlike("0 or 1");
        case ColumnKind::drug:
            return is_one_of(text, kDrugs) ? std::string() : unlike(listed(kDrugs));
        case ColumnKind::route:
            return is_one_of(text, kRoutes) ? std::string() : unlike(listed(kRoutes));
        case ColumnKind::ordered:
            return is_one_of(text, kOrders) ? std::string() : unlike(listed(kOrders));
        }
        return {};
    }

    std::string create_statement(const Table& table)
    {
        std::string sql = std::string("CREATE TABLE ") + table.name + " (line INTEGER NOT NULL";
        bool first = true;
        for (const Column& column : table.columns) {
            sql += std::string(", ") + column.name + (column.kind == ColumnKind::flag ? " INTEGER" : " TEXT")
                + (column.kind == ColumnKind::optional_id || column.kind == ColumnKind::ordered ? "" : " NOT NULL")
                + (first && table.has_key ? " UNIQUE" : "");
            if (column.kind == ColumnKind::date)
                sql += ", day INTEGER NOT NULL";
            first = false;
        }
        return sql + ")";
    }

    std::string insert_statement(const Table& table)
    {
        std::string names = "line", values = "?";
        for (const Column& column : table.columns) {
            names += std::string(", ") + column.name;
            values += ", ?";
            if (column.kind == ColumnKind::date) {
                names += ", day";
                values += ", ?";
            }
        }
        // A repeated key inserts nothing, which is then seen.
        return std::string("INSERT OR IGNORE INTO ") + table.name + " (" + names + ") VALUES (" + values + ")";
    }

    /// Where the table's columns stand in the file. @throws InputError on a missing column
    std::vector<std::size_t> places(const Table& table, const datasets::CsvRow& header)
    {
        std::vector<std::size_t> found;
        for (const Column& column : table.columns) {
            const auto at = std::ranges::find(header.fields, column.name);
            if (at == header.fields.end())
                throw InputError(std::string("has no column \"") + column.name + "\"", table.file);
            if (std::find(at + 1, header.fields.end(), column.name) != header.fields.end())
                throw InputError(std::string("has the column \"") + column.name + "\" twice", table.file);
            found.push_back(static_cast<std::size_t>(at - header.fields.begin()));
        }
        return found;
    }

    void insert(datasets::SqliteStatement& statement, const Table& table, const std::vector<std::size_t>& at,
        const datasets::CsvRow& row)
    {
        statement.reset();
        statement.bind(static_cast<int>(row.line));
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
            const std::string& text = row.fields[at[c]];
            if (text.empty())
                statement.bind_null();
            else if (table.columns[c].kind == ColumnKind::flag)
                statement.bind(text == "1" ? 1 : 0);
            else
                statement.bind(std::string_view(text));
            if (table.columns[c].kind == ColumnKind::date)
                statement.bind(day_of(text).value_or(0));
        }
        statement.step();
    }

    void load_table(const Table& table, const fs::path& file, const datasets::SqliteDatabase& database,
        LoadedRecords& loaded, const Job& job)
    {
        database.run(create_statement(table));
        datasets::SqliteStatement statement(database, insert_statement(table));
        std::vector<std::size_t> at;
        std::size_t columns = 0, inserted = 0;
        datasets::read_csv(
            file,
            [&](const datasets::CsvRow& row) {
                if (at.empty()) {
                    at = places(table, row);
                    columns = row.fields.size();
                    return;
                }
                std::string reason;
                if (row.fields.size() != columns)
                    reason = "has " + std::to_string(row.fields.size()) + " fields, the header has "
                        + std::to_string(columns);
                for (std::size_t c = 0; c < table.columns.size() && reason.empty(); ++c)
                    reason = fault(table.columns[c], row.fields[at[c]]);
                if (reason.empty()) {
                    insert(statement, table, at, row);
                    if (sqlite3_changes(database.handle.get()) > 0) {
                        ++inserted;
                        return;
                    }
                    reason = std::string(table.columns[0].name) + " \"" + row.fields[at[0]] + "\" occurs before";
                }
                loaded.bad.add({ table.file, row.line, reason });
            },
            job);
        if (at.empty())
            throw InputError("is empty: the first line names the columns", table.file);
        loaded.rows[table.name] = inserted;
    }

    /// Takes out the rows of a table that name an examination that is not there, or another patient's.
    void check_references(
        const Table& table, bool has_patient, const datasets::SqliteDatabase& database, LoadedRecords& loaded)
    {
        const std::string name = table.name;
        const std::string wrong = "FROM " + name
            + " AS t LEFT JOIN examination AS e ON e.examination = t.examination WHERE t.examination IS NOT NULL AND "
              "(e.examination IS NULL"
            + (has_patient ? " OR e.patient <> t.patient" : "") + ")";
        datasets::SqliteStatement select(
            database, "SELECT t.line, t.examination, e.examination IS NULL " + wrong + " ORDER BY t.line");
        std::size_t found = 0;
        while (select.step()) {
            ++found;
            loaded.bad.add({ table.file, static_cast<std::size_t>(select.integer(0)),
                "examination \"" + select.text(1)
                    + (select.integer(2) != 0 ? "\" has no right row in examinations.csv"
                                              : "\" is another patient's") });
        }
        if (found == 0)
            return;
        database.run("DELETE FROM " + name + " WHERE rowid IN (SELECT t.rowid " + wrong + ")");
        loaded.rows[name] -= found;
    }

} // namespace

LoadedRecords load_hospital_records(
    const fs::path& folder, const datasets::SqliteDatabase& database, BadRowPolicy policy, const Job& job)
{
    LoadedRecords loaded;
    if (!fs::is_directory(folder))
        throw IoError("is no folder", folder.string());
    database.run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN");
    for (const Table& table : kTables) {
        const fs::path file = folder / table.file;
        if (!table.required && !fs::exists(file))
            continue;
        if (!fs::exists(file))
            throw IoError("is missing", file.string());
        load_table(table, file, database, loaded, job);
        if (job.cancelled())
            return loaded;
        loaded.has_truth = loaded.has_truth || std::string_view(table.name) == "truth";
    }
    job.report("index", 0.5);
    for (const char* table : { "examination", "administration", "oxygen", "surgery" })
        database.run(std::string("CREATE INDEX ") + table + "_of_patient ON " + table + " (patient, day)");
    check_references(kTables[1], true, database, loaded);
    if (loaded.has_truth)
        check_references(kTables[4], false, database, loaded);
    database.run("COMMIT; ANALYZE");
    if (loaded.bad.count > 0 && policy == BadRowPolicy::refuse)
        throw InputError(
            std::to_string(loaded.bad.count) + " rows are wrong:\n" + bad_rows_text(loaded.bad), folder.string());
    return loaded;
}

std::optional<int> day_of(std::string_view date)
{
    if (date.size() != 10 || date[4] != '-' || date[7] != '-')
        return std::nullopt;
    int parts[3] = { 0, 0, 0 };
    const std::size_t from[3] = { 0, 5, 8 }, size[3] = { 4, 2, 2 };
    for (int n = 0; n < 3; ++n) {
        const char* begin = date.data() + from[n];
        const char* end = begin + size[n];
        if (*begin < '0' || *begin > '9')
            return std::nullopt;
        const auto [at, error] = std::from_chars(begin, end, parts[n]);
        if (error != std::errc {} || at != end)
            return std::nullopt;
    }
    const std::chrono::year_month_day day { std::chrono::year(parts[0]),
        std::chrono::month(static_cast<unsigned>(parts[1])), std::chrono::day(static_cast<unsigned>(parts[2])) };
    if (!day.ok())
        return std::nullopt;
    return static_cast<int>(std::chrono::sys_days(day).time_since_epoch().count());
}

std::string date_of(int day)
{
    const std::chrono::year_month_day date { std::chrono::sys_days(std::chrono::days(day)) };
    char text[16];
    std::snprintf(text, sizeof text, "%04d-%02u-%02u", static_cast<int>(date.year()),
        static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
    return text;
}

} // namespace retractor::planner
