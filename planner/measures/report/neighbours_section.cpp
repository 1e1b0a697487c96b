#include "planner/measures/report/neighbours_section.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/measures/comparison.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/report/html_text.h"

#include <algorithm>

namespace retractor::planner {

namespace {

    bool is_planned(const ReportNeighbour& neighbour) { return neighbour.field.has_value(); }

    /// "one space lower: not planned; 20 mm forwards: the space leaves room for 4 mm only"
    std::string missing_text(const std::vector<ReportNeighbour>& neighbours)
    {
        std::string text;
        for (const ReportNeighbour& neighbour : neighbours)
            if (!is_planned(neighbour))
                text += (text.empty() ? "" : "; ") + neighbour.where + ": " + neighbour.missing;
        return text;
    }

    /// The number with its error, and a plus or minus where it differs from the first field's by more than both errors.
    void write_number(
        std::ostream& out, const ComparedMeasure& row, const std::vector<FieldMetrics>& fields, std::size_t n)
    {
        const int lead = n == 0 ? 0 : lead_over(*row.metric, fields[n], fields.front());
        out << (is_solved(fields[n]) ? "<td>" : "<td class=\"failed\">")
            << metric_text(*row.metric, row.numbers[n].value);
        if (row.numbers[n].bar)
            out << " &plusmn; " << metric_text(*row.metric, *row.numbers[n].bar);
        if (lead != 0)
            out << (lead > 0 ? " <strong title=\"better by more than both errors\">+</strong>"
                             : " <strong title=\"worse by more than both errors\">&minus;</strong>");
        out << "</td>";
    }

    void write_table(std::ostream& out, const FieldMetrics& field, const std::vector<ReportNeighbour>& neighbours)
    {
        std::vector<FieldMetrics> fields { field };
        out << "<h3>" << escaped(field.name) << "</h3><table><thead><tr><th>Measure</th><th>as planned</th>";
        for (const ReportNeighbour& neighbour : neighbours)
            if (is_planned(neighbour)) {
                fields.push_back(*neighbour.field);
                out << "<th>" << escaped(neighbour.where)
                    << (is_solved(*neighbour.field) ? "" : " <span class=\"bad\">not usable</span>") << "</th>";
            }
        out << "</tr></thead><tbody>";
        for (const ComparedMeasure& row : compared_measures(fields)) {
            out << "<tr><td title=\"" << escaped(row.metric->meaning) << "\">" << escaped(row.metric->caption)
                << "</td>";
            for (std::size_t n = 0; n < fields.size(); ++n)
                write_number(out, row, fields, n);
            out << "</tr>";
        }
        out << "</tbody></table>";
        if (const std::string missing = missing_text(neighbours); !missing.empty())
            out << "<p>Without a plan: " << escaped(missing) << ".</p>";
    }

} // namespace

void write_neighbours(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<ReportNeighbour>>& neighbours)
{
    RETRACTOR_ASSERT(neighbours.empty() || neighbours.size() == fields.size());
    if (std::ranges::all_of(neighbours, [](const auto& beside) { return beside.empty(); }))
        return;
    out << "<h2>One space higher or lower</h2><p>A plus is better and a minus is worse than as planned, by more than "
           "both "
           "errors together. In the window B adds these approaches, and Shift+P plans them.</p>";
    for (std::size_t n = 0; n < neighbours.size(); ++n)
        if (std::ranges::any_of(neighbours[n], is_planned))
            write_table(out, fields[n], neighbours[n]);
        else if (!neighbours[n].empty())
            out << "<p>" << escaped(fields[n].name) << ": " << escaped(missing_text(neighbours[n])) << ".</p>";
}

} // namespace retractor::planner
