#include "ui/workstation/planning/metric_rows.h"

#include "mesh/base/text_format.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/metrics.h"

#include <algorithm>

namespace retractor::ui {

namespace {

    /// A volume that more than doubles or halves is an artefact of the model, not a result.
    constexpr double kDoubtfulVolumeRatio = 2.0;

    std::string number(double value, int digits, const char* unit)
    {
        return formatted(*unit == '\0' ? "%.*f%s" : "%.*f %s", digits, value, unit);
    }

    std::string percent(double fraction) { return number(100.0 * fraction, 1, "%"); }

    std::string joined(const std::vector<std::string>& words)
    {
        std::string out;
        for (const std::string& word : words)
            out += (out.empty() ? "" : ", ") + word;
        return out.empty() ? "none" : out;
    }

    constexpr const char* kBar = " ±: what finer elements would change.";

    /// The row of a number: "58.0 ± 1.2 mm" with an estimate, otherwise "58.0 mm".
    MetricRow metric_row(const planner::FieldMetrics& field, const planner::MetricField& metric)
    {
        const int digits = metric.group == planner::MetricGroup::distances ? 0
            : metric.unit == planner::MetricUnit::none                     ? 2
                                                                           : 1;
        MetricRow row { metric.caption, planner::metric_text(metric, metric.of(field), digits), metric.meaning };
        if (const auto error = planner::metric_error(metric, field)) {
            row.value = planner::metric_number(metric, metric.of(field), digits) + " ± "
                + planner::metric_text(metric, *error, digits);
            row.meaning += kBar;
        }
        return row;
    }

    /// Adds the numbers of a group, in the order of the table.
    void add_rows(MetricSection& section, const planner::FieldMetrics& field, planner::MetricGroup group)
    {
        for (const planner::MetricField& metric : planner::metric_fields())
            if (metric.group == group)
                section.rows.push_back(metric_row(field, metric));
    }

    MetricSection sight_section(const planner::FieldMetrics& field)
    {
        MetricSection section { "Sight", { { "Target", field.target, "What the surgeon wants to see." } } };
        add_rows(section, field, planner::MetricGroup::sight);
        section.rows.push_back({ "Bone in sight", joined(field.bone_in_sight),
            "Bones that are first to block lines of sight to the target." });
        section.rows.push_back(
            { "Held aside", joined(field.retracted), "Organs that this approach takes as retracted." });
        for (std::size_t i = 0; i < std::min<std::size_t>(3, field.blockers.size()); ++i)
            section.rows.push_back({ "Blocked by " + field.blockers[i].name, percent(field.blockers[i].share),
                "Share of the sight lines that this structure is the first to block." });
        return section;
    }

    MetricSection opening_section(const planner::FieldMetrics& field)
    {
        MetricSection section { "Opening", {} };
        add_rows(section, field, planner::MetricGroup::opening);
        add_rows(section, field, planner::MetricGroup::distances);
        for (const planner::RiskDistance& risk : field.at_risk)
            section.rows.push_back({ "Blade to " + risk.name,
                risk.distance_mm > 0.0 ? in_words(risk.distance_mm, 1) + " mm" : "passes through it",
                "Shortest distance from the blade to this structure at risk, at rest." });
        return section;
    }

    MetricSection force_section(const planner::FieldMetrics& field)
    {
        MetricSection section { "Force and strain", {} };
        add_rows(section, field, planner::MetricGroup::force);
        add_rows(section, field, planner::MetricGroup::strain);
        if (field.strain_p99_at) {
            const Vec3& at = *field.strain_p99_at;
            section.rows.push_back(
                { "... at", number(at.x(), 0, "") + ", " + number(at.y(), 0, "") + ", " + number(at.z(), 0, "mm"),
                    "Left, back, head (patient LPS), before the wound was opened." });
        }
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const bool known = field.error && field.error->message.empty() && i < field.error->hook_forces_N.size();
            const double force = field.hooks[i].force_N;
            section.rows.push_back({ "Hook " + field.hooks[i].name,
                known ? number(force, 1, "") + " ± " + number(field.error->hook_forces_N[i], 1, "N")
                      : number(force, 1, "N"),
                {} });
        }
        return section;
    }

