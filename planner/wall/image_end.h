#pragma once
// Where the image ends, the body is cut off. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

namespace retractor::planner {

/// Flat faces that close the body where the image cuts it off: what the labels of the outermost slices cover, with the
/// cavities that they enclose. They stand half a voxel outside this slice, so that the organs end before them. No line
/// of sight passes through them, because no one looks into a patient from the place where the image ends.
/// A slice counts as outermost within three voxels of the image's border, unless the body grows thin there and so ends
/// by itself. @returns an empty surface where the image cuts nothing off
TriMesh image_end_faces(const mesh::LabelVolume& labels);

} // namespace retractor::planner
