#pragma once
// Checks whether each rib is one whole bone under one label: its pieces, its length against the rib of the other side
// and its neighbours, and other bone that has a rib's shape. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// A connected piece of a bone's label.
struct BonePiece {
    Label label = 0;
    double volume_ml = 0.0;
    double length_mm = 0.0; ///< the longest of the shortest ways inside the piece
    Vec3 first_end = Vec3::Zero(), second_end = Vec3::Zero(); ///< of this way
    bool at_image_end = false; ///< a voxel lies on the border of the grid

    /// Diameter of a rod of the same volume and length.
    double thickness_mm() const;
};

/// The pieces of these labels, connected over faces, edges and corners; of each label the largest first.
/// @param flags one per label id; @returns nothing when the job was cancelled
std::vector<BonePiece> bone_pieces(const mesh::LabelVolume& labels, const mesh::LabelFlags& flags, const Job& job = {});

/// Doubts about the ribs, one sentence each: "rib 8 on the right is 118 mm long, and rib 8 on the left 205 mm: it may
/// be cut in two". Empty: none, or there are no ribs.
std::vector<std::string> rib_doubts(const mesh::LabelVolume& labels, const Job& job = {});

} // namespace retractor::planner
