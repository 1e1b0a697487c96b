#pragma once
// Where the image ends, the body is cut off. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

namespace retractor::planner {

/// Flat faces that close the body where the image cuts it off: what the labels of the outermost slices cover, with the
/// cavities that they enclose. They stand a voxel outside, so that the organs end before them. No line of sight passes
/// through them, because no one looks into a patient from the place where the image ends.
/// A slice counts as outermost within three voxels of the image's border. @returns an empty surface where none is
/// labelled
TriMesh image_end_faces(const mesh::LabelVolume& labels);

} // namespace retractor::planner
