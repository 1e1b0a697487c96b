#include "ui/cli/evidence/rule_plot.h"

#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    constexpr double kWidthPx = 720.0, kHeightPx = 480.0, kLeftPx = 70.0, kRightPx = 20.0, kTopPx = 30.0,
                     kBottomPx = 60.0;
    constexpr std::size_t kMostMarks = 400; ///< more cannot be told apart
    constexpr double kLargestPx = 10.0; ///< radius of the mark of the largest lift

    /// A round step that divides a range into about five parts.
    double round_step(double range)
    {
        const double rough = range / 5.0, order = std::pow(10.0, std::floor(std::log10(rough)));
        for (const double factor : { 1.0, 2.0, 5.0 })
            if (factor * order >= rough)
                return factor * order;
        return 10.0 * order;
    }

} // namespace

std::string rule_plot_svg(const std::vector<planner::AssociationRule>& rules, const planner::RuleThresholds& thresholds)
{
    double most_support = 2.0 * std::max(thresholds.support, 1e-6);
    for (const planner::AssociationRule& rule : rules)
        most_support = std::max(most_support, 1.1 * rule.support);
    const auto x = [&](double support) { return kLeftPx + (kWidthPx - kLeftPx - kRightPx) * support / most_support; };
    const auto y
        = [](double confidence) { return kHeightPx - kBottomPx - (kHeightPx - kTopPx - kBottomPx) * confidence; };
    std::string svg
        = formatted("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" font-family=\"sans-serif\" "
                    "font-size=\"13\"><rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
            kWidthPx, kHeightPx);
    const double step = round_step(most_support);
    for (double tick = 0.0; tick <= most_support; tick += step)
        svg += formatted("<path d=\"M%.1f %.1fV%.1f\" stroke=\"#dde3e8\"/><text x=\"%.1f\" y=\"%.1f\" "
                         "text-anchor=\"middle\">%g</text>\n",
            x(tick), y(0.0), y(1.0), x(tick), y(0.0) + 18.0, tick);
    for (const double tick : { 0.0, 0.25, 0.5, 0.75, 1.0 })
        svg += formatted("<path d=\"M%.1f %.1fH%.1f\" stroke=\"#dde3e8\"/><text x=\"%.1f\" y=\"%.1f\" "
                         "text-anchor=\"end\">%g</text>\n",
            x(0.0), y(tick), x(most_support), x(0.0) - 6.0, y(tick) + 4.0, tick);
    svg += formatted(
        "<path d=\"M%.1f %.1fV%.1fM%.1f %.1fH%.1f\" stroke=\"#b3261e\" stroke-dasharray=\"5 4\" fill=\"none\"/>\n",
        x(thresholds.support), y(0.0), y(1.0), x(0.0), y(thresholds.confidence), x(most_support));
    svg += formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">support</text><text x=\"18\" y=\"%.1f\" "
                     "text-anchor=\"middle\" transform=\"rotate(-90 18 %.1f)\">confidence</text>\n",
        x(0.5 * most_support), kHeightPx - 16.0, y(0.5), y(0.5));
    svg += formatted("<text x=\"%.1f\" y=\"18\">%s; the area of a mark is the lift; dashed: thresholds</text>\n",
        kLeftPx,
        (rules.size() > kMostMarks ? "the first " + std::to_string(kMostMarks) + " of " + std::to_string(rules.size())
                                   : std::to_string(rules.size()))
            .append(" rules")
            .c_str());
    double largest_lift = 1e-9;
    for (const planner::AssociationRule& rule : rules)
        largest_lift = std::max(largest_lift, rule.lift);
    // Rules of one place share a mark, with all their numbers beside it.
    std::map<std::pair<double, double>, std::vector<std::size_t>> places;
    for (std::size_t n = 0; n < std::min(rules.size(), kMostMarks); ++n)
        places[{ rules[n].support, rules[n].confidence }].push_back(n);
    for (const auto& [place, there] : places) {
        std::string numbers;
        for (const std::size_t n : there)
            numbers += (numbers.empty() ? "" : ", ") + std::to_string(n + 1);
        const double radius = kLargestPx * std::sqrt(rules[there.front()].lift / largest_lift);
        svg += formatted("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"#1c5d99\" fill-opacity=\"0.5\"/>"
                         "<text x=\"%.1f\" y=\"%.1f\">",
                   x(place.first), y(place.second), radius, x(place.first) + radius + 3.0, y(place.second) + 4.5)
            + numbers + "</text>\n";
    }
    return svg + "</svg>\n";
}

} // namespace retractor::ui::cli
