#pragma once
// The visible state of a cutting session, for bit-for-bit comparison, and random operations on a session.

#include "mesh/cutting/cut_session.h"

#include <Eigen/Geometry>

#include <random>
#include <vector>

namespace retractor::test_support {

struct SessionState {
    explicit SessionState(const mesh::CutSession& session);
    bool operator==(const SessionState& other) const;

    mesh::SlotMap map; // declared before the mesh, whose initialisation fills the map
    mesh::TetMesh mesh;
    std::vector<TetId> origins;
    std::vector<mesh::LipFace> lips; ///< ids of the session
    std::size_t cuts = 0;
    bool redo = false, stroke = false;
};

/// A box of elements in three layers along z, labels 1 to 3 from below.
mesh::TetMesh three_layers(int nx, int ny, int nz, double spacing);

/// A random blade from above that runs through or past a box of this extent (mm).
mesh::Blade random_stroke(std::mt19937& random, const Vec3& extent);

/// Elements with their centroid in the box.
inline std::vector<TetId> elements_in(const mesh::CutSession& session, const Eigen::AlignedBox3d& box)
{
    std::vector<TetId> inside;
    for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t) {
        if (!session.has_tet(t))
            continue;
        Vec3 centroid = Vec3::Zero();
        for (const VertexId v : session.tet(t).nodes)
            centroid += 0.25 * session.position(v);
        if (box.contains(centroid))
            inside.push_back(t);
    }
    return inside;
}

/// Elements in a ball of this radius (mm) round a random point.
std::vector<TetId> random_marks(
    std::mt19937& random, const mesh::CutSession& session, const Vec3& extent, double radius);

} // namespace retractor::test_support
