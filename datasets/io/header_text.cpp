#include "datasets/io/header_text.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <sstream>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr std::size_t kMostFiles = 100000;

    template <typename T>
    T parsed(std::string_view text, const std::string& field, const std::string& where, const char* kind)
    {
        const std::string word = trimmed(text);
        const std::size_t sign = word.starts_with('+') ? 1 : 0; // from_chars() does not accept a plus sign
        T value {};
        const auto [end, error] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size())
            throw InputError("\"" + field + "\" must be " + kind + ", it is \"" + word.substr(0, 40) + "\"", where);
        return value;
    }

    /// The name of one file of a pattern with a single %d, possibly with a width ("%03d").
    std::string numbered(const std::string& pattern, std::int64_t number, const std::string& where)
    {
        const std::size_t percent = pattern.find('%');
        std::size_t end = percent + 1;
        while (end < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[end])))
            ++end;
        if (end >= pattern.size() || (pattern[end] != 'd' && pattern[end] != 'i' && pattern[end] != 'u')
            || pattern.find('%', end) != std::string::npos || end > percent + 4)
            throw InputError("the pattern of data files must have one %d: \"" + pattern + "\"", where);
        const std::string format = pattern.substr(percent + 1, end - percent - 1);
        std::string digits = std::to_string(number);
        const std::size_t width = format.empty() ? 0 : static_cast<std::size_t>(std::stoi(format));
        if (digits.size() < width)
            digits.insert(0, width - digits.size(), format.front() == '0' ? '0' : ' ');
        return pattern.substr(0, percent) + digits + pattern.substr(end + 1);
    }

} // namespace

std::string trimmed(std::string_view text)
{
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!text.empty() && blank(text.front()))
        text.remove_prefix(1);
    while (!text.empty() && blank(text.back()))
        text.remove_suffix(1);
    return std::string(text);
}

std::string lower_case(std::string_view text)
{
    std::string lower(text);
    std::transform(
        lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return lower;
}

std::vector<std::string> words_of(std::string_view text)
{
    std::istringstream stream { std::string(text) };
    std::vector<std::string> words;
    for (std::string word; stream >> word;)
        words.push_back(word);
    return words;
}

double number_in(std::string_view text, const std::string& field, const std::string& where)
{
    return parsed<double>(text, field, where, "a number");
}

std::int64_t integer_in(std::string_view text, const std::string& field, const std::string& where)
{
    return parsed<std::int64_t>(text, field, where, "a whole number");
}

std::vector<double> numbers_in(std::string_view text, const std::string& field, const std::string& where)
{
    std::vector<double> numbers;
    for (const std::string& word : words_of(text))
        numbers.push_back(number_in(word, field, where));
    return numbers;
}

bool next_header_line(std::ifstream& file, std::string& line, const std::string& where)
{
    constexpr std::size_t kLongest = 1U << 22U; // 3D Slicer writes its conversion parameters into one line
    line.clear();
    std::streambuf& bytes = *file.rdbuf();
    using Traits = std::ifstream::traits_type;
    int c = bytes.sbumpc();
    if (c == Traits::eof())
        return false;
    for (; c != Traits::eof() && c != '\n'; c = bytes.sbumpc()) {
        line.push_back(static_cast<char>(c));
        if (c == 0 || line.size() > kLongest)
            throw InputError("the header does not end before the data: no text header", where);
    }
    if (line.ends_with('\r'))
        line.pop_back();
    return true;
}

fs::path data_file(const fs::path& header, const std::string& name)
{
    const fs::path relative = fs::path(name).lexically_normal();
    if (name.empty() || relative.is_absolute() || relative.empty() || *relative.begin() == "..")
        throw InputError("the data file \"" + name + "\" lies outside the folder of its header, which is not allowed",
            header.string());
    const fs::path path = header.parent_path() / relative;
    if (!fs::is_regular_file(path))
        throw InputError("the data file that the header names is missing: \"" + name + "\"", header.string());
    return path;
}

std::vector<fs::path> data_files(const fs::path& header, const std::string& value, std::ifstream& rest)
{
    const std::string where = header.string();
    const std::vector<std::string> words = words_of(value);
    std::vector<fs::path> files;
    const auto add = [&](const std::string& name) {
        files.push_back(data_file(header, name));
        if (files.size() > kMostFiles)
            throw InputError("the header names more than " + std::to_string(kMostFiles) + " data files", where);
    };
    if (!words.empty() && words.front() == "LIST") {
        for (std::string line; next_header_line(rest, line, where);)
            if (!trimmed(line).empty())
                add(trimmed(line));
        if (files.empty())
            throw InputError("the header's LIST of data files is empty", where);
        return files;
    }
    if (words.size() < 4 || value.find('%') == std::string::npos) {
        add(value);
        return files;
    }
    const std::int64_t first = integer_in(words[1], "data file: first", where);
    const std::int64_t last = integer_in(words[2], "data file: last", where);
    const std::int64_t step = integer_in(words[3], "data file: step", where);
    const std::int64_t most = static_cast<std::int64_t>(1) << 40;
    if (step == 0 || (step > 0) != (last >= first) || std::abs(first) > most || std::abs(last) > most
        || std::abs(step) > most)
        throw InputError("the numbers of the pattern of data files lead nowhere", where);
    for (std::int64_t n = first; step > 0 ? n <= last : n >= last; n += step)
        add(numbered(words[0], n, where));
    return files;
}

} // namespace retractor::datasets
