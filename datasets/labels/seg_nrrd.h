#pragma once
// Reads segmentations of 3D Slicer (.seg.nrrd): labels with the names of their segments, in one layer, or in several
// layers that may overlap. Format: https://slicer.readthedocs.io, "Segmentations", file format.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace retractor::datasets {

/// One segment of the file.
struct Segment {
    std::string id; ///< "Segment_1"
    std::string name; ///< as the user wrote the name: "Left lung"
    int layer = 0; ///< index of the layer
    Label value = 1; ///< value of the segment's voxels in its layer
    std::map<std::string, std::string> tags; ///< terminology and other tags: "TerminologyEntry" -> "..."
};

/// The layers and segments of a file.
struct SegmentedImage {
    mesh::ImageGrid grid;
    int layers = 1;
    std::vector<Label> voxels; ///< layer fastest: voxel v of layer l is at v * layers + l
    std::vector<Segment> segments; ///< in the order of the file
    std::vector<std::string> notes; ///< decisions of the reader, one line each
};

/// True for an NRRD file whose header names segments, with any suffix. False for every other or unreadable file.
bool is_seg_nrrd(const std::filesystem::path& path);

/// Reads a segmentation.
/// @throws InputError as read_volume() does, and for a header without segments, two segments with the same layer and
/// value, a missing layer, and voxels of a value without a segment; IoError when the file cannot be read.
SegmentedImage read_seg_nrrd(const std::filesystem::path& path, const Job& job = {});

/// The layers merged into one label map, with names from describe_structure(). Where segments overlap, the segment with
/// fewer voxels wins, so that a vessel inside an organ stays visible.
struct MergedSegments {
    mesh::LabelVolume labels;
    std::size_t overlapping_voxels = 0; ///< voxels of two or more segments
    std::vector<std::string> notes; ///< notes of the image, then notes on new ids, new names and overlaps
};
/// Merges the layers of a segmentation.
MergedSegments merge_segments(const SegmentedImage& image, const Job& job = {});

} // namespace retractor::datasets
