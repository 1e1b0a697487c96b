#pragma once
// The shared types for points and triangle surfaces. Units mm; frame patient LPS unless a comment names another.

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace retractor {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// Points as rows, n x 3; the coordinates of a point are contiguous, as VTK and Embree expect.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

using VertexId = std::int32_t;
using TetId = std::int32_t;
/// The structure that a voxel or an element belongs to, an id of a LabelTable; 0 means nothing.
using Label = std::uint16_t;

inline Vec3 point_at(const Points& points, VertexId v) { return points.row(v).transpose(); }

/// Triangles over a point set; the corners run counter-clockwise seen from outside.
struct TriMesh {
    Points vertices;
    std::vector<std::array<VertexId, 3>> triangles;
    std::vector<Label> labels; ///< one label per triangle, or empty
};

} // namespace retractor
