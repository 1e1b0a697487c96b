#pragma once
// Intercostal muscle of the spaces that close while another space is opened. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/anatomy/anatomy.h"
#include "planner/approach/intercostal_space.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <cstddef>
#include <string>
#include <vector>

namespace retractor::planner {

/// The intercostal spaces that the blade of the approach and the strokes of its division open: those in which lies at
/// least a tenth of the intercostal muscle that they cut. Empty where the incision lies over such muscle for less than
/// a third of its length, where it opens more than two spaces, because it then runs across ribs, and where it saws the
/// sternum.
std::vector<SpaceNumber> opened_spaces(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const Approach& approach);

/// Gives intercostal muscle the label of muscle in all spaces of the opened side but the opened ones. The ribs beside
/// an opened space move towards their neighbours, so that the muscle of the other spaces becomes shorter. Relaxed
/// intercostal muscle has a passive tension only where it is longer than at rest (Farkas, Decramer, Rochester, De
/// Troyer 1985, J Appl Physiol 59:528, dogs). Shortened, it bears as muscle does across its fibres.
/// @param wall after the cut: a blade that divides intercostal muscle must still find it
/// @param opened empty: no label changes
/// @return the number of elements with a new label; 0 where the table has no muscle
std::size_t slacken_other_spaces(
    mesh::TetMesh& wall, const mesh::LabelTable& table, const Anatomy& anatomy, const std::vector<SpaceNumber>& opened);

/// The same for the wall of a plan. No label changes where no hook or blade bears on bone, where the landmarks of the
/// chest are not found, and where the case's muscle is stiffer than its intercostal muscle.
/// @param approach with the bones on which its hooks bear
/// @return what was done, for people; empty: nothing
std::string slacken_other_spaces(mesh::TetMesh& wall, Patient& patient, const Approach& approach);

} // namespace retractor::planner
