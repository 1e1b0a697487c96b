#pragma once
// A load on a sheet of springs that is spread over a particle and its neighbours.

#include "haptics/springs/spring_motion.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace retractor::test_support {

/// The particles about one shortest spring from v, in rising order.
inline std::vector<VertexId> ring(const haptics::SpringBody& body, VertexId v)
{
    double shortest = std::numeric_limits<double>::infinity();
    for (const haptics::TissueSpring& spring : body.springs)
        if (spring.a == v || spring.b == v)
            shortest = std::min(shortest, spring.length);
    constexpr double kRing = 1.5; // as for the grips of haptics/springs/spring_tissue.cpp
    std::vector<VertexId> found;
    for (const haptics::TissueSpring& spring : body.springs)
        if ((spring.a == v || spring.b == v) && spring.length < kRing * shortest)
            found.push_back(spring.a == v ? spring.b : spring.a);
    std::sort(found.begin(), found.end());
    return found;
}

/// A steady force, N, shared evenly by the particle and the particles one structural spring (its shortest) away, as in
/// figs 15 and 16 of Tang and others (2020, doi 10.1016/j.cmpb.2020.105344). @returns how many share it.
/// @throws InputError as SpringMotion::set_load() does.
inline std::size_t set_ring_load(haptics::SpringMotion& motion, VertexId v, const Vec3& force)
{
    const std::vector<VertexId> around = ring(motion.body(), v);
    const double share = 1.0 / static_cast<double>(around.size() + 1);
    motion.set_load(v, share * force);
    for (const VertexId other : around)
        motion.set_load(other, share * force);
    return around.size() + 1;
}

} // namespace retractor::test_support
