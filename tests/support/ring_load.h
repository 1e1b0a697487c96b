#pragma once
// A load on a sheet of springs that is spread over a particle and its neighbours.

#include "haptics/springs/spring_motion.h"

#include <cstddef>
#include <vector>

namespace retractor::test_support {

/// A steady force, N, shared evenly by the particle and the particles one structural spring (its shortest) away, as in
/// figs 15 and 16 of Tang and others (2020, doi 10.1016/j.cmpb.2020.105344). @returns how many share it.
/// @throws InputError as SpringMotion::set_load() does.
inline std::size_t set_ring_load(haptics::SpringMotion& motion, VertexId v, const Vec3& force)
{
    const std::vector<VertexId> around = motion.ring(v);
    const double share = 1.0 / static_cast<double>(around.size() + 1);
    motion.set_load(v, share * force);
    for (const VertexId other : around)
        motion.set_load(other, share * force);
    return around.size() + 1;
}

} // namespace retractor::test_support
