#pragma once
// From the tags of a series to the grid it forms, or to the reason why it forms none. A library that averages uneven
// gaps and splits mixed orientations in silence is no help here: every check is made on the tags of every slice.

#include "datasets/dicom/dicom_tags.h"
#include "mesh/image/volume.h"

namespace retractor::datasets {

/// A slice whose geometry is complete and finite. Frame: patient LPS, mm.
struct DicomSlice {
    std::size_t file = 0; ///< place in the list of files
    int frame = 0; ///< within the file
    Vec3 position = Vec3::Zero(); ///< centre of the first pixel
    Vec3 row = Vec3::Zero(); ///< direction of rising column index, unit
    Vec3 column = Vec3::Zero();
    double row_spacing = 0.0; ///< between rows
    double column_spacing = 0.0;
    double thickness = 0.0; ///< 0 where not given
    double slope = 1.0;
    double intercept = 0.0;
    bool has_rescale = true;
};

struct DicomArrangement {
    mesh::ImageGrid grid; ///< what the volume will have: grown in the plane where the slices are shifted
    std::vector<DicomSlice> slices; ///< by rising k
    /// Tilted gantry: slice k lies k times this (pixels along i and j) from the first; zero for straight stacks.
    std::array<double, 2> shift { 0.0, 0.0 };
    std::array<int, 2> first { 0, 0 }; ///< grid index (0, 0) in pixels of the first slice
    double tilt_degrees = 0.0;
    double rounding = 0.0; ///< mm, largest distance of a slice from its even place
};

bool is_axial(const DicomFrame& frame);

/// @throws InputError naming file and tag for what is missing, not finite or contradictory in one slice.
std::vector<DicomSlice> dicom_slices(const std::vector<DicomFile>& files);

/// @throws InputError naming files and positions for mixed sizes, spacings or orientations, several slices at one
/// place, uneven gaps, and shifted slices (all of them when `rectify_tilt` is false).
DicomArrangement arrange_dicom(std::vector<DicomSlice> slices, const std::vector<DicomFile>& files, bool rectify_tilt);

/// "file.dcm", with the frame where the file has several.
std::string slice_name(const DicomSlice& slice, const std::vector<DicomFile>& files);

/// Millimetres with as many digits as matter.
std::string mm_text(double mm);

/// Several slices at one place, sorted by `heights` (mm along the normal): says where, and whether they look like
/// phases and which tag tells them apart. Defined in dicom_phases.cpp.
/// @throws InputError when a place is taken twice.
void check_places(
    const std::vector<DicomSlice>& slices, const std::vector<double>& heights, const std::vector<DicomFile>& files);

} // namespace retractor::datasets
