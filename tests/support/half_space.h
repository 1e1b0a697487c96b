#pragma once
// The condensed contact on a body whose answer is known: a rigid punch or sphere on an elastic half-space [validation:
// flat punch F = 2 a E* d; Sneddon 1965]. A quarter of a block that reaches 100 contact radii (a block stiffens the
// answer by about 1.3 contact radii over its depth), graded towards the edge of the contact, with the same stations,
// columns and contact solver as the tissue. Units mm, N, MPa.

#include "haptics/condensed/contact_node_compliance.h"
#include "mesh/base/job.h"

#include <functional>
#include <memory>

namespace retractor::test_support {

class HalfSpace {
public:
    /// @param radius of the contact, about which the mesh is graded. @param fineness 1: some 7,000 nodes.
    HalfSpace(double radius, double youngs_modulus, double poissons_ratio, int fineness = 1, const Job& job = {});
    ~HalfSpace();

    struct Answer {
        double force = 0.0; ///< on the indenter
        double contact_radius = 0.0; ///< of the farthest point that presses
    };
    /// @param depth_at how far the indenter stands below the surface at a distance from its axis; negative: above.
    Answer press(const std::function<double(double)>& depth_at) const;
    std::size_t node_count() const { return mesh_.vertex_count(); }

private:
    mesh::TetMesh mesh_;
    std::unique_ptr<haptics::TouchSurface> surface_;
    std::unique_ptr<haptics::ContactNodeCompliance> body_;
    std::vector<std::int32_t> near_; ///< stations that may press
};

/// F = 2 a E* d. E* = E / (1 - nu^2)
double flat_punch_force(double a, double depth, double youngs_modulus, double poissons_ratio);

} // namespace retractor::test_support
