#pragma once
// Checks the capabilities of this machine, one finding a line. Every check tries or measures something.

#include "ui/cli/framework/command.h"

#include <string>
#include <vector>

namespace retractor::ui::cli {

enum class Health {
    ok,
    warning, ///< the main job runs, but something is slower or missing
    missing, ///< not installed, or not working
};
std::string to_string(Health health);

struct Finding {
    std::string topic; ///< "machine", "solver", "images", "drawing", "window", "reference", "devices"
    std::string name;
    Health health = Health::ok;
    std::string found = {}; ///< observation or measurement
    std::string advice = {}; ///< remedy; empty when nothing needs doing
    bool essential = false; ///< the main job (import, plan, render) cannot run without this
};

/// Cores, memory, instruction sets, space for temporary files.
std::vector<Finding> check_machine();
/// BLAS and sparse factorisation.
std::vector<Finding> check_linear_algebra();
/// Image formats and transfer syntaxes.
std::vector<Finding> check_images();
/// Draws a picture with the kind of OpenGL context that this program uses.
Finding check_own_drawing();
/// The programs beside this one: the other kind of OpenGL context, and the window.
std::vector<Finding> check_other_drawing();
std::vector<Finding> check_window();
/// Programs for a second opinion.
std::vector<Finding> check_references();
/// Libraries of haptic devices.
std::vector<Finding> check_devices();

} // namespace retractor::ui::cli
