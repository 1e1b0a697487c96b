#include "planner/measures/comparison.h"

#include "planner/measures/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace retractor::planner {

namespace {

    std::optional<std::size_t> leader(const MetricField& metric, const std::vector<FieldMetrics>& fields)
    {
        std::optional<std::size_t> best;
        std::size_t candidates = 0;
        for (std::size_t i = 0; i < fields.size(); ++i) {
            if (!is_solved(fields[i]))
                continue;
            ++candidates;
            if (!best || (metric.of(fields[i]) - metric.of(fields[*best])) * metric.better > 0.0)
                best = i;
        }
        if (metric.better == 0 || candidates < 2)
            return std::nullopt;
        for (std::size_t i = 0; i < fields.size(); ++i)
            if (is_solved(fields[i]) && i != *best && lead_over(metric, fields[*best], fields[i]) <= 0)
                return std::nullopt;
        return best;
    }

} // namespace

bool has_error_bars(const FieldMetrics& field) { return field.error && field.error->message.empty(); }

bool is_solved(const FieldMetrics& field) { return why_not_to_use(field).empty(); }

std::optional<double> relative_opening_bar(const FieldMetrics& field)
{
    if (!has_error_bars(field) || !(field.opening_width_mm > 0.0))
        return std::nullopt;
    return field.error->opening_width_mm / field.opening_width_mm;
}

std::optional<double> error_bar(const MetricField& metric, const FieldMetrics& field)
{
    switch (metric.bar) {
    case MetricBar::exact:
        return 0.0;
    case MetricBar::estimated:
        return metric_error(metric, field);
    case MetricBar::of_opening:
        if (const auto relative = relative_opening_bar(field))
            return *relative * metric.of(field);
        return std::nullopt;
    case MetricBar::of_sight:
        if (const auto relative = relative_opening_bar(field))
            return std::max(*relative * metric.of(field), field.error->seen_best_eye);
        return std::nullopt;
    case MetricBar::unknown:
        break;
    }
    return std::nullopt;
}

std::vector<ComparedMeasure> compared_measures(const std::vector<FieldMetrics>& fields)
{
    const bool one_target = have_one_target(fields);
    std::vector<ComparedMeasure> measures;
    for (const MetricField& metric : metric_fields()) {
        if (!metric.compared)
            continue;
        ComparedMeasure measure { .metric = &metric, .numbers = {} };
        for (const FieldMetrics& field : fields)
            measure.numbers.push_back({ metric.of(field), metric_error(metric, field) });
        if (one_target || metric.group != MetricGroup::sight)
            measure.leader = leader(metric, fields);
        measures.push_back(std::move(measure));
    }
    return measures;
}

int lead_over(const MetricField& metric, const FieldMetrics& first, const FieldMetrics& second)
{
    const std::optional<double> own = error_bar(metric, first), other = error_bar(metric, second);
    if (!own || !other || !is_solved(first) || !is_solved(second))
        return 0;
    const double lead = (metric.of(first) - metric.of(second)) * metric.better;
    return std::abs(lead) > *own + *other ? (lead > 0.0 ? 1 : -1) : 0;
}

bool have_one_target(const std::vector<FieldMetrics>& fields)
{
    return std::all_of(fields.begin(), fields.end(), [&](const FieldMetrics& field) {
        const TargetSpec &one = field.target_spec, &first = fields.front().target_spec;
        return field.target == fields.front().target && one.label == first.label && one.site == first.site
            && one.centre == first.centre && one.radius_mm == first.radius_mm;
    });
}

std::string compared_letter(std::size_t n)
{
    constexpr std::size_t kLetters = 26;
    return std::string(1, static_cast<char>('A' + n % kLetters));
}

} // namespace retractor::planner
