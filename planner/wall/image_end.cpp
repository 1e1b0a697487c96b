#include "planner/wall/image_end.h"

#include "mesh/image/plane_holes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr int kBorderVoxels = 3;

    /// One slice of the labels across an axis, as a mask of the labelled voxels and what they enclose.
    struct Slice {
        int across = 2; ///< axis, and its position
        int at = 0;
        std::array<int, 2> axes { 0, 1 }; ///< of the plane
        std::vector<std::uint8_t> mask;
    };

    Slice slice_of(const mesh::LabelVolume& labels, int across, int at)
    {
        Slice slice { .across = across, .at = at, .axes = { (across + 1) % 3, (across + 2) % 3 }, .mask = {} };
        const auto& size = labels.grid.size;
        const int columns = size[static_cast<std::size_t>(slice.axes[0])];
        const int rows = size[static_cast<std::size_t>(slice.axes[1])];
        std::array<int, 3> index { 0, 0, 0 };
        index[static_cast<std::size_t>(across)] = at;
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column) {
                index[static_cast<std::size_t>(slice.axes[0])] = column;
                index[static_cast<std::size_t>(slice.axes[1])] = row;
                const Label label = labels.voxels[labels.grid.offset(index[0], index[1], index[2])];
                slice.mask.push_back(label != 0 ? 1 : 0);
            }
        slice.mask = mesh::holes_filled_in_planes({ columns, rows, 1 }, slice.mask, 2);
        return slice;
    }

    /// Whether the body ends at a slice because it grows thin there, and not because the image cuts it off.
    bool ends_by_itself(const Slice& outermost, const Slice& further_in)
    {
        constexpr std::ptrdiff_t kShrinks = 2;
        const auto area = [](const Slice& slice) { return std::count(slice.mask.begin(), slice.mask.end(), 1); };
        return kShrinks * area(outermost) < area(further_in);
    }

    /// The mask with a margin, blurred over a voxel to each side, so that its outline is no staircase. The
    /// level kOutline stays at straight edges.
    struct Smoothed {
        int columns = 0, rows = 0;
        std::vector<double> values;
        double at(int column, int row) const
        {
            return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns)
                + static_cast<std::size_t>(column)];
        }
    };
    constexpr double kOutline = 0.5;

    Smoothed smoothed(const Slice& slice, int columns, int rows)
    {
        constexpr int kMargin = 2;
        Smoothed wide { columns + 2 * kMargin, rows + 2 * kMargin, {} };
        wide.values.assign(static_cast<std::size_t>(wide.columns) * static_cast<std::size_t>(wide.rows), 0.0);
        const auto index = [&](int column, int row) {
            return static_cast<std::size_t>(row) * static_cast<std::size_t>(wide.columns)
                + static_cast<std::size_t>(column);
        };
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column)
                wide.values[index(column + kMargin, row + kMargin)]
                    = slice.mask[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns)
                        + static_cast<std::size_t>(column)];
        for (const bool along_rows : { true, false }) {
            const std::vector<double> before = wide.values;
            const std::size_t step = along_rows ? 1 : static_cast<std::size_t>(wide.columns);
            for (int row = 1; row + 1 < wide.rows; ++row)
                for (int column = 1; column + 1 < wide.columns; ++column) {
                    const std::size_t n = index(column, row);
                    wide.values[n] = 0.25 * before[n - step] + 0.5 * before[n] + 0.25 * before[n + step];
                }
        }
        return wide;
    }

    /// The part of a cell between four values that lies within the outline, as a polygon (marching squares; of a
    /// saddle, the corners hang together). @param corner places and values, in order round the cell
    std::vector<std::array<double, 2>> part_within(const std::array<std::array<double, 3>, 4>& corner)
    {
        std::vector<std::array<double, 2>> polygon;
        for (std::size_t n = 0; n < corner.size(); ++n) {
            const auto &a = corner.at(n), &b = corner.at((n + 1) % corner.size());
            const bool a_in = a[2] >= kOutline, b_in = b[2] >= kOutline;
            if (a_in)
                polygon.push_back({ a[0], a[1] });
            if (a_in != b_in) {
                const double t = (kOutline - a[2]) / (b[2] - a[2]);
                polygon.push_back({ a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]) });
            }
        }
        return polygon;
    }

    /// Adds what lies within the slice's smoothed outline: a rectangle for each run of whole cells, and the parts of
    /// cells at the outline. @param outside_at coordinate across the slice, voxels
    void add_faces(const mesh::ImageGrid& grid, const Slice& slice, double outside_at, std::vector<Vec3>& places,
        std::vector<std::array<VertexId, 3>>& triangles)
    {
        const int columns = grid.size[static_cast<std::size_t>(slice.axes[0])];
        const int rows = grid.size[static_cast<std::size_t>(slice.axes[1])];
        const Smoothed mask = smoothed(slice, columns, rows);
        const int margin = (mask.columns - columns) / 2;
        const auto add = [&](const std::vector<std::array<double, 2>>& polygon) {
            const auto first = static_cast<VertexId>(places.size());
            for (const auto& [column, row] : polygon) {
                Vec3 index;
                index[slice.across] = outside_at;
                index[slice.axes[0]] = column - margin;
                index[slice.axes[1]] = row - margin;
                places.push_back(grid.world(index));
            }
            for (VertexId n = 2; n < static_cast<VertexId>(polygon.size()); ++n)
                triangles.push_back({ first, first + n - 1, first + n });
        };
        for (int row = 0; row + 1 < mask.rows; ++row) {
            const auto whole = [&](int column) {
                return mask.at(column, row) >= kOutline && mask.at(column + 1, row) >= kOutline
                    && mask.at(column, row + 1) >= kOutline && mask.at(column + 1, row + 1) >= kOutline;
            };
            for (int column = 0; column + 1 < mask.columns;) {
                int end = column;
                while (end + 1 < mask.columns && whole(end))
                    ++end;
                const double low = row, high = row + 1;
                if (end > column) {
                    const double from = column, to = end;
                    add({ { from, low }, { to, low }, { to, high }, { from, high } });
                    column = end;
                    continue;
                }
                const double from = column, to = column + 1;
                add(part_within({ { { from, low, mask.at(column, row) }, { to, low, mask.at(column + 1, row) },
                    { to, high, mask.at(column + 1, row + 1) }, { from, high, mask.at(column, row + 1) } } }));
                ++column;
            }
        }
    }

} // namespace

