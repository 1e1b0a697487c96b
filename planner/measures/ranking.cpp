#include "planner/measures/ranking.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/comparison.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/rupture.h"
#include "planner/measures/verdict.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kLargestAngleDeg = 60.0;

    double bar_of(const char* key, const Candidate& candidate)
    {
        return error_bar(metric_field(key), candidate.field).value_or(0.0);
    }

    double bone_load(const Candidate& candidate)
    {
        const FieldMetrics& field = candidate.field;
        const bool removed = std::ranges::any_of(
            field.removed, [](const RemovedTissue& tissue) { return is_long_bone(tissue.label); });
        double load = candidate.divided_bones.empty() && !removed ? 0.0 : 1.0;
        for (const BoneMetrics& bone : field.bones)
            load = std::max(load, std::min(bone.utilisation, 1.0));
        return load;
    }

    /// All or nothing where the loads were not computed.
    double bone_bar(const Candidate& candidate)
    {
        return candidate.field.bones.empty() && !candidate.field.bones_message.empty() ? 1.0 : 0.0;
    }

    /// Where nothing is seen there is no line of sight, straight or not.
    double angle_off_the_straight_view(const Candidate& candidate)
    {
        return candidate.field.seen_best_eye > 0.0 ? candidate.field.coaxiality_deg : kLargestAngleDeg;
    }

    double nearest_risk(const Candidate& candidate)
    {
        double nearest = kFarthestRiskMm;
        for (const auto* risks : { &candidate.field.at_risk, &candidate.field.steel_at_risk })
            for (const RiskDistance& risk : *risks)
                if (!risk.is_assumed)
                    nearest = std::min(nearest, risk.distance_mm);
        return nearest;
    }

    double peak_force(const Candidate& candidate)
    {
        const FieldMetrics& field = candidate.field;
        return field.force_moments && field.force_moments->message.empty() ? field.force_moments->peak_N
                                                                           : field.hook_force_N;
    }

    /// The bar is that of the force in the plan, and grows with it to the force at the last turn.
    double peak_force_bar(const Candidate& candidate)
    {
        const double force = candidate.field.hook_force_N;
        return force > 0.0 ? bar_of("hook_force_N", candidate) * peak_force(candidate) / force : 0.0;
    }

    constexpr auto kNoBar = [](const Candidate&) { return 0.0; };

    constexpr std::array<Criterion, kCriteria> kAllCriteria { {
        { .key = "seen",
            .caption = "target seen",
            .meaning
            = "share of the target that the best eye sees, 0 to 100 %; below 25 % the whole score falls with it",
            .weight = 3.0,
            .exposure = true,
            .value = [](const Candidate& one) { return one.field.seen_best_eye; },
            .bar = [](const Candidate& one) { return bar_of("seen_best_eye", one); } },
        { .key = "instruments",
            .caption = "reached by instruments",
            .meaning = "share that is seen and reached by two instruments, 0 to 100 %",
            .weight = 2.0,
            .exposure = true,
            .value = [](const Candidate& one) { return one.field.reached_by_two_instruments; },
            .bar = [](const Candidate& one) { return bar_of("reached_by_two_instruments", one); } },
        { .key = "angle",
            .caption = "straight view",
            .meaning = "angle between the best line of sight and the straight view into the opening, 60 to 0 degrees",
            .worst = kLargestAngleDeg,
            .best = 0.0,
            .exposure = true,
            .value = angle_off_the_straight_view,
            .bar = kNoBar },
        { .key = "incision",
            .caption = "short incision",
            .meaning = "length of the incision, 300 to 30 mm",
            .worst = 300.0,
            .best = 30.0,
            .value = [](const Candidate& one) { return one.field.incision_length_mm; },
            .bar = kNoBar },
        { .key = "bone",
            .caption = "bone spared",
            .meaning
            = "a bone that is sawn through, removed or breaks counts 1, else the largest share of what a bone bears: "
              "1 to 0",
            .worst = 1.0,
            .best = 0.0,
            .weight = 2.0,
            .value = bone_load,
            .bar = bone_bar },
        { .key = "risk",
            .caption = "structures far",
            .meaning = "distance of the nearest structure at risk from the blades, 0 to 20 mm",
            .worst = 0.0,
            .best = 20.0,
            .weight = 2.0,
            .value = nearest_risk,
            .bar = kNoBar },
        { .key = "force",
            .caption = "low force",
            .meaning = "force at the last turn, from twice the smallest force at which tissue ruptured (122.5 N) to 0",
            .worst = 2.0 * kRuptureForceN,
            .best = 0.0,
            .value = peak_force,
            .bar = peak_force_bar },
    } };

    bool dominates(const Score& one, const Score& other, const Weights& weights)
    {
        bool better = false;
        for (std::size_t n = 0; n < kCriteria; ++n) {
            if (!(weights[n] > 0.0))
                continue;
            if (one.shares[n] < other.shares[n])
                return false;
            better = better || one.shares[n] > other.shares[n];
        }
        return better;
    }

    std::string risk_sentence(const RiskDistance& risk)
    {
        constexpr double kTouchingMm = 2.0; // about a voxel, to which the distance is known
        const std::string structure = "The " + risk_name(risk);
        if (risk.from.empty() && !(risk.distance_mm > 0.0))
            return structure + (risk.is_assumed ? " may be cut." : " is cut.");
        if (!risk.from.empty() && risk.distance_mm < kTouchingMm)
            return structure + " lies against the " + readable(risk.from) + ".";
        return structure + " lies " + two_digits(risk.distance_mm) + " mm from the "
            + (risk.from.empty() ? "blade that cuts" : readable(risk.from)) + ".";
    }

    /// What a plan that can be used foretells.
    void add_injuries(const FieldMetrics& field, std::vector<std::string>& sentences)
    {
        for (const BoneMetrics& bone : field.bones)
            if (bone.opening_at_limit_mm)
                sentences.push_back(
                    capital(bone_in_words(bone.name)) + " would break from " + opening_at_limit_text(bone) + " on.");
        for (const TissueStrain& tissue : field.tissue_strain)
            if (may_tear(tissue))
                sentences.push_back(
                    "The " + readable(tissue.tissue) + (would_tear(tissue) ? " would tear." : " may tear."));
        if (may_rupture(field))
            sentences.emplace_back(kRuptureSentence);
    }

} // namespace

