#include "planner/measures/metric_table.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace retractor::planner {

namespace {

    constexpr std::array kMetricFields {
        MetricField { .key = "seen_best_eye",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "Target seen, best eye",
            .meaning
            = "Seen from the best place of the surgeon's eye, at less than 60 degrees of incidence; share of what "
              "an eye would see with the wall removed.",
            .member = &FieldMetrics::seen_best_eye,
            .better = 1,
            .bar = MetricBar::estimated,
            .error = &ErrorBars::seen_best_eye,
            .compared = true },
        MetricField { .key = "seen_two_eyes",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "... with two eyes and a lamp",
            .meaning = "Seen by both of two eyes 64 mm apart, with light from between them.",
            .member = &FieldMetrics::seen_two_eyes,
            .better = 1,
            .bar = MetricBar::of_sight,
            .compared = true },
        MetricField { .key = "reached_by_two_instruments",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "... and reached by two instruments",
            .meaning = "Seen, and within reach of two straight shafts of 8 mm at once, at least 15 degrees apart.",
            .member = &FieldMetrics::reached_by_two_instruments,
            .better = 1,
            .bar = MetricBar::of_sight,
            .compared = true },
        MetricField { .key = "reached_by_finger",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "Touched by a finger",
            .meaning = "Within reach of a straight finger, 16 mm thick and 80 mm from the skin, seen or not.",
            .member = &FieldMetrics::reached_by_finger,
            .better = 1,
            .bar = MetricBar::of_sight,
            .compared = true },
        MetricField { .key = "best_eye_picture",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "Target in the picture",
            .meaning
            = "Share of the target's picture that the best eye sees: area as it appears, over that of the target "
              "alone.",
            .member = &FieldMetrics::best_eye_picture },
        MetricField { .key = "visible_fraction_mean_eye",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "Target's area seen, mean eye",
            .meaning = "Share of the target's whole area that an eye of the cone sees, averaged over the cone.",
            .member = &FieldMetrics::visible_fraction_mean_eye,
            .better = 1,
            .bar = MetricBar::of_sight,
            .compared = true },
        MetricField { .key = "visible_fraction_central_eye",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "... from the central eye alone",
            .meaning = "The same share, seen from the middle of the cone alone.",
            .member = &FieldMetrics::visible_fraction_central_eye,
            .better = 1,
            .bar = MetricBar::of_opening },
        MetricField { .key = "visible_fraction",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "... from any eye of the cone (union)",
            .meaning
            = "Share of the target's whole area that at least one eye of the cone sees. No single eye sees all "
              "of it.",
            .member = &FieldMetrics::visible_fraction,
            .compared = true },
        MetricField { .key = "visible_fraction_wall_removed",
            .group = MetricGroup::sight,
            .unit = MetricUnit::percent,
            .caption = "... the same with the wall removed",
            .meaning = "The union with no chest wall in the way: no retractor can show more.",
            .member = &FieldMetrics::visible_fraction_wall_removed,
            .compared = true },
        MetricField { .key = "opening_area_mm2",
            .group = MetricGroup::opening,
            .unit = MetricUnit::cm2,
            .caption = "Opening area",
            .meaning = "Area between the opened lips.",
            .member = &FieldMetrics::opening_area_mm2,
            .better = 1,
            .bar = MetricBar::estimated,
            .error = &ErrorBars::opening_area_mm2,
            .compared = true },
        MetricField { .key = "opening_width_mm",
            .group = MetricGroup::opening,
            .unit = MetricUnit::mm,
            .caption = "Opening width",
            .meaning = "Largest distance between the lips, across the incision.",
            .member = &FieldMetrics::opening_width_mm,
            .better = 1,
            .bar = MetricBar::estimated,
            .error = &ErrorBars::opening_width_mm,
            .compared = true },
        MetricField { .key = "working_distance_mm",
            .group = MetricGroup::distances,
            .unit = MetricUnit::mm,
            .caption = "Working distance",
            .meaning = "Distance from the opening to the target.",
            .member = &FieldMetrics::working_distance_mm,
            .better = -1,
            .compared = true },
        MetricField { .key = "access_horizontal_deg",
            .group = MetricGroup::distances,
            .unit = MetricUnit::degree,
            .caption = "Access angle, horizontal",
            .meaning = "Direction from the target to the opening: in the axial plane, from straight ahead towards the "
                       "patient's left.",
            .member = &FieldMetrics::access_horizontal_deg,
            .compared = true },
        MetricField { .key = "access_vertical_deg",
            .group = MetricGroup::distances,
            .unit = MetricUnit::degree,
            .caption = "Access angle, vertical",
            .meaning = "Direction from the target to the opening: out of the axial plane, towards the head.",
            .member = &FieldMetrics::access_vertical_deg,
            .compared = true },
        MetricField { .key = "coaxiality_deg",
            .group = MetricGroup::distances,
            .unit = MetricUnit::degree,
            .caption = "Best eye off the square view",
            .meaning = "Angle between the best eye's line of sight and the normal of the opening's skin plane.",
            .member = &FieldMetrics::coaxiality_deg },
        MetricField { .key = "target_offset_mm",
            .group = MetricGroup::distances,
            .unit = MetricUnit::mm,
            .caption = "Target off the middle",
            .meaning = "Distance of the target from the line through the middle of the opening, square to the skin.",
            .member = &FieldMetrics::target_offset_mm,
            .compared = true },
        MetricField { .key = "attack_along_deg",
            .group = MetricGroup::distances,
            .unit = MetricUnit::degree,
            .caption = "Angle of attack along the cut",
            .meaning = "Angle at the target between the outermost straight lines to the lips of the skin, along the "
                       "incision. What lies between does not count.",
            .member = &FieldMetrics::attack_along_deg,
            .better = 1,
            .bar = MetricBar::of_opening,
            .compared = true },
        MetricField { .key = "attack_across_deg",
            .group = MetricGroup::distances,
            .unit = MetricUnit::degree,
            .caption = "Angle of attack across the cut",
            .meaning = "The same angle across the incision.",
            .member = &FieldMetrics::attack_across_deg,
            .better = 1,
            .bar = MetricBar::of_opening,
            .compared = true },
        MetricField { .key = "opening_solid_angle_sr",
            .group = MetricGroup::distances,
            .unit = MetricUnit::sr,
            .caption = "Solid angle of the opening",
            .meaning = "Solid angle that the opening of the skin fills, seen from the target; half of all directions "
                       "are 6.3 sr.",
            .member = &FieldMetrics::opening_solid_angle_sr,
            .better = 1,
            .bar = MetricBar::of_opening },
        MetricField { .key = "surgical_freedom_mm2",
            .group = MetricGroup::distances,
            .unit = MetricUnit::cm2,
            .caption = "Surgical freedom",
            .meaning = "Area over which the near end of a straight instrument of 300 mm and 8 mm can move, with its "
                       "tip on the middle of what is seen, past wall, blades and organs.",
            .member = &FieldMetrics::surgical_freedom_mm2,
            .better = 1,
            .bar = MetricBar::of_opening,
            .compared = true },
        MetricField { .key = "incision_length_mm",
            .group = MetricGroup::distances,
            .unit = MetricUnit::mm,
            .caption = "Incision length",
            .meaning = "Length of the incision along the skin.",
            .member = &FieldMetrics::incision_length_mm,
            .better = -1,
            .bar = MetricBar::exact,
            .compared = true },
        MetricField { .key = "cut_depth_mm",
            .group = MetricGroup::distances,
            .unit = MetricUnit::mm,
            .caption = "Depth of cut",
            .meaning = "Depth of the cut along the blade.",
            .member = &FieldMetrics::cut_depth_mm,
            .bar = MetricBar::exact },
        MetricField { .key = "hook_force_N",
            .group = MetricGroup::force,
            .unit = MetricUnit::N,
            .caption = "Force, larger side",
            .meaning
            = "Sum over the hooks of the side that pulls harder, at the last turn of a slow opening where they are "
              "moved by a distance.",
            .member = &FieldMetrics::hook_force_N,
            .better = -1,
            .bar = MetricBar::estimated,
            .error = &ErrorBars::hook_force_N,
            .compared = true },
        MetricField { .key = "strain_p99",
            .group = MetricGroup::strain,
            .unit = MetricUnit::percent,
            .caption = "Tissue strain, 99th percentile",
            .meaning = "Exceeded by one hundredth of the wall's volume, outside the patches and the cut front.",
            .member = &FieldMetrics::strain_p99,
            .better = -1,
            .compared = true },
        MetricField { .key = "max_volume_ratio",
            .group = MetricGroup::soundness,
            .caption = "Largest volume ratio",
            .meaning = "Largest change of volume of an element.",
            .member = &FieldMetrics::max_volume_ratio },
        MetricField { .key = "residual",
            .group = MetricGroup::soundness,
            .caption = "Residual",
            .meaning = "Relative residual force of the mechanical equilibrium.",
            .member = &FieldMetrics::residual },
    };

} // namespace

