#pragma once
// A plot of association rules as SVG: support across, confidence up, lift by the size of the mark.

#include "planner/evidence/association_rules.h"

#include <string>
#include <vector>

namespace retractor::ui::cli {

/// The plot; marks have the numbers of the rules in the list, from 1.
std::string rule_plot_svg(
    const std::vector<planner::AssociationRule>& rules, const planner::RuleThresholds& thresholds);

} // namespace retractor::ui::cli
