#include "ui/cli/arguments.h"

#include "mesh/base/error.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

namespace retractor::cli {

namespace {
    constexpr int kLargestPictureEdge = 16384;
} // namespace

std::vector<std::string> split(const std::string& text, char separator)
{
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);)
        parts.push_back(part);
    return parts;
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& where)
{
    std::vector<double> numbers;
    for (const std::string& part : split(text, ',')) {
        double value = 0.0;
        const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
        if (error != std::errc {} || end != part.data() + part.size() || !std::isfinite(value))
            throw InputError("\"" + part + "\" in \"" + text + "\" is not a number", where);
        numbers.push_back(value);
    }
    if (numbers.size() != count)
        throw InputError("\"" + text + "\" must be " + std::to_string(count) + " numbers separated by commas", where);
    return numbers;
}

Vec3 parse_point(const std::string& text, const std::string& where)
{
    const std::vector<double> n = parse_numbers(text, 3, where);
    return { n[0], n[1], n[2] };
}

TargetSpec parse_target(const std::string& text)
{
    TargetSpec target;
    if (text.find(',') == std::string::npos) {
        target.label = text;
        return target;
    }
    const std::vector<double> n = parse_numbers(text, 4, "--target");
    target.centre = { n[0], n[1], n[2] };
    target.radius_mm = n[3];
    if (!(target.radius_mm > 0.0))
        throw InputError("the radius of the target must be positive", "--target");
    return target;
}

std::pair<int, int> parse_size(const std::string& text)
{
    const std::vector<std::string> parts = split(text, 'x');
    std::array<int, 2> size {};
    bool good = parts.size() == 2;
    for (std::size_t i = 0; good && i < 2; ++i) {
        const auto [end, error] = std::from_chars(parts[i].data(), parts[i].data() + parts[i].size(), size[i]);
        good = error == std::errc {} && end == parts[i].data() + parts[i].size() && size[i] > 0
            && size[i] <= kLargestPictureEdge;
    }
    if (!good)
        throw InputError("\"" + text + "\" is no picture size like 1280x960", "--size");
    return { size[0], size[1] };
}

} // namespace retractor::cli
