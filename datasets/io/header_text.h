#pragma once
// Parses text headers (NRRD, MetaImage). A number must fill its whole text. The names of data files must stay in the
// folder of the header.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::datasets {

/// The text without blanks at its ends.
std::string trimmed(std::string_view text);
/// The text in lower case (ASCII).
std::string lower_case(std::string_view text);
/// The words of a text, separated by blanks.
std::vector<std::string> words_of(std::string_view text);

/// These functions read one number, one whole number, or numbers separated by blanks. NaN is accepted.
/// @param field the header field, for messages
/// @throws InputError, naming `field`, when the text is no number.
double number_in(std::string_view text, const std::string& field, const std::string& where);
std::int64_t integer_in(std::string_view text, const std::string& field, const std::string& where);
std::vector<double> numbers_in(std::string_view text, const std::string& field, const std::string& where);

/// Reads one line without its end (LF or CRLF). Returns false at the end of the file.
/// @throws InputError when the line is longer than any line of a header, because the file is then no text header.
bool next_header_line(std::ifstream& file, std::string& line, const std::string& where);

/// The path of the data file `name`, relative to the folder of `header`.
/// @throws InputError when `name` is absolute, when it leaves the folder of the header, or when the file does not
/// exist.
std::filesystem::path data_file(const std::filesystem::path& header, const std::string& name);

/// The data files that a header names. `value` is one name, "LIST" with names in the following lines of `rest`, or a
/// pattern such as "slice%03d.raw 1 124 1" (first, last, step).
/// @throws as data_file() does.
std::vector<std::filesystem::path> data_files(
    const std::filesystem::path& header, const std::string& value, std::ifstream& rest);

} // namespace retractor::datasets
