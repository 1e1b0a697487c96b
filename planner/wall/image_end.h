#pragma once
// Where the image ends, the body is cut off. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

#include <vector>

namespace retractor::planner {

/// A side of the image that cuts the body off.
struct ImageEnd {
    int across = 2; ///< axis of the image
    bool at_end = false; ///< at its end, or at its begin
    int slice = 0; ///< the outermost one with labels
    double face = 0.0; ///< coordinate of the face that closes the body, voxels: one voxel outside this slice
};

/// The sides that cut the body off. A slice counts as outermost within three voxels of the image's border, unless the
/// body grows thin there and so ends by itself.
std::vector<ImageEnd> image_ends(const mesh::LabelVolume& labels);

/// Flat faces that close the body where the image cuts it off: what the labels of the outermost slices cover, with the
/// cavities that they enclose, within a smoothed outline. No line of sight passes through them, because no one looks
/// into a patient from the place where the image ends. @returns an empty surface where the image cuts nothing off
TriMesh image_end_faces(const mesh::LabelVolume& labels);

/// Brings what a wound has pushed out at these sides back behind their faces, for a picture: nobody knows what lies
/// there.
/// @param vertices changed in place, mm, patient LPS
void keep_within_image(Points& vertices, const mesh::ImageGrid& grid, const std::vector<ImageEnd>& ends);

} // namespace retractor::planner
