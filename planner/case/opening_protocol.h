#pragma once
// How fast a wound is opened: the turns of a retractor's crank, with a wait after each step, and the hold at the end.
// Plain data, written to and read from case.json. Units mm, s.

#include <string>

namespace retractor::planner {

/// Steps of the crank. The opening is divided into equal steps, none longer than `turns_per_step`; a step itself takes
/// no time.
struct OpeningProtocol {
    /// Opening per whole turn. A half turn of a Finochietto spreader moves a blade by one tooth of the rack, 5 to 9 mm
    /// (Chanoit 2019, BioMed Eng OnLine 18:45, doi 10.1186/s12938-019-0664-z, Fig. 2); the middle value is ours.
    double turn_mm = 14.0;
    /// The crank locks after each half turn (Chanoit 2019, Fig. 2).
    double turns_per_step = 0.5;
    /// From one step to the next. Half a turn in 10 s is the speed beyond which nearly all retractions ruptured tissue
    /// (Chanoit 2019); that surgeons open at this speed is ours.
    double wait_s = 10.0;
    double hold_s = 300.0; ///< from the last turn to the moment of the held force (ours)

    bool operator==(const OpeningProtocol&) const = default;
};

/// Speed of the crank beyond which nearly all retractions ruptured tissue (Chanoit 2019), turns per second.
inline constexpr double kFastTurnsPerS = 0.5 / 10.0;

/// @param pointer JSON pointer of the protocol, put before the failing key in InputError::where()
/// @throws InputError on NaN and values out of range
void check_opening_protocol(const OpeningProtocol& protocol, const std::string& pointer);

/// Number of steps to this opening; at least one. @pre check_opening_protocol() accepts the protocol
int step_count(const OpeningProtocol& protocol, double opening_mm);

/// Time from the first step to the last one, s. @pre check_opening_protocol() accepts the protocol
double opening_time(const OpeningProtocol& protocol, double opening_mm);

/// Whether the crank turns faster than half a turn in 10 s.
bool is_fast(const OpeningProtocol& protocol);

/// "half a turn of the crank (7 mm) every 10 s".
std::string opening_protocol_text(const OpeningProtocol& protocol);

/// "10 s", "5 minutes", "7.5 minutes": a time for people.
std::string time_text(double seconds);

} // namespace retractor::planner
