#include "tests/verification/cli/verify_tables.h"

#include "haptics/recording/csv_field.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>

namespace retractor::verification {

namespace {

    bool skipped(const VerificationRow& row) { return row.note.starts_with("skipped"); }

    /// A number as JSON: null for NaN and infinity, which JSON does not have.
    ui::cli::Json number(double value) { return std::isfinite(value) ? ui::cli::Json(value) : ui::cli::Json(nullptr); }

    template <class... Values> std::string format(const char* pattern, Values... values)
    {
        const int size = std::snprintf(nullptr, 0, pattern, values...);
        std::string text(static_cast<std::size_t>(size), '\0');
        (void)std::snprintf(text.data(), text.size() + 1, pattern, values...);
        return text;
    }

    std::string order_text(const VerificationRow& row)
    {
        return std::isfinite(row.order) && std::isfinite(row.expected_order)
            ? format("%.1f (%.1f)", row.order, row.expected_order)
            : std::string();
    }

    /// Quantities of each problem. Several quantities have a panel each.
    std::map<std::string, std::set<std::string>> quantities_of(const std::vector<VerificationRow>& rows)
    {
        std::map<std::string, std::set<std::string>> quantities;
        for (const VerificationRow& row : rows)
            quantities[row.problem].insert(row.quantity);
        return quantities;
    }

    /// The quantity without its unit, because errors are relative.
    std::string panel_title(const VerificationRow& row, const std::map<std::string, std::set<std::string>>& quantities)
    {
        if (quantities.at(row.problem).size() == 1)
            return row.problem;
        return row.problem + ", " + row.quantity.substr(0, row.quantity.find(','));
    }

    std::string short_number(double value) { return std::isfinite(value) ? format("%.1e", value) : std::string("-"); }

    std::string condition_text(const StabilityRow& row, double condition)
    {
        return std::isfinite(condition) ? short_number(condition) : unconditioned_name(row.unconditioned);
    }

