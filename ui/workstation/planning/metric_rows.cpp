#include "ui/workstation/planning/metric_rows.h"

#include "mesh/base/text_format.h"
#include "planner/anatomy/deflated_lung.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/retractors.h"
#include "planner/case/opening_protocol.h"
#include "planner/measures/accuracy.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/hook_opening.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/metrics.h"
#include "planner/measures/region_text.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/rupture.h"
#include "planner/measures/sight/table_position.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/volume_failures.h"

#include <algorithm>
#include <cmath>

namespace retractor::ui {

namespace {

    /// A volume that more than doubles or halves is an artefact of the model, not a result.
    constexpr double kDoubtfulVolumeRatio = 2.0;

    std::string number(double value, int digits, const char* unit)
    {
        return formatted(*unit == '\0' ? "%.*f%s" : "%.*f %s", digits, value, unit);
    }

    std::string percent(double fraction) { return number(100.0 * fraction, 1, "%"); }

    /// "left rib 4, left lung"; "none" without names.
    std::string names_in_words(const std::vector<std::string>& names)
    {
        return names.empty() ? "none" : readable(joined(names));
    }

    constexpr const char* kBar = " ±: estimated change of the number with a finer mesh.";

    /// The row of a number: "58.0 ± 1.2 mm" with an estimate, otherwise "58.0 mm".
    MetricRow metric_row(const planner::FieldMetrics& field, const planner::MetricField& metric)
    {
        const int digits = metric.group == planner::MetricGroup::distances                       ? 0
            : metric.unit == planner::MetricUnit::none || metric.unit == planner::MetricUnit::sr ? 2
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
        MetricSection section { "Sight",
            { { "Target", readable(field.target), "Structure that the surgeon wants to see." } } };
        add_rows(section, field, planner::MetricGroup::sight);
        if (const std::string estimated = planner::estimated_text(field); !estimated.empty())
            section.rows.push_back({ "Estimated", names_in_words(field.estimated),
                "Labels that the image does not show. They were estimated from their surroundings.", true });
        for (const planner::ShiftedSight& shifted : field.if_organs_shift)
            section.rows.push_back(
                { "Seen with organs " + number(shifted.shift_mm, 0, "mm higher"), percent(shifted.seen_best_eye),
                    "Seen by the best eye with the organs nearer to the head, as in expiration." });
        for (const planner::LungSight& lung : field.if_lung_keeps)
            section.rows.push_back({ "Seen past a lung of " + number(100.0 * lung.lung_share, 0, "% of its volume"),
                percent(lung.seen_best_eye),
                formatted(
                    "Seen by the best eye when the lung that is held aside keeps another share of its volume than "
                    "the assumed %.0f %%.",
                    100.0 * planner::kDeflatedLungShare) });
        for (const planner::TurnedSight& turned : field.if_turned)
            section.rows.push_back(
                { "Seen " + planner::position_words(turned.left_side_up_deg), percent(turned.seen_best_eye),
                    formatted(
                        "Seen by the best eye that looks down at the wound by at least %.0f degrees, with the patient "
                        "so on the table. Organs sink with gravity.",
                        planner::kLowestSightDeg) });
        section.rows.push_back({ "Bone in sight", names_in_words(planner::bones_in_sight(field)),
            "Bones that block the view of the target." });
        section.rows.push_back(
            { "Held aside", names_in_words(field.retracted), "Organs that are held aside in this approach." });
        for (std::size_t i = 0; i < std::min<std::size_t>(3, field.best_eye.hidden_by.size()); ++i)
            section.rows.push_back(
                { "Hidden by " + readable(field.best_eye.hidden_by[i].name), percent(field.best_eye.hidden_by[i].share),
                    "Share of the target that this structure hides first from the best eye." });
        return section;
    }

    MetricSection opening_section(const planner::FieldMetrics& field)
    {
        MetricSection section { "Opening", {} };
        if (!field.hooks.empty())
            section.rows.push_back({ "Planned opening, from side to side", planner::asked_text(field),
                "What the retractor or the hooks are set to. The skin's edge opens more or less than they do." });
        add_rows(section, field, planner::MetricGroup::opening);
        add_rows(section, field, planner::MetricGroup::distances);
        for (const planner::RiskDistance& risk : field.at_risk)
            section.rows.push_back({ "Cut to " + planner::risk_name(risk),
                risk.distance_mm > 0.0 ? in_words(risk.distance_mm, 1) + " mm" : "passes through it",
                "Shortest distance from the cut to this structure at risk, before opening." });
        for (const planner::RiskDistance& risk : field.steel_at_risk)
            section.rows.push_back(
                { readable(risk.from) + " to " + readable(risk.name), in_words(risk.distance_mm, 1) + " mm",
                    "Shortest distance from this instrument, where it stands in the opened wound, to this structure at "
                    "risk, "
                    "where the CT shows it." });
        return section;
    }

