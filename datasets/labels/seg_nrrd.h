#pragma once
// Segmentations of 3D Slicer (.seg.nrrd): labels with the names of their segments, in one layer or several that may
// overlap. Keys: https://slicer.readthedocs.io, "Segmentations", file format.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::datasets {

struct Segment {
    std::string id; ///< "Segment_1"
    std::string name; ///< as the user wrote it: "Left lung"
    int layer = 0;
    Label value = 1; ///< of its voxels in that layer
    std::map<std::string, std::string> tags; ///< terminology and the like, "TerminologyEntry" -> "..."
};

struct SegmentedImage {
    mesh::ImageGrid grid;
    int layers = 1;
    std::vector<Label> voxels; ///< layer fastest: voxel v of layer l is at v * layers + l
    std::vector<Segment> segments; ///< in the file's order
    std::vector<std::string> notes;
};

/// True for an NRRD whose header names segments, whatever its suffix. False for what is no readable NRRD.
bool is_seg_nrrd(const std::filesystem::path& path);

/// @throws InputError for a header that names no segments, two segments with one layer and value, a layer that is not
/// there, voxels of a value that no segment has, and as read_volume() does; IoError.
SegmentedImage read_seg_nrrd(const std::filesystem::path& path, const Job& job = {});

/// Layers merged into one label map, named by describe_structure(). Where segments overlap the one with fewer voxels
/// wins: a vessel inside an organ stays visible.
struct MergedSegments {
    mesh::LabelVolume labels;
    std::size_t overlapping_voxels = 0;
    std::vector<std::string> notes; ///< those of the image, renumbering, renaming, overlap
};
MergedSegments merge_segments(const SegmentedImage& image, const Job& job = {});

} // namespace retractor::datasets
