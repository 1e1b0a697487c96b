#pragma once
// Decides which label each cell of a tetrahedralisation gets. Delaunay refinement gives a cell the label at its
// circumcentre. In a layer thinner than the cells, the circumcentre often lies outside the cell and beyond the layer,
// and the surface gets pits and spikes of single cells. Here each cell gets the label that fills it, unless that
// crumples the interfaces. Local frame of mesh/image/label_field.h, mm. Sequential and deterministic.

#include "mesh/image/label_field.h"

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::mesh {

/// Points spread evenly in a cell: barycentric coordinates.
inline constexpr std::array<std::array<double, 4>, 11> kCellSamples { { { .25, .25, .25, .25 }, { .55, .15, .15, .15 },
    { .15, .55, .15, .15 }, { .15, .15, .55, .15 }, { .15, .15, .15, .55 }, { .35, .35, .15, .15 },
    { .35, .15, .35, .15 }, { .35, .15, .15, .35 }, { .15, .35, .35, .15 }, { .15, .35, .15, .35 },
    { .15, .15, .35, .35 } } };

/// A tetrahedralisation that also covers space outside the body; cells outside have label 0.
struct LabelledCells {
    std::vector<Vec3> vertices; ///< mm
    std::vector<std::array<VertexId, 4>> tets; ///< positive orientation
    std::vector<std::array<TetId, 4>> neighbours; ///< neighbour across the face opposite each corner; -1: none
    std::vector<std::uint8_t> labels; ///< label number per cell, as LabelField::at
};

/// Changes the labels of single cells, and of two neighbours together, while a change lowers the sum of misfit volume
/// and interface area. Misfit volume is the volume of parts of cells where the field has another label; the area is
/// multiplied by a small length.
void fit_labels(LabelledCells& cells, const LabelField& field);

} // namespace retractor::mesh
