#pragma once
// Commands of a live palpation, as plain data. A front end fills a command in and gives it to PalpationWorker::run(). A
// command that cannot run is refused, and the next snapshot gives the reason. Units mm; frame: the scene's.

#include "haptics/condensed/elastic_template.h"
#include "planner/session/palpation_session.h"

#include <cstddef>
#include <filesystem>
#include <variant>

namespace retractor::planner {
namespace palpation {

    /// Rebuilds the parts that differ: the tissue for another model, the servo for other devices and gains.
    struct ChangeSetup {
        PalpationSetup setup {};
    };
    struct Reset { }; ///< restores the scene as it was read
    /// Gives the tissue inside a template other values. Refused when nothing lies inside.
    struct EditTissue {
        haptics::ElasticTemplate edit {};
    };
    struct SetHeartRate {
        double per_min = 60.0;
    };
    struct Grip {
        std::size_t finger = 0;
        bool held = false;
    };
    struct Rearm { }; ///< lets the force return after a fault
    struct StartRecording { }; ///< refused while an unwritten recording is kept
    /// Stops the recording and writes it. A recording that cannot be written is kept for the next StopRecording. Does
    /// nothing without a recording.
    struct StopRecording {
        std::filesystem::path path {};
    };

    using Command
        = std::variant<ChangeSetup, Reset, EditTissue, SetHeartRate, Grip, Rearm, StartRecording, StopRecording>;

} // namespace palpation
} // namespace retractor::planner
