#pragma once
// Pictures of proposed ports: the patient from outside with scope and instruments, and what the scope shows. Units mm;
// frame patient LPS.

#include "planner/case/patient.h"
#include "planner/ports/port_search.h"
#include "ui/scene/scene.h"

namespace retractor::ui {

/// A proposal: on the left the patient with the skin clear, on the right the picture of the scope.
/// @throws InputError, IoError as Patient does
Picture port_picture(planner::Patient& patient, const planner::PortRequest& request, const planner::PortPlan& plan,
    int width, int height);

} // namespace retractor::ui
