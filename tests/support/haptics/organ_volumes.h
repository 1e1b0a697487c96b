#pragma once
// The volumes of organs that are filled with spheres.

#include "haptics/spheres/sphere_motion.h"

#include <array>
#include <vector>

namespace retractor::test_support {

struct OrganVolume {
    double rest = 0.0, now = 0.0; ///< volume inside the surface, mm^3
    double error() const { return now / rest - 1.0; }
};

/// One volume per organ.
inline std::vector<OrganVolume> organ_volumes(const haptics::SphereMotion& motion)
{
    Points deformed;
    motion.deform(deformed);
    const TriMesh& surface = motion.surface();
    std::vector<OrganVolume> volumes(motion.organ_count());
    for (std::size_t o = 0; o < volumes.size(); ++o) {
        std::vector<std::array<VertexId, 3>> triangles;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            if (surface.labels[t] == o + 1)
                triangles.push_back(surface.triangles[t]);
        volumes[o]
            = { haptics::enclosed_volume(surface.vertices, triangles), haptics::enclosed_volume(deformed, triangles) };
    }
    return volumes;
}

} // namespace retractor::test_support
