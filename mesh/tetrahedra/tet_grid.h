#pragma once
// Finds the elements near a box with a uniform grid of cells. The grid follows a mesh while the mesh is cut. The cost
// of finding the elements under a blade grows with the length of the blade, not with the size of the mesh. Units mm.

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
    /// @param box extent of the mesh (mm)
    /// @param cell edge of a cell (mm), about two edges of the mesh
    TetGrid(const Eigen::AlignedBox3d& box, double cell);

    /// Lists an element in the cells that its box touches; a listed element is moved to its new cells.
    void insert(TetId t, const Eigen::AlignedBox3d& box);
    void remove(TetId t);
    /// Appends every element listed in a cell that the box touches. An element may be appended several times.
    void gather(const Eigen::AlignedBox3d& box, std::vector<TetId>& out) const;
    std::size_t bytes() const; ///< memory in use

private:
    using Range = std::array<std::int16_t, 6>; ///< first and last cell per axis; not listed when first > last
    Range range(const Eigen::AlignedBox3d& box) const;
    template <class Visit> void for_cells(const Range& range, Visit&& visit) const;

    Vec3 origin_ = Vec3::Zero();
    double cell_ = 1.0;
    std::array<int, 3> size_ { 1, 1, 1 };
    std::vector<std::vector<TetId>> cells_ { 1 };
    std::vector<Range> listed_; ///< cells of each element
};

} // namespace retractor::mesh
