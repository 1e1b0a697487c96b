#include "datasets/dicom/dicom.h"

#include "datasets/dicom/dicom_geometry.h"
#include "datasets/dicom/dicom_pixels.h"
#include "datasets/dicom/dicom_series.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    void note_tags(const std::vector<DicomFile>& files, const DicomArrangement& stack, std::vector<std::string>& notes)
    {
        std::size_t without_rescale = 0;
        for (const DicomSlice& slice : stack.slices)
            without_rescale += slice.has_rescale ? 0 : 1;
        if (without_rescale > 0)
            notes.push_back("no rescale slope and intercept in " + std::to_string(without_rescale) + " of "
                + std::to_string(stack.slices.size())
                + " slices: assumed 1 and 0, the values may be no Hounsfield units");
        const auto unspecified = [](const DicomFile& f) {
            return std::any_of(
                f.frames.begin(), f.frames.end(), [](const DicomFrame& i) { return i.rescale_type == "US"; });
        };
        if (std::any_of(files.begin(), files.end(), unspecified))
            notes.push_back("the files leave the unit of their values unspecified: taken as Hounsfield units");
        if (std::any_of(files.begin(), files.end(), is_lossy))
            notes.push_back("the images were compressed with loss: values are near those of the scanner, not equal");
    }

    void note_geometry(const DicomArrangement& stack, std::vector<std::string>& notes)
    {
        constexpr double kWorthSaying = 0.01; // mm; a smaller rounding gives no note
        if (stack.slices.size() == 1)
            notes.push_back("a single slice, " + mm_text(stack.grid.spacing.z()) + " mm thick");
        if (stack.rounding > kWorthSaying)
            notes.push_back("the slice positions are rounded: up to " + mm_text(stack.rounding)
                + " mm from even places " + mm_text(stack.grid.spacing.z()) + " mm apart");
        if (stack.tilt_degrees > 0.0)
            notes.push_back("gantry tilt of " + mm_text(std::round(stack.tilt_degrees * 100.0) / 100.0)
                + " degrees straightened: slices moved in their planes by linear interpolation, grid now "
                + std::to_string(stack.grid.size[0]) + " x " + std::to_string(stack.grid.size[1]) + " x "
                + std::to_string(stack.grid.size[2]));
    }

    void note_pixels(const DicomPixelCounts& counts, std::vector<std::string>& notes)
    {
        constexpr int kAir = -1024;
        if (counts.padding > 0) {
            std::string range = std::to_string(counts.padding_darkest);
            if (counts.padding_brightest != counts.padding_darkest)
                range += " to " + std::to_string(counts.padding_brightest);
            notes.push_back(std::to_string(counts.padding) + " padding voxels (" + range + " HU) set to air, -1024 HU"
                + (counts.padding_brightest > kAir ? "; the file declares a value as padding that air or tissue has"
                                                   : ""));
        }
        if (counts.circle > 0)
            notes.push_back(std::to_string(counts.circle) + " voxels outside the scan circle ("
                + std::to_string(counts.circle_value) + " HU) set to air, -1024 HU");
    }

    DicomVolume read(const fs::path& path, const DicomReadOptions& options, const Job& job)
    {
        const Stopwatch watch;
        DicomVolume result;
        DicomFolder folder = scan_dicom(path, job);
        if (job.cancelled())
            return {};
        const DicomGroup group = choose_dicom_series(
            group_dicom_series(std::move(folder), result.notes), options.series, path.string(), result.notes);
        for (const DicomFile& file : group.files)
            check_pixel_tags(file);
        const DicomArrangement stack = arrange_dicom(dicom_slices(group.files), group.files, options.rectify_tilt);
        note_tags(group.files, stack, result.notes);
        note_geometry(stack, result.notes);

        result.volume.grid = stack.grid;
        result.volume.voxels.resize(stack.grid.voxel_count());
        const DicomPixelCounts counts = read_dicom_pixels(group.files, stack, result.volume.voxels, job);
        if (job.cancelled())
            return {};
        note_pixels(counts, result.notes);
        record_part(job, "voxels", watch, result.volume.voxels.size() * sizeof(std::int16_t));
        return result;
    }

} // namespace

DicomVolume read_dicom(const fs::path& path, const DicomReadOptions& options, const Job& job)
{
    try {
        return read(path, options, job);
    } catch (const std::bad_alloc&) {
        throw InputError("the series does not fit into memory, or its sizes are damaged", path.string());
    } catch (const std::length_error&) {
        throw InputError("the sizes of the series are damaged", path.string());
    }
}

mesh::Volume read_dicom_series(const fs::path& folder, const Job& job) { return read_dicom(folder, {}, job).volume; }

} // namespace retractor::datasets
