#include "mesh/generation/mesh_forecast.h"

#include <algorithm>
#include <cmath>

namespace retractor::mesh {

double expected_tetrahedra(const LabelField& field, const SizeField& size)
{
    // A regular tetrahedron has a volume of 0.118 edge^3. Edges come out shorter than asked, since every interface
    // needs vertices of its own; measured on meshes of the phantoms and the chest.
    constexpr double kVolumeOfUnitEdge = 0.09;
    constexpr double kMostSamples = 300'000.0; // a second of time, and an error of a few percent
    const WallVoxels& wall = field.wall();
    const double voxels = static_cast<double>(wall.size[0]) * wall.size[1] * wall.size[2];
    const int stride = std::max(1, static_cast<int>(std::ceil(std::cbrt(voxels / kMostSamples))));
    const double volume = wall.spacing.prod() * std::pow(stride, 3);
    double count = 0.0;
    for (int k = stride / 2; k < wall.size[2]; k += stride)
        for (int j = stride / 2; j < wall.size[1]; j += stride)
            for (int i = stride / 2; i < wall.size[0]; i += stride) {
                const Vec3 centre = wall.centre(i, j, k);
                const int number = wall.voxels[wall.offset(i, j, k)] != 0 ? field.at(centre) : 0;
                if (number != 0)
                    count += volume / (kVolumeOfUnitEdge * std::pow(size.edge(centre, number), 3));
            }
    return count;
}

} // namespace retractor::mesh
