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
    constexpr double kOutsideVoxels = 1.0;

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

    /// Adds one rectangle for each run of the mask along a row. @param outside_at coordinate across the slice, voxels
    void add_faces(const mesh::ImageGrid& grid, const Slice& slice, double outside_at, std::vector<Vec3>& corners)
    {
        const int columns = grid.size[static_cast<std::size_t>(slice.axes[0])];
        const int rows = grid.size[static_cast<std::size_t>(slice.axes[1])];
        const auto corner = [&](double column, double row) {
            Vec3 index;
            index[slice.across] = outside_at;
            index[slice.axes[0]] = column - 0.5;
            index[slice.axes[1]] = row - 0.5;
            corners.push_back(grid.world(index));
        };
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns;) {
                const auto first = slice.mask.begin() + static_cast<std::ptrdiff_t>(row) * columns;
                const auto begin = std::find(first + column, first + columns, std::uint8_t { 1 });
                const auto end = std::find(begin, first + columns, std::uint8_t { 0 });
                if (begin == end)
                    break;
                const auto a = static_cast<double>(begin - first), b = static_cast<double>(end - first);
                corner(a, row);
                corner(b, row);
                corner(b, row + 1);
                corner(a, row + 1);
                column = static_cast<int>(end - first);
            }
    }

} // namespace

TriMesh image_end_faces(const mesh::LabelVolume& labels)
{
    std::vector<Vec3> corners;
    for (int across = 0; across < 3; ++across) {
        const int count = labels.grid.size[static_cast<std::size_t>(across)];
        for (const bool at_end : { false, true })
            for (int n = 0; n < std::min(kBorderVoxels, count); ++n) {
                const int at = at_end ? count - 1 - n : n;
                const Slice slice = slice_of(labels, across, at);
                if (std::find(slice.mask.begin(), slice.mask.end(), std::uint8_t { 1 }) == slice.mask.end())
                    continue;
                const int further_in = std::clamp(at_end ? at - kBorderVoxels : at + kBorderVoxels, 0, count - 1);
                if (ends_by_itself(slice, slice_of(labels, across, further_in)))
                    break;
                add_faces(labels.grid, slice, at_end ? at + kOutsideVoxels : at - kOutsideVoxels, corners);
                break;
            }
    }
    TriMesh faces;
    faces.vertices.resize(static_cast<Eigen::Index>(corners.size()), 3);
    for (std::size_t v = 0; v < corners.size(); ++v)
        faces.vertices.row(static_cast<Eigen::Index>(v)) = corners[v].transpose();
    for (VertexId v = 0; v < static_cast<VertexId>(corners.size()); v += 4) {
        faces.triangles.push_back({ v, v + 1, v + 2 });
        faces.triangles.push_back({ v, v + 2, v + 3 });
    }
    return faces;
}

} // namespace retractor::planner
