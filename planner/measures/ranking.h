#pragma once
// Ranks planned fields by a score that weighs what is seen against what it costs, lists the fields that no other field
// beats in everything, and names what must be thought of first. Units as stored: mm, mm2, N; fractions 0 to 1.
//
// Each criterion gives a field a share between 0 (its worst value) and 1 (its best). Both values are fixed, so that the
// order of two fields does not hang on a third. The score is the weighted mean of the shares, in points of 100, less
// what exposure_factor() takes. Weights and values are ours, and the weights are the user's to change; no score of
// planned incisions is published.

#include "planner/measures/field_metrics.h"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// A planned field that is ranked.
struct Candidate {
    FieldMetrics field;
    std::vector<std::string> divided_bones; ///< labels of bones that the blade saws through
};

struct Criterion {
    const char* key; ///< in JSON and in options
    const char* caption; ///< for people
    const char* meaning; ///< in one sentence
    double worst = 0.0, best = 1.0; ///< values with the shares 0 and 1
    double weight = 1.0; ///< unless the user gives another
    bool exposure = false; ///< what is gained; else what it costs
    double (*value)(const Candidate&) = nullptr;
    double (*bar)(const Candidate&) = nullptr; ///< error bar of the value; 0 where it has none of its own
};

inline constexpr std::size_t kCriteria = 7;
std::span<const Criterion, kCriteria> criteria();

using Weights = std::array<double, kCriteria>;
Weights default_weights();
/// "seen 3, instruments 2".
std::string weights_text(const Weights& weights);

/// Share of a value between the worst (0) and the best (1).
double share_of(const Criterion& criterion, double value);

/// Seeing less of the target than this does not suffice to work by, whatever is spared.
inline constexpr double kEnoughSeen = 0.25;
/// What a score is multiplied by: 1 where kEnoughSeen of the target is seen, and in proportion to what is seen below.
double exposure_factor(double seen);

struct Score {
    double points = 0.0; ///< 0 to 100
    std::optional<double> bar {}; ///< the criteria's error bars, added; not set: the field has none (has_error_bars())
    std::array<double, kCriteria> shares {};
    double factor = 1.0; ///< by which the points were multiplied; 1 where what is seen has no weight
};
/// @pre the weights are finite and at least 0, and one is above 0
Score score_of(const Candidate& candidate, const Weights& weights);

enum class CriterionKind { exposure, cost };
/// The weighted mean of the shares of one kind; 0 where none of them has a weight.
double mean_share(const Score& score, const Weights& weights, CriterionKind kind);

struct RankedField {
    std::size_t index = 0; ///< of the candidate
    Score score;
    bool within_error = false; ///< the field before it leads by no more than both bars, or a bar is not known
    /// A field that is at least as good by every criterion with a weight, and better by one.
    std::optional<std::size_t> dominated_by {};
};

/// The fields that were solved (is_solved()), the highest score first.
/// @pre as score_of(); all fields have one target
std::vector<RankedField> ranked(std::span<const Candidate> candidates, const Weights& weights);

/// Structures nearer to a blade than this are named by crisis_check(), mm.
inline constexpr double kCrisisMm = 10.0;

/// What must be thought of before the score, one sentence each: structures at risk that are near, bones that are sawn
/// through or removed, injury that the plan foretells (of plans that can be used), and organs that are only held aside.
std::vector<std::string> crisis_check(const Candidate& candidate);
/// The sentences after each other, or "Nothing found."
std::string crisis_text(const Candidate& candidate);

} // namespace retractor::planner