    std::string bound_text(const StabilityRow& row)
    {
        return std::isfinite(row.bound) ? format("; must stay below %.1e", row.bound) : std::string();
    }

} // namespace

std::string verdict(const VerificationRow& row)
{
    if (skipped(row))
        return "skipped";
    if (!row.passed())
        return "FAILED";
    if (row.measured)
        return measured_verdict(row.value, *row.measured);
    if (std::isfinite(row.bound) || row.order_verdict != OrderVerdict::not_judged)
        return "ok";
    if (row.in_series)
        return "series";
    return row.only_shown && !row.note.empty() ? "shown" : "FAILED";
}

ui::cli::Json row_document(const VerificationRow& row)
{
    ui::cli::Json document { { "problem", row.problem }, { "element", row.element }, { "law", row.law },
        { "quantity", row.quantity }, { "nodes", row.nodes }, { "tets", row.tets }, { "size", row.size },
        { "value", number(row.value) }, { "expected", number(row.expected) }, { "error", number(row.error) },
        { "bound", number(row.bound) }, { "order", number(row.order) },
        { "expected_order", number(row.expected_order) }, { "order_verdict", order_verdict_name(row.order_verdict) },
        { "residual", number(row.residual) }, { "seconds", row.seconds }, { "outcome", verdict(row) },
        { "note", row.note } };
    if (row.measured) {
        document["measured_least"] = number(row.measured->least);
        document["measured_most"] = number(row.measured->most);
        document["bar"] = number(row.measured->bar);
    }
    return document;
}

std::string csv(const std::vector<VerificationRow>& rows)
{
    std::ostringstream text;
    text.precision(10);
    text
        << "problem,element,law,quantity,nodes,tets,size,value,expected,error,bound,order,expected_order,order_verdict,"
           "residual,seconds,outcome,note\n";
    for (const VerificationRow& row : rows)
        text << haptics::csv_field(row.problem) << ',' << haptics::csv_field(row.element) << ','
             << haptics::csv_field(row.law) << ',' << haptics::csv_field(row.quantity) << ',' << row.nodes << ','
             << row.tets << ',' << row.size << ',' << row.value << ',' << row.expected << ',' << row.error << ','
             << row.bound << ',' << row.order << ',' << row.expected_order << ','
             << order_verdict_name(row.order_verdict) << ',' << row.residual << ',' << row.seconds << ','
             << verdict(row) << ',' << haptics::csv_field(row.note) << '\n';
    return text.str();
}

std::string table(const std::vector<VerificationRow>& rows)
{
    std::string text;
    std::string heading;
    for (const VerificationRow& row : rows) {
        const std::string this_heading = row.problem + ": " + row.quantity;
        if (this_heading != heading) {
            heading = this_heading;
            text += "\n" + heading + "\n";
            text += format("  %-16s %-22s %8s %12s %12s %9s %9s %10s %8s  %s\n", "element", "law", "tets", "value",
                "expected", "error", "bound", "order", "seconds", "");
        }
        if (skipped(row)) {
            text += "  " + row.note + "\n";
            continue;
        }
        text += format("  %-16s %-22s %8zu %12.6g %12.6g %9.2e %9s %10s %8.3f  %s%s%s\n", row.element.c_str(),
            row.law.c_str(), row.tets, row.value, row.expected, row.error,
            std::isfinite(row.bound) ? format("%.3g", row.bound).c_str() : "", order_text(row).c_str(), row.seconds,
            verdict(row).c_str(), row.note.empty() ? "" : ": ", row.note.c_str());
    }
    return text;
}

ui::ChartPicture charts(const std::vector<VerificationRow>& rows)
{
    ui::ChartPicture picture { .x_title = "run time, s", .y_title = "relative error", .panels = {}, .columns = 4 };
    std::map<std::string, std::size_t> panel_of;
    std::map<std::string, std::set<std::string>> laws;
    const auto quantities = quantities_of(rows);
    for (const VerificationRow& row : rows)
        laws[panel_title(row, quantities)].insert(row.law);
    for (const VerificationRow& row : rows) {
        if (row.size == 0.0 || skipped(row))
            continue;
        const std::string title = panel_title(row, quantities);
        const auto [at, added] = panel_of.try_emplace(title, picture.panels.size());
        if (added)
            picture.panels.push_back({ title, {} });
        auto& series = picture.panels[at->second].series;
        // springs have no law beside their element
        const bool law_too = laws[title].size() > 1 && row.law != row.element;
        const std::string name = law_too ? row.element + ", " + row.law : row.element;
        if (series.empty() || series.back().name != name)
            series.push_back({ name, {}, {} });
        series.back().x.push_back(row.seconds);
        series.back().y.push_back(row.error);
    }
    constexpr std::size_t kMostOnPlot = 5; // names in a legend; more names leave no room for the curves
    constexpr int kLegend = 230; // pixels, for the longest names
    for (ui::ChartPanel& panel : picture.panels)
        panel.legend_beside = panel.series.size() > kMostOnPlot;
    if (std::any_of(
            picture.panels.begin(), picture.panels.end(), [](const ui::ChartPanel& p) { return p.legend_beside; }))
        picture.panel_width += kLegend;
    return picture;
}

std::string verdict(const StabilityRow& row) { return row.passed() ? "ok" : "FAILED"; }

ui::cli::Json row_document(const StabilityRow& row)
{
    return { { "case", row.problem }, { "model", row.model }, { "outcome", outcome_name(row.outcome) },
        { "reason", row.reason }, { "quantity", row.quantity }, { "residual", number(row.residual) },
        { "error", number(row.error) }, { "bound", number(row.bound) }, { "condition", number(row.condition) },
        { "scaled_condition", number(row.scaled_condition) }, { "no_condition", unconditioned_name(row.unconditioned) },
        { "seconds", row.seconds }, { "verdict", verdict(row) } };
}

std::string csv(const std::vector<StabilityRow>& rows)
{
    std::ostringstream text;
    text.precision(10);
    text << "case,model,outcome,quantity,residual,error,bound,condition,scaled_condition,no_condition,seconds,verdict,"
            "reason\n";
    for (const StabilityRow& row : rows)
        text << haptics::csv_field(row.problem) << ',' << haptics::csv_field(row.model) << ','
             << outcome_name(row.outcome) << ',' << haptics::csv_field(row.quantity) << ',' << row.residual << ','
             << row.error << ',' << row.bound << ',' << row.condition << ',' << row.scaled_condition << ','
             << unconditioned_name(row.unconditioned) << ',' << row.seconds << ',' << verdict(row) << ','
             << haptics::csv_field(row.reason) << '\n';
    return text.str();
}

std::string table(const std::vector<StabilityRow>& rows)
{
    std::string text = format("\n%-34s %-32s %-10s %9s %9s %9s %9s %8s  %s\n", "case", "model", "outcome", "residual",
        "error", "condition", "scaled", "seconds", "");
    for (const StabilityRow& row : rows) {
        text += format("%-34s %-32s %-10s %9s %9s %9s %9s %8.3f  %s\n", row.problem.c_str(), row.model.c_str(),
            outcome_name(row.outcome).c_str(), short_number(row.residual).c_str(), short_number(row.error).c_str(),
            condition_text(row, row.condition).c_str(), short_number(row.scaled_condition).c_str(), row.seconds,
            verdict(row).c_str());
        if (!row.quantity.empty() && std::isfinite(row.error))
            text += format("    error: %s%s\n", row.quantity.c_str(), bound_text(row).c_str());
        if (!row.reason.empty())
            text += "    " + row.reason + "\n";
    }
    text += "\nresidual: largest force left over the largest force; error: as named below the row. condition: of the "
            "stiffness, 2-norm; scaled: of the same with a unit\ndiagonal, which round-off follows. no matrix: refused "
            "before a stiffness was assembled, or none is needed. no factor: the stiffness is not positive\ndefinite "
            "(a piece is loose, an element turned over). explicit: time steps, nothing is solved. "
            "seconds: without the condition numbers.\n";
    return text;
}

} // namespace retractor::verification