    MetricSection model_section(const planner::FieldMetrics& field)
    {
        double seconds = 0.0;
        for (const auto& [stage, time] : field.seconds)
            seconds += time;
        MetricRow volume_ratio = metric_row(field, planner::metric_field("max_volume_ratio"));
        volume_ratio.warning = field.max_volume_ratio > kDoubtfulVolumeRatio;
        MetricSection section { "Model",
            {
                { "Equilibrium", field.mechanics_status, "Whether the mechanical solution converged.",
                    field.mechanics_status != "converged" },
                { "Solved as", planner::solution_text(field.solution.choice),
                    "Fields solved differently do not compare." },
                { "Tetrahedra", std::to_string(field.tets), {} },
                { "Inverted", std::to_string(field.inverted_elements),
                    "Elements turned inside out: the numbers are then wrong near them.", field.inverted_elements > 0 },
                volume_ratio,
                { "Time to plan", number(seconds, 1, "s"), {} },
            } };
        if (field.tension)
            section.rows.push_back({ field.pressures.empty() ? "Gapes by itself" : "Gapes under pressure, no hooks",
                field.tension->message.empty() ? number(field.tension->gape_mm, 1, "mm") : "not told",
                planner::tension_text(field) + "." });
        for (const planner::PressureMetrics& pressure : field.pressures)
            section.rows.push_back(
                { "Pressure", number(pressure.pressure_kPa, 2, "kPa"), planner::pressure_text(pressure) + "." });
        return section;
    }

    /// The row of a number of the table that is known before planning.
    MetricRow asked_row(const char* key, double value)
    {
        const planner::MetricField& metric = planner::metric_field(key);
        return { metric.caption, planner::metric_text(metric, value, 0), metric.meaning };
    }

    /// The row of a hook's drive: a force, or a motion that a limit and a grip may shorten.
    MetricRow hook_row(const planner::HookSpec& hook)
    {
        const planner::HookPull& pull = hook.pull;
        if (pull.force_N)
            return { "Hook " + hook.name, number(*pull.force_N, 1, "N"),
                "The force it pulls its lip with, however far that goes." };
        MetricRow row { "Hook " + hook.name, number(hook.opening_mm, 0, "mm"), "How far it moves its lip." };
        if (!pull.prescribes())
            row.meaning = "How far it is drawn; its lip may go less far.";
        if (pull.force_limit_N) {
            row.value += ", at most " + number(*pull.force_limit_N, 1, "N");
            row.meaning += " It yields where the force would be more.";
        }
        if (pull.grip_N_per_mm) {
            row.value += ", grip " + number(*pull.grip_N_per_mm, 1, "N/mm");
            row.meaning += " The lip follows it through its grip.";
        }
        return row;
    }

} // namespace

std::vector<MetricSection> field_rows(const planner::FieldMetrics& field)
{
    return { sight_section(field), opening_section(field), force_section(field), model_section(field) };
}

std::vector<MetricSection> approach_rows(const planner::Approach& approach)
{
    std::vector<MetricSection> sections { { "Approach",
        {
            { "Template", approach.template_name, {} },
            { "Target",
                approach.target.is_sphere() ? "sphere of " + number(approach.target.radius_mm, 0, "mm")
                                            : approach.target.label,
                {} },
            asked_row("incision_length_mm", planner::incision_length(approach)),
            asked_row("cut_depth_mm", approach.depth_mm),
            { "Held aside", joined(approach.retracted), "Organs that this approach takes as retracted." },
        } } };
    MetricSection hooks { "Hooks", {} };
    for (const planner::HookSpec& hook : approach.hooks)
        hooks.rows.push_back(hook_row(hook));
    if (!hooks.rows.empty())
        sections.push_back(std::move(hooks));
    return sections;
}

std::string field_summary(const planner::FieldMetrics& field)
{
    const auto text = [&](const char* key) {
        return planner::metric_text(planner::metric_field(key), planner::metric_field(key).of(field), 0);
    };
    return text("visible_fraction") + " seen, " + text("hook_force_N") + ", " + text("opening_area_mm2");
}

std::string approach_summary(const planner::Approach& approach)
{
    return approach.template_name + ", " + number(planner::incision_length(approach), 0, "mm") + ", "
        + std::to_string(approach.hooks.size()) + (approach.hooks.size() == 1 ? " hook" : " hooks");
}

} // namespace retractor::ui
