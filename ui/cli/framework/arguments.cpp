#include "ui/cli/framework/arguments.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

namespace retractor::ui::cli {

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
    RETRACTOR_ASSERT(count > 0);
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
    RETRACTOR_ASSERT(n.size() == 3);
    return { n[0], n[1], n[2] };
}

planner::TargetSpec parse_target(const std::string& text)
{
    planner::TargetSpec target;
    if (text.find(',') == std::string::npos) {
        target.label = text;
        return target;
    }
    std::string numbers = text;
    if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) {
        const std::size_t first = text.find(':');
        target.site = text.substr(0, first);
        target.label = first == colon ? std::string() : text.substr(first + 1, colon - first - 1);
        if (target.site.empty() || target.label.empty())
            throw InputError("give LABEL, SITE:LABEL:X,Y,Z,RADIUS or X,Y,Z,RADIUS", "--target " + text);
        numbers = text.substr(colon + 1);
    }
    constexpr std::size_t kSphere = 4, kSphereAndNormal = 7;
    const bool has_normal
        = target.is_site() && static_cast<std::size_t>(std::ranges::count(numbers, ',')) + 1 == kSphereAndNormal;
    const std::vector<double> n = parse_numbers(numbers, has_normal ? kSphereAndNormal : kSphere, "--target");
    RETRACTOR_ASSERT(n.size() >= kSphere);
    if (has_normal)
        target.normal = Vec3(n[4], n[5], n[6]);
    target.centre = { n[0], n[1], n[2] };
    target.radius_mm = n[3];
    if (!(target.radius_mm > 0.0))
        throw InputError("the radius of the target must be positive", "--target");
    return target;
}

planner::AblationSpec parse_ablation(const std::string& text)
{
    const std::string where = "--ablate " + text;
    const std::vector<std::string> parts = split(text, ':');
    const bool whole = std::none_of(parts.begin(), parts.end(), [](const std::string& part) { return part.empty(); });
    if (!whole || parts.size() < 2 || parts.size() > 3 || text.back() == ':')
        throw InputError("give LABEL:FROM,TO, LABEL:FROM,TO:ALONG_FROM,ALONG_TO, ball:X,Y,Z,RADIUS or "
                         "ball:X,Y,Z,RADIUS:LABEL",
            where);
    planner::AblationSpec ablation;
    if (parts[0] == "ball") {
        const std::vector<double> n = parse_numbers(parts[1], 4, where);
        ablation.centre = { n[0], n[1], n[2] };
        ablation.radius_mm = n[3];
        if (!ablation.is_ball())
            throw InputError("the radius of a ball must be positive", where);
        ablation.label = parts.size() == 3 ? parts[2] : std::string();
        return ablation;
    }
    ablation.label = parts[0];
    const std::vector<double> across = parse_numbers(parts[1], 2, where);
    ablation.from_mm = across[0];
    ablation.to_mm = across[1];
    if (!(ablation.from_mm < ablation.to_mm))
        throw InputError("across the incision, FROM must be less than TO", where);
    if (parts.size() == 3) {
        const std::vector<double> along = parse_numbers(parts[2], 2, where);
        ablation.along_from_mm = along[0];
        ablation.along_to_mm = along[1];
        if (!(along[0] < along[1]))
            throw InputError("along the incision, FROM must be less than TO", where);
    }
    return ablation;
}

std::optional<planner::AccuracyGoal> parse_accuracy(const std::string& text, const planner::AccuracyGoal& otherwise)
{
    if (text == "none")
        return std::nullopt;
    const std::string where = "--accuracy";
    const std::size_t percent = text.find('%');
    const std::string rest = percent == std::string::npos ? "" : text.substr(percent + 1);
    if (percent == std::string::npos || (!rest.empty() && (rest.front() != ',' || rest.size() < 2)))
        throw InputError(
            "\"" + text + "\" is no accuracy like 15%, 15%,2 (of the force, and mm of the opening) or none", where);
    planner::AccuracyGoal goal = otherwise;
    constexpr double kPercent = 0.01;
    goal.force = kPercent * parse_numbers(text.substr(0, percent), 1, where).front();
    if (!rest.empty())
        goal.opening_mm = parse_numbers(rest.substr(1), 1, where).front();
    return goal;
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

std::pair<double, double> parse_span(const std::string& text, const std::string& where)
{
    const std::vector<std::string> parts = split(text, '-');
    if (parts.empty() || parts.size() > 2 || text.ends_with('-'))
        throw InputError("give one number, or two with \"-\" between them", where);
    const double first = parse_numbers(parts.front(), 1, where).front();
    return { first, parts.size() == 1 ? first : parse_numbers(parts.back(), 1, where).front() };
}

std::pair<int, int> parse_spaces(const std::string& text)
{
    constexpr double kMost = 100.0; // more than any body has; what uses the spaces names the range
    const auto [first, last] = parse_span(text, "--spaces");
    if (first != std::floor(first) || last != std::floor(last) || !(first < kMost && last < kMost))
        throw InputError("spaces are whole numbers from 1 to 11", "--spaces");
    return { static_cast<int>(first), static_cast<int>(last) };
}

} // namespace retractor::ui::cli
