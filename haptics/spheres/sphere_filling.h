#pragma once
// Fills an organ's surface with equal spheres on a face-centred lattice (Suzuki et al., "Performing virtual surgery
// with a force feedback system", ICAT). Units mm.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::haptics {

struct SphereFilling {
    double radius = 0.0; ///< radius of every sphere, mm
    /// Distance to which each sphere represents its organ, mm. A lattice leaves gaps under the surface, so outer
    /// spheres reach up to the surface, by at most 2.5 radii; inner spheres reach one radius.
    std::vector<double> reach;
    Points centres; ///< n x 3, in the order of the lattice, mm
    /// The neighbours of sphere i are the spheres that touch it, at most twelve: neighbours[first[i]] ...
    /// neighbours[first[i + 1] - 1], in rising order.
    std::vector<std::int32_t> first, neighbours;

    std::size_t count() const { return static_cast<std::size_t>(centres.rows()); }
    std::span<const std::int32_t> of(std::size_t i) const
    {
        return { neighbours.data() + first[i], neighbours.data() + first[i + 1] };
    }
};

/// Fills the surface with spheres that lie wholly inside. The lattice starts at the middle of the surface's box.
/// @throws InputError as SurfaceLocator, on a radius that is not positive or that would give more than kMostSpheres,
/// and when no sphere fits
SphereFilling fill_with_spheres(const TriMesh& surface, double radius);

/// Finds the radius whose sphere count is nearest to `wanted`, within the relative `tolerance` (a lattice adds whole
/// layers at once).
/// @throws InputError as fill_with_spheres(), on a count outside 1 to kMostSpheres, and when no radius is within the
/// tolerance, naming the radius that comes nearest
SphereFilling fill_with_count(const TriMesh& surface, std::size_t wanted, double tolerance = 0.01);

inline constexpr std::size_t kMostSpheres = 1'000'000;

} // namespace retractor::haptics