    /// Whether the opening can be had, and what the ribs bear.
    void add_bones(MetricSection& section, const planner::FieldMetrics& field)
    {
        const bool warning
            = field.attainable == planner::Attainable::with_injury || field.attainable == planner::Attainable::no;
        section.rows.push_back(
            { "Opening possible", planner::attainable_text(field), planner::bones_text(field), warning });
        if (planner::breaks_bone(field))
            section.rows.push_back(
                { "Without a fracture", "about " + number(std::floor(*field.largest_uninjured_opening_mm), 0, "mm"),
                    "Largest opening of the hooks at which no rib breaks: an estimate in proportion to the opening." });
        if (!field.bones.empty() && field.bones.front().capacity_Nm)
            section.rows.push_back({ "Most loaded rib", percent(field.bones.front().utilisation),
                "Moment in " + planner::bone_in_words(field.bones.front().name)
                    + " over the moment at which tested ribs broke.",
                field.bones.front().utilisation >= 1.0 });
    }

    /// What the ranges of the tissue values do to the force, beside the bar of the mesh.
    void add_parameters(MetricSection& section, const planner::FieldMetrics& field)
    {
        if (field.parameters) {
            const planner::ParameterInterval& interval = *field.parameters;
            section.rows.push_back({ "... by tissue values",
                interval.message.empty()
                    ? number(interval.force_low_N, 0, "") + " to " + number(interval.force_high_N, 0, "N")
                    : "not known",
                interval.message.empty() ? planner::force_with_intervals(field)
                        + ". One standard deviation of the tissues' published values."
                                         : planner::parameter_text(field) + "." });
        }
    }

    void add_bone_stiffness(MetricSection& section, const planner::FieldMetrics& field)
    {
        if (const std::string stiffness = planner::bone_stiffness_text(field); !stiffness.empty())
            section.rows.push_back({ "Stiffness of bones", stiffness,
                "Young's moduli of the ribs and cartilages in the wall; the report has a table." });
    }

    /// The force on a side at the last turn of the crank and minutes later, or why there is none.
    void add_moments(MetricSection& section, const planner::FieldMetrics& field)
    {
        if (!field.force_moments)
            return;
        const planner::ForceMoments& moments = *field.force_moments;
        if (!moments.message.empty()) {
            section.rows.push_back({ "... after minutes", "not applicable", planner::force_moments_text(field) + "." });
            return;
        }
        section.rows.push_back({ "... at the last turn", number(moments.peak_N, 0, "N"),
            planner::force_moments_text(field) + ".", moments.is_fast });
        section.rows.push_back(
            { "... after " + planner::time_text(moments.hold_s), "about " + number(moments.held_N, 0, "N"),
                "Held at this opening: " + number(moments.held_least_N, 0, "") + " to "
                    + number(moments.held_most_N, 0, "N") + " between animals; " + moments.source + "." });
    }

    /// The largest strain of each tissue, averaged over balls, and whether skin would tear.
    void add_tissue_strain(MetricSection& section, const planner::FieldMetrics& field)
    {
        for (const planner::TissueStrain& tissue : field.tissue_strain)
            section.rows.push_back({ "Strain of " + readable(tissue.tissue), number(100.0 * tissue.strain, 0, "%"),
                "Largest mean over balls of " + number(planner::kBallRadiusMm, 0, "mm")
                    + " radius: " + planner::strain_text(tissue) + ".",
                planner::may_tear(tissue) });
        if (planner::any_may_tear(field))
            section.rows.push_back({ "Tearing", planner::any_would_tear(field) ? "expected" : "possible",
                planner::tearing_text(field) + ".", true });
    }

