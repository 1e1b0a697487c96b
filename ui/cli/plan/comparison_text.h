#pragma once
// The comparison of planned fields as `retractor compare` prints it: verdicts, crisis check, numbers and ranking.

#include "planner/measures/ranking.h"
#include "ui/cli/framework/command.h"

#include <string>
#include <vector>

namespace retractor::ui::cli {

/// A planned field with its name for people.
struct ComparedField {
    planner::Candidate candidate;
    std::string name;
};

enum class Marks {
    leader, ///< a star at the field that is better than every other
    against_first, ///< plus and minus at fields that are better and worse than the first
};

/// The comparison as text, under the letters "A", "B".
std::string comparison_text(const std::vector<ComparedField>& fields, const planner::Weights& weights, Marks marks);

/// The same as a document: approaches, crisis check, measures and ranking.
Json comparison_document(const std::vector<ComparedField>& fields, const planner::Weights& weights);

/// Weights with the changes "seen=3". @throws InputError on an unknown criterion, a negative or no finite number, and
/// where no weight is left
planner::Weights parse_weights(const std::vector<std::string>& changes);

} // namespace retractor::ui::cli
