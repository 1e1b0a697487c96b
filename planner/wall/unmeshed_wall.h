#pragma once
// The chest wall outside the meshed region. It is drawn and blocks the view, but is not calculated. Units mm; frame
// patient LPS.

#include "mesh/base/job.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <vector>

namespace retractor::planner {

/// Width of the region's rim that pictures leave out, mm: the tetrahedra end there in slopes of about an element. 0
/// where the cut may reach into the rim.
double drawn_rim_width_mm(double region_mm, double cut_depth_mm);

/// The boundary of the meshed wall without the faces of soft tissue in the rim of the region.
/// @param boundary displaced or not, with a label per triangle; @param at_rest the same triangles at rest
/// @param rim_mm drawn_rim_width_mm()
TriMesh without_rim(TriMesh boundary, const TriMesh& at_rest, const mesh::MeshSizing& sizing, double rim_mm);

/// The part of the body's surface that the tetrahedra do not cover. The surface is open round the region, and ends a
/// little below the region's tissue, to which it is fitted.
/// The surface moves with the opened rim and with the bones kept beyond the rim. The motion fades to zero 40 mm away (a
/// harmonic function in between: smooth, no mechanics). Each triangle has the label of the wall tissue just inside it.
/// @param body surface of all wall labels, see Patient::body()
/// @param displacement n x 3 (mm), one row per vertex of `wall`
/// @param rim_mm width of the rim that the picture of the tetrahedra leaves out; 0: none, and the surface is not fitted
/// @returns an empty surface when the region has no limit, because the tetrahedra are then the whole wall
TriMesh unmeshed_wall_region(const TriMesh& body, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing,
    const mesh::TetMesh& wall, const Points& displacement, double rim_mm, const Job& job = {});

/// The labels with which the boundary of the meshed wall is drawn. In its coarse model (MeshSizing::coarse_beyond_mm),
/// which has no layer of skin, faces at the outside of the body are skin, and so are faces of soft tissue that lie
/// there where the layer has a gap. All other faces keep their label.
/// @param boundary of the wall at rest, one label per triangle
std::vector<Label> drawn_labels(
    const TriMesh& boundary, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing);

} // namespace retractor::planner
