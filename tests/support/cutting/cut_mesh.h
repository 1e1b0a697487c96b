#pragma once
// Cuts a mesh once, without a session of the caller.

#include "mesh/cutting/cut_session.h"

#include <string>
#include <utility>
#include <vector>

namespace retractor::test_support {

struct [[nodiscard]] CutMesh {
    mesh::CutStatus status = mesh::CutStatus::done;
    std::string message; ///< remarks for the user; may be empty
    mesh::TetMesh mesh;
    std::vector<mesh::LipFace> lips; ///< ids of `mesh`
    mesh::CutReport report;
};

/// @throws InputError and SolverError as CutSession and CutSession::cut()
inline CutMesh cut(const mesh::TetMesh& mesh, const mesh::Blade& blade, const mesh::CutOptions& options = {})
{
    mesh::CutSession session(mesh);
    const mesh::CutResult result = session.cut(blade, options);
    mesh::SlotMap map;
    CutMesh out { result.status, result.message, session.compact_mesh(&map), session.lips(), result.report };
    for (mesh::LipFace& lip : out.lips)
        lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
    return out;
}

} // namespace retractor::test_support
