#include "planner/plan/explanation.h"

#include "mesh/base/text_format.h"
#include "planner/measures/metrics.h"
#include "planner/measures/sight/finger_text.h"
#include "planner/plan/planned_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::planner {

namespace {

    /// Smaller shares are not worth a surgeon's attention.
    constexpr double kSmallestShareToName = 0.03;
    /// The hidden part lies "to one side" when its distance from the seen part exceeds this share of the target's
    /// radius.
    constexpr double kSideOffset = 0.25;

    std::string percent(double share) { return formatted("%.0f %%", 100.0 * share); }

    std::string millimetres(double value) { return formatted("%.0f mm", value); }

    std::string listed(const std::vector<std::string>& words)
    {
        std::string out;
        for (std::size_t i = 0; i < words.size(); ++i)
            out += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
        return out;
    }

    /// The directions from the seen samples to the samples that no eye sees, e.g. "posterior and inferior".
    std::string hidden_side(const Exposure& exposure, const AnatomicalFrame& frame)
    {
        Vec3 seen = Vec3::Zero();
        Vec3 hidden = Vec3::Zero();
        double seen_count = 0.0;
        double hidden_count = 0.0;
        for (std::size_t i = 0; i < exposure.sample_points.size(); ++i) {
            const bool is_seen = exposure.sample_seen[i] > 0.0F;
            (is_seen ? seen : hidden) += exposure.sample_points[i].position;
            (is_seen ? seen_count : hidden_count) += 1.0;
        }
        if (seen_count == 0.0 || hidden_count == 0.0)
            return {};
        const Vec3 offset = hidden / hidden_count - seen / seen_count;
        const double radius = std::sqrt(exposure.target_area_mm2 / (4.0 * M_PI));
        struct Direction {
            double amount;
            const char* positive;
            const char* negative;
        };
        const std::array<Direction, 3> directions { { { offset.dot(frame.anterior), "anterior", "posterior" },
            { offset.dot(frame.superior), "superior", "inferior" }, { offset.dot(frame.left), "left", "right" } } };
        std::vector<std::string> words;
        for (const Direction& d : directions)
            if (std::abs(d.amount) > kSideOffset * radius)
                words.emplace_back(d.amount > 0.0 ? d.positive : d.negative);
        return listed(words);
    }

    std::string sight_sentence(const FieldMetrics& metrics)
    {
        const std::string target = readable(metrics.target);
        if (!(metrics.seen_best_eye > 0.0))
            return !(metrics.best_eye.bound_area_mm2 > 0.0)
                ? "Organs hide the " + target + " even with the wall removed. "
                : formatted("No eye sees the %s through the opening at less than %.0f degrees of incidence. ",
                    target.c_str(), kLargestIncidenceDeg);
        return "The best eye sees " + percent(metrics.seen_best_eye) + " of what an eye would see of the " + target
            + " with the wall removed. Both eyes with a lamp see " + percent(metrics.seen_two_eyes)
            + ". Two instruments reach " + percent(metrics.reached_by_two_instruments) + ". ";
    }

    std::string annulus_sentence(const FieldMetrics& metrics)
    {
        if (!metrics.annulus)
            return {};
        const AnnulusAccess& annulus = *metrics.annulus;
        if (!annulus.message.empty())
            return "No angle to the valve: " + annulus.message + ". ";
        const std::string sight = metrics.seen_best_eye > 0.0
            ? formatted("; the best eye looks along it at %.0f degrees", annulus.sight_off_axis_deg)
            : std::string();
        return formatted("The opening lies %.0f mm from the annulus, %.0f degrees off the valve's axis",
                   annulus.distance_mm, annulus.opening_off_axis_deg)
            + sight + ". ";
    }

    /// Names with their shares, the largest first.
    std::string named_shares(const std::vector<SightShare>& shares, std::size_t most)
    {
        std::vector<std::string> words;
        for (const SightShare& share : shares)
            if (share.share >= kSmallestShareToName && words.size() < most)
                words.push_back(readable(share.name) + " (" + percent(share.share) + ")");
        return listed(words);
    }

    std::string blocker_sentence(const SurgeonEye& eye)
    {
        const std::string words = named_shares(eye.hidden_by, 4);
        if (words.empty())
            return words;
        double hidden = 0.0;
        for (const SightShare& share : eye.hidden_by)
            hidden += share.share;
        return "Of the side of the target that faces "
            + std::string(eye.seen_fraction > 0.0 ? "this eye" : "the middle of the cone") + ", "
            + percent(std::max(0.0, 1.0 - hidden)) + " is seen. The rest is hidden by " + words + ". ";
    }

    std::string bone_sentence(const Exposure& exposure)
    {
        const std::string words = named_shares(exposure.bone_in_sight, exposure.bone_in_sight.size());
        if (words.empty())
            return "No bone stands in the line of sight. ";
        return "Share of the lines of sight from the cone that meet bone, also behind other tissue: " + words
            + ". Part of this bone would have to be pulled further or removed to see more. ";
    }

    std::string opening_sentence(const FieldMetrics& metrics)
    {
        const std::string hole = skin_hole_text(metrics);
        return "The skin opens by " + millimetres(metrics.opening_width_mm) + " over an incision of "
            + millimetres(metrics.incision_length_mm) + ", and the target lies "
            + millimetres(metrics.working_distance_mm) + " below it."
            + (hole.empty() ? "" : " Mind that " + hole + ".");
    }

} // namespace

std::string explain_field(const PlannedField& field, const AnatomicalFrame& frame)
{
    std::string text = field.approach.rationale.empty() ? "" : field.approach.rationale + " ";
    text += sight_sentence(field.metrics) + annulus_sentence(field.metrics) + finger_text(field.metrics) + " ";
    if (const std::string side = hidden_side(field.exposure, frame); !side.empty())
        text += "What stays hidden is its " + side + " part. ";
    text += blocker_sentence(field.best_eye) + bone_sentence(field.exposure) + opening_sentence(field.metrics);
    return text;
}

} // namespace retractor::planner
