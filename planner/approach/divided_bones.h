#pragma once
// The bones and cartilages under an incision: what a saw or knife divides, and what stays whole in its way. Units mm;
// frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/case/approach.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Labels of the wall's bones through which the blade of the approach goes over at least `least_mm2`, in the order of
/// the table. Bones that the blade does not sever are left out.
std::vector<std::string> divided_bones(
    const mesh::LabelVolume& labels, const Approach& approach, double least_mm2 = 20.0);

/// Labels of the wall's bones that the blade crosses over at least `least_mm2` and leaves whole, in the order of the
/// table. A retractor in such an incision pulls at whole bones. A bone is crossed, not grazed, where the blade still
/// meets it when moved 3 mm to either side. The section of a rib has some 80 mm2.
std::vector<std::string> crossed_bones(
    const mesh::LabelVolume& labels, const Approach& approach, double least_mm2 = 50.0);

/// "The incision crosses bone that stays whole: rib 4 on the left, rib 5 on the left." Empty without bones.
std::string crossed_bones_text(std::span<const std::string> bones);

/// Labels of the wall's cartilages that the blade crosses and severs, as crossed_bones().
std::vector<std::string> divided_cartilages(
    const mesh::LabelVolume& labels, const Approach& approach, double least_mm2 = 50.0);

/// "The incision divides cartilage: costal cartilages." Empty without cartilages.
std::string divided_cartilages_text(std::span<const std::string> cartilages);

/// Puts bones in the way and divided cartilages first in the rationale. Returns what was put there.
std::string name_crossed_skeleton(Approach& approach, const mesh::LabelVolume& labels);

} // namespace retractor::planner
