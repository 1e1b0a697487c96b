#include "mesh/cutting/stroke/cut_retry.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>
#include <utility>

namespace retractor::mesh {

CutQualityError::CutQualityError(Kind kind, const std::string& what, std::string where)
    : SolverError(what, std::move(where))
    , kind_(kind)
{
}

StrokeSettings settings_of_retry(const StrokeSettings& settings, CutQualityError::Kind kind)
{
    RETRACTOR_ASSERT(kind != CutQualityError::Kind::growth);
    RETRACTOR_ASSERT(settings.attempt >= 1 && settings.attempt < kMostAttempts);
    StrokeSettings next = settings;
    ++next.attempt;
    if (kind == CutQualityError::Kind::shape) {
        next.snap *= next.attempt < kMostAttempts ? 0.6 : 0.0;
        next.on_blade = std::min(kMostOnBlade, 2.0 * settings.on_blade);
    } else {
        struct Setting {
            double crease_deg, chord;
            bool past_ends;
        };
        constexpr std::array<Setting, 5> kSettings { { { 8.0, 0.0, false }, { 3.0, 0.06, false }, { 3.0, 0.04, true },
            { 3.0, 0.025, false }, { 0.0, 0.0, false } } }; // the last one follows twists too
        const Setting& setting = kSettings[static_cast<std::size_t>(std::clamp(settings.attempt - 1, 0, 4))];
        next.crease_deg = std::min(settings.crease_deg, setting.crease_deg);
        next.chord = setting.chord;
        next.past_ends = setting.past_ends;
        next.border *= 0.5;
        if (next.attempt == kMostAttempts - 1)
            next.snap *= 0.5;
    }
    return next;
}

double largest_blade_deviation(const StrokeSettings& settings)
{
    return settings.attempt < kMostAttempts ? 0.09 : 0.098;
}

std::string quality_message(const std::string& would, double most, const std::string& how)
{
    std::ostringstream text;
    text << "the wound would " << would << " more than " << most << " local edges " << how << " the blade";
    return text.str();
}

CutQualityError final_error(const CutQualityError& broken, int attempts)
{
    if (broken.kind() == CutQualityError::Kind::growth)
        return broken;
    const std::string tried = attempts > 1
        ? "; " + std::to_string(attempts) + " attempts were made, with less snapping or more bends followed"
        : std::string {};
    return { broken.kind(), broken.what() + tried + "; try another blade", broken.where() };
}

} // namespace retractor::mesh
