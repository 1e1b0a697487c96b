#include "ui/cli/plan/field_table.h"

#include "mesh/base/text_format.h"
#include "planner/measures/accuracy.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/comparison.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/metrics.h"
#include "planner/measures/region_text.h"
#include "planner/measures/rupture.h"
#include "planner/measures/sight/table_position.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/verdict.h"
#include "planner/measures/volume_failures.h"
#include "ui/results/field_files.h"

#include <algorithm>
#include <cstddef>

namespace retractor::ui::cli {

namespace {

    constexpr int kTetsWidth = 8;

    /// Text after a space, right-aligned in a column of this width.
    std::string right_aligned(const std::string& text, int width)
    {
        const std::size_t missing
            = static_cast<std::size_t>(width) - std::min(text.size(), static_cast<std::size_t>(width));
        return std::string(1 + missing, ' ') + text;
    }

    /// A column of the table for the terminal, with a short heading.
    struct Column {
        const char* key;
        const char* head;
        int width;
    };

    constexpr Column kColumns[] = {
        { "seen_best_eye", "seen", 7 },
        { "seen_two_eyes", "2 eyes", 7 },
        { "reached_by_two_instruments", "2 tools", 7 },
        { "opening_area_mm2", "area cm2", 9 },
        { "opening_width_mm", "width mm", 9 },
        { "working_distance_mm", "depth mm", 9 },
        { "hook_force_N", "force N", 9 },
        { "strain_p99", "strain", 8 },
    };

    /// Text of a cell: " 62.3 %" or "     57.9". The unit of lengths, areas and forces is in the column's heading.
    std::string cell(const Column& column, const planner::FieldMetrics& field)
    {
        const planner::MetricField& metric = planner::metric_field(column.key);
        const std::string text = metric.unit == planner::MetricUnit::percent
            ? planner::metric_text(metric, metric.of(field))
            : planner::metric_number(metric, metric.of(field));
        return right_aligned(text, column.width);
    }

    std::string residual_text(const planner::FieldMetrics& field)
    {
        return formatted("; relative residual %.1e", field.residual);
    }

} // namespace

int exit_code_of(const std::vector<planner::PlannedField>& fields)
{
    for (const planner::PlannedField& field : fields)
        if (!is_answer(field) || (field.metrics.second_opinion && field.metrics.second_opinion->status != "agrees"))
            return 1;
    return 0;
}

std::string field_table(const std::vector<planner::PlannedField>& fields)
{
    std::string text = formatted("%-16s", "approach");
    for (const Column& column : kColumns)
        text += right_aligned(column.head, column.width);
    text += right_aligned("tets", kTetsWidth) + "\n";
    for (const planner::PlannedField& field : fields) {
        if (!planner::is_measured(field)) {
            text += field.approach.name + ": " + std::string(status_word(field.status))
                + (field.message.empty() ? "" : ": " + field.message) + "\n";
            continue;
        }
        const planner::FieldMetrics& m = field.metrics;
        text += formatted("%-16s", m.name.c_str());
        for (const Column& column : kColumns)
            text += cell(column, m);
        text += right_aligned(std::to_string(m.tets), kTetsWidth) + "\n";
        if (field.status != planner::PlanStatus::done)
            text += "  " + m.mechanics_status + "\n"
                + (planner::keeps_volume(m) ? "" : "  " + planner::volume_failure_text(m) + "\n");
        else if (!field.message.empty())
            text += "  " + field.message + "\n";
        for (const std::string& remark :
            { planner::division_text(m), planner::removed_text(m.removed), planner::skin_hole_text(m) })
            if (!remark.empty())
                text += "  " + remark + "\n";
        if (const std::string retractor = planner::retractor_text(m); !retractor.empty())
            text += "  " + retractor + "\n";
        if (const std::string lips = planner::lips_text(m); !lips.empty())
            text += "  " + lips + "\n";
        if (const std::string hooks = planner::hooks_text(m); !hooks.empty())
            text += "  " + hooks + "\n";
        if (const std::string moments = planner::force_moments_text(m); !moments.empty())
            text += "  " + moments + "\n";
        text += "  " + planner::solution_text(m) + residual_text(m) + "\n";
        for (const planner::PressureMetrics& pressure : m.pressures)
            text += "  " + planner::pressure_text(pressure) + "\n";
        if (m.tension)
            text += "  " + planner::tension_text(m) + "\n";
        text += "  " + planner::error_text(m) + "\n";
        if (const std::string parameters = planner::parameter_text(m); !parameters.empty())
            text += "  " + parameters + "\n";
        if (const std::string stiffness = planner::bone_stiffness_text(m); !stiffness.empty())
            text += "  " + stiffness + "\n";
        text += (planner::is_region_too_small(m) ? "  caution: " : "  ") + planner::region_text(m) + "\n";
        if (const std::string piercing = planner::piercing_text(m); !piercing.empty())
            text += "  " + piercing + "\n";
        if (const std::string accuracy = planner::accuracy_text(m); !accuracy.empty())
            text += "  " + accuracy + "\n";
        if (m.contact)
            text += (planner::passes_through(m) ? "  caution: " : "  ") + planner::contact_text(m) + "\n";
        if (m.second_opinion)
            text += "  " + planner::opinion_text(*m.second_opinion) + "\n";
        if (const std::string shifted = planner::shifted_sight_text(m); !shifted.empty())
            text += "  " + shifted + "\n";
        if (const std::string turned = planner::turned_sight_text(m); !turned.empty())
            text += "  " + turned + "\n";
        if (const std::string estimated = planner::estimated_text(m); !estimated.empty())
            text += "  caution: " + estimated + "\n";
        if (!m.at_risk.empty())
            text += "  " + planner::risks_text(m) + "\n";
        if (!m.hooks.empty()) {
            text += "  hooks bear on:";
            for (const planner::HookForce& hook : m.hooks)
                text += (&hook == &m.hooks.front() ? " " : "; ") + hook.name + " on " + planner::bearing_text(hook);
            text += "\n";
        }
        if (m.hook_force_N > planner::kImpossibleForceN)
            text += "  failed: " + planner::why_not_to_use(m) + "\n";
        for (const std::string& implausible : m.implausible)
            text += "  caution: accepted although implausible: " + implausible + "\n";
        if (const std::string bones = planner::bones_text(m); !bones.empty())
            text += (planner::breaks_bone(m) ? "  caution: " : "  ") + bones + "\n";
        if (const std::string joints = planner::joints_text(m); !joints.empty())
            text += "  " + joints + "\n";
        if (const std::string strain = planner::tissue_strain_text(m); !strain.empty())
            text += "  " + strain + "\n";
        if (const std::string tearing = planner::tearing_text(m); !tearing.empty())
            text += "  caution: " + tearing + "\n";
        if (planner::may_rupture(m))
            text += "  caution: " + planner::rupture_text(m) + "\n";
        if (const std::string fast = planner::fast_opening_text(m); !fast.empty())
            text += "  caution: " + fast + "\n";
        if (m.inverted_elements > 0)
            text += formatted("  caution: %d element(s) are turned inside out, and tissue is stretched to %.1f times "
                              "its volume: strain and force are inaccurate\n",
                m.inverted_elements, m.max_volume_ratio);
    }
    return text;
}

} // namespace retractor::ui::cli
