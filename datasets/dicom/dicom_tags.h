#pragma once
// Reads the tags of DICOM files, once per file, without checking the values. A folder may hold any files, and only the
// chosen series must be correct. Patient name and id are read only to remove them from descriptions.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets {

/// One slice: a file, or a frame of an enhanced multi-frame object with its functional groups. Each member holds the
/// numbers that the file gives: none when the tag is absent, NaN when the text is no number. dicom_slices() checks
/// them.
struct DicomFrame {
    std::vector<double> position; ///< ImagePositionPatient, mm
    std::vector<double> orientation; ///< ImageOrientationPatient
    std::vector<double> pixel_spacing; ///< PixelSpacing, mm: between rows, between columns
    std::vector<double> thickness; ///< SliceThickness, mm
    std::vector<double> spacing_between_slices; ///< SpacingBetweenSlices, mm
    std::vector<double> slope; ///< RescaleSlope
    std::vector<double> intercept; ///< RescaleIntercept
    std::string rescale_type; ///< RescaleType, "HU" for a CT
    std::vector<std::string> phase; ///< values of kDicomPhaseTags
};

/// Names of the tags that may distinguish images at the same place, in the order in which a radiographer would look.
extern const std::vector<std::string> kDicomPhaseTags;

/// The content of a DICOM file.
enum class DicomKind {
    slices, ///< images in the patient
    localizer, ///< a projection: scout, topogram
    capture, ///< a captured screen, a dose table
    no_image, ///< structured report, presentation state, DICOMDIR ...
    damaged, ///< begins like DICOM, but cannot be parsed
};

/// The tags of one file. Numbers are stored as in DicomFrame.
struct DicomFile {
    std::filesystem::path path;
    DicomKind kind = DicomKind::no_image;
    std::string series_uid;
    std::string series_number;
    std::string description; ///< SeriesDescription; empty when it repeats the patient's name or id
    std::string modality;
    std::string identity; ///< distinguishes series without a UID; never shown
    std::string sop_instance;
    std::string frame_of_reference;
    std::string transfer_syntax;
    std::string photometric;
    bool lossy = false; ///< the file says that its compression lost information
    bool modality_lut = false; ///< a table replaces slope and intercept
    bool overlay_in_pixels = false; ///< unused bits of the pixels hold an overlay (retired in DICOM)
    std::vector<double> columns;
    std::vector<double> rows;
    std::vector<double> samples_per_pixel;
    std::vector<double> bits_allocated;
    std::vector<double> bits_stored;
    std::vector<double> high_bit;
    std::vector<double> pixel_representation;
    std::vector<double> padding_value;
    std::vector<double> padding_limit;
    bool has_pixels = false;
    bool damaged_pixels = false; ///< the tags are complete, but the file ends within the pixels
    std::uint64_t pixel_offset = 0; ///< start of the pixels, bytes from the start of the file
    std::uint32_t pixel_length = 0; ///< length of the pixels as declared, bytes; 0xFFFFFFFF for compressed pixels
    std::uint64_t file_size = 0; ///< bytes
    std::vector<DicomFrame> frames; ///< one per slice
};

/// True when the file declares lossy compression, or uses a transfer syntax that always loses information (JPEG
/// baseline and extended, near-lossless JPEG-LS).
bool is_lossy(const DicomFile& file);

/// Reads the tags of a file. Returns nothing when the file is not DICOM.
std::optional<DicomFile> read_dicom_tags(const std::filesystem::path& path);

} // namespace retractor::datasets
