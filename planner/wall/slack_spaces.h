#pragma once
// Intercostal muscle of the spaces that close while another space is opened. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/anatomy/anatomy.h"
#include "planner/approach/intercostal_space.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <cstddef>
#include <vector>

namespace retractor::planner {

/// The intercostal spaces that the blade of the approach and the strokes of its division pass: those with at least a
/// tenth of what they cut of intercostal muscle. Empty where the incision lies over such muscle for less than a third
/// of its length, as one along the sternum.
std::vector<SpaceNumber> opened_spaces(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const Approach& approach);

/// Gives intercostal muscle the label of muscle in all spaces of the opened side but the opened ones. The ribs beside
/// an opened space move towards their neighbours. The muscle between these becomes shorter than at rest, where it bears
/// no tension: intercostal muscle has its length of greatest force when the patient lies relaxed, and passive tension
/// beyond it only (Farkas, Decramer, Rochester, De Troyer 1985, J Appl Physiol 59:528, dogs). What then bears is muscle
/// across its fibres.
/// @param wall before any cut
/// @param opened empty: the approach opens no space, and no label changes
/// @return the number of elements with a new label; 0 where the table has no label of either material
std::size_t slacken_other_spaces(
    mesh::TetMesh& wall, const mesh::LabelTable& table, const Anatomy& anatomy, const std::vector<SpaceNumber>& opened);

/// The same for the wall of a patient. Ribs that cannot be told apart leave all labels as they are.
std::size_t slacken_other_spaces(mesh::TetMesh& wall, Patient& patient, const Approach& approach);

} // namespace retractor::planner
