#pragma once
// Reads and writes CSV files (RFC 4180) by libcsv, row by row.

#include "mesh/base/job.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::datasets {

struct CsvRow {
    std::size_t line = 0; ///< on which the row begins, from 1
    std::vector<std::string> fields; ///< spaces at the ends of fields without quotes are dropped
};

/// Calls `take` with every row, the header first. Empty lines are skipped. A mark of UTF-8 at the begin is dropped.
/// @throws InputError with file and line where a quote stands inside a field or is not closed, or a line ends with a
/// carriage return alone; IoError when the file cannot be read. The job's cancellation ends the reading early.
void read_csv(const std::filesystem::path& file, const std::function<void(const CsvRow&)>& take, const Job& job = {});

/// The text in quotes, with quotes inside doubled.
std::string csv_quoted(std::string_view text);

/// A bad row of a file.
struct BadRow {
    std::string file;
    std::size_t line = 0;
    std::string reason;
};

/// Rows that are bad, counted, the first of them in words.
struct BadRows {
    static constexpr std::size_t kListed = 20;
    std::size_t count = 0;
    std::vector<BadRow> first; ///< at most kListed
    void add(BadRow row)
    {
        if (count++ < kListed)
            first.push_back(std::move(row));
    }
};

/// "oxygen.csv:12: ...", one line each, and the number of others.
std::string bad_rows_text(const BadRows& bad);

} // namespace retractor::datasets
