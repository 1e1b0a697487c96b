#pragma once
// Finds soft tissue that changes its volume. Soft tissue is mostly water and nearly incompressible. A solution in which
// it shrinks or grows by more than a tenth is a failure of the computation, not a finding (the tenth is ours). Units
// mm.

#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/measures/field_metrics.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Volume over volume at rest within which soft tissue keeps its volume.
inline constexpr double kLeastVolumeRatio = 0.9, kMostVolumeRatio = 1.1;

/// Share of the soft tissue's volume from which on no number of the plan is to be believed (ours). Strain has no bound
/// at the ends of a wound and at the edges of hooks, so some tissue fails there in every plan; a smaller share is told
/// with its place. In plans of the phantom 1 to 3 % fail with ten-node elements. Of four-node elements whose force is
/// off by two thirds 9 to 14 % failed when each was judged by itself.
inline constexpr double kMostFailedShare = 0.05;

/// @param wall at rest
/// @param volume_ratio deformed volume over volume at rest, one per element of the wall
/// @param table bones and cartilages are no soft tissue; labels that are not in the table are
/// @param inverted_elements number of elements that are inside out
VolumeFailures find_volume_failures(const mesh::TetMesh& wall, std::span<const double> volume_ratio,
    const mesh::LabelTable& table, int inverted_elements);

/// Volume ratios averaged round the vertices. Locking-free elements keep the volume of patches of elements, and not
/// the volume of each element (fem/element/locking_free.h). Plain four-node elements are judged alike: neighbours
/// shrink and grow in turn, and what the tissue does is their mean. The averages are taken over elements of the same
/// label.
/// @param volume_ratio one per element of the wall
std::vector<double> averaged_volume_ratios(const mesh::TetMesh& wall, std::span<const double> volume_ratio);

/// Whether the volumes say nothing against the field's numbers; also true where they were not computed.
bool keeps_volume(const FieldMetrics& field);

/// Whether neither the volumes nor bones that come out through the skin (RegionMetrics::piercing) say anything against
/// the field's numbers.
bool is_believable(const FieldMetrics& field);

/// "not usable: these numbers are not to be believed: 14 % of the soft tissue ...", or for a field that keeps its
/// volume where little tissue fails "caution: 2.4 % of the soft tissue ..."; empty where nothing fails.
std::string volume_failure_text(const FieldMetrics& field);

} // namespace retractor::planner
