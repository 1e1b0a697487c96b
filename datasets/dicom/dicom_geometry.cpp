#include "datasets/dicom/dicom_geometry.h"

#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace retractor::datasets {

namespace {

    constexpr double kDegree = std::numbers::pi / 180.0;

    [[noreturn]] void refuse(
        const std::string& what, const DicomSlice& slice, const std::vector<DicomFile>& files, const char* tag)
    {
        throw InputError(what, files[slice.file].path.string() + " " + tag);
    }

    std::string vector_text(const Vec3& v)
    {
        return formatted("(%s, %s, %s)", mm_text(v.x()).c_str(), mm_text(v.y()).c_str(), mm_text(v.z()).c_str());
    }

    /// Lists the orientations: "12 slices from a.dcm to b.dcm (normal ...), 3 slices from ..."
    std::string orientation_groups(
        const std::vector<DicomSlice>& slices, const std::vector<DicomFile>& files, double tolerance)
    {
        std::vector<std::vector<std::size_t>> groups;
        for (std::size_t s = 0; s < slices.size(); ++s) {
            const auto like = [&](const std::vector<std::size_t>& g) {
                const DicomSlice& other = slices[g.front()];
                return (slices[s].row - other.row).norm() <= tolerance
                    && (slices[s].column - other.column).norm() <= tolerance;
            };
            const auto group = std::find_if(groups.begin(), groups.end(), like);
            if (group != groups.end())
                group->push_back(s);
            else
                groups.push_back({ s });
        }
        constexpr std::size_t kShown = 4;
        std::string text;
        for (std::size_t g = 0; g < std::min(groups.size(), kShown); ++g) {
            const DicomSlice& first = slices[groups[g].front()];
            const Vec3 normal = first.row.cross(first.column);
            double low = first.position.dot(normal);
            double high = low;
            for (const std::size_t s : groups[g]) {
                low = std::min(low, slices[s].position.dot(normal));
                high = std::max(high, slices[s].position.dot(normal));
            }
            text += (g > 0 ? "; " : "") + std::to_string(groups[g].size()) + " with normal " + vector_text(normal)
                + " at " + mm_text(low) + (high > low ? " to " + mm_text(high) : std::string()) + " mm, first "
                + slice_name(first, files);
        }
        return groups.size() > kShown ? text + "; and " + std::to_string(groups.size() - kShown) + " more" : text;
    }

    void check_alike(const std::vector<DicomSlice>& slices, const std::vector<DicomFile>& files)
    {
        constexpr double kDirectionTolerance = 1e-4;
        constexpr double kSpacingTolerance = 1e-4; // relative
        const DicomSlice& first = slices.front();
        const DicomFile& first_file = files[first.file];
        for (const DicomSlice& slice : slices) {
            const DicomFile& file = files[slice.file];
            if (file.columns != first_file.columns || file.rows != first_file.rows)
                refuse("slices of different sizes: " + mm_text(file.columns[0]) + " x " + mm_text(file.rows[0])
                        + " here, " + mm_text(first_file.columns[0]) + " x " + mm_text(first_file.rows[0]) + " in "
                        + slice_name(first, files),
                    slice, files, "Columns (0028,0011)");
            if ((slice.row - first.row).norm() > kDirectionTolerance
                || (slice.column - first.column).norm() > kDirectionTolerance)
                refuse("slices of different orientations: " + orientation_groups(slices, files, kDirectionTolerance),
                    slice, files, "ImageOrientationPatient (0020,0037)");
            if (std::abs(slice.row_spacing - first.row_spacing) > kSpacingTolerance * first.row_spacing
                || std::abs(slice.column_spacing - first.column_spacing) > kSpacingTolerance * first.column_spacing)
                refuse("slices of different pixel spacing: " + mm_text(slice.column_spacing) + " x "
                        + mm_text(slice.row_spacing) + " mm here, " + mm_text(first.column_spacing) + " x "
                        + mm_text(first.row_spacing) + " mm in " + slice_name(first, files),
                    slice, files, "PixelSpacing (0028,0030)");
            if (file.frame_of_reference != first_file.frame_of_reference && !file.frame_of_reference.empty()
                && !first_file.frame_of_reference.empty())
                refuse("slices of different frames of reference: this one and " + slice_name(first, files), slice,
                    files, "FrameOfReferenceUID (0020,0052)");
        }
    }

    /// The median gap between slices (mm). Of two middle gaps the smaller is returned, because slices get lost but are
    /// not added.
    double usual_gap(const std::vector<double>& heights)
    {
        std::vector<double> gaps(heights.size());
        std::adjacent_difference(heights.begin(), heights.end(), gaps.begin());
        gaps.erase(gaps.begin());
        return value_of_rank(gaps, (gaps.size() - 1) / 2);
    }

