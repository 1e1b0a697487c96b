#include "planner/measures/verdict.h"

#include "mesh/base/text_format.h"
#include "planner/anatomy/deflated_lung.h"
#include "planner/approach/divided_bones.h"
#include "planner/case/opening_protocol.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/region_text.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/rupture.h"
#include "planner/measures/sight/table_position.h"
#include "planner/measures/volume_failures.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kNotSeen = 0.005; ///< a share that rounds to nothing
    constexpr double kLittleSeen = 0.1; ///< ours: what is seen of a target hardly serves an operation
    constexpr double kMuchLess = 0.5; ///< ours: with another volume of the lung less than half as much is seen
    constexpr double kTouching = 2.0; ///< mm: about a voxel, to which the distance is known
    constexpr double kNearBreaking = 0.7; ///< utilisation; the capacities of tested ribs vary by about a third
    constexpr double kWideInterval = 0.5; ///< half of the interval over the force: its first digit is in doubt

    /// A sentence with what it means for the light.
    struct Said {
        Light light = Light::clear;
        std::string sentence;
    };
    using Sentences = std::vector<Said>;

    void say(Sentences& said, Light light, std::string sentence)
    {
        said.emplace_back();
        said.back().light = light;
        said.back().sentence = std::move(sentence);
    }

    /// Injury outweighs caution; nothing outweighs numbers that are not to be relied on.
    bool is_worse(const Said& a, const Said& b) { return static_cast<int>(a.light) > static_cast<int>(b.light); }

    void say_sight(const FieldMetrics& field, Sentences& said)
    {
        const std::string target = readable(field.target);
        if (field.seen_best_eye < kNotSeen)
            return say(said, Light::injury, "The " + target + " is not seen.");
        say(said, field.seen_best_eye < kLittleSeen ? Light::caution : Light::clear,
            "Shows " + two_digits(100.0 * field.seen_best_eye) + " % of what could be seen of the " + target + ".");
        const LungSight* least = nullptr; // the lung that hides most
        for (const LungSight& lung : field.if_lung_keeps)
            if (lung.seen_best_eye < kMuchLess * field.seen_best_eye
                && (least == nullptr || lung.seen_best_eye < least->seen_best_eye))
                least = &lung;
        if (least != nullptr)
            say(said, Light::caution,
                formatted("A lung that keeps %.0f %% of its volume instead of %.0f %% leaves ",
                    100.0 * least->lung_share, 100.0 * kDeflatedLungShare)
                    + (least->seen_best_eye < kNotSeen ? "nothing"
                                                       : "only " + two_digits(100.0 * least->seen_best_eye) + " %")
                    + " of the " + target + " in sight.");
    }

    /// How the patient should lie, where it changes much of what an eye above the table sees.
    void say_position(const FieldMetrics& field, Sentences& said)
    {
        constexpr double kWorthTurning = 1.25, kWorthTurningBy = 0.02;
        if (field.if_turned.empty())
            return;
        const double first = field.if_turned.front().seen_best_eye;
        const TurnedSight& best = *std::ranges::max_element(field.if_turned, {}, &TurnedSight::seen_best_eye);
        if (best.seen_best_eye > kWorthTurning * first && best.seen_best_eye > first + kWorthTurningBy)
            say(said, Light::clear,
                "From above the table " + two_digits(100.0 * best.seen_best_eye) + " % is seen "
                    + position_words(best.left_side_up_deg) + ", and " + two_digits(100.0 * first) + " % "
                    + position_words(field.if_turned.front().left_side_up_deg) + ".");
    }

    void say_opening(const FieldMetrics& field, Sentences& said)
    {
        say(said, Light::clear,
            field.retractor && field.retractor->opening_mm > 0.0
                ? "Opens " + two_digits(field.retractor->opening_mm) + " mm."
                : "Opens " + two_digits(field.opening_width_mm) + " mm wide.");
    }

    void say_force(const FieldMetrics& field, Sentences& said)
    {
        const bool has_moments = field.force_moments && field.force_moments->message.empty();
        const double force = has_moments ? field.force_moments->peak_N : field.hook_force_N;
        if (!(force > 0.0))
            return;
        if (field.retractor && field.retractor->hand_moment_Nm)
            say(said, Light::caution,
                "A hand or an arm at the table must keep the retractor from tilting ("
                    + two_digits(*field.retractor->hand_moment_Nm) + " N m).");
        const ForceInterval interval = force_interval(field);
        std::string text = (has_moments ? "Peak " : "Force ") + two_digits(force) + " N";
        Light light = Light::caution; // how sure the number is, may not be known
        if (interval.is_known()) {
            const double scale = field.hook_force_N > 0.0 ? force / field.hook_force_N : 1.0;
            text += " (" + two_digits(scale * interval.low_N) + " to " + two_digits(scale * interval.high_N) + ")";
            if (interval.high_N - interval.low_N <= 2.0 * kWideInterval * field.hook_force_N)
                light = Light::clear;
        }
        if (has_moments)
            text += ", held " + two_digits(field.force_moments->held_N) + " N after "
                + time_text(field.force_moments->hold_s);
        say(said, light, text + ".");
    }

    void say_bones(const FieldMetrics& field, Sentences& said)
    {
        for (const BoneMetrics& bone : field.bones) {
            const std::string name = capital(bone_in_words(bone.name));
            if (bone.opening_at_limit_mm)
                say(said, Light::injury, name + " would break from " + opening_at_limit_text(bone) + " on.");
            else if (bone.capacity_Nm && bone.utilisation > kNearBreaking)
                say(said, Light::caution, name + " comes near breaking.");
        }
        if (field.bones.empty() && !field.bones_message.empty())
            say(said, Light::caution, "Whether a bone would break is not known.");
    }

    /// A blade that holds only soft tissue pulls with little force, and leaves the bones where they are.
    void say_bearing(const FieldMetrics& field, Sentences& said)
    {
        const bool no_bone_near = field.bones.empty() && field.bones_message.empty();
        if (!field.retractor || no_bone_near)
            return;
        const auto on_soft = [](const HookForce& blade) { return blade.bears_on.empty(); };
        if (field.hooks.size() == 2 && std::ranges::all_of(field.hooks, on_soft))
            say(said, Light::caution, "The blades bear on soft tissue only, on no bone.");
        else
            for (const HookForce& blade : field.hooks)
                if (on_soft(blade))
                    say(said, Light::caution,
                        "The " + readable(blade.name) + " bears on soft tissue only, on no bone.");
    }

    /// The blade goes round a bone that it meets, and what opens the wound pulls at this bone.
    void say_crossed_skeleton(const FieldMetrics& field, Light light, Sentences& said)
    {
        if (!field.crossed_bones.empty())
            say(said, light, crossed_bones_text(field.crossed_bones));
        if (!field.divided_cartilages.empty())
            say(said, light, divided_cartilages_text(field.divided_cartilages));
    }

    void say_tissue(const FieldMetrics& field, Sentences& said)
    {
        for (const TissueStrain& tissue : field.tissue_strain)
            if (may_tear(tissue))
                say(said, would_tear(tissue) ? Light::injury : Light::caution,
                    capital(readable(tissue.tissue)) + (would_tear(tissue) ? " would tear." : " may tear."));
        if (may_rupture(field))
            say(said, Light::caution, std::string(kRuptureSentence));
        if (!piercing_text(field).empty())
            say(said, Light::unknown, "Bone comes through the skin, which the model does not hinder.");
        else if (is_region_too_small(field))
            say(said, Light::caution, "Tissue still moves where the model ends: the force is less certain.");
    }

    void say_risks(const FieldMetrics& field, Sentences& said)
    {
        for (const RiskDistance& risk : field.at_risk)
            if (!(risk.distance_mm > 0.0))
                say(said, risk.is_assumed ? Light::caution : Light::injury,
                    (risk.is_assumed ? "The blade may cut the " : "The blade cuts the ") + risk_name(risk) + ".");
            else if (risk.distance_mm < kTouching)
                say(said, Light::caution, "The cut comes within 2 mm of the " + risk_name(risk) + ".");
        for (const RiskDistance& risk : field.steel_at_risk)
            if (risk.distance_mm < kTouching)
                say(said, Light::caution,
                    "The " + readable(risk.from) + " lies against the " + readable(risk.name) + ".");
        if (std::ranges::find(field.retracted, "mediastinum") != field.retracted.end())
            say(said, Light::caution,
                "The mediastinum is held aside in one piece. Vessels in it without a label are not drawn, and no "
                "distance to them is kept.");
        for (const std::string& estimated : field.estimated)
            if (estimated == field.target_spec.label)
                say(said, Light::caution, "The " + readable(estimated) + " is only estimated.");
    }

} // namespace

