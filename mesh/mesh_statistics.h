#pragma once
// What a mesh of labels is worth: volumes against the voxels, distance of its surfaces from the smooth
// label boundary, dihedral angles, connectedness. Units mm.

#include "mesh/hybrid_model.h"
#include "mesh/label_field.h"

namespace retractor {

/// @param mesh labels of `labels`; vertices in patient LPS. @param field the label function it was made from.
/// @param local_corridor the corridor in the field's frame.
/// Fills everything but the times.
MeshStatistics mesh_statistics(const TetMesh& mesh, const LabelVolume& labels, const LabelField& field,
    const std::vector<Vec3>& local_corridor, const MeshSizing& sizing);

} // namespace retractor
