#include "planner/measures/report/ranking_section.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/measures/comparison.h"
#include "planner/measures/ranking.h"
#include "planner/measures/report/html_text.h"

#include <algorithm>

namespace retractor::planner {

namespace {

    std::vector<Candidate> candidates_of(
        const std::vector<FieldMetrics>& fields, const std::vector<std::vector<std::string>>& divided_bones)
    {
        RETRACTOR_ASSERT(divided_bones.empty() || divided_bones.size() == fields.size());
        std::vector<Candidate> candidates;
        for (std::size_t n = 0; n < fields.size(); ++n)
            candidates.push_back({ .field = fields[n],
                .divided_bones = divided_bones.empty() ? std::vector<std::string>() : divided_bones[n] });
        return candidates;
    }

    void write_score_table(
        std::ostream& out, const std::vector<FieldMetrics>& fields, const std::vector<RankedField>& order)
    {
        out << "<table><thead><tr><th>Approach</th><th>Score of 100</th>";
        for (const Criterion& criterion : criteria())
            out << "<th title=\"" << escaped(criterion.meaning) << "\">" << criterion.caption << " (weight "
                << formatted("%g", criterion.weight) << ")</th>";
        out << "</tr></thead><tbody>";
        for (const RankedField& ranked : order) {
            out << "<tr><td>" << compared_letter(ranked.index) << " " << escaped(fields[ranked.index].name)
                << "</td><td>" << in_words(ranked.score.points, 0);
            if (ranked.score.bar)
                out << " &plusmn; " << in_words(*ranked.score.bar, 0);
            if (ranked.score.factor < 1.0)
                out << formatted(" (times %.2f: little is seen)", ranked.score.factor);
            out << (ranked.within_error ? " (not behind by more than the error)" : "") << "</td>";
            for (const double share : ranked.score.shares)
                out << "<td>" << in_words(100.0 * share, 0) << "</td>";
            out << "</tr>";
        }
        out << "</tbody></table>";
    }

    /// A place in the plot, in pixels.
    struct PlotPlace {
        double x = 0.0, y = 0.0;
    };
    constexpr double kPlotPx = 320.0, kMarginPx = 46.0;

    PlotPlace place(const Score& score)
    {
        const Weights weights = default_weights();
        return { kMarginPx + kPlotPx * mean_share(score, weights, CriterionKind::exposure),
            10.0 + kPlotPx * (1.0 - mean_share(score, weights, CriterionKind::cost)) };
    }

    void write_plot(std::ostream& out, const std::vector<RankedField>& order)
    {
        out << "<div class=\"bars\"><svg viewBox=\"0 0 420 390\" role=\"img\" aria-label=\"What each approach shows "
               "against what it spares\" font-size=\"13\">";
        out << formatted("<rect x=\"%g\" y=\"10\" width=\"%g\" height=\"%g\" fill=\"none\" stroke=\"#9aa5af\"/>",
            kMarginPx, kPlotPx, kPlotPx);
        for (const double share : { 0.0, 0.5, 1.0 }) {
            out << formatted("<text x=\"%g\" y=\"%g\" text-anchor=\"middle\">%g</text>", kMarginPx + kPlotPx * share,
                kPlotPx + 26.0, 100.0 * share);
            out << formatted("<text x=\"%g\" y=\"%g\" text-anchor=\"end\">%g</text>", kMarginPx - 5.0,
                14.0 + kPlotPx * (1.0 - share), 100.0 * share);
        }
        out << formatted("<text x=\"%g\" y=\"%g\" text-anchor=\"middle\">shows (points of its criteria)</text>",
            kMarginPx + 0.5 * kPlotPx, kPlotPx + 46.0);
        out << formatted(
            "<text x=\"13\" y=\"%g\" text-anchor=\"middle\" transform=\"rotate(-90 13 %g)\">spares (points "
            "of its criteria)</text>",
            10.0 + 0.5 * kPlotPx, 10.0 + 0.5 * kPlotPx);
        for (const RankedField& ranked : order) {
            const PlotPlace at = place(ranked.score);
            const char* const ink = ranked.dominated_by ? "#1c5d99" : "white";
            out << formatted("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"10\" stroke=\"#1c5d99\" stroke-width=\"2\" "
                             "fill=\"%s\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"%s\">%s</text>",
                at.x, at.y, ranked.dominated_by ? "white" : "#1c5d99", at.x, at.y + 4.5, ink,
                compared_letter(ranked.index).c_str());
        }
        out << "</svg><p>The letters are those of the table. Right: the approach shows more. Up: it spares more "
               "(incision, bone, structures at risk, "
               "force). "
               "An open circle: another approach is at least as good by every criterion, and better by one.</p></div>";
    }

} // namespace

void write_crisis_check(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<std::string>>& divided_bones)
{
    if (fields.empty())
        return;
    out << "<h2>Think of this first</h2><ul>";
    const std::vector<Candidate> candidates = candidates_of(fields, divided_bones);
    for (std::size_t n = 0; n < candidates.size(); ++n)
        out << "<li><b>" << (candidates.size() > 1 ? compared_letter(n) + " " : std::string())
            << escaped(candidates[n].field.name) << "</b>: " << escaped(crisis_text(candidates[n])) << "</li>";
    out << "</ul>";
    for (const std::string& sentence : sight_order_sentences(fields))
        out << "<p>" << escaped(sentence) << "</p>";
}

void write_ranking(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<std::string>>& divided_bones)
{
    if (fields.size() < 2)
        return;
    const std::vector<RankedField> order = ranked(candidates_of(fields, divided_bones), default_weights());
    if (order.size() < 2)
        return;
    out << "<h2>Score</h2>";
    if (!have_one_target(fields)) {
        out << "<p>" << kDifferentTargets << "</p>";
        return;
    }
    write_score_table(out, fields, order);
    out << "<p>The score is the weighted mean of the criteria, each 0 to 100 between two fixed values. Weights and "
           "values "
           "are a choice, not a finding: <code>retractor compare --weights</code> takes others.</p>";
    write_plot(out, order);
}

} // namespace retractor::planner
