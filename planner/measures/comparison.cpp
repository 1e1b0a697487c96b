#include "planner/measures/comparison.h"

#include "mesh/base/text_format.h"
#include "planner/measures/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

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

namespace {

    /// What every field would show under a condition.
    struct SightCondition {
        std::string words; ///< "the organs 10 mm nearer to the head"
        std::vector<double> seen; ///< of each field
    };

    /// The conditions that were measured for all solved fields. A field without a lung held aside shows past any lung
    /// what it shows.
    std::vector<SightCondition> sight_conditions(const std::vector<FieldMetrics>& fields, const FieldMetrics& first)
    {
        std::vector<SightCondition> conditions;
        const auto add = [&](const std::string& words, const auto& seen_of) {
            SightCondition condition { .words = words, .seen = {} };
            for (const FieldMetrics& field : fields) {
                const std::optional<double> seen = is_solved(field) ? seen_of(field) : 0.0;
                if (!seen)
                    return;
                condition.seen.push_back(*seen);
            }
            conditions.push_back(std::move(condition));
        };
        for (const ShiftedSight& shift : first.if_organs_shift)
            add(formatted("the organs %.0f mm nearer to the head", shift.shift_mm),
                [&](const FieldMetrics& field) -> std::optional<double> {
                    for (const ShiftedSight& same : field.if_organs_shift)
                        if (same.shift_mm == shift.shift_mm)
                            return same.seen_best_eye;
                    return std::nullopt;
                });
        for (const TurnedSight& turn : first.if_turned) {
            const double degrees = std::abs(turn.left_side_up_deg);
            constexpr double kOnOneSideDeg = 90.0;
            add(degrees >= kOnOneSideDeg ? "the patient on the other side"
                    : degrees > 0.0      ? formatted("the incision's side up by %.0f degrees", degrees)
                                         : "the patient supine",
                [&](const FieldMetrics& field) -> std::optional<double> {
                    for (const TurnedSight& same : field.if_turned)
                        if (std::abs(same.left_side_up_deg) == degrees)
                            return same.seen_best_eye;
                    return std::nullopt;
                });
        }
        std::vector<double> shares;
        for (const FieldMetrics& field : fields)
            for (const LungSight& lung : field.if_lung_keeps)
                if (std::find(shares.begin(), shares.end(), lung.lung_share) == shares.end())
                    shares.push_back(lung.lung_share);
        for (const double share : shares)
            add(formatted("lungs of %.0f %% of their volume", 100.0 * share),
                [&](const FieldMetrics& field) -> std::optional<double> {
                    if (field.if_lung_keeps.empty())
                        return field.seen_best_eye;
                    for (const LungSight& same : field.if_lung_keeps)
                        if (same.lung_share == share)
                            return same.seen_best_eye;
                    return std::nullopt;
                });
        return conditions;
    }

} // namespace

std::vector<std::string> sight_order_sentences(
    const std::vector<FieldMetrics>& fields, std::vector<std::string> letters)
{
    for (std::size_t n = letters.size(); n < fields.size(); ++n)
        letters.push_back(compared_letter(n));
    constexpr double kSampling = 0.01; // a lead within the error of the samples is none
    std::vector<double> seen;
    const FieldMetrics* first = nullptr;
    int solved = 0;
    for (const FieldMetrics& field : fields) {
        seen.push_back(is_solved(field) ? field.seen_best_eye : 0.0);
        solved += is_solved(field) ? 1 : 0;
        if (first == nullptr && is_solved(field))
            first = &field;
    }
    if (solved < 2 || !have_one_target(fields))
        return {};
    const auto best_of = [](const std::vector<double>& shares) {
        return static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
    };
    const std::size_t best = best_of(seen);
    for (std::size_t n = 0; n < seen.size(); ++n)
        if (n != best && seen[n] + kSampling > seen[best])
            return {}; // none leads
    std::vector<std::string> sentences;
    std::vector<std::pair<double, std::string>> same; // what the same approach shows under each condition
    for (const SightCondition& condition : sight_conditions(fields, *first)) {
        const std::size_t other = best_of(condition.seen);
        if (condition.seen[other] > condition.seen[best] + kSampling)
            sentences.push_back("With " + condition.words + ", " + letters[other]
                + formatted(" shows most (%.0f %%), not ", 100.0 * condition.seen[other]) + letters[best]
                + formatted(" (%.0f %%).", 100.0 * condition.seen[best]));
        else if (condition.seen[best] > kSampling)
            same.emplace_back(condition.seen[best], condition.words);
    }
    if (!sentences.empty() || same.empty())
        return sentences;
    const auto [least, most] = std::minmax_element(same.begin(), same.end());
    const auto part = [](const auto& one) { return formatted("%.0f %% with ", 100.0 * one.first) + one.second; };
    sentences.push_back(letters[best] + " shows most also when patient, organs or lungs lie otherwise"
        + (least == most ? ": " + part(*least) : ": from " + part(*least) + " to " + part(*most)) + ".");
    return sentences;
}

std::string compared_letter(std::size_t n)
{
    constexpr std::size_t kLetters = 26;
    return std::string(1, static_cast<char>('A' + n % kLetters));
}

} // namespace retractor::planner
