#pragma once
// An organ's surface filled with equal spheres on a face-centred lattice [Suzuki et al., "Performing virtual surgery
// with a force feedback system"]. Units mm.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::haptics {

struct SphereFilling {
    double radius = 0.0; ///< of every sphere
    /// How far a sphere answers for its organ: a lattice leaves gaps under the surface, so that the outer ones reach to
    /// it, by at most 2.5 radii; inner ones their radius.
    std::vector<double> reach;
    Points centres; ///< n x 3, in the lattice's order
    /// The spheres that touch sphere i, at most twelve: neighbours[first[i]] ... neighbours[first[i + 1] - 1], rising.
    std::vector<std::int32_t> first, neighbours;

    std::size_t count() const { return static_cast<std::size_t>(centres.rows()); }
    std::span<const std::int32_t> of(std::size_t i) const
    {
        return { neighbours.data() + first[i], neighbours.data() + first[i + 1] };
    }
};

/// Every sphere lies inside the surface, wholly. The lattice starts at the middle of the surface's box.
/// @throws InputError as SurfaceLocator, on a radius that is not positive or so small that more than kMostSpheres would
/// fit, and when not one does.
SphereFilling fill_with_spheres(const TriMesh& surface, double radius);

/// The radius that gives nearest to `wanted` spheres: within `tolerance` of it (a lattice gives whole layers at once).
/// @throws InputError as above, on a count out of 1 to kMostSpheres, and when no radius comes so near, saying which
/// did.
SphereFilling fill_with_count(const TriMesh& surface, std::size_t wanted, double tolerance = 0.01);

inline constexpr std::size_t kMostSpheres = 1'000'000;

} // namespace retractor::haptics
