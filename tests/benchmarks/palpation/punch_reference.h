#pragma once
// What finite elements say of a press: the answer that springs and spheres are measured against. Units mm, N, MPa.

#include "fem/material/material.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::benchmarks {

/// A body on its support, pressed in by a bonded patch of its surface.
struct PunchProblem {
    mesh::TetMesh mesh; ///< four-node elements, one label (1)
    fem::Material material;
    std::vector<VertexId> fixed; ///< corners
    Vec3 centre = Vec3::Zero(); ///< of the patch, on the surface
    double radius = 5.0; ///< surface vertices not farther from `centre` are pressed
    Vec3 press = Vec3::Zero(); ///< how far they are moved, mm
};

struct PunchAnswer {
    double force = 0.0; ///< against the press, N
    std::size_t nodes = 0, patch = 0;
    double seconds = 0.0;
};

/// The surface vertices that are pressed, rising. @throws InputError when there are none.
std::vector<VertexId> punch_patch(const PunchProblem& problem);

/// Linear elasticity; with `quadratic` ten-node elements, where midpoints between two fixed or two pressed corners are
/// fixed or pressed too. @throws as EquilibriumSolver::solve().
PunchAnswer punch_by_elements(const PunchProblem& problem, bool quadratic, const Job& job);

/// A block on its bottom, pressed at the middle of its top: cubes of `spacing`, each split into six.
PunchProblem punched_block(int across, int high, double spacing, double depth, const fem::Material& material);

} // namespace retractor::benchmarks