std::string_view to_string(Light light)
{
    switch (light) {
    case Light::clear:
        return "clear";
    case Light::caution:
        return "caution";
    case Light::injury:
        return "injury";
    case Light::unknown:
        break;
    }
    return "unknown";
}

std::string why_not_to_use(const FieldMetrics& field)
{
    if (field.mechanics_status != "converged")
        return "The wound could not be computed: do not use these numbers.";
    if (field.inverted_elements > 0 || !is_believable(field))
        return "The model fails near the wound: do not use these numbers.";
    if (field.hook_force_N > kImpossibleForceN)
        return "No retractor pulls with " + two_digits(field.hook_force_N)
            + " N: do not use these numbers. Check what the hooks hold.";
    if (!field.implausible.empty())
        return "The case holds numbers that no patient has: do not use the result.";
    return {};
}

std::string two_digits(double value)
{
    if (!std::isfinite(value) || value == 0.0)
        return in_words(value);
    const int order = static_cast<int>(std::floor(std::log10(std::abs(value))));
    const double step = std::pow(10.0, order - 1);
    const double rounded = std::round(value / step) * step;
    return in_words(rounded, std::abs(rounded) < 10.0 ? std::max(0, 1 - order) : 0);
}

ForceInterval force_interval(const FieldMetrics& field)
{
    const double force = field.hook_force_N;
    const double mesh = field.error && field.error->message.empty() ? field.error->hook_force_N : 0.0;
    double below = mesh, above = mesh;
    if (field.parameters && field.parameters->message.empty()) {
        below = std::hypot(below, std::max(0.0, force - field.parameters->force_low_N));
        above = std::hypot(above, std::max(0.0, field.parameters->force_high_N - force));
    }
    return { std::max(0.0, force - below), force + above };
}