    MetricSection force_section(const planner::FieldMetrics& field)
    {
        MetricSection section { "Force and strain", {} };
        add_rows(section, field, planner::MetricGroup::force);
        add_parameters(section, field); // the rows of these two begin with "..." and belong to the force
        add_moments(section, field);
        add_bone_stiffness(section, field);
        add_rows(section, field, planner::MetricGroup::strain);
        add_tissue_strain(section, field);
        add_bones(section, field);
        if (planner::may_rupture(field))
            section.rows.push_back({ "Rupture", "possible", planner::rupture_text(field) + ".", true });
        if (const std::string fast = planner::fast_opening_text(field); !fast.empty())
            section.rows.push_back({ "Speed of opening", "fast", fast + ".", true });
        if (field.retractor && field.retractor->hand_moment_Nm)
            section.rows.push_back({ "Retractor, kept from tilting", number(*field.retractor->hand_moment_Nm, 2, "N m"),
                "The free frame found no balance: a hand or an arm at the table holds its direction.", true });
        if (field.retractor)
            for (const planner::BladeMetrics& blade : field.retractor->blades)
                section.rows.push_back({ "Retractor, " + readable(blade.name),
                    number(blade.force_N.norm(), 1, "N") + ", " + number(blade.moment_Nm.norm(), 2, "N m"),
                    planner::blade_text(blade) + "." });
        for (const planner::LipDeviation& lip : field.lip_deviation)
            section.rows.push_back({ "Off its line: " + planner::lip_name(field, lip.side),
                number(lip.largest_mm, 1, "mm"),
                "Largest distance of the skin's edge from the line of its hooks, in the middle part of the incision; "
                    + number(lip.mean_mm, 1, "mm") + " in the mean." });
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const bool known = field.error && field.error->message.empty() && i < field.error->hook_forces_N.size();
            const double force = field.hooks[i].force_N;
            section.rows.push_back(
                { field.retractor ? "Force of the " + readable(field.hooks[i].name) : "Hook " + field.hooks[i].name,
                    known ? number(force, 1, "") + " ± " + number(field.error->hook_forces_N[i], 1, "N")
                          : number(force, 1, "N"),
                    "Bears on " + planner::bearing_text(field.hooks[i]) + "." });
        }
        return section;
    }

    std::string contact_value(const planner::ContactMetrics& contact)
    {
        if (contact.computed)
            return contact.touching > 0 ? std::to_string(contact.touching) + " points touch" : "nothing touches";
        if (!contact.needed)
            return "not tested";
        if (*contact.needed)
            return number(contact.largest_penetration_mm, 1, "mm") + " passed through";
        return planner::sinks_in(contact) ? number(contact.largest_penetration_mm, 1, "mm") + " sunk in"
                                          : "nothing touches";
    }

