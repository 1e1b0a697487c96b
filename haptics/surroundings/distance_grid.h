#pragma once
// Distances from surfaces on a regular grid, for questions at every millisecond. Units mm.
//
// ITK has a distance transform of images. haptics does without ITK, and needs the nearest triangle's surface, too.
// Method: exact distances at the grid points next to each triangle, carried from point to point in eight sweeps along
// the axes, each with the nearest triangle of its neighbour (Danielsson 1980, doi 10.1016/0146-664X(80)90054-4).
// Error: carried distances may be a little too large, by less than a step. Between grid points the distance is linear,
// which is too large near a surface: by half a step at a plane, by 0.71 at an edge, by 0.87 at a corner at most.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "mesh/surface/named_surface.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::haptics {

class DistanceGrid {
public:
    /// @param box where distances are known
    /// @param farthest_mm larger distances are not told apart
    /// @throws InputError on a box or a step that is not positive, and on a triangle with a vertex out of range;
    /// SolverError "cancelled" with a cancelled job
    DistanceGrid(const std::vector<mesh::NamedSurface>& surfaces, const Eigen::AlignedBox3d& box, double step_mm,
        double farthest_mm, const Job& job = {});

    /// Distance from the nearest surface, at most farthest_mm(), which also holds outside the box. Allocates nothing.
    [[nodiscard]] double distance(const Vec3& at) const noexcept;
    /// Unit vector away from the nearest surface; zero where no surface is near. Allocates nothing.
    [[nodiscard]] Vec3 away(const Vec3& at) const noexcept;
    static constexpr int kNone = -1;
    /// Number of the nearest surface; kNone where none is near. Allocates nothing.
    [[nodiscard]] int nearest(const Vec3& at) const noexcept;
    [[nodiscard]] double farthest_mm() const noexcept { return farthest_; }
    [[nodiscard]] Eigen::AlignedBox3d box() const noexcept;
    /// Whether distances are known at a place.
    [[nodiscard]] bool contains(const Vec3& at) const noexcept;
    [[nodiscard]] const std::vector<std::string>& names() const noexcept { return names_; }

private:
    [[nodiscard]] std::size_t index(int x, int y, int z) const noexcept
    {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y))
            * static_cast<std::size_t>(size_[0])
            + static_cast<std::size_t>(x);
    }

    std::vector<std::string> names_;
    Vec3 origin_;
    double step_, farthest_;
    std::array<int, 3> size_ {};
    std::vector<float> distance_;
    std::vector<std::int16_t> surface_; ///< kNone: none is near
};

} // namespace retractor::haptics
