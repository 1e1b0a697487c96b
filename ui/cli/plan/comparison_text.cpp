#include "ui/cli/plan/comparison_text.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/comparison.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/verdict.h"
#include "ui/cli/framework/arguments.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace retractor::ui::cli {

namespace {

    std::vector<planner::FieldMetrics> metrics_of(const std::vector<ComparedField>& fields)
    {
        std::vector<planner::FieldMetrics> metrics;
        std::transform(fields.begin(), fields.end(), std::back_inserter(metrics),
            [](const ComparedField& field) { return field.candidate.field; });
        return metrics;
    }

    std::vector<planner::RankedField> ranking_of(
        const std::vector<ComparedField>& fields, const planner::Weights& weights)
    {
        std::vector<planner::Candidate> candidates;
        std::transform(fields.begin(), fields.end(), std::back_inserter(candidates),
            [](const ComparedField& field) { return field.candidate; });
        return planner::ranked(candidates, weights);
    }

    /// What the marks of a table need.
    struct MarkedTable {
        const std::vector<planner::FieldMetrics>& metrics;
        Marks marks = Marks::leader;
        bool one_target = true;
    };

    std::string cell(const planner::ComparedMeasure& measure, std::size_t n, const MarkedTable& marked)
    {
        const planner::ComparedNumber& number = measure.numbers[n];
        std::string text = planner::metric_text(*measure.metric, number.value);
        if (number.bar)
            text += " +- " + planner::metric_number(*measure.metric, *number.bar);
        if (marked.marks == Marks::leader)
            return measure.leader == n ? text + " *" : text;
        if (n == 0 || (!marked.one_target && measure.metric->group == planner::MetricGroup::sight))
            return text;
        const int lead = planner::lead_over(*measure.metric, marked.metrics[n], marked.metrics.front());
        return lead > 0 ? text + " +" : lead < 0 ? text + " -" : text;
    }