    MetricSection model_section(const planner::FieldMetrics& field)
    {
        double seconds = 0.0;
        for (const auto& [stage, time] : field.seconds)
            seconds += time;
        MetricRow volume_ratio = metric_row(field, planner::metric_field("max_volume_ratio"));
        volume_ratio.warning = field.max_volume_ratio > kDoubtfulVolumeRatio;
        MetricSection section { .title = "Technical",
            .rows = {
                { "Equilibrium", field.mechanics_status, "Whether the computation found the equilibrium.",
                    field.mechanics_status != "converged" },
                { "Computed as", planner::solution_text(field.solution.choice),
                    "Fields that were computed differently cannot be compared." },
                { "Tetrahedra", std::to_string(field.tets), {} },
                { "Inverted", std::to_string(field.inverted_elements),
                    "Elements that turned inside out. The numbers near them are wrong.", field.inverted_elements > 0 },
                volume_ratio,
                { "Planning time", number(seconds, 1, "s"), {} },
            },
            .technical = true };
        if (field.accuracy)
            for (const planner::AccuracyField& row : planner::accuracy_fields())
                if (const auto value = row.of(*field.accuracy))
                    section.rows.push_back({ row.caption, planner::accuracy_number(row, *value),
                        row.meaning + (" " + planner::accuracy_text(field)),
                        field.accuracy->ended_by != planner::AccuracyEnd::reached });
        if (field.volume_failures)
            section.rows.push_back({ "Soft tissue off its volume", number(100.0 * field.volume_failures->share, 2, "%"),
                planner::keeps_volume(field)
                    ? "Share of the soft tissue that shrinks or grows by more than a tenth. Soft tissue keeps its "
                      "volume, so the numbers near such tissue are wrong."
                    : "The plan " + planner::volume_failure_text(field) + ".",
                !planner::keeps_volume(field) });
        section.rows.push_back(
            { "Rim of the model", field.region.rim_place.empty() ? "none" : number(field.region.rim_motion_mm, 1, "mm"),
                "Largest motion where the model ends. " + planner::region_text(field),
                planner::is_region_too_small(field) });
        if (const std::string piercing = planner::piercing_text(field); !piercing.empty())
            section.rows.push_back({ "Bones through the skin", std::to_string(field.region.piercing.size()),
                "The plan " + piercing + ".", true });
        if (field.contact)
            section.rows.push_back({ "Contact", contact_value(*field.contact), planner::contact_text(field) + ".",
                planner::passes_through(field) });
        if (field.tension)
            section.rows.push_back(
                { field.pressures.empty() ? "Gape without hooks" : "Gape under pressure, without hooks",
                    field.tension->message.empty() ? number(field.tension->gape_mm, 1, "mm") : "unknown",
                    planner::tension_text(field) + "." });
        for (const planner::PressureMetrics& pressure : field.pressures)
            section.rows.push_back(
                { "Pressure", number(pressure.pressure_kPa, 2, "kPa"), planner::pressure_text(pressure) + "." });
        for (const std::string& implausible : field.implausible)
            section.rows.push_back({ "Implausible", "accepted", implausible, true });
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
                "The hook pulls its lip with this force. The opening follows from the force." };
        MetricRow row { "Hook " + hook.name, number(hook.opening_mm, 0, "mm"),
            "The hook moves its lip by this distance." };
        if (!pull.prescribes())
            row.meaning = "The hook moves by this distance. Its lip may move less.";
        if (pull.force_limit_N) {
            row.value += ", at most " + number(*pull.force_limit_N, 1, "N");
            row.meaning += " The hook yields above the force limit.";
        }
        if (pull.grip_N_per_mm) {
            row.value += ", grip " + number(*pull.grip_N_per_mm, 1, "N/mm");
            row.meaning += " The lip follows the hook through a soft grip.";
        }
        return row;
    }

    /// What the blade divides, for people.
    std::string divides_in_words(const planner::Approach& approach)
    {
        if (planner::divides_sternum(approach.division.extent))
            return "The sternum, along and across";
        if (approach.division.extent == planner::DivisionExtent::full)
            return "The space between the ribs, beyond the incision too";
        if (approach.uncut_labels.empty())
            return "All tissue under the incision";
        return approach.template_name.starts_with("median") ? "Soft tissue and the sternum under the incision"
                                                            : "Soft tissue along the incision";
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
            { "Kind", planner::surgical_name(approach), {} },
            { "Target",
                approach.target.is_sphere() ? "sphere of " + number(approach.target.radius_mm, 0, "mm")
                                            : readable(planner::target_name(approach.target)),
                {} },
            asked_row("incision_length_mm", planner::incision_length(approach)),
            asked_row("cut_depth_mm", approach.depth_mm),
            { "Divides", divides_in_words(approach), "What the knife or the saw goes through." },
            { "Held aside", names_in_words(approach.retracted), "Organs that are held aside in this approach." },
        } } };
    MetricSection hooks { "Hooks", {} };
    for (const planner::HookSpec& hook : approach.hooks)
        hooks.rows.push_back(hook_row(hook));
    if (approach.retractor)
        hooks.rows.push_back({ "Instrument", planner::retractor_text(*approach.retractor),
            "Kind of the instrument, and its opening or force." });
    if (approach.opening_protocol && !hooks.rows.empty())
        hooks.rows.push_back({ "Opened by", planner::opening_protocol_text(*approach.opening_protocol),
            "Steps of the crank. Slower steps take less force." });
    if (!hooks.rows.empty())
        sections.push_back(std::move(hooks));
    return sections;
}

std::string field_summary(const planner::FieldMetrics& field)
{
    if (!planner::why_not_to_use(field).empty())
        return planner::words_of(planner::Light::unknown);
    const auto text = [&](const char* key) {
        return planner::metric_text(planner::metric_field(key), planner::metric_field(key).of(field), 0);
    };
    return text("seen_best_eye") + " seen, " + text("hook_force_N") + ", " + text("opening_area_mm2");
}

LightLook light_look(planner::Light light)
{
    const char* const words = planner::words_of(light);
    switch (light) {
    case planner::Light::clear:
        return { "#3fa7a0", words };
    case planner::Light::caution:
        return { "#e6b422", words };
    case planner::Light::injury:
        return { "#d1495b", words };
    case planner::Light::unknown:
        break;
    }
    return { "#8b949c", words };
}

std::string hooks_in_words(std::size_t count)
{
    return count == 0 ? "no hooks" : std::to_string(count) + (count == 1 ? " hook" : " hooks");
}

std::string approach_summary(const planner::Approach& approach)
{
    return number(planner::incision_length(approach), 0, "mm") + " long, "
        + (approach.retractor ? planner::retractor_text(*approach.retractor) : hooks_in_words(approach.hooks.size()));
}

} // namespace retractor::ui