const char* words_of(Light light)
{
    switch (light) {
    case Light::clear:
        return "No objection";
    case Light::caution:
        return "Caution";
    case Light::injury:
        return "Objection";
    case Light::unknown:
        break;
    }
    return "Not usable";
}

namespace {

    Sentences sentences_of(const FieldMetrics& field)
    {
        Sentences said;
        if (const std::string why = why_not_to_use(field); !why.empty()) {
            say(said, Light::unknown, why); // numbers beside this sentence would be used all the same
            say_crossed_skeleton(field, Light::unknown, said);
            say_risks(field, said);
        } else {
            say_bones(field, said);
            say_crossed_skeleton(field, Light::caution, said);
            say_tissue(field, said);
            say_bearing(field, said);
            say_risks(field, said);
            say_sight(field, said);
            say_position(field, said);
            say_opening(field, said);
            say_force(field, said);
        }
        std::ranges::stable_sort(said, is_worse);
        return said;
    }

} // namespace

Verdict verdict_of(const FieldMetrics& field)
{
    Sentences said = sentences_of(field);
    Verdict verdict { .light = said.front().light, .sentences = {} };
    for (Said& each : said)
        verdict.sentences.push_back(std::move(each.sentence));
    return verdict;
}

std::string objections_of(const FieldMetrics& field)
{
    std::string text;
    for (const Said& each : sentences_of(field))
        if (each.light == Light::injury)
            text += (text.empty() ? "" : " ") + each.sentence;
    return text;
}

} // namespace retractor::planner
