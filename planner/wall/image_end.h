#pragma once
// Where the image ends, the body is cut off. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

namespace retractor::planner {

inline constexpr double kImageEndVoxels = 1.0; ///< from the outermost slice to the faces below

/// Flat faces that close the body where the image cuts it off: what the labels of the outermost slices cover, with the
/// cavities that they enclose, within a smoothed outline. They stand kImageEndVoxels outside this slice, so that the
/// organs end before them. No line of sight passes through them, because no one looks into a patient from the place
/// where the image ends. A slice counts as outermost within three voxels of the image's border, unless the body grows thin there and so ends
/// by itself. @returns an empty surface where the image cuts nothing off
TriMesh image_end_faces(const mesh::LabelVolume& labels);

/// Brings what a wound has pushed out of the image back behind these faces, for a picture: nobody knows what lies
/// there.
void keep_within_image(Points& vertices, const mesh::ImageGrid& grid);

} // namespace retractor::planner