std::span<const Criterion, kCriteria> criteria() { return kAllCriteria; }

std::string weights_text(const Weights& weights)
{
    std::string text;
    for (std::size_t n = 0; n < kCriteria; ++n)
        text += (text.empty() ? "" : ", ") + std::string(criteria()[n].key) + " " + formatted("%g", weights[n]);
    return text;
}

Weights default_weights()
{
    Weights weights {};
    std::transform(kAllCriteria.begin(), kAllCriteria.end(), weights.begin(),
        [](const Criterion& criterion) { return criterion.weight; });
    return weights;
}

double share_of(const Criterion& criterion, double value)
{
    // Adding zero makes no share "-0".
    return std::clamp((value - criterion.worst) / (criterion.best - criterion.worst), 0.0, 1.0) + 0.0;
}

double exposure_factor(double seen) { return std::clamp(seen / kEnoughSeen, 0.0, 1.0); }

Score score_of(const Candidate& candidate, const Weights& weights)
{
    Score score;
    double sum = 0.0, bars = 0.0;
    for (std::size_t n = 0; n < kCriteria; ++n) {
        RETRACTOR_ASSERT(std::isfinite(weights[n]) && weights[n] >= 0.0);
        const Criterion& criterion = kAllCriteria[n];
        const double value = criterion.value(candidate), bar = criterion.bar(candidate);
        score.shares[n] = share_of(criterion, value);
        // A value beyond its worst or best counts as these; what its bar leaves of the share is its error.
        const double error = std::max(std::abs(share_of(criterion, value + bar) - score.shares[n]),
            std::abs(share_of(criterion, value - bar) - score.shares[n]));
        score.points += 100.0 * weights[n] * score.shares[n];
        bars += 100.0 * weights[n] * error;
        sum += weights[n];
    }
    RETRACTOR_ASSERT(sum > 0.0);
    const Criterion& seen = kAllCriteria.front();
    const double value = seen.value(candidate), bar = seen.bar(candidate);
    const auto factor_at = [&](double share) { return weights.front() > 0.0 ? exposure_factor(share) : 1.0; };
    score.factor = factor_at(value);
    const double factor_error = std::max(factor_at(value + bar) - score.factor, score.factor - factor_at(value - bar));
    const double mean = score.points / sum;
    score.points = score.factor * mean;
    if (has_error_bars(candidate.field))
        score.bar = score.factor * bars / sum + factor_error * mean;
    return score;
}

