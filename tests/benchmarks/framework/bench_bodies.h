#pragma once
// The bodies on which the knife is measured, each with its blade.

#include "datasets/phantoms/phantom.h"
#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/case/approach.h"

#include "mesh/base/job.h"

#include <string>
#include <vector>

namespace retractor::benchmarks {

struct BenchBody {
    std::string name;
    mesh::TetMesh mesh;
    mesh::Blade blade; ///< blade whose line has a point at each freehand step of kFreehandStep
    std::vector<Label> uncut_labels; ///< labels that the blade does not sever
    std::vector<Label> skin; ///< labels of the skin, ascending; empty when there is only one tissue
    fem::Supports supports {}; ///< supports of the thorax
    std::vector<fem::Material> materials {}; ///< materials of the thorax, by label
};

inline constexpr double kFreehandStep = 5.0; ///< length of a freehand step, mm

/// Boxes of Kuhn tetrahedra with 4 mm edges, "12k", "96k" and "1M", with a straight blade of 60 x 12 mm. The blade
/// heads 7.3 degrees off the grid, is tilted by 10 degrees, and its middle lies off the box's middle.
BenchBody bench_box(const std::string& name);

/// The smallest box with a blade that is long and deep enough to sever the box. This isolates the subdivision of
/// completely crossed elements, as in table 1 of [Nakao and others 2006, doi 10.1007/s10916-006-9021-4].
BenchBody bench_box_severed();

/// The uncut wall of a phantom round an approach.
struct BenchWall {
    mesh::TetMesh mesh;
    fem::Supports supports;
    std::vector<fem::Material> materials; ///< by label
};
/// @throws SolverError when cancelled.
BenchWall bench_wall(const datasets::Phantom& phantom, const planner::Approach& approach, const Job& job);

/// The thorax phantom's chest wall round its median approach, with elements of 3 mm near the incision and up to 15 mm
/// elsewhere, and the blade of the approach.
/// @throws SolverError when cancelled.
BenchBody bench_thorax(const Job& job);

/// The blade with a line whose points are `step` mm apart, with the end point; directions are interpolated.
mesh::Blade resampled(const mesh::Blade& blade, double step);

/// The blade as drawn by hand: its line swings 4 mm to both sides, and its directions turn by 5 degrees each way.
mesh::Blade drawn_by_hand(const mesh::Blade& blade);

/// The first `points` points of a blade.
mesh::Blade beginning(const mesh::Blade& blade, std::size_t points);

} // namespace retractor::benchmarks
