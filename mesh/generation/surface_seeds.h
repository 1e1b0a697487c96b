#pragma once
// First points for the mesher, on the surface of every connected component of every label, so that the mesher finds
// every component. Local frame of mesh/image/label_field.h, mm.

#include "mesh/generation/size_field.h"
#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

struct SurfaceSeed {
    Vec3 point; ///< on the interface of labels a and b, to 0.01 mm
    int a = 0, b = 0; ///< a < b; 0 is outside
};

/// A sparse set of points, two edge lengths apart, and closer on smaller components.
/// @param order 0: the points are chosen in the order of the voxels; another number: in a shuffled order of that number
std::vector<SurfaceSeed> surface_seeds(const LabelField& field, const SizeField& size, unsigned order = 0);

} // namespace retractor::mesh
