#pragma once
// Finds the triangle of a moving surface that is nearest to a point and looks towards it, for contact in fem: a
// hierarchy of axis-aligned bounding boxes that is built once, and refitted where the surface moves [van den Bergen
// 1997, doi 10.1080/10867651.1997.10487480]. Beside the box of its triangles each node has the box of their normals,
// so that the surface round a point itself, which looks the same way, is left out early. Units mm.

#include "mesh/base/geometry.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace retractor::mesh {

class TriangleHierarchy {
public:
    /// @param vertices the places by which the triangles are grouped; also their first places
    /// @pre corners are within range
    TriangleHierarchy(const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles);

    /// Moves the surface. Linear in the number of triangles.
    /// @param vertices finite, as many as before
    void refit(const Points& vertices);

    struct Found {
        std::int32_t triangle = 0;
        double distance = 0.0; ///< mm
    };
    struct Query {
        Vec3 point; ///< finite
        double distance = 0.0; ///< mm: only triangles that are at most this far away
        Vec3 direction; ///< only triangles whose unit normal has a cosine below `cosine` with this unit vector
        double cosine = 0.0;
    };
    /// The nearest triangle that `accept` takes; at equal distance that with the lower number. `accept` is asked only
    /// for triangles that are nearer than all it has taken before.
    std::optional<Found> nearest(const Query& query, const std::function<bool(std::int32_t)>& accept) const;

private:
    struct Bounds {
        Vec3 low, high; ///< mm
        Vec3 normal_low, normal_high;
    };
    /// Children follow their parents. A leaf has no children.
    struct Node {
        std::int32_t begin = 0, end = 0; ///< positions in `order_`
        std::int32_t children = -1; ///< the first of two successive nodes
    };
    void fit(std::size_t node);

    std::vector<std::array<VertexId, 3>> triangles_; ///< in the order of the leaves
    std::vector<std::int32_t> order_; ///< number of each triangle
    std::vector<std::array<Vec3, 3>> corners_; ///< at the present places, in the order of the leaves
    std::vector<Vec3> normals_; ///< unit, or zero for a triangle without area
    std::vector<Node> nodes_;
    std::vector<Bounds> bounds_; ///< of each node
};

} // namespace retractor::mesh
