#include "datasets/tables/csv_reader.h"

#include "mesh/base/error.h"

#include <csv.h>

#include <cerrno>
#include <exception>
#include <fstream>
#include <system_error>

namespace retractor::datasets {

namespace {

    /// What libcsv's callbacks fill.
    struct Reading {
        CsvRow row;
        const std::function<void(const CsvRow&)>* take = nullptr;
        std::exception_ptr failure; ///< of `take`; it must not pass through C
    };

    void add_field(void* bytes, std::size_t size, void* data)
    {
        auto& reading = *static_cast<Reading*>(data);
        if (!reading.failure)
            try {
                reading.row.fields.emplace_back(static_cast<const char*>(bytes), size);
            } catch (...) {
                reading.failure = std::current_exception();
            }
    }

    void end_row(int, void* data)
    {
        auto& reading = *static_cast<Reading*>(data);
        if (!reading.failure && !reading.row.fields.empty())
            try {
                (*reading.take)(reading.row);
            } catch (...) {
                reading.failure = std::current_exception();
            }
        reading.row.fields.clear();
        reading.row.line = 0;
    }

    struct Parser {
        Parser()
        {
            if (csv_init(&state, CSV_STRICT | CSV_STRICT_FINI) != 0)
                throw IoError("the CSV parser cannot be made");
        }
        ~Parser() { csv_free(&state); }
        Parser(const Parser&) = delete;
        Parser& operator=(const Parser&) = delete;
        csv_parser state {};
    };

} // namespace

void read_csv(const std::filesystem::path& file, const std::function<void(const CsvRow&)>& take, const Job& job)
{
    std::ifstream in(file, std::ios::binary);
    if (!in)
        throw IoError("cannot be read: " + std::generic_category().message(errno), file.string());
    std::error_code no_size;
    const auto size = static_cast<double>(std::filesystem::file_size(file, no_size));
    Parser parser;
    Reading reading { .row = {}, .take = &take, .failure = nullptr };
    const auto refuse = [&](std::size_t line) {
        throw InputError(
            "a quote stands inside a field, or is not closed", file.filename().string() + ":" + std::to_string(line));
    };
    std::string text;
    std::size_t line = 0, done = 0;
    constexpr std::size_t kReportEvery = 1 << 16; // lines
    while (std::getline(in, text)) {
        ++line;
        if (line == 1 && text.starts_with("\xEF\xBB\xBF"))
            text.erase(0, 3);
        if (const std::size_t alone = text.find('\r'); alone < text.size() - 1 && alone != std::string::npos)
            throw InputError("a carriage return stands alone: save the file with the line ends of Unix or Windows",
                file.filename().string() + ":" + std::to_string(line));
        done += text.size() + 1;
        text += '\n';
        if (reading.row.line == 0)
            reading.row.line = line;
        const bool begun = !reading.row.fields.empty();
        if (csv_parse(&parser.state, text.data(), text.size(), add_field, end_row, &reading) != text.size())
            refuse(reading.row.line == 0 ? line : reading.row.line);
        if (reading.failure)
            std::rethrow_exception(reading.failure);
        if (!begun && reading.row.fields.empty() && parser.state.entry_pos == 0 && parser.state.quoted == 0)
            reading.row.line = 0; // an empty line
        if (line % kReportEvery == 0) {
            job.report("read " + file.filename().string(), no_size ? 0.0 : static_cast<double>(done) / size);
            if (job.cancelled())
                return;
        }
    }
    if (in.bad())
        throw IoError("cannot be read to its end", file.string());
    if (csv_fini(&parser.state, add_field, end_row, &reading) != 0)
        refuse(reading.row.line == 0 ? line : reading.row.line);
    if (reading.failure)
        std::rethrow_exception(reading.failure);
}

std::string csv_quoted(std::string_view text)
{
    std::string quoted(2 * text.size() + 2, '\0');
    quoted.resize(csv_write(quoted.data(), quoted.size(), text.data(), text.size()));
    return quoted;
}

std::string bad_rows_text(const BadRows& bad)
{
    std::string text;
    for (const BadRow& row : bad.first)
        text += row.file + ":" + std::to_string(row.line) + ": " + row.reason + "\n";
    if (bad.count > bad.first.size())
        text += "and " + std::to_string(bad.count - bad.first.size()) + " other rows\n";
    return text;
}

} // namespace retractor::datasets