std::vector<ImageEnd> image_ends(const mesh::LabelVolume& labels)
{
    constexpr double kOutsideVoxels = 1.0; // so that organs end before the faces
    std::vector<ImageEnd> ends;
    for (int across = 0; across < 3; ++across) {
        const int count = labels.grid.size[static_cast<std::size_t>(across)];
        for (const bool at_end : { false, true })
            for (int n = 0; n < std::min(kBorderVoxels, count); ++n) {
                const int at = at_end ? count - 1 - n : n;
                const Slice slice = slice_of(labels, across, at);
                if (std::find(slice.mask.begin(), slice.mask.end(), std::uint8_t { 1 }) == slice.mask.end())
                    continue;
                const int further_in = std::clamp(at_end ? at - kBorderVoxels : at + kBorderVoxels, 0, count - 1);
                if (!ends_by_itself(slice, slice_of(labels, across, further_in)))
                    ends.push_back({ .across = across,
                        .at_end = at_end,
                        .slice = at,
                        .face = at_end ? at + kOutsideVoxels : at - kOutsideVoxels });
                break;
            }
    }
    return ends;
}

TriMesh image_end_faces(const mesh::LabelVolume& labels)
{
    std::vector<Vec3> places;
    TriMesh faces;
    for (const ImageEnd& end : image_ends(labels))
        add_faces(labels.grid, slice_of(labels, end.across, end.slice), end.face, places, faces.triangles);
    faces.vertices.resize(static_cast<Eigen::Index>(places.size()), 3);
    for (std::size_t v = 0; v < places.size(); ++v)
        faces.vertices.row(static_cast<Eigen::Index>(v)) = places[v].transpose();
    return faces;
}

void keep_within_image(Points& vertices, const mesh::ImageGrid& grid, const std::vector<ImageEnd>& ends)
{
    constexpr double kBehindVoxels = 0.2; // so that the two do not flicker
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        const Vec3 index = grid.index(vertices.row(v).transpose());
        Vec3 within = index;
        for (const ImageEnd& end : ends) {
            double& at = within[end.across];
            at = end.at_end ? std::min(at, end.face - kBehindVoxels) : std::max(at, end.face + kBehindVoxels);
        }
        if (within != index)
            vertices.row(v) = grid.world(within).transpose();
    }
}

} // namespace retractor::planner
