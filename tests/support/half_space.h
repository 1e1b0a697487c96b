#pragma once
// Verification of the condensed contact on a body with a closed solution: a rigid punch or sphere on an elastic
// half-space (flat punch F = 2 a E* d; Sneddon 1965). The mesh is a quarter of a block that reaches 100 contact radii,
// because a block stiffens the response by about 1.3 contact radii over its depth. The mesh is graded towards the edge
// of the contact. Contact nodes, columns and contact solver are those of the tissue. Units mm, N, MPa.

#include "haptics/condensed/contact_node_compliance.h"
#include "mesh/base/job.h"

#include <functional>
#include <memory>

namespace retractor::test_support {

class HalfSpace {
public:
    /// @param radius radius of the contact, which the mesh is graded about
    /// @param fineness 1 gives about 7,000 nodes
    HalfSpace(double radius, double youngs_modulus, double poissons_ratio, int fineness = 1, const Job& job = {});
    ~HalfSpace();

    struct Answer {
        double force = 0.0; ///< on the indenter, N
        double contact_radius = 0.0; ///< distance of the farthest pressing point from the axis, mm
    };
    /// @param depth_at depth of the indenter below the surface at a distance from its axis, mm; negative: above the
    /// surface
    Answer press(const std::function<double(double)>& depth_at) const;
    std::size_t node_count() const { return mesh_.vertex_count(); }

private:
    mesh::TetMesh mesh_;
    std::unique_ptr<haptics::TouchSurface> surface_;
    std::unique_ptr<haptics::ContactNodeCompliance> body_;
    std::vector<std::int32_t> near_; ///< contact nodes that may press
};

/// Force of a flat punch of radius a, N: F = 2 a E* d with E* = E / (1 - nu^2).
double flat_punch_force(double a, double depth, double youngs_modulus, double poissons_ratio);

} // namespace retractor::test_support
