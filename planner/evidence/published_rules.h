#pragma once
// The rules that ship with the program (planner/evidence/rules/).

#include <span>
#include <string_view>

namespace retractor::planner {

struct PublishedRule {
    std::string_view name; ///< "shock-accounting"
    std::string_view sql;
};

std::span<const PublishedRule> published_rules();

} // namespace retractor::planner
