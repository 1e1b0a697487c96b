#pragma once
// Association rules "who has L, has R" (Agrawal, Imielinski, Swami 1993): mining over items of persons.
//
// Of n persons n_L hold all items of the left side, n_R the item of the right side, n_LR both. Then support = n_LR / n,
// confidence = n_LR / n_L, lift = confidence / (n_R / n), and z = (n_LR - E) / sqrt(E (1 - E / n)) with E = n_L n_R / n
// as expected by chance: the published z, which takes both sides for free and is too small where they are common.
// The p-value does not come from it: it is Fisher's exact one, two-sided (all splits of the persons at most as likely
// as the one that was found). Where both sides have more than kExactUpTo persons it is that of the normal distribution
// with the hypergeometric variance. It is adjusted for the number of rules that were tested (Benjamini, Hochberg 1995,
// J R Stat Soc B 57:289), which are those whose two sides have the least support each, whatever their confidence and
// lift.

#include "mesh/base/job.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::planner {

struct Item {
    std::string name;
    bool left = false, right = false; ///< sides of a rule on which the item may stand
    std::vector<std::uint64_t> holders; ///< one bit for each person, 64 to a word
};

struct ItemTable {
    std::size_t persons = 0;
    std::vector<Item> items; ///< each with words_for(persons) words
};

std::size_t words_for(std::size_t persons);

struct RuleThresholds {
    double support = 0.013, confidence = 0.5, lift = 1.2; ///< the least of each
    int most_left = 1; ///< largest number of items on the left side
};

struct AssociationRule {
    std::vector<std::size_t> left; ///< indices of items, ascending
    std::size_t right = 0;
    std::size_t n_left = 0, n_right = 0, n_both = 0;
    double left_support = 0.0, right_support = 0.0, support = 0.0, confidence = 0.0, lift = 0.0, z = 0.0;
    double p = 1.0, p_adjusted = 1.0;
};

struct FoundRules {
    std::vector<AssociationRule> rules; ///< the largest lift first
    std::size_t tested = 0; ///< rules to whose number p_adjusted is adjusted
};

/// Rules that reach all thresholds. Left sides that fewer persons hold than the least support needs are not extended,
/// since no larger side can have more.
/// @throws InputError on thresholds out of range, no person, and more than 50 million rules to test. The job's
/// cancellation gives what was found so far.
FoundRules find_rules(const ItemTable& table, const RuleThresholds& thresholds, const Job& job = {});

/// Sides with more persons have the approximate p-value.
inline constexpr std::size_t kExactUpTo = 5000;

/// The two-sided p-value of n_both persons with both sides, see above. @pre n_both <= n_left, n_right <= persons
double p_of_both(std::size_t persons, std::size_t n_left, std::size_t n_right, std::size_t n_both);

/// The adjusted p-values of all tests, in their order (Benjamini, Hochberg 1995).
std::vector<double> adjusted_p_values(const std::vector<double>& p);

} // namespace retractor::planner
