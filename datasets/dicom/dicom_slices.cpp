#include "datasets/dicom/dicom_geometry.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <cmath>

namespace retractor::datasets {

namespace {

    /// Returns the values of a tag. @throws InputError unless there are exactly `count` finite numbers.
    const std::vector<double>& needed(
        const std::vector<double>& values, std::size_t count, const char* tag, const std::string& where)
    {
        if (values.size() != count)
            throw InputError("a CT slice needs " + std::to_string(count) + (count == 1 ? " number" : " numbers")
                    + " here, the file has " + std::to_string(values.size()),
                where + " " + tag);
        for (const double v : values)
            if (!std::isfinite(v))
                throw InputError("not a finite number", where + " " + tag);
        return values;
    }

    double optional(const std::vector<double>& values, double otherwise, const char* tag, const std::string& where)
    {
        return values.empty() ? otherwise : needed(values, 1, tag, where)[0];
    }

    void check_directions(const DicomSlice& slice, const std::string& where)
    {
        constexpr double kUnitTolerance = 1e-3; // some scanners write five digits
        if (std::abs(slice.row.norm() - 1.0) > kUnitTolerance || std::abs(slice.column.norm() - 1.0) > kUnitTolerance
            || std::abs(slice.row.dot(slice.column)) > kUnitTolerance)
            throw InputError("row and column directions must be perpendicular unit vectors",
                where + " ImageOrientationPatient (0020,0037)");
    }

    void check_rescale(const DicomSlice& slice, const DicomFrame& frame, const std::string& where)
    {
        if (slice.slope == 0.0)
            throw InputError("a rescale slope of zero leaves no image", where + " RescaleSlope (0028,1053)");
        if (!frame.rescale_type.empty() && frame.rescale_type != "HU" && frame.rescale_type != "US")
            throw InputError("the values are \"" + frame.rescale_type + "\", not Hounsfield units",
                where + " RescaleType (0028,1054)");
    }

    DicomSlice slice_of(const DicomFrame& frame, const std::string& where)
    {
        DicomSlice slice;
        const auto& p = needed(frame.position, 3, "ImagePositionPatient (0020,0032)", where);
        const auto& o = needed(frame.orientation, 6, "ImageOrientationPatient (0020,0037)", where);
        const auto& s = needed(frame.pixel_spacing, 2, "PixelSpacing (0028,0030)", where);
        constexpr double kFarthest = 1e5; // mm; a position beyond 100 m is a damaged number
        for (const double x : p)
            if (std::abs(x) > kFarthest)
                throw InputError("a position of " + mm_text(x) + " mm is outside any scanner",
                    where + " ImagePositionPatient (0020,0032)");
        slice.position = { p[0], p[1], p[2] };
        slice.row = { o[0], o[1], o[2] };
        slice.column = { o[3], o[4], o[5] };
        slice.row_spacing = s[0];
        slice.column_spacing = s[1];
        constexpr double kSmallest = 1e-3; // mm
        constexpr double kLargest = 1e3;
        for (const double x : s)
            if (x < kSmallest || x > kLargest)
                throw InputError(
                    "pixel spacing must be positive, between 0.001 and 1000 mm", where + " PixelSpacing (0028,0030)");
        check_directions(slice, where);
        slice.thickness = optional(frame.thickness, 0.0, "SliceThickness (0018,0050)", where);
        if (slice.thickness == 0.0)
            slice.thickness = optional(frame.spacing_between_slices, 0.0, "SpacingBetweenSlices (0018,0088)", where);
        slice.slope = optional(frame.slope, 1.0, "RescaleSlope (0028,1053)", where);
        slice.intercept = optional(frame.intercept, 0.0, "RescaleIntercept (0028,1052)", where);
        slice.has_rescale = !frame.slope.empty() && !frame.intercept.empty();
        check_rescale(slice, frame, where);
        return slice;
    }

} // namespace

std::string mm_text(double mm)
{
    std::string result = formatted(std::abs(mm) < 1e7 ? "%.3f" : "%.6g", mm);
    if (result.find('.') != std::string::npos && result.find('e') == std::string::npos) {
        result.erase(result.find_last_not_of('0') + 1);
        if (result.back() == '.')
            result.pop_back();
    }
    return result == "-0" ? "0" : result;
}

std::string slice_name(const DicomSlice& slice, const std::vector<DicomFile>& files)
{
    const DicomFile& file = files[slice.file];
    return file.path.filename().string()
        + (file.frames.size() > 1 ? " frame " + std::to_string(slice.frame + 1) : std::string());
}

std::vector<DicomSlice> dicom_slices(const std::vector<DicomFile>& files)
{
    std::vector<DicomSlice> slices;
    for (std::size_t f = 0; f < files.size(); ++f) {
        const DicomFile& file = files[f];
        if (file.kind == DicomKind::damaged)
            throw InputError("damaged DICOM file", file.path.string());
        for (std::size_t i = 0; i < file.frames.size(); ++i) {
            const std::string where
                = file.path.string() + (file.frames.size() > 1 ? " frame " + std::to_string(i + 1) : std::string());
            slices.push_back(slice_of(file.frames[i], where));
            slices.back().file = f;
            slices.back().frame = static_cast<int>(i);
        }
    }
    return slices;
}

} // namespace retractor::datasets
