#pragma once
// Text headers (NRRD, MetaImage): numbers that are numbers to the last character, and names of data files that stay
// in their folder.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::datasets {

std::string trimmed(std::string_view text);
std::string lower_case(std::string_view text);
std::vector<std::string> words_of(std::string_view text);

/// NaN passes, text does not. @throws InputError naming `field`.
double number_in(std::string_view text, const std::string& field, const std::string& where);
std::int64_t integer_in(std::string_view text, const std::string& field, const std::string& where);
std::vector<double> numbers_in(std::string_view text, const std::string& field, const std::string& where);

/// One line without its end (LF or CRLF), or false at the end of the file.
/// @throws InputError when it is longer than any header's line: the file is something else.
bool next_header_line(std::ifstream& file, std::string& line, const std::string& where);

/// `name` beside the file `header`. @throws InputError when it is absolute, climbs out of the header's folder, or is
/// not there.
std::filesystem::path data_file(const std::filesystem::path& header, const std::string& name);

/// The files that a header names: one name, "LIST" with names in the lines that follow, or a pattern such as
/// "slice%03d.raw 1 124 1" (first, last, step). @throws as data_file().
std::vector<std::filesystem::path> data_files(
    const std::filesystem::path& header, const std::string& value, std::ifstream& rest);

} // namespace retractor::datasets
