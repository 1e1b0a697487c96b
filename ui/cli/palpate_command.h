#pragma once
// One palpation, tick by tick: what the command writes, kept so that tests and benches can look at it.

#include "ui/cli/command.h"
#include "ui/cli/palpate_tissue.h"

#include <vector>

namespace retractor::cli {

void add_palpate_command(Commands& commands);

/// What one finger does and feels over time; all of one length.
struct FingerLog {
    std::string site;
    std::vector<double> time, pressure_mmHg, depth, stiffness, hand_force;
    std::vector<Vec3> position, force; ///< of the tissue on the finger, gain included
};

/// One press: its fingers, and the surface when they were deepest.
struct PressLog {
    std::string name;
    std::vector<FingerLog> fingers;
    Points deformed;
    long ticks = 0, late_ticks = 0;
};

} // namespace retractor::cli