    std::string gap_text(const std::vector<DicomSlice>& slices, const std::vector<double>& heights,
        const std::vector<DicomFile>& files, std::size_t s, double usual)
    {
        const double gap = heights[s] - heights[s - 1];
        std::string text = mm_text(gap) + " mm between " + slice_name(slices[s - 1], files) + " (at "
            + mm_text(heights[s - 1]) + ") and " + slice_name(slices[s], files) + " (at " + mm_text(heights[s]) + ")";
        const double steps = std::round(gap / usual);
        constexpr double kWhole = 0.05;
        if (steps < 2.0 || std::abs(gap / usual - steps) > kWhole)
            return text;
        constexpr double kShown = 3.0;
        text += ", probably missing: " + mm_text(steps - 1.0) + (steps > 2.0 ? " slices at" : " slice at");
        for (double m = 1.0; m < steps && m <= kShown; m += 1.0)
            text += (m > 1.0 ? ", " : " ") + mm_text(heights[s - 1] + m * usual);
        return text + (steps - 1.0 > kShown ? " ..." : "");
    }

    /// Returns the largest distance of a slice from its evenly spaced place (mm).
    /// @throws InputError for gaps that the rounding of positions does not explain.
    double check_gaps(
        const std::vector<DicomSlice>& slices, const std::vector<double>& heights, const std::vector<DicomFile>& files)
    {
        constexpr double kGapTolerance = 0.1; // relative to the usual gap
        constexpr double kRounding = 0.06; // mm; some positions have one decimal
        const double usual = usual_gap(heights);
        const double spacing = (heights.back() - heights.front()) / static_cast<double>(heights.size() - 1);
        double rounding = 0.0;
        std::vector<std::size_t> uneven;
        for (std::size_t s = 1; s < heights.size(); ++s) {
            rounding = std::max(rounding, std::abs(heights[s] - heights.front() - spacing * static_cast<double>(s)));
            if (std::abs(heights[s] - heights[s - 1] - usual) > kGapTolerance * usual)
                uneven.push_back(s);
        }
        if (uneven.empty() && rounding <= std::min(kRounding, kGapTolerance * spacing))
            return rounding;
        if (uneven.empty()) // the gaps change slowly, so the message names the two most different gaps
            for (std::size_t s = 1; s < heights.size(); ++s)
                if (std::abs(heights[s] - heights[s - 1] - usual) > 0.01 * usual)
                    uneven.push_back(s);
        constexpr std::size_t kShown = 4;
        std::string text
            = "uneven gaps between slices, usually " + mm_text(usual) + " mm (positions along the normal):";
        for (std::size_t u = 0; u < std::min(uneven.size(), kShown); ++u)
            text += (u > 0 ? "; " : " ") + gap_text(slices, heights, files, uneven[u], usual);
        if (uneven.size() > kShown)
            text += "; and " + std::to_string(uneven.size() - kShown) + " more gaps";
        if (uneven.empty())
            text += " slices lie up to " + mm_text(rounding) + " mm from their even places";
        refuse(text, slices[uneven.empty() ? 0 : uneven.front()], files, "ImagePositionPatient (0020,0032)");
    }

    /// Shift of each slice against the first slice, in the plane of the image (mm along row and column).
    std::vector<Eigen::Vector2d> shifts_of(const std::vector<DicomSlice>& slices, const Mat3& axes)
    {
        std::vector<Eigen::Vector2d> shifts;
        for (const DicomSlice& slice : slices)
            shifts.push_back((axes.transpose() * (slice.position - slices.front().position)).head<2>());
        return shifts;
    }

