#pragma once
// What can be asked of a live palpation, as plain data: a front end fills a command in and gives it to
// PalpationWorker::run(). A command that cannot be carried out is refused; the next snapshot says why. Units mm; the
// frame is the scene's.

#include "haptics/condensed/elastic_template.h"
#include "planner/session/palpation_session.h"

#include <cstddef>
#include <filesystem>
#include <variant>

namespace retractor::planner {
namespace palpation {

    /// Makes anew what differs: the tissue for another model, the servo for other devices and gains.
    struct ChangeSetup {
        PalpationSetup setup {};
    };
    struct Reset { }; ///< the scene as it was read
    /// Gives the tissue inside a template other values. Refused where nothing lies inside.
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
    struct Rearm { }; ///< the force comes back after a fault
    struct StartRecording { }; ///< refused while a recording is kept that could not be written
    /// Stops the recording and writes it; a recording that cannot be written is kept for the next command of this kind.
    /// Nothing where there is no recording.
    struct StopRecording {
        std::filesystem::path path {};
    };

    using Command
        = std::variant<ChangeSetup, Reset, EditTissue, SetHeartRate, Grip, Rearm, StartRecording, StopRecording>;

} // namespace palpation
} // namespace retractor::planner
