#pragma once
// The shared words for points and triangle surfaces. Units mm; frame: patient LPS unless said otherwise.

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace retractor {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// n x 3, one point contiguous: the layout VTK and Embree read too.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

using VertexId = std::int32_t;
using TetId = std::int32_t;
/// What a voxel or an element is made of: an index into a LabelTable. 0 is "nothing".
using Label = std::uint16_t;

inline Vec3 point_at(const Points& points, VertexId v) { return points.row(v).transpose(); }

/// Triangles over a point set, counter-clockwise seen from outside.
struct TriMesh {
    Points vertices;
    std::vector<std::array<VertexId, 3>> triangles;
    std::vector<Label> labels; ///< one per triangle, or empty
};

} // namespace retractor