double mean_share(const Score& score, const Weights& weights, CriterionKind kind)
{
    double sum = 0.0, of_shares = 0.0;
    for (std::size_t n = 0; n < kCriteria; ++n)
        if (kAllCriteria[n].exposure == (kind == CriterionKind::exposure)) {
            sum += weights[n];
            of_shares += weights[n] * score.shares[n];
        }
    return sum > 0.0 ? of_shares / sum : 0.0;
}

std::vector<RankedField> ranked(std::span<const Candidate> candidates, const Weights& weights)
{
    std::vector<RankedField> order;
    for (std::size_t n = 0; n < candidates.size(); ++n)
        if (is_solved(candidates[n].field))
            order.push_back({ .index = n, .score = score_of(candidates[n], weights) });
    std::stable_sort(order.begin(), order.end(),
        [](const RankedField& a, const RankedField& b) { return a.score.points > b.score.points; });
    for (std::size_t n = 0; n < order.size(); ++n) {
        if (n > 0) {
            const Score &above = order[n - 1].score, &own = order[n].score;
            order[n].within_error = !above.bar || !own.bar || above.points - own.points <= *above.bar + *own.bar;
        }
        for (const RankedField& other : order)
            if (dominates(other.score, order[n].score, weights)) {
                order[n].dominated_by = other.index;
                break;
            }
    }
    return order;
}

std::vector<std::string> crisis_check(const Candidate& candidate)
{
    const FieldMetrics& field = candidate.field;
    std::vector<std::string> sentences;
    std::vector<RiskDistance> risks = field.at_risk;
    risks.insert(risks.end(), field.steel_at_risk.begin(), field.steel_at_risk.end());
    for (const RiskDistance& risk : nearest_risks(std::move(risks)))
        if (risk.distance_mm <= kCrisisMm)
            sentences.push_back(risk_sentence(risk));
    for (const std::string& bone : candidate.divided_bones)
        sentences.push_back(capital(bone_in_words(bone)) + " is sawn through.");
    for (const RemovedTissue& tissue : field.removed)
        if (is_long_bone(tissue.label))
            sentences.push_back(capital(bone_in_words(tissue.label)) + " is removed in part.");
    if (is_solved(field))
        add_injuries(field, sentences);
    if (!field.retracted.empty()) {
        std::vector<std::string> organs;
        std::transform(field.retracted.begin(), field.retracted.end(), std::back_inserter(organs), readable);
        sentences.push_back("Held aside for this view: " + joined(organs) + ".");
    }
    return sentences;
}

std::string crisis_text(const Candidate& candidate)
{
    std::string text;
    for (const std::string& sentence : crisis_check(candidate))
        text += (text.empty() ? "" : " ") + sentence;
    return text.empty() ? "Nothing found." : text;
}

} // namespace retractor::planner
