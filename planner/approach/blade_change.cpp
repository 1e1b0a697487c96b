#include "planner/approach/blade_change.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/blade_sweep.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

namespace retractor::planner {

Approach with_blade(Patient& patient, const Approach& approach, double depth_mm, const Vec3& inward)
{
    constexpr double kLeastMm = 5.0, kMostMm = 250.0;
    constexpr std::string_view kBladeWords = "Blade set by hand: ";
    if (!(depth_mm >= kLeastMm && depth_mm <= kMostMm))
        throw InputError("the blade goes 5 to 250 mm deep, not " + in_words(depth_mm) + " mm", "", { "depth_mm" });
    if (!inward.allFinite() || !(inward.norm() > 0.0))
        throw InputError("the direction of the blade is no direction", "", { "directions" });
    const IncisionPlace middle = incision_place(approach, 0.5 * incision_length(approach));
    const Eigen::Quaterniond turn
        = Eigen::Quaterniond::FromTwoVectors(middle.of(approach.directions).normalized(), inward.normalized());
    const double turned_deg = Eigen::AngleAxisd(turn).angle() * 180.0 / std::numbers::pi;
    if (turned_deg > kMostTurnedDeg)
        throw InputError("the blade would be turned by " + in_words(turned_deg) + " degrees; 60 are possible at most",
            "", { "directions" });
    Approach placed = approach;
    placed.depth_mm = depth_mm;
    for (Vec3& direction : placed.directions)
        direction = turn * direction;
    check_sweep(placed);
    const BodyProbe probe(*patient.labels());
    for (std::size_t n = 0; n < placed.wall_thickness_mm.size(); ++n)
        placed.wall_thickness_mm[n]
            = std::min(depth_mm, probe.wall_thickness(placed.incision[n], placed.directions[n]).value_or(depth_mm));
    // What the rationale says of the depth before goes.
    constexpr std::string_view kTemplateWords = "; the blade goes ", kTemplateEnd = " mm deep";
    if (const std::size_t at = placed.rationale.find(kTemplateWords); at != std::string::npos)
        if (const std::size_t end = placed.rationale.find(kTemplateEnd, at); end != std::string::npos)
            placed.rationale.erase(at, end + kTemplateEnd.size() - at);
    const std::size_t before = placed.rationale.find(kBladeWords);
    if (before != std::string::npos) // of an earlier change
        placed.rationale.erase(before);
    placed.rationale += (placed.rationale.empty() || placed.rationale.ends_with(' ') ? "" : " ")
        + std::string(kBladeWords) + in_words(depth_mm) + " mm deep.";
    return with_incision_of(approach, placed);
}

} // namespace retractor::planner
