#pragma once
// A press computed by finite elements: the reference for springs and spheres. Units mm, N, MPa.

#include "fem/material/material.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::benchmarks {

/// A body on its support. A patch of its surface, bonded to a punch, is pressed in.
struct PunchProblem {
    mesh::TetMesh mesh; ///< four-node elements, one label (1)
    fem::Material material;
    std::vector<VertexId> fixed; ///< fixed corner vertices
    Vec3 centre = Vec3::Zero(); ///< centre of the patch on the surface, mm
    double radius = 5.0; ///< radius of the patch, mm: surface vertices within this distance of `centre` are pressed
    Vec3 press = Vec3::Zero(); ///< displacement of the patch, mm
};

struct PunchAnswer {
    double force = 0.0; ///< force against the press, N
    std::size_t nodes = 0, patch = 0;
    double seconds = 0.0;
};

/// The surface vertices that are pressed, sorted.
/// @throws InputError when there are none.
std::vector<VertexId> punch_patch(const PunchProblem& problem);

/// The force of a press by linear elasticity.
/// @param quadratic uses ten-node elements. A midpoint between two fixed or two pressed corners is fixed or pressed
/// too.
/// @throws as EquilibriumSolver::solve().
PunchAnswer punch_by_elements(const PunchProblem& problem, bool quadratic, const Job& job);

/// A block that is fixed at its bottom and pressed at the middle of its top: cubes of `spacing`, each split into six
/// elements.
PunchProblem punched_block(int across, int high, double spacing, double depth, const fem::Material& material);

} // namespace retractor::benchmarks