    /// Characters on the screen, of UTF-8.
    std::size_t width_of(const std::string& text)
    {
        return static_cast<std::size_t>(std::count_if(
            text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
    }

    std::string padded(const std::string& text, std::size_t width)
    {
        return text + std::string(std::max(width, width_of(text)) - width_of(text), ' ');
    }

    std::string aligned(const std::vector<std::vector<std::string>>& rows)
    {
        std::vector<std::size_t> widths(rows.front().size(), 0);
        for (const auto& row : rows)
            for (std::size_t c = 0; c < row.size(); ++c)
                widths[c] = std::max(widths[c], width_of(row[c]));
        std::string text;
        for (const auto& row : rows) {
            std::string line;
            for (std::size_t c = 0; c < row.size(); ++c)
                line += padded(row[c], widths[c]) + "  ";
            text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
        }
        return text;
    }

    std::string number_table(const MarkedTable& marked)
    {
        std::vector<std::vector<std::string>> rows { { "" } };
        for (std::size_t n = 0; n < marked.metrics.size(); ++n)
            rows.front().push_back(
                planner::compared_letter(n) + (planner::is_solved(marked.metrics[n]) ? "" : " (not usable)"));
        for (const planner::ComparedMeasure& measure : planner::compared_measures(marked.metrics)) {
            rows.push_back({ measure.metric->caption });
            for (std::size_t n = 0; n < marked.metrics.size(); ++n)
                rows.back().push_back(cell(measure, n, marked));
        }
        return aligned(rows) + std::string(planner::kSharesAreOf) + "\n"
            + (marked.marks == Marks::leader ? "* better than every other by more than both errors together\n"
                                             : "+ better than A by more than both errors together, - worse\n");
    }

    std::string crisis_text(const std::vector<ComparedField>& fields)
    {
        std::string text
            = "Think of this first (structures within " + in_words(planner::kCrisisMm) + " mm, injury, held aside):\n";
        for (std::size_t n = 0; n < fields.size(); ++n)
            text += planner::compared_letter(n) + "  " + planner::crisis_text(fields[n].candidate) + "\n";
        return text;
    }

    std::string ranking_text(const std::vector<ComparedField>& fields, const planner::Weights& weights)
    {
        const std::vector<planner::RankedField> order = ranking_of(fields, weights);
        if (order.empty())
            return {};
        std::string text = "Score of 100 points (weights: " + planner::weights_text(weights) + "):\n";
        std::string unbeaten;
        for (std::size_t place = 0; place < order.size(); ++place) {
            const planner::RankedField& ranked = order[place];
            text += formatted(
                "%zu. %s  %.0f", place + 1, planner::compared_letter(ranked.index).c_str(), ranked.score.points);
            text += (ranked.score.bar ? formatted(" +- %.0f", *ranked.score.bar) : " (error not known)")
                + ("  " + fields[ranked.index].name);
            if (ranked.score.factor < 1.0)
                text += formatted("; times %.2f, since little of the target is seen", ranked.score.factor);
            if (ranked.within_error)
                text += "; not behind the one above by more than the error";
            if (ranked.dominated_by)
                text += "; " + planner::compared_letter(*ranked.dominated_by)
                    + " is at least as good in everything that counts";
            else
                unbeaten += (unbeaten.empty() ? "" : ", ") + planner::compared_letter(ranked.index);
            text += "\n";
        }
        return text + "Worth a choice, as no other is at least as good in everything: " + unbeaten + "\n";
    }

} // namespace

std::string comparison_text(const std::vector<ComparedField>& fields, const planner::Weights& weights, Marks marks)
{
    const std::vector<planner::FieldMetrics> metrics = metrics_of(fields);
    std::string text;
    for (std::size_t n = 0; n < fields.size(); ++n) {
        text += planner::compared_letter(n) + "  " + fields[n].name + ":";
        for (const std::string& sentence : planner::verdict_of(metrics[n]).sentences)
            text += " " + sentence;
        text += "\n";
    }
    const bool one_target = planner::have_one_target(metrics);
    text += "\n" + crisis_text(fields) + "\n";
    for (const std::string& sentence : planner::sight_order_sentences(metrics))
        text += sentence + "\n";
    text += "\n" + number_table({ metrics, marks, one_target }) + "\n";
    return text + (one_target ? ranking_text(fields, weights) : std::string(planner::kDifferentTargets) + "\n");
}

Json comparison_document(const std::vector<ComparedField>& fields, const planner::Weights& weights)
{
    const std::vector<planner::FieldMetrics> metrics = metrics_of(fields);
    Json document;
    document["approaches"] = Json::array();
    for (std::size_t n = 0; n < fields.size(); ++n) {
        const planner::Verdict verdict = planner::verdict_of(metrics[n]);
        document["approaches"].push_back(
            { { "name", metrics[n].name }, { "title", fields[n].name }, { "light", planner::to_string(verdict.light) },
                { "sentences", verdict.sentences }, { "crisis_check", planner::crisis_check(fields[n].candidate) },
                { "divided_bones", fields[n].candidate.divided_bones } });
    }
    document["one_target"] = planner::have_one_target(metrics);
    document["sight_order"] = planner::sight_order_sentences(metrics);
    document["measures"] = Json::array();
    for (const planner::ComparedMeasure& measure : planner::compared_measures(metrics)) {
        Json row { { "key", measure.metric->key }, { "values", Json::array() }, { "bars", Json::array() } };
        for (const planner::ComparedNumber& number : measure.numbers) {
            row["values"].push_back(number.value);
            row["bars"].push_back(number.bar ? Json(*number.bar) : Json());
        }
        row["leader"] = measure.leader ? Json(metrics[*measure.leader].name) : Json();
        document["measures"].push_back(row);
    }
    document["weights"] = Json::object();
    for (std::size_t n = 0; n < planner::kCriteria; ++n)
        document["weights"][planner::criteria()[n].key] = weights[n];
    document["ranking"] = Json::array();
    if (!planner::have_one_target(metrics))
        return document;
    for (const planner::RankedField& ranked : ranking_of(fields, weights)) {
        Json row { { "name", metrics[ranked.index].name }, { "points", ranked.score.points },
            { "within_error", ranked.within_error } };
        row["factor"] = ranked.score.factor;
        row["bar"] = ranked.score.bar ? Json(*ranked.score.bar) : Json();
        row["dominated_by"] = ranked.dominated_by ? Json(metrics[*ranked.dominated_by].name) : Json();
        for (std::size_t n = 0; n < planner::kCriteria; ++n)
            row["shares"][planner::criteria()[n].key] = ranked.score.shares[n];
        document["ranking"].push_back(row);
    }
    return document;
}

planner::Weights parse_weights(const std::vector<std::string>& changes)
{
    planner::Weights weights = planner::default_weights();
    for (const std::string& change : changes) {
        const std::size_t equals = change.find('=');
        const std::string key = change.substr(0, equals);
        const auto found = std::ranges::find_if(
            planner::criteria(), [&](const planner::Criterion& criterion) { return criterion.key == key; });
        if (equals == std::string::npos || found == planner::criteria().end())
            throw InputError("a weight is CRITERION=NUMBER; the criteria are " + planner::weights_text(weights),
                "--weights " + change);
        const double weight = parse_numbers(change.substr(equals + 1), 1, "--weights " + change).front();
        if (weight < 0.0)
            throw InputError("a weight is at least 0", "--weights " + change);
        weights.at(static_cast<std::size_t>(found - planner::criteria().begin())) = weight;
    }
    if (std::ranges::all_of(weights, [](double weight) { return weight == 0.0; }))
        throw InputError("all weights are 0: nothing would count", "--weights");
    return weights;
}

} // namespace retractor::ui::cli
