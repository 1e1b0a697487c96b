#include "planner/case/opening_protocol.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    constexpr double kRoundOff = 1e-9; ///< of a quotient of two numbers as people type them

    void check_number(double value, double low, double high, const std::string& where)
    {
        if (!(value >= low && value <= high))
            throw InputError(formatted("must be between %g and %g, got %g", low, high, value), where);
    }

} // namespace

void check_opening_protocol(const OpeningProtocol& protocol, const std::string& pointer)
{
    // Wide ranges of instruments and of patience (ours): beyond them the unit is mistaken.
    check_number(protocol.turn_mm, 1.0, 100.0, pointer + "/turn_mm");
    check_number(protocol.turns_per_step, 0.05, 20.0, pointer + "/turns_per_step");
    check_number(protocol.wait_s, 0.0, 3600.0, pointer + "/wait_s");
    check_number(protocol.hold_s, 0.0, 36000.0, pointer + "/hold_s");
}

int step_count(const OpeningProtocol& protocol, double opening_mm)
{
    const double step_mm = protocol.turn_mm * protocol.turns_per_step;
    return std::max(1, static_cast<int>(std::ceil(opening_mm / step_mm * (1.0 - kRoundOff))));
}

double opening_time(const OpeningProtocol& protocol, double opening_mm)
{
    return (step_count(protocol, opening_mm) - 1) * protocol.wait_s;
}

bool is_fast(const OpeningProtocol& protocol)
{
    return protocol.turns_per_step > kFastTurnsPerS * protocol.wait_s * (1.0 + kRoundOff);
}

std::string opening_protocol_text(const OpeningProtocol& protocol)
{
    const double turns = protocol.turns_per_step;
    return (turns == 0.5          ? std::string("half a turn")
                   : turns == 1.0 ? std::string("one turn")
                                  : formatted("%g turns", turns))
        + formatted(" of the crank (%.3g mm) ", turns * protocol.turn_mm)
        + (protocol.wait_s > 0.0 ? "every " + time_text(protocol.wait_s) : std::string("without a wait"));
}

std::string time_text(double seconds)
{
    constexpr double kMinute = 60.0, kLongestInSeconds = 120.0;
    if (seconds < kLongestInSeconds)
        return formatted("%.3g s", seconds);
    return formatted("%.3g minutes", seconds / kMinute);
}

} // namespace retractor::planner