std::span<const MetricField> metric_fields() { return kMetricFields; }

const MetricField& metric_field(std::string_view key)
{
    const auto* const found = std::find_if(
        kMetricFields.begin(), kMetricFields.end(), [&](const MetricField& metric) { return metric.key == key; });
    RETRACTOR_ASSERT(found != kMetricFields.end());
    return *found;
}

std::string metric_number(const MetricField& metric, double value, int digits)
{
    constexpr double kPercent = 100.0, kMm2PerCm2 = 100.0;
    constexpr int kLeastDigitsOfSr = 2; // a wound fills some tenths
    switch (metric.unit) {
    case MetricUnit::percent:
        return in_words(kPercent * value, digits);
    case MetricUnit::cm2:
        return in_words(value / kMm2PerCm2, digits);
    case MetricUnit::sr:
        return in_words(value, std::max(digits, kLeastDigitsOfSr));
    case MetricUnit::degree:
    case MetricUnit::mm:
    case MetricUnit::N:
    case MetricUnit::none:
        break;
    }
    return in_words(value, digits);
}

std::string metric_text(const MetricField& metric, double value, int digits)
{
    constexpr std::array kUnits { " %", " cm²", "°", " mm", " N", " sr", "" }; // in the order of MetricUnit
    return metric_number(metric, value, digits) + kUnits.at(static_cast<std::size_t>(metric.unit));
}

std::optional<double> metric_error(const MetricField& metric, const FieldMetrics& field)
{
    if (metric.error == nullptr || !field.error || !field.error->message.empty())
        return std::nullopt;
    return (*field.error).*metric.error;
}

} // namespace retractor::planner
