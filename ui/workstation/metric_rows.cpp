#include "ui/workstation/metric_rows.h"

#include "mesh/base/text.h"
#include "planner/metrics.h"

#include <algorithm>

namespace retractor {

namespace {

    /// Tissue that more than doubles or halves its volume is an artefact of the model, not a result.
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

    /// "58.0 ± 1.2 mm" where there is an estimate, else "58.0 mm".
    std::string with_bar(double value, double bar, int digits, const char* unit, const FieldMetrics& field)
    {
        if (!field.error || !field.error->message.empty())
            return number(value, digits, unit);
        return number(value, digits, "") + " ± " + number(bar, digits, unit);
    }

    constexpr const char* kBar = " ±: what finer elements would change.";

    MetricSection sight_section(const FieldMetrics& field)
    {
        MetricSection section { "Sight", {} };
        section.rows = {
            { "Target", field.target, "What the surgeon wants to see." },
            { "Seen, whole cone", percent(field.visible_fraction),
                "Share of the target's area seen from at least one eye position of the cone." },
            { "Seen, mean eye", percent(field.visible_fraction_mean_eye),
                "The same share, averaged over the eye positions." },
            { "Seen, central eye", percent(field.visible_fraction_central_eye),
                "The same share from the middle of the cone alone." },
            { "Upper bound", percent(field.visible_fraction_wall_removed),
                "The same cone with no chest wall in the way: no retractor can do better." },
            { "Bone in sight", joined(field.bone_in_sight),
                "Bones that are first to block lines of sight to the target." },
            { "Held aside", joined(field.retracted), "Organs that this approach takes as retracted." },
        };
        for (std::size_t i = 0; i < std::min<std::size_t>(3, field.blockers.size()); ++i)
            section.rows.push_back({ "Blocked by " + field.blockers[i].name, percent(field.blockers[i].share),
                "Share of the sight lines that this structure is the first to block." });
        return section;
    }

    MetricSection opening_section(const FieldMetrics& field)
    {
        return { "Opening",
            {
                { "Area", number(field.opening_area_mm2 / 100.0, 1, "cm²"), "Area between the opened lips." },
                { "Width",
                    with_bar(field.opening_width_mm, field.error ? field.error->opening_width_mm : 0.0, 1, "mm", field),
                    std::string("Largest distance between the lips, across the incision.") + kBar },
                { "Working distance", number(field.working_distance_mm, 0, "mm"), "From the opening to the target." },
                { "Incision", number(field.incision_length_mm, 0, "mm"), "Length along the skin." },
                { "Depth of cut", number(field.cut_depth_mm, 0, "mm"), "Along the blade." },
            } };
    }

    MetricSection force_section(const FieldMetrics& field)
    {
        MetricSection section { "Force and strain",
            {
                { "Pull, larger side",
                    with_bar(field.hook_force_N, field.error ? field.error->hook_force_N : 0.0, 1, "N", field),
                    std::string("Sum over the hooks of the side that pulls harder.") + kBar },
                { "Strain, 99 %", percent(field.strain_p99),
                    "Exceeded by one hundredth of the wall's volume, outside the patches and the cut front." },
            } };
        if (field.strain_p99_at) {
            const Vec3& at = *field.strain_p99_at;
            section.rows.push_back(
                { "... at", number(at.x(), 0, "") + ", " + number(at.y(), 0, "") + ", " + number(at.z(), 0, "mm"),
                    "Left, back, head (patient LPS), before the wound was opened." });
        }
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const bool known = field.error && i < field.error->hook_forces_N.size();
            section.rows.push_back({ "Hook " + field.hooks[i].name,
                known ? with_bar(field.hooks[i].force_N, field.error->hook_forces_N[i], 1, "N", field)
                      : number(field.hooks[i].force_N, 1, "N"),
                {} });
        }
        return section;
    }

    MetricSection model_section(const FieldMetrics& field)
    {
        double seconds = 0.0;
        for (const auto& [stage, time] : field.seconds)
            seconds += time;
        MetricSection section { "Model",
            {
                { "Equilibrium", field.mechanics_status, "Whether the mechanical solution converged.",
                    field.mechanics_status != "converged" },
                { "Solved as", solution_text(field.solution.choice), "Fields solved differently do not compare." },
                { "Tetrahedra", std::to_string(field.tets), {} },
                { "Inverted", std::to_string(field.inverted_elements),
                    "Elements turned inside out: the numbers are then wrong near them.", field.inverted_elements > 0 },
                { "Volume ratio", number(field.max_volume_ratio, 2, ""), "Largest change of volume of an element.",
                    field.max_volume_ratio > kDoubtfulVolumeRatio },
                { "Time to plan", number(seconds, 1, "s"), {} },
            } };
        if (field.tension)
            section.rows.push_back({ field.pressures.empty() ? "Gapes by itself" : "Gapes under pressure, no hooks",
                field.tension->message.empty() ? number(field.tension->gape_mm, 1, "mm") : "not told",
                tension_text(field) + "." });
        for (const PressureMetrics& pressure : field.pressures)
            section.rows.push_back(
                { "Pressure", number(pressure.pressure_kPa, 2, "kPa"), pressure_text(pressure) + "." });
        return section;
    }

    /// What drives the hook: a force, or a way that a limit and a grip may cut short.
    MetricRow hook_row(const HookSpec& hook)
    {
        const HookPull& pull = hook.pull;
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

std::vector<MetricSection> field_rows(const FieldMetrics& field)
{
    return { sight_section(field), opening_section(field), force_section(field), model_section(field) };
}

std::vector<MetricSection> approach_rows(const Approach& approach)
{
    std::vector<MetricSection> sections { { "Approach",
        {
            { "Template", approach.template_name, {} },
            { "Target",
                approach.target.is_sphere() ? "sphere of " + number(approach.target.radius_mm, 0, "mm")
                                            : approach.target.label,
                {} },
            { "Incision", number(incision_length(approach), 0, "mm"), "Length along the skin." },
            { "Depth of cut", number(approach.depth_mm, 0, "mm"), "Along the blade." },
            { "Held aside", joined(approach.retracted), "Organs that this approach takes as retracted." },
        } } };
    MetricSection hooks { "Hooks", {} };
    for (const HookSpec& hook : approach.hooks)
        hooks.rows.push_back(hook_row(hook));
    if (!hooks.rows.empty())
        sections.push_back(std::move(hooks));
    return sections;
}

std::string field_summary(const FieldMetrics& field)
{
    return number(100.0 * field.visible_fraction, 0, "%") + " seen, " + number(field.hook_force_N, 0, "N") + ", "
        + number(field.opening_area_mm2 / 100.0, 0, "cm²");
}

std::string approach_summary(const Approach& approach)
{
    return approach.template_name + ", " + number(incision_length(approach), 0, "mm") + ", "
        + std::to_string(approach.hooks.size()) + (approach.hooks.size() == 1 ? " hook" : " hooks");
}

} // namespace retractor