    void check_tilt(DicomArrangement& stack, const std::vector<double>& heights, const std::vector<DicomFile>& files,
        bool rectify_tilt)
    {
        const auto& slices = stack.slices;
        const std::vector<Eigen::Vector2d> shifts = shifts_of(slices, stack.grid.direction);
        const double last = static_cast<double>(shifts.size() - 1);
        const double pixel = stack.grid.spacing.head<2>().minCoeff();
        const double tolerance = 0.1 * pixel; // a shift that nobody can see
        const auto farthest = std::max_element(shifts.begin(), shifts.end(),
            [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.squaredNorm() < b.squaredNorm(); });
        if (farthest->norm() <= tolerance)
            return;
        for (std::size_t s = 1; s < shifts.size(); ++s) {
            const Eigen::Vector2d even = shifts.back() * (static_cast<double>(s) / last);
            if ((shifts[s] - even).norm() > tolerance)
                refuse("slices shifted against each other unevenly: " + slice_name(slices[s], files) + " (at "
                        + mm_text(heights[s]) + " mm along the normal) lies " + mm_text((shifts[s] - even).norm())
                        + " mm aside",
                    slices[s], files, "ImagePositionPatient (0020,0032)");
        }
        const double height = heights.back() - heights.front();
        stack.tilt_degrees = std::atan2(shifts.back().norm(), height) / kDegree;
        constexpr double kMostTilt = 40.0; // degrees; gantries tilt up to 30
        const std::string angle = mm_text(std::round(stack.tilt_degrees * 100.0) / 100.0) + " degrees";
        if (stack.tilt_degrees > kMostTilt)
            refuse("slices shifted aside by " + angle + ", more than a gantry tilts, from "
                    + slice_name(slices.front(), files) + " (at " + mm_text(heights.front())
                    + " mm along the normal) to " + slice_name(slices.back(), files) + " (at " + mm_text(heights.back())
                    + ")",
                slices.back(), files, "ImagePositionPatient (0020,0032)");
        if (!rectify_tilt)
            refuse("a tilted gantry, " + angle + ": slices shifted aside by " + mm_text(shifts.back().norm())
                    + " mm from " + slice_name(slices.front(), files) + " (at " + mm_text(heights.front())
                    + " mm along the normal) to " + slice_name(slices.back(), files) + " (at " + mm_text(heights.back())
                    + "); let it be straightened, or resample the series first",
                slices.back(), files, "ImagePositionPatient (0020,0032)");
        for (int a = 0; a < 2; ++a)
            stack.shift[static_cast<std::size_t>(a)] = shifts.back()[a] / last / stack.grid.spacing[a];
    }

    /// Enlarges the grid by whole pixels, so that every shifted slice fits.
    void grow_for_tilt(DicomArrangement& stack)
    {
        for (std::size_t a = 0; a < 2; ++a) {
            constexpr double kRoundOff = 1e-6; // pixels
            const double total = stack.shift[a] * static_cast<double>(stack.slices.size() - 1);
            const int low = static_cast<int>(std::floor(std::min(total, 0.0) + kRoundOff));
            const int high = static_cast<int>(std::ceil(std::max(total, 0.0) - kRoundOff));
            stack.first[a] = low;
            stack.grid.size[a] += high - low;
            const auto axis = static_cast<Eigen::Index>(a);
            stack.grid.origin += stack.grid.direction.col(axis) * (low * stack.grid.spacing[axis]);
        }
    }

} // namespace

bool is_axial(const DicomFrame& frame)
{
    if (frame.orientation.size() != 6)
        return false;
    const Vec3 row(frame.orientation[0], frame.orientation[1], frame.orientation[2]);
    const Vec3 column(frame.orientation[3], frame.orientation[4], frame.orientation[5]);
    const Vec3 normal = row.cross(column);
    return std::abs(normal.z()) >= std::cos(45.0 * kDegree) * normal.norm() && normal.norm() > 0.0;
}

DicomArrangement arrange_dicom(std::vector<DicomSlice> slices, const std::vector<DicomFile>& files, bool rectify_tilt)
{
    check_alike(slices, files);
    const Vec3 row = slices.front().row.normalized();
    const Vec3 column = (slices.front().column - slices.front().column.dot(row) * row).normalized();
    const Vec3 normal = row.cross(column);
    std::stable_sort(slices.begin(), slices.end(),
        [&](const DicomSlice& a, const DicomSlice& b) { return a.position.dot(normal) < b.position.dot(normal); });
    std::vector<double> heights;
    for (const DicomSlice& slice : slices)
        heights.push_back(slice.position.dot(normal));
    check_places(slices, heights, files);

    DicomArrangement stack;
    const DicomSlice& first = slices.front();
    if (slices.size() == 1 && !(first.thickness > 0.0))
        refuse("a single slice needs a positive slice thickness", first, files, "SliceThickness (0018,0050)");
    double spacing = first.thickness;
    if (slices.size() > 1) {
        stack.rounding = check_gaps(slices, heights, files);
        spacing = (heights.back() - heights.front()) / static_cast<double>(slices.size() - 1);
    }
    const DicomFile& file = files[first.file];
    stack.grid.size
        = { static_cast<int>(file.columns[0]), static_cast<int>(file.rows[0]), static_cast<int>(slices.size()) };
    stack.grid.spacing = { first.column_spacing, first.row_spacing, spacing };
    stack.grid.origin = first.position;
    stack.grid.direction << row, column, normal;
    stack.slices = std::move(slices);
    if (stack.slices.size() > 1) {
        check_tilt(stack, heights, files, rectify_tilt);
        grow_for_tilt(stack);
    }
    mesh::check_grid(stack.grid);
    return stack;
}

} // namespace retractor::datasets
