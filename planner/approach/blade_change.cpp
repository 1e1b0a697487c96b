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
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kLeastMm = 5.0, kMostMm = 250.0; ///< depth of a blade
    constexpr std::string_view kByHand = " Blade set by hand:";

    /// The rationale with the new depth in place of what it says of the one before.
    std::string rationale_with_blade(std::string rationale, double depth_mm)
    {
        if (const std::size_t at = rationale.find(kBladeGoes); at != std::string::npos)
            if (const std::size_t end = rationale.find(kDeep, at); end != std::string::npos)
                rationale.erase(at, end + kDeep.size() - at);
        rationale.erase(std::min(rationale.find(kByHand), rationale.size())); // of an earlier change
        return rationale + std::string(kByHand) + " " + in_words(depth_mm) + std::string(kDeep) + ".";
    }

    double angle_deg(const Vec3& a, const Vec3& b)
    {
        return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    }

} // namespace

Approach with_blade(Patient& patient, const Approach& approach, double depth_mm, const Vec3& inward)
{
    if (!(depth_mm >= kLeastMm && depth_mm <= kMostMm))
        throw InputError("the blade goes " + in_words(kLeastMm) + " to " + in_words(kMostMm) + " mm deep, not "
                + in_words(depth_mm) + " mm",
            "", { "depth_mm" });
    if (!inward.allFinite() || !(inward.norm() > 0.0))
        throw InputError("the direction of the blade is no direction", "", { "directions" });
    const BodyProbe probe(*patient.labels());
    const IncisionPlace middle = incision_place(approach, 0.5 * incision_length(approach));
    const double tilt_deg = angle_deg(inward, -probe.skin_normal(middle.of(approach.incision)));
    if (tilt_deg > kMostTiltedDeg)
        throw InputError("the blade would be tilted by " + in_words(tilt_deg) + " degrees against the skin; "
                + in_words(kMostTiltedDeg) + " are possible at most",
            "", { "directions" });
    const Eigen::Quaterniond turn
        = Eigen::Quaterniond::FromTwoVectors(middle.of(approach.directions).normalized(), inward.normalized());
    Approach placed = approach;
    placed.depth_mm = depth_mm;
    for (Vec3& direction : placed.directions)
        direction = turn * direction;
    check_sweep(placed);
    for (std::size_t n = 0; n < placed.wall_thickness_mm.size(); ++n)
        placed.wall_thickness_mm[n]
            = std::min(depth_mm, probe.wall_thickness(placed.incision[n], placed.directions[n]).value_or(depth_mm));
    placed.rationale = rationale_with_blade(std::move(placed.rationale), depth_mm);
    return with_incision_of(approach, placed);
}

} // namespace retractor::planner
