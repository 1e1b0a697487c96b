#include "planner/measures/accuracy.h"

#include "mesh/base/text_format.h"

#include <array>

namespace retractor::planner {

namespace {

    using Accuracy = AccuracyMetrics;

    constexpr std::array kAccuracyFields {
        AccuracyField { .key = "asked_force",
            .unit = AccuracyUnit::percent,
            .caption = "Asked accuracy of the force",
            .meaning = "The error bar of the force over the force that was asked for.",
            .of = [](const Accuracy& a) { return std::optional(a.asked.force); } },
        AccuracyField { .key = "asked_opening",
            .unit = AccuracyUnit::mm,
            .caption = "Asked accuracy of the opening",
            .meaning = "The error bar of the opening that was asked for.",
            .of = [](const Accuracy& a) { return std::optional(a.asked.opening_mm); } },
        AccuracyField { .key = "asked_time",
            .unit = AccuracyUnit::s,
            .caption = "Time for the accuracy",
            .meaning = "The time that the meshes of this approach may take.",
            .of = [](const Accuracy& a) { return std::optional(a.asked.time_s); } },
        AccuracyField { .key = "reached_force",
            .unit = AccuracyUnit::percent,
            .caption = "Accuracy of the force",
            .meaning = "The error bar of the force over the force.",
            .of = [](const Accuracy& a) { return a.reached_force; } },
        AccuracyField { .key = "reached_opening",
            .unit = AccuracyUnit::mm,
            .caption = "Accuracy of the opening",
            .meaning = "The error bar of the opening.",
            .of = [](const Accuracy& a) { return a.reached_opening_mm; } },
        AccuracyField { .key = "edge",
            .unit = AccuracyUnit::mm,
            .caption = "Finest edges tried",
            .meaning = "Edge length round the incision in the finest mesh that gave an answer.",
            .of = [](const Accuracy& a) { return std::optional(a.edge_mm); } },
    };

    /// "127", "9", "0.62": at least two digits that count.
    std::string short_number(double value)
    {
        constexpr double kWithoutFraction = 10.0;
        return formatted(value < kWithoutFraction ? "%.2g" : "%.0f", value);
    }

    std::string percent_text(double fraction) { return short_number(100.0 * fraction) + " %"; }
    std::string mm_text(double mm) { return short_number(mm) + " mm"; }

    /// What ended the search, as the end of a sentence.
    std::string limit_text(const Accuracy& accuracy)
    {
        switch (accuracy.ended_by) {
        case AccuracyEnd::reached:
            return "";
        case AccuracyEnd::time:
            return formatted(" within %.0f s", accuracy.asked.time_s);
        case AccuracyEnd::memory:
            return " in the memory of this machine";
        case AccuracyEnd::rounds:
            return formatted(" on %d meshes, the finest with edges of %.1f mm", accuracy.rounds, accuracy.edge_mm);
        case AccuracyEnd::failure:
            return ", because " + accuracy.message;
        }
        return {};
    }

} // namespace

std::string_view to_string(AccuracyEnd end)
{
    constexpr std::array<std::string_view, 5> kNames { "reached", "time", "memory", "rounds", "failure" };
    return kNames.at(static_cast<std::size_t>(end)); // in the order of AccuracyEnd
}

std::span<const AccuracyField> accuracy_fields() { return kAccuracyFields; }

std::string accuracy_number(const AccuracyField& field, double value)
{
    switch (field.unit) {
    case AccuracyUnit::percent:
        return in_words(100.0 * value, 1) + " %";
    case AccuracyUnit::mm:
        return in_words(value, 1) + " mm";
    case AccuracyUnit::s:
        break;
    }
    return in_words(value) + " s";
}

std::string accuracy_text(const FieldMetrics& field)
{
    if (!field.accuracy)
        return {};
    const Accuracy& accuracy = *field.accuracy;
    const AccuracyGoal& asked = accuracy.asked;
    if (accuracy.ended_by == AccuracyEnd::reached && accuracy.reached_opening_mm) {
        const std::string opening = "The opening is known to " + mm_text(*accuracy.reached_opening_mm)
            + " (asked: " + mm_text(asked.opening_mm) + ").";
        if (!accuracy.reached_force)
            return opening;
        return "The force is known to " + percent_text(*accuracy.reached_force)
            + " (asked: " + percent_text(asked.force) + "). " + opening;
    }
    const std::string end = " was not reached" + limit_text(accuracy);
    if (accuracy.reached_opening_mm && !accuracy.reached_force)
        return "The asked accuracy of " + mm_text(asked.opening_mm) + end + "; the opening is known to "
            + mm_text(*accuracy.reached_opening_mm) + ".";
    const std::string text
        = "The asked accuracy of " + percent_text(asked.force) + " and " + mm_text(asked.opening_mm) + end;
    if (!accuracy.reached_opening_mm)
        return text + "; the errors of this answer are not known.";
    return text + "; the force is known to " + percent_text(*accuracy.reached_force) + " and the opening to "
        + mm_text(*accuracy.reached_opening_mm) + ".";
}

} // namespace retractor::planner
