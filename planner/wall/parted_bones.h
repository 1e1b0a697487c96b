#pragma once
// Meshes a wall in which bones that touch ribs are parted from them. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "mesh/generation/hybrid_model.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstddef>
#include <functional>

namespace retractor::planner {

/// Gives elements of bones that share a vertex with a rib the label of the soft tissue round that vertex, or round the
/// other such vertices. A rib moves against spine, shoulder girdle and sternum by joints (rib_joints.h), or glides on
/// soft tissue. Where a mesh is coarse, or the labels touch, elements of both bones would share vertices: one vertex is
/// a ball joint, three are a weld. The other bone gives way, because ribs are the thinner ones. Cartilage is no bone
/// here: it is grown together with rib and sternum. Ribs that touch each other stay as they are: the loss of an element
/// could divide a rib.
/// @param mesh the wall before any cut
/// @return the number of elements with a new label; 0 where no such rib touches soft tissue
std::size_t part_ribs_from_other_bones(mesh::TetMesh& mesh, const mesh::LabelTable& table);

/// mesh::build_hybrid_model() with parted bones: the wall that is planned, cut, exported and shown. The statistics are
/// those of the mesher, before the bones are parted.
/// @throws as mesh::build_hybrid_model()
mesh::HybridModel build_wall(const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing, const Job& job = {},
    const std::function<void(double expected)>& on_forecast = {});

} // namespace retractor::planner
