#include "planner/measures/report/report.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/base64.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/accuracy.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/comparison.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/hook_opening.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/metrics.h"
#include "planner/measures/region_text.h"
#include "planner/measures/report/html_text.h"
#include "planner/measures/report/ranking_section.h"
#include "planner/measures/rupture.h"
#include "planner/measures/sight/table_position.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/verdict.h"
#include "planner/measures/volume_failures.h"
#include "planner/wall/wall_tension.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

namespace retractor::planner {

namespace {

    constexpr std::string_view kStyle = R"css(
body { font: 16px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: #1c2733; margin: 0; background: #f4f6f8; }
main { max-width: 1180px; margin: 0 auto; padding: 24px; }
h1 { font-size: 26px; margin: 8px 0; } h2 { font-size: 21px; margin: 36px 0 8px; border-bottom: 2px solid #b9c6d2; } h3 { font-size: 17px; margin: 24px 0 4px; }
.notice { background: #fff4d6; border-left: 5px solid #d99a00; padding: 8px 14px; }
.chosen { background: #e3f1e8; border-left: 5px solid #2f8f5b; padding: 8px 14px; }
table { border-collapse: collapse; background: #fff; width: 100%; }
th, td { border: 1px solid #d3dce4; padding: 6px 10px; text-align: right; } th:first-child, td:first-child { text-align: left; }
thead th { background: #e6ecf1; } .best { font-weight: 700; color: #0a6b3d; } .bad { color: #a61b1b; font-weight: 700; } .failed { color: #9aa5af; text-decoration: line-through; } .caution { color: #8a5a00; }
.verdict { background: #fff; border-left: 10px solid #9aa5af; padding: 10px 14px; font-size: 18px; }
.verdict b { margin-right: 8px; } .verdict.clear { border-color: #2f8f5b; } .verdict.caution { border-color: #d99a00; color: inherit; } .verdict.injury { border-color: #b3261e; } .verdict.unknown { border-color: #6b1410; color: #a61b1b; }
.words td, .materials td:last-child { text-align: left; } .words td:first-child { width: 16em; } .materials { margin-top: 10px; font-size: 14px; }
figure { margin: 0; background: #fff; border: 1px solid #d3dce4; } figure img { width: 100%; display: block; }
figcaption { padding: 6px 10px; color: #46555f; font-size: 14px; }
.field-view { background: #191e23; color: #dfe5ea; margin: 14px 0; padding: 8px; } .field-view-canvas { height: 520px; position: relative; }
.field-view-controls { display: flex; flex-wrap: wrap; gap: 6px 14px; align-items: center; padding-bottom: 8px; font-size: 14px; }
.field-view-hint { padding-top: 6px; color: #9aa5af; font-size: 13px; }
@media print { .field-view { display: none; } }
.row { display: grid; grid-template-columns: 1fr 1fr; gap: 14px; } .wide { grid-column: 1 / -1; }
.bars { display: grid; grid-template-columns: 1fr 1fr; gap: 14px; margin: 14px 0; } .bars svg { background: #fff; border: 1px solid #d3dce4; width: 100%; }
)css";

    std::string percent(double fraction) { return in_words(100.0 * fraction, 1) + " %"; }

    std::string file_content(const std::filesystem::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        std::string content { std::istreambuf_iterator<char>(in), {} };
        if (!in || content.empty())
            throw IoError("cannot read the picture", path.string());
        return content;
    }

    std::string listed(const std::vector<std::string>& words)
    {
        return words.empty() ? "none" : escaped(joined(words));
    }

    /// Explains the marks, and how certain the shares without a bar of their own are.
    void write_reading(std::ostream& out, const std::vector<FieldMetrics>& fields)
    {
        out << "<p class=\"reading\">" << kSharesAreOf
            << " Green: better "
               "than every other approach by more than both error bars together. "
               "Without a mark the lead is within the error, or the error is unknown. The other shares of the target "
               "have no error bars of their own: they are at least as uncertain as the opening, whose bar is ";
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const std::optional<double> relative = relative_opening_bar(fields[i]);
            out << (i == 0 ? "" : ", ") << (relative ? percent(*relative) : std::string("not estimated"))
                << (fields.size() > 1 ? " (" + escaped(fields[i].name) + ")" : std::string());
        }
        out << " of its width. Leads in these shares are compared with this bar or that of the best eye, whichever is "
               "larger.";
        if (!have_one_target(fields))
            out << " " << kDifferentTargets;
        out << "</p>";
    }

    /// The hooks that yielded, with their force and the reached part of the prescribed motion.
    std::string yielded_hooks(const FieldMetrics& field)
    {
        std::string text;
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const HookForce& hook = field.hooks[i];
            if (!hook.yielded)
                continue;
            text += (text.empty() ? "" : "; ") + escaped(hook.name) + " at " + in_words(hook.force_N, 1)
                + " N: " + in_words(hook.moved_mm, 1)
                + (has_error_bars(field) ? " &plusmn; " + in_words(field.error->hook_moved_mm[i], 1) : std::string())
                + " of " + in_words(hook.asked_mm, 1) + " mm";
        }
        return text.empty() ? "none" : text;
    }

    /// "upper blade 91.2 +- 4.0 N; lower blade 88.0 +- 3.9 N".
    std::string force_of_each(const FieldMetrics& field)
    {
        std::string text;
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            text += (i == 0 ? "" : "; ") + escaped(readable(field.hooks[i].name)) + " "
                + in_words(field.hooks[i].force_N, 1)
                + (has_error_bars(field) ? " &plusmn; " + in_words(field.error->hook_forces_N[i], 1) : std::string())
                + " N";
        return text.empty() ? "none" : text;
    }

    /// Rows that say whether each opening can be had, and what it may injure.
    template <class TextRow> void write_injuries(const std::vector<FieldMetrics>& fields, const TextRow& text_row)
    {
        text_row("Opening possible", [](const FieldMetrics& f) {
            const char* const mark = f.attainable == Attainable::no ? "bad"
                : f.attainable == Attainable::with_injury           ? "caution"
                                                                    : "";
            return "<span class=\"" + std::string(mark) + "\">" + escaped(attainable_text(f)) + "</span>";
        });
        if (std::ranges::any_of(fields, breaks_bone))
            text_row("Largest opening without a fracture (estimate)", [](const FieldMetrics& f) {
                if (f.largest_uninjured_opening_mm && !breaks_bone(f))
                    return "no rib breaks up to " + in_words(std::floor(*f.largest_uninjured_opening_mm), 0) + " mm";
                return f.largest_uninjured_opening_mm ? in_words(std::floor(*f.largest_uninjured_opening_mm), 0) + " mm"
                                                      : std::string("not known");
            });
        if (std::ranges::any_of(fields, [](const FieldMetrics& f) { return !f.tissue_strain.empty(); }))
            text_row("Largest strain of each tissue, over balls of " + in_words(kBallRadiusMm) + " mm radius",
                [](const FieldMetrics& f) {
                    std::vector<std::string> words;
                    for (const TissueStrain& tissue : f.tissue_strain)
                        words.push_back(readable(tissue.tissue) + " " + in_words(100.0 * tissue.strain) + " %");
                    return listed(words);
                });
        if (std::ranges::any_of(fields, any_may_tear))
            text_row("Caution, tearing", [](const FieldMetrics& f) {
                return "<span class=\"caution\">" + escaped(tearing_text(f)) + "</span>";
            });
        if (std::ranges::any_of(fields, may_rupture))
            text_row("Caution", [](const FieldMetrics& f) {
                return may_rupture(f) ? "<span class=\"caution\">" + escaped(rupture_text(f)) + "</span>"
                                      : std::string();
            });
        if (std::ranges::any_of(fields, [](const FieldMetrics& f) { return !fast_opening_text(f).empty(); }))
            text_row("Caution, speed of opening", [](const FieldMetrics& f) {
                return "<span class=\"caution\">" + escaped(fast_opening_text(f)) + "</span>";
            });
    }

    void write_comparison(std::ostream& out, const std::vector<FieldMetrics>& fields)
    {
        out << "<table><thead><tr><th>Measure</th>";
        for (std::size_t n = 0; n < fields.size(); ++n) {
            const FieldMetrics& field = fields[n];
            out << "<th>" << (fields.size() > 1 ? compared_letter(n) + " " : std::string()) << escaped(field.name)
                << (is_solved(field) ? "" : " <span class=\"bad\">not usable</span>") << "</th>";
        }
        out << "</tr></thead><tbody>";
        for (const ComparedMeasure& row : compared_measures(fields)) {
            out << "<tr><td title=\"" << escaped(row.metric->meaning) << "\">" << escaped(row.metric->caption)
                << "</td>";
            for (std::size_t i = 0; i < row.numbers.size(); ++i) {
                out << (row.leader == i        ? "<td class=\"best\">"
                        : is_solved(fields[i]) ? "<td>"
                                               : "<td class=\"failed\">")
                    << metric_text(*row.metric, row.numbers[i].value);
                if (row.numbers[i].bar)
                    out << " &plusmn; " << metric_text(*row.metric, *row.numbers[i].bar);
                out << "</td>";
            }
            out << "</tr>";
        }
        const auto text_row = [&](std::string_view label, auto&& text) {
            out << "<tr><td>" << label << "</td>";
            for (const FieldMetrics& field : fields)
                out << "<td>" << text(field) << "</td>";
            out << "</tr>";
        };
        text_row("Planned opening, from side to side", [](const FieldMetrics& f) { return escaped(asked_text(f)); });
        text_row("... reached by the tissue under them",
            [](const FieldMetrics& f) { return in_words(hook_opening(f).reached_mm, 1) + " mm"; });
        if (std::ranges::any_of(fields, [](const FieldMetrics& f) { return f.force_moments.has_value(); }))
            text_row("Force on a side and its moment", [](const FieldMetrics& f) {
                return f.force_moments && f.force_moments->message.empty()
                    ? escaped(force_moments_cell(*f.force_moments))
                    : escaped(force_moments_text(f));
            });
        text_row("Force on each blade or hook", [](const FieldMetrics& f) {
            return is_solved(f) ? force_of_each(f) : "<span class=\"failed\">" + force_of_each(f) + "</span>";
        });
        if (std::any_of(fields.begin(), fields.end(), has_limited_hooks))
            text_row("Hooks that yielded", yielded_hooks);
        text_row("Bone in the line of sight", [](const FieldMetrics& f) { return listed(bones_in_sight(f)); });
        text_row("Nearest structures at risk, from the blade", [](const FieldMetrics& f) {
            std::vector<std::string> words;
            for (const RiskDistance& risk : f.at_risk)
                words.push_back(risk_text(risk));
            return listed(words);
        });
        text_row("Nearest structures at risk, from hooks and retractor", [](const FieldMetrics& f) {
            std::vector<std::string> words;
            for (const RiskDistance& risk : f.steel_at_risk)
                words.push_back(risk_text(risk));
            return listed(words);
        });
        text_row("Hooks and blades bear on", [](const FieldMetrics& f) {
            std::vector<std::string> words;
            for (const HookForce& hook : f.hooks)
                words.push_back(readable(hook.name) + ": " + bearing_text(hook));
            return listed(words);
        });
        write_injuries(fields, text_row);
        if (std::ranges::any_of(fields, [](const FieldMetrics& f) { return f.division.has_value(); }))
            text_row("Intercostal space divided beyond the skin",
                [](const FieldMetrics& f) { return escaped(division_cell(f)); });
        text_row("Held aside", [](const FieldMetrics& f) { return readable(listed(f.retracted)); });
        const auto has = [&](auto&& list) {
            return std::any_of(fields.begin(), fields.end(), [&](const FieldMetrics& f) { return !list(f).empty(); });
        };
        if (has([](const FieldMetrics& f) { return f.removed; }))
            text_row("Removed", [](const FieldMetrics& f) {
                std::vector<std::string> words;
                for (const RemovedTissue& tissue : f.removed)
                    words.push_back(in_words(1e-3 * tissue.volume_mm3, 2) + " cm3 of " + readable(tissue.label));
                return listed(words);
            });
        if (has([](const FieldMetrics& f) { return f.loose_pieces; }))
            text_row("Loose pieces", [](const FieldMetrics& f) { return readable(listed(f.loose_pieces)); });
        out << "</tbody></table>";
    }

    void write_provenance(std::ostream& out, const Provenance& computed)
    {
        out << "<h2>What was computed</h2><table class=\"words\"><tbody>";
        for (const auto& [what, value] : provenance_rows(computed))
            out << "<tr><td>" << escaped(what) << "</td><td>" << escaped(value) << "</td></tr>";
        out << "</tbody></table><table class=\"materials\"><thead><tr><th>Material of the wall</th><th>Young's modulus"
               "</th><th>Poisson's ratio</th><th>Law</th><th>Tension before the "
               "cut</th><th>Source</th></tr></thead><tbody>";
        for (const fem::Material& material : computed.materials) {
            out << "<tr><td>" << escaped(material.name) << "</td><td>"
                << formatted("%.4g MPa", material.youngs_modulus_MPa) << "</td><td>"
                << in_words(material.poissons_ratio, 3) << "</td><td>" << escaped(law_text(computed, material))
                << "</td><td>" << escaped(pre_strain_text(material.pre_strain)) << "</td><td>"
                << escaped(material.source) << "</td></tr>";
        }
        out << "</tbody></table>";
    }

    /// Horizontal bars, one per approach, with whiskers where there are error bars.
    void write_bars(std::ostream& out, const std::vector<FieldMetrics>& fields, const MetricField& metric)
    {
        const auto bar = [&](const FieldMetrics& f) { return metric_error(metric, f).value_or(0.0); };
        double largest = 0.0;
        for (const FieldMetrics& field : fields)
            largest = std::max(largest, metric.of(field) + bar(field));
        constexpr double kLeft = 12.0, kLongest = 390.0; // of the bars, with room for the number
        const auto wide = [&](double v) { return largest > 0.0 ? kLongest * std::max(v, 0.0) / largest : 0.0; };
        const std::size_t height = 40 + 50 * fields.size();
        out << "<svg viewBox=\"0 0 560 " << height << "\" role=\"img\" aria-label=\"" << metric.caption
            << "\"><text x=\"12\" y=\"26\" font-size=\"16\" font-weight=\"700\">" << metric.caption << "</text>";
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const double v = metric.of(fields[i]), off = bar(fields[i]);
            const std::size_t y = 58 + 50 * i; // the name stands above its bar
            out << "<text x=\"12\" y=\"" << y - 7 << "\" font-size=\"14\">" << escaped(fields[i].name)
                << "</text><rect x=\"12\" y=\"" << y << "\" width=\"" << in_words(wide(v), 1)
                << "\" height=\"22\" fill=\"#3a7ca5\"/>";
            if (off > 0.0) {
                const std::string from = in_words(kLeft + wide(v - off), 1), to = in_words(kLeft + wide(v + off), 1);
                out << "<path class=\"whisker\" d=\"M" << from << " " << y + 11 << "H" << to << "M" << from << " "
                    << y + 5 << "v12M" << to << " " << y + 5 << "v12\" stroke=\"#1c2733\" stroke-width=\"2\"/>";
            }
            out << "<text x=\"" << in_words(kLeft + 8.0 + wide(v + off), 1) << "\" y=\"" << y + 16
                << "\" font-size=\"14\">" << metric_text(metric, v)
                << (off > 0.0 ? " &#177; " + metric_text(metric, off) : std::string()) << "</text>";
        }
        out << "</svg>";
    }

    /// The deviation of both lips from the lines of their hooks, along the incision.
    void write_lips(std::ostream& out, const FieldMetrics& field)
    {
        if (field.lip_deviation.empty())
            return;
        constexpr double kLeft = 60.0, kTop = 40.0, kWidth = 480.0, kHeight = 150.0; // of the axes
        double first = 0.0, last = 1.0, lowest = 0.0, highest = 1.0;
        for (const LipDeviation& lip : field.lip_deviation)
            for (const auto& [along, deviation] : lip.curve) {
                first = std::min(first, along);
                last = std::max(last, along);
                lowest = std::min(lowest, deviation);
                highest = std::max(highest, deviation);
            }
        const auto x = [&](double along) { return kLeft + kWidth * (along - first) / (last - first); };
        const auto y = [&](double mm) { return kTop + kHeight * (mm - lowest) / (highest - lowest); };
        const auto text = [&](double at_x, double at_y, const char* anchor, const std::string& words) {
            out << "<text x=\"" << in_words(at_x, 1) << "\" y=\"" << in_words(at_y, 1)
                << "\" font-size=\"13\" text-anchor=\"" << anchor << "\">" << escaped(words) << "</text>";
        };
        const LipDeviation& any = field.lip_deviation.front();
        out << "<div class=\"bars\"><svg class=\"lips\" viewBox=\"0 0 560 240\" role=\"img\" aria-label=\"How far "
               "the lips hang behind their hooks\"><text x=\"12\" y=\"24\" font-size=\"16\" font-weight=\"700\">How "
               "far "
               "each lip hangs behind its "
            << (field.retractor ? "blade" : "hooks") << " (mm)</text><rect x=\"" << in_words(x(any.from_mm), 1)
            << "\" y=\"" << kTop << "\" width=\"" << in_words(x(any.to_mm) - x(any.from_mm), 1) << "\" height=\""
            << kHeight << "\" fill=\"#eef2f5\"/><path d=\"M" << kLeft << " " << in_words(y(0.0), 1) << "h" << kWidth
            << "\" stroke=\"#46555f\"/>";
        text(kLeft - 6.0, y(0.0) + 5.0, "end", "0");
        text(kLeft - 6.0, y(highest) + 5.0, "end", in_words(highest, 1));
        if (lowest < -0.25 * highest)
            text(kLeft - 6.0, y(lowest) + 5.0, "end", in_words(lowest, 1));
        text(kLeft, kTop + kHeight + 18.0, "start", in_words(first) + " mm");
        text(kLeft + kWidth, kTop + kHeight + 18.0, "end", in_words(last) + " mm along the incision");
        double key = kLeft;
        for (const LipDeviation& lip : field.lip_deviation) {
            const char* const colour = lip.side > 0 ? "#3a7ca5" : "#b0562a";
            out << "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"" << colour << "\" points=\"";
            for (const auto& [along, deviation] : lip.curve)
                out << in_words(x(along), 1) << "," << in_words(y(deviation), 1) << " ";
            out << "\"/><rect x=\"" << in_words(key, 1) << "\" y=\"220\" width=\"14\" height=\"4\" fill=\"" << colour
                << "\"/>";
            text(key + 20.0, 227.0, "start", lip_name(field, lip.side));
            key += 180.0;
        }
        out << "</svg></div>";
    }

    void write_pictures(std::ostream& out, const Report& report, const std::string& approach)
    {
        out << "<div class=\"row\">";
        for (const ReportPicture& picture : report.pictures)
            if (picture.approach == approach)
                out << "<figure" << (picture.caption.starts_with("Slices") ? " class=\"wide\"" : "") << "><img alt=\""
                    << escaped(picture.caption) << "\" src=\"data:image/png;base64,"
                    << base64(file_content(picture.file)) << "\"/><figcaption>" << escaped(picture.caption)
                    << "</figcaption></figure>";
        out << "</div>";
    }

    /// The place of a field's interactive view, and its scene. On paper only the pictures stay.
    void write_view(std::ostream& out, const Report& report, const std::string& approach)
    {
        for (std::size_t n = 0; n < report.views.size(); ++n)
            if (report.views[n].approach == approach)
                out << "<div class=\"field-view\" data-scene=\"scene-" << n
                    << "\">The interactive view appears here when it comes into sight; it needs JavaScript. The "
                       "pictures below show the same "
                       "field.</div>"
                    << "<script type=\"application/json\" id=\"scene-" << n << "\">" << report.views[n].scene
                    << "</script>";
    }

    /// "+7.7 %", "0.0 %".
    std::string change_text(double percent)
    {
        const std::string size = in_words(percent, 1);
        return (size.front() == '-' || size == "0.0" ? "" : "+") + size + " %";
    }

    /// Three digits, without powers of ten for large numbers: "0.115", "6110".
    std::string three_digits(double value)
    {
        if (!(std::abs(value) >= 1000.0) || !std::isfinite(value))
            return formatted("%.3g", value);
        const double step = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2.0);
        return in_words(std::round(value / step) * step);
    }

    /// The interval from tissue values, and the table of the parameters that decide.
    void write_parameters(std::ostream& out, const FieldMetrics& field)
    {
        if (!field.parameters)
            return;
        const std::string forces = force_with_intervals(field);
        out << "<p>" << escaped(forces.empty() ? parameter_text(field) : "Force " + forces) << ".</p>";
        if (field.parameters->parameters.empty())
            return;
        out << "<p>" << escaped(parameter_text(field))
            << ": one standard deviation. Force and opening change to first order with the values; the bars of the "
               "mesh are no part of it.</p><table class=\"materials\"><thead><tr><th>Stiffness</th><th>Planned "
               "with</th><th>Range</th><th>Force at the upper end</th><th>Opening at the upper end</th><th>From</th>"
               "</tr></thead><tbody>";
        for (const ParameterInfluence& p : field.parameters->parameters)
            out << "<tr><td>" << escaped(p.name) << "</td><td>" << three_digits(p.value) << ' '
                << escaped(p.unit == "1" ? "" : p.unit) << "</td><td>" << three_digits(p.low) << " to "
                << three_digits(p.high) << "</td><td>" << change_text(p.force_change_percent) << "</td><td>"
                << change_text(p.opening_change_percent) << "</td><td>" << escaped(p.source) << "</td></tr>";
        out << "</tbody></table>";
    }

    void write_bone_stiffness(std::ostream& out, const FieldMetrics& field)
    {
        if (field.bone_stiffness.empty())
            return;
        out << "<table class=\"materials\"><thead><tr><th>Bone</th><th>Young's modulus</th><th>Range</th><th>Found by"
               "</th><th>From</th></tr></thead><tbody>";
        for (const BoneStiffness& bone : field.bone_stiffness)
            out << "<tr><td>" << escaped(readable(bone.name)) << "</td><td>"
                << in_words(bone.modulus_MPa, bone.modulus_MPa < 100.0 ? 1 : 0) + " MPa"
                << "</td><td>"
                << formatted(bone.modulus_MPa < 100.0 ? "%.1f to %.1f" : "%.0f to %.0f", bone.low_MPa, bone.high_MPa)
                << "</td><td>" << escaped(std::string(to_string(bone.origin))) << "</td><td>" << escaped(bone.words)
                << "</td></tr>";
        out << "</tbody></table>";
    }

    /// What the field means for use, beside the colour of its light.
    /// @param name before the words; empty: none
    void write_verdict(std::ostream& out, const FieldMetrics& field, const std::string& name)
    {
        const Verdict verdict = verdict_of(field);
        out << "<p class=\"verdict " << to_string(verdict.light) << "\"><b>" << escaped(name)
            << (name.empty() ? "" : ": ") << words_of(verdict.light) << ".</b> ";
        for (const std::string& sentence : verdict.sentences)
            out << escaped(sentence) << ' ';
        out << "</p>";
    }

    void write_field(std::ostream& out, const Report& report, const FieldMetrics& field)
    {
        out << "<h2>" << escaped(field.name) << "</h2>";
        write_verdict(out, field, "");
        if (const std::string failed = volume_failure_text(field); !failed.empty())
            out << "<p class=\"notice" << (keeps_volume(field) ? "" : " bad") << "\">" << escaped(field.name) << " "
                << escaped(failed) << ".</p>";
        if (const std::string piercing = piercing_text(field); !piercing.empty())
            out << "<p class=\"notice bad\">" << escaped(field.name) << " " << escaped(piercing) << ".</p>";
        out << "<p>" << escaped(field.explanation) << "</p>";
        write_view(out, report, field.name);
        write_pictures(out, report, field.name);
        for (std::size_t n = 0; n < report.landmarks.size() && n < report.fields.size(); ++n)
            if (&report.fields[n] == &field && !report.landmarks[n].empty()) {
                out << "<p>To check on the skin in the theatre:";
                for (const std::string& sentence : report.landmarks[n])
                    out << ' ' << escaped(sentence);
                out << "</p>";
            }
        out << (field.retractor ? "<p>Blades: " : "<p>Hooks: ") << force_of_each(field) << ". The best eye is "
            << in_words(field.best_eye.distance_mm, 0) << " mm from the opening";
        if (field.seen_best_eye > 0.0)
            out << " and meets what it sees at " << in_words(field.best_eye.incidence_deg, 0) << " degrees on average";
        out << "; it was searched within " << in_words(field.cone_half_angle_deg, 0)
            << " degrees of the cone's axis. The mean and the union are over " << field.eyes << " eyes "
            << in_words(field.eye_distance_mm, 0) << " mm from the target; " << field.target_samples
            << " samples on the target.</p>";
        if (const std::string estimated = estimated_text(field); !estimated.empty())
            out << "<p class=\"notice\">" << escaped(field.name) << ": " << escaped(estimated) << ".</p>";
        if (const std::string shifted = shifted_sight_text(field); !shifted.empty())
            out << "<p>The CT is taken in inspiration: " << escaped(shifted) << ".</p>";
        if (const std::string turned = turned_sight_text(field); !turned.empty())
            out << "<p>Position on the table: " << escaped(turned) << ".</p>";
        if (field.best_eye_pixels) {
            constexpr double kAgrees = 0.02; // half a pixel along the outlines, and the samples of the rays
            const double off = std::abs(*field.best_eye_pixels - field.best_eye_picture);
            out << (off > kAgrees ? "<p class=\"notice\">" : "<p>") << "The picture from the best eye shows "
                << percent(*field.best_eye_pixels) << " of the target, counted in pixels; rays give "
                << percent(field.best_eye_picture) << ".</p>";
        }
        if (const std::string retractor = retractor_text(field); !retractor.empty())
            out << "<p>" << escaped(retractor) << ".</p>";
        if (const std::string lips = lips_text(field); !lips.empty())
            out << "<p>" << escaped(lips) << ". The shaded part of the plot is the part that these numbers cover.</p>";
        write_lips(out, field);
        if (const std::string division = division_text(field); !division.empty())
            out << "<p>" << escaped(division) << ".</p>";
        if (const std::string hooks = hooks_text(field); !hooks.empty())
            out << "<p>" << escaped(hooks) << ".</p>";
        if (const std::string bones = bones_text(field); !bones.empty())
            out << (breaks_bone(field) ? "<p class=\"notice\">" : "<p>") << escaped(bones) << "</p>";
        if (const std::string joints = joints_text(field); !joints.empty())
            out << "<p>" << escaped(joints) << "</p>";
        if (const std::string strain = tissue_strain_text(field); !strain.empty())
            out << "<p>" << escaped(strain) << ".</p>";
        if (const std::string tearing = tearing_text(field); !tearing.empty())
            out << "<p class=\"notice\">" << escaped(tearing) << ".</p>";
        if (is_region_too_small(field))
            out << "<p class=\"notice\">" << escaped(region_text(field)) << "</p>";
        if (field.contact && passes_through(field))
            out << "<p class=\"notice\">" << escaped(contact_text(field)) << ".</p>";
        for (const std::string& implausible : field.implausible)
            out << "<p class=\"notice\">Accepted although implausible: " << escaped(implausible) << "</p>";
        out << "<h3>How it was computed</h3><p>" << escaped(error_text(field))
            << ". Errors of the materials, the supports and the model are not included.</p>";
        write_parameters(out, field);
        write_bone_stiffness(out, field);
        if (const std::string accuracy = accuracy_text(field); !accuracy.empty())
            out << (field.accuracy->ended_by == AccuracyEnd::reached ? "<p>" : "<p class=\"notice\">")
                << escaped(accuracy) << "</p>";
        out << "<p>" << escaped(solution_text(field)) << "; " << field.tets << " elements, relative residual "
            << formatted("%.1e", field.residual) << "; " << escaped(field.mechanics_status) << ", "
            << field.inverted_elements << " elements inside out, largest volume ratio "
            << in_words(field.max_volume_ratio, 2) << ".</p>";
        if (!is_region_too_small(field))
            out << "<p>" << escaped(region_text(field)) << "</p>";
        if (const std::string force = force_moments_text(field); !force.empty())
            out << "<p>" << escaped(force) << ".</p>";
        for (const PressureMetrics& pressure : field.pressures)
            out << "<p>" << escaped(pressure_text(pressure)) << ".</p>";
        if (field.tension)
            out << "<p>" << escaped(tension_text(field)) << ".</p>";
        if (field.contact && !passes_through(field))
            out << "<p>" << escaped(contact_text(field)) << ".</p>";
        if (field.second_opinion)
            out << "<p" << (field.second_opinion->status == "agrees" ? ">" : " class=\"notice\">")
                << escaped(opinion_text(*field.second_opinion)) << ".</p>";
        out << "<p>Time: ";
        for (std::size_t i = 0; i < field.seconds.size(); ++i)
            out << (i == 0 ? "" : ", ") << escaped(field.seconds[i].first) << " "
                << in_words(field.seconds[i].second, 2) << " s";
        out << ".</p>";
    }

} // namespace

void write_report(const std::filesystem::path& path, const Report& report)
{
    std::ostringstream out;
    out << "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>" << escaped(report.title)
        << "</title><style>" << kStyle << "</style></head><body><main><h1>" << escaped(report.title) << "</h1><p>"
        << escaped(report.patient) << "</p><p class=\"notice\">Research software, not a medical device.</p>";
    if (!report.chosen.empty())
        out << "<p class=\"chosen\">" << escaped(report.chosen) << "</p>";
    write_pictures(out, report, "");
    for (const std::string& refusal : report.refused)
        out << "<p class=\"notice\">" << escaped(refusal) << "</p>";
    for (std::size_t n = 0; n < report.fields.size(); ++n)
        write_verdict(out, report.fields[n],
            (report.fields.size() > 1 ? compared_letter(n) + " " : std::string()) + report.fields[n].name);
    write_crisis_check(out, report.fields, report.divided_bones);
    out << "<h2>Comparison</h2>";
    write_comparison(out, report.fields);
    write_reading(out, report.fields);
    out << "<div class=\"bars\">";
    for (const char* key : { "seen_best_eye", "opening_width_mm", "hook_force_N" })
        write_bars(out, report.fields, metric_field(key));
    out << "</div>";
    write_ranking(out, report.fields, report.divided_bones);
    write_neighbours(out, report.fields, report.neighbours);
    for (const FieldMetrics& field : report.fields)
        write_field(out, report, field);
    if (report.computed)
        write_provenance(out, *report.computed);
    out << "<h2>What these numbers do not say</h2><ul>";
    for (const std::string& limit : report.limits)
        out << "<li>" << escaped(limit) << "</li>";
    out << "</ul></main>";
    if (!report.views.empty())
        out << "<script>" << report.viewer << "</script>";
    out << "</body></html>\n";
    write_file_atomically(path, out.str());
}

} // namespace retractor::planner
