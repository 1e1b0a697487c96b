#pragma once
// Computes the grid that the tags of a series form, or throws the reason why the slices form no grid. Every check uses
// the tags of every slice, because libraries average uneven gaps and split mixed orientations without a message. The
// frame is patient LPS; lengths are in mm.

#include "datasets/dicom/dicom_tags.h"
#include "mesh/image/volume.h"

namespace retractor::datasets {

/// A slice whose geometry is complete and finite. Frame: patient LPS, mm.
struct DicomSlice {
    std::size_t file = 0; ///< index in the list of files
    int frame = 0; ///< index within the file
    Vec3 position = Vec3::Zero(); ///< centre of the first pixel
    Vec3 row = Vec3::Zero(); ///< unit direction of rising column index
    Vec3 column = Vec3::Zero(); ///< unit direction of rising row index
    double row_spacing = 0.0; ///< distance between rows, mm
    double column_spacing = 0.0; ///< distance between columns, mm
    double thickness = 0.0; ///< mm; 0 when the file gives none
    double slope = 1.0; ///< RescaleSlope, HU per stored unit
    double intercept = 0.0; ///< RescaleIntercept, HU
    bool has_rescale = true; ///< the file gives slope and intercept
};

/// The slices of a series in order, and the grid that they form.
struct DicomArrangement {
    mesh::ImageGrid grid; ///< grid of the volume, enlarged in the plane when the slices are shifted
    std::vector<DicomSlice> slices; ///< in order of rising k
    /// For a tilted gantry: slice k is shifted by k times this vector (pixels along i and j) against the first slice.
    /// Zero for a straight stack.
    std::array<double, 2> shift { 0.0, 0.0 };
    std::array<int, 2> first { 0, 0 }; ///< pixel of the first slice at grid index (0, 0)
    double tilt_degrees = 0.0; ///< angle of the gantry
    double rounding = 0.0; ///< largest distance of a slice from its evenly spaced place, mm
};

/// True when the image plane is perpendicular to the patient's long axis, within 45 degrees.
bool is_axial(const DicomFrame& frame);

/// Checks the tags of every frame and returns one slice per frame.
/// @throws InputError, naming file and tag, when a value of a slice is missing, not finite or contradictory.
std::vector<DicomSlice> dicom_slices(const std::vector<DicomFile>& files);

/// Sorts the slices along their normal and computes their grid.
/// @throws InputError, naming files and positions, for mixed sizes, spacings or orientations, several slices at one
/// place, uneven gaps, and shifted slices that no tilt explains. Without `rectify_tilt`, every shift is refused.
DicomArrangement arrange_dicom(std::vector<DicomSlice> slices, const std::vector<DicomFile>& files, bool rectify_tilt);

/// The name of a slice for a message: "file.dcm", with the frame when the file has several.
std::string slice_name(const DicomSlice& slice, const std::vector<DicomFile>& files);

/// A length in mm as text, without digits that do not matter.
std::string mm_text(double mm);

/// Refuses several slices at one place. The message gives the place, says whether the slices look like phases, and
/// names the tag that differs. Implemented in dicom_phases.cpp.
/// @param heights position of each slice along the normal (mm), in rising order like `slices`
/// @throws InputError when two slices lie at one place.
void check_places(
    const std::vector<DicomSlice>& slices, const std::vector<double>& heights, const std::vector<DicomFile>& files);

} // namespace retractor::datasets
