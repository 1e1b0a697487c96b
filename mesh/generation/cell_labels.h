#pragma once
// Which cells of a tetrahedralisation belong to which label. Delaunay refinement gives a cell the label at its
// circumcentre; in a layer thinner than the cells are wide the circumcentre often lies outside the cell, beyond the
// layer, and the surface gets pits and spikes of single cells. Here cells get the label that fills them, as far as
// that does not crumple the interfaces. Local frame of mesh/label_field.h, mm. Sequential and deterministic.

#include "mesh/image/label_field.h"

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::mesh {

/// A tetrahedralisation of more than the body: what is outside has label 0.
struct LabelledCells {
    std::vector<Vec3> vertices;
    std::vector<std::array<VertexId, 4>> tets; ///< positive orientation
    std::vector<std::array<TetId, 4>> neighbours; ///< beyond the face opposite each corner; -1: none
    std::vector<std::uint8_t> labels; ///< LabelField::at
};

/// Lowers the sum of misfit volume (parts of cells where the field has another label) and interface area (times a
/// small length) by changing the labels of single cells, until none gains.
/// @return the number of cells whose label changed.
std::size_t fit_labels(LabelledCells& cells, const LabelField& field);

} // namespace retractor::mesh
