#pragma once
// Finds values by their position: a hash of cubic cells. Only occupied cells take memory, so that the points may lie
// far apart. Units mm, or the unit of the points.

#include "mesh/base/assert.h"
#include "mesh/base/geometry.h"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace retractor {

template <class Value> class SpatialHash {
public:
    /// @param cell edge of a cell (> 0), about the usual search distance
    explicit SpatialHash(double cell)
        : cell_(cell)
    {
        RETRACTOR_ASSERT(cell > 0.0);
    }

    /// @pre the point lies within 2^20 cells of the origin along each axis
    void add(const Vec3& point, Value value) { cells_[key(cell_of(point))].push_back(std::move(value)); }

    /// Calls visit(value) for every value in the cells round the point's cell, up to `distance` rounded up to whole
    /// cells along each axis. The visit includes all values within the distance and some beyond. The visit stops when
    /// visit returns false.
    /// @return true when no call returned false
    template <class Visit> bool visit_near(const Vec3& point, double distance, Visit&& visit) const
    {
        const auto reach = static_cast<std::int64_t>(std::ceil(distance / cell_));
        const Cell c = cell_of(point);
        for (std::int64_t z = -reach; z <= reach; ++z)
            for (std::int64_t y = -reach; y <= reach; ++y)
                for (std::int64_t x = -reach; x <= reach; ++x)
                    if (const auto found = cells_.find(key(c + Cell(x, y, z))); found != cells_.end())
                        for (const Value& value : found->second)
                            if (!visit(value))
                                return false;
        return true;
    }

private:
    using Cell = Eigen::Array<std::int64_t, 3, 1>;
    Cell cell_of(const Vec3& point) const { return (point.array() / cell_).floor().template cast<std::int64_t>(); }
    static std::int64_t key(const Cell& c)
    {
        constexpr std::int64_t kBias = 1 << 20;
        return ((c[0] + kBias) << 42) + ((c[1] + kBias) << 21) + (c[2] + kBias);
    }

    double cell_;
    std::unordered_map<std::int64_t, std::vector<Value>> cells_;
};

} // namespace retractor
