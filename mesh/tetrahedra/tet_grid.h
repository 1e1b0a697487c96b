#pragma once
// Which elements are near a box: a uniform grid of cells that follows a mesh while it is cut, so that finding the
// elements under a blade costs what the blade is long, not what the mesh is large. Units mm.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace retractor::mesh {

class TetGrid {
public:
    TetGrid() = default;
    /// @param cell edge of a cell (mm): about two edges of the mesh.
    TetGrid(const Eigen::AlignedBox3d& box, double cell);

    /// Also after the element has moved: it is listed where it is now.
    void insert(TetId t, const Eigen::AlignedBox3d& box);
    void remove(TetId t);
    /// Appends every element listed in a cell that the box touches; one may come several times.
    void gather(const Eigen::AlignedBox3d& box, std::vector<TetId>& out) const;
    std::size_t bytes() const; ///< memory

private:
    using Range = std::array<std::int16_t, 6>; ///< first and last cell per axis; first > last: not listed
    Range range(const Eigen::AlignedBox3d& box) const;
    template <class Visit> void for_cells(const Range& range, Visit&& visit) const;

    Vec3 origin_ = Vec3::Zero();
    double cell_ = 1.0;
    std::array<int, 3> size_ { 1, 1, 1 };
    std::vector<std::vector<TetId>> cells_ { 1 };
    std::vector<Range> listed_; ///< per element
};

} // namespace retractor::mesh
