#pragma once
// What this machine can do, one finding a line. Everything is tried out or measured here and now.

#include "ui/cli/framework/command.h"

#include <string>
#include <vector>

namespace retractor::ui::cli {

enum class Health {
    ok,
    warning, ///< the main job runs, something is slower or left out
    missing, ///< not there, or not working
};
std::string to_string(Health health);

struct Finding {
    std::string topic; ///< "machine", "solver", "images", "drawing", "window", "reference", "devices"
    std::string name;
    Health health = Health::ok;
    std::string found = {}; ///< what was seen or measured
    std::string advice = {}; ///< what to do; empty when nothing needs doing
    bool essential = false; ///< without it the main job (import, plan, render) cannot run
};

/// Cores, memory, instruction sets, room for temporary files.
std::vector<Finding> check_machine();
/// BLAS and sparse factorisation.
std::vector<Finding> check_linear_algebra();
/// Formats and transfer syntaxes.
std::vector<Finding> check_images();
/// A picture by this program's own kind of context.
Finding check_own_drawing();
/// The programs beside this one: the other kind of context, the window.
std::vector<Finding> check_other_drawing();
std::vector<Finding> check_window();
/// Programs that give a second opinion.
std::vector<Finding> check_references();
/// Libraries of haptic devices.
std::vector<Finding> check_devices();

} // namespace retractor::ui::cli
