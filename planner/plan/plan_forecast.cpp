#include "planner/plan/plan_forecast.h"

#include "mesh/base/assert.h"
#include "mesh/base/memory.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    /// Memory is base + linear x + factor x^(4/3) GiB, and time is seconds x^growth, with x = tetrahedra / kUnit.
    /// The factor of a sparse matrix grows with the power 4/3 of the unknowns in three dimensions (George 1973).
    struct PlanCost {
        double base_GiB, linear_GiB, factor_GiB;
        double seconds, growth;
    };
    constexpr double kUnit = 50'000.0;
    // Calibrated by measured plans with error bars.
    constexpr PlanCost kTenNodes { 0.35, 0.3, 0.95, 60.0, 1.5 };
    constexpr PlanCost kFourNodes { 0.35, 0.1, 0.06, 15.0, 1.3 };
    constexpr double kFactorGrowth = 4.0 / 3.0;

    const PlanCost& cost_of(ElementKind element) { return element == ElementKind::p1 ? kFourNodes : kTenNodes; }

    double bytes_of(double tetrahedra, const PlanCost& cost)
    {
        const double x = tetrahedra / kUnit;
        return kGiB * (cost.base_GiB + cost.linear_GiB * x + cost.factor_GiB * std::pow(x, kFactorGrowth));
    }

    /// "57,000": two digits that count.
    std::string rounded_count(double count)
    {
        constexpr double kTwoDigits = 10.0;
        const double step = count < kTwoDigits ? 1.0 : std::pow(10.0, std::floor(std::log10(count)) - 1.0);
        std::string text = in_words(std::round(count / step) * step);
        for (std::size_t at = text.size(); at > 3;) {
            at -= 3;
            text.insert(at, ",");
        }
        return text;
    }

    std::string memory_text(double bytes) { return in_words(bytes / kGiB, 1) + " GiB"; }

} // namespace

PlanForecast forecast_plan(double tetrahedra, ElementKind element)
{
    RETRACTOR_ASSERT(tetrahedra >= 0.0 && std::isfinite(tetrahedra));
    const PlanCost& cost = cost_of(element);
    return { .tetrahedra = tetrahedra,
        .seconds = cost.seconds * std::pow(tetrahedra / kUnit, cost.growth),
        .bytes = bytes_of(tetrahedra, cost) };
}

double most_tetrahedra(double bytes, ElementKind element)
{
    const PlanCost& cost = cost_of(element);
    if (!(bytes > bytes_of(0.0, cost)))
        return 0.0;
    // Without the term of the factor more tetrahedra would fit, so the answer lies below.
    double fits = 0.0, beyond = kUnit * bytes / (kGiB * cost.linear_GiB);
    constexpr int kHalvings = 60; // more than the bits of a double's fraction
    for (int n = 0; n < kHalvings; ++n) {
        const double middle = 0.5 * (fits + beyond);
        (bytes_of(middle, cost) <= bytes ? fits : beyond) = middle;
    }
    return fits;
}

double tetrahedra_limit(std::optional<double> bytes, ElementKind element)
{
    return bytes ? std::max(1.0, most_tetrahedra(*bytes, element)) : 0.0;
}

std::string forecast_text(const PlanForecast& forecast)
{
    return "about " + rounded_count(forecast.tetrahedra) + " tetrahedra, about "
        + rounded_count(std::max(1.0, forecast.seconds)) + " s, " + memory_text(forecast.bytes);
}

void check_memory(const PlanForecast& forecast, std::optional<double> bytes)
{
    if (!bytes || forecast.bytes <= *bytes)
        return;
    throw MemoryRefusal("this plan needs about " + memory_text(forecast.bytes) + " of memory for about "
            + rounded_count(forecast.tetrahedra) + " tetrahedra, and it can have " + memory_text(*bytes)
            + " (plans that run at the same time share what is available): choose a longer corridor_edge_mm, or close "
              "other programs",
        "sizing/corridor_edge_mm", { "corridor_edge_mm" });
}

} // namespace retractor::planner
