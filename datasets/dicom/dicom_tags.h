#pragma once
// What the tags of DICOM files say, read once per file and without judgement: a folder may hold anything, and only
// the series that is chosen must be right. Patient name and id are looked at only to keep them out of descriptions.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets {

/// One slice: a file, or a frame of an enhanced multi-frame object (its functional groups looked up). Numbers as the
/// file gives them, none when the tag is absent, NaN where the text is no number; checked by dicom_slices().
struct DicomFrame {
    std::vector<double> position; ///< ImagePositionPatient
    std::vector<double> orientation; ///< ImageOrientationPatient
    std::vector<double> pixel_spacing; ///< between rows, between columns
    std::vector<double> thickness;
    std::vector<double> spacing_between_slices;
    std::vector<double> slope;
    std::vector<double> intercept;
    std::string rescale_type;
    std::vector<std::string> phase; ///< values of kDicomPhaseTags
};

/// What may tell images at the same place apart, in the order in which a radiographer would look.
extern const std::vector<std::string> kDicomPhaseTags;

enum class DicomKind {
    slices, ///< images in the patient, or meant to be
    localizer, ///< scout, topogram: a projection
    capture, ///< a screen, a dose table
    no_image, ///< structured report, presentation state, DICOMDIR ...
    damaged, ///< begins like DICOM and cannot be parsed
};

struct DicomFile {
    std::filesystem::path path;
    DicomKind kind = DicomKind::no_image;
    std::string series_uid;
    std::string series_number;
    std::string description; ///< empty where it repeats the patient's name or id
    std::string modality;
    std::string identity; ///< tells series apart that have no UID; never shown
    std::string sop_instance;
    std::string frame_of_reference;
    std::string transfer_syntax;
    std::string photometric;
    bool lossy = false;
    bool modality_lut = false; ///< a table instead of slope and intercept
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
    bool damaged_pixels = false; ///< the tags are whole, the file ends in the middle of the pixels
    std::uint64_t pixel_offset = 0; ///< bytes from the start of the file
    std::uint32_t pixel_length = 0; ///< as declared; 0xFFFFFFFF for compressed pixels
    std::uint64_t file_size = 0;
    std::vector<DicomFrame> frames;
};

/// Said by the file, or a transfer syntax that always loses (JPEG baseline and extended, near-lossless JPEG-LS).
bool is_lossy(const DicomFile& file);

/// No DICOM file: nothing.
std::optional<DicomFile> read_dicom_tags(const std::filesystem::path& path);

} // namespace retractor::datasets
