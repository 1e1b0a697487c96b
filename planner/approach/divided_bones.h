#pragma once
// The bones that an approach saws through. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/case/approach.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// Labels of the wall's bones through which the blade of the approach goes over at least `least_mm2`, in the order of
/// the table. Bones that the blade does not sever are left out.
std::vector<std::string> divided_bones(
    const mesh::LabelVolume& labels, const Approach& approach, double least_mm2 = 20.0);

} // namespace retractor::planner
