#pragma once
// The bodies that the knife is measured on, and the blade through each.

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
    mesh::Blade blade; ///< drawn in freehand steps of kFreehandStep: its line has a point at each
    std::vector<Label> uncut_labels; ///< what the blade does not sever
    std::vector<Label> skin; ///< ascending; none: there is one tissue only
    fem::Supports supports {}; ///< of the thorax
    std::vector<fem::Material> materials {}; ///< by label, of the thorax
};

inline constexpr double kFreehandStep = 5.0; ///< mm

/// Boxes of Kuhn tetrahedra with 4 mm edges, "12k", "96k" and "1M"; a straight blade of 60 x 12 mm, heading 7.3 degrees
/// off the grid, tilted by 10 degrees, its middle off the box's middle.
BenchBody bench_box(const std::string& name);

/// The smallest box with the same blade, only so long and deep that it severs the box: nothing but the subdivision of
/// elements that are crossed from end to end, which is what the source's table is about.
BenchBody bench_box_severed();

/// A phantom's wall round an approach, not cut.
struct BenchWall {
    mesh::TetMesh mesh;
    fem::Supports supports;
    std::vector<fem::Material> materials; ///< by label
};
/// @throws SolverError when cancelled.
BenchWall bench_wall(const datasets::Phantom& phantom, const planner::Approach& approach, const Job& job);

/// The thorax phantom's chest wall round its median approach: elements of 3 mm near the incision, up to 15 mm
/// elsewhere; the blade of the approach. @throws SolverError when cancelled.
BenchBody bench_thorax(const Job& job);

/// The blade with its line's points `step` mm apart (and its end), directions interpolated between its own.
mesh::Blade resampled(const mesh::Blade& blade, double step);

/// The blade as a hand draws it: its line swings 4 mm to both sides, its directions turn by 5 degrees each way.
mesh::Blade drawn_by_hand(const mesh::Blade& blade);

/// The beginning of a blade: its first `points` points.
mesh::Blade beginning(const mesh::Blade& blade, std::size_t points);

} // namespace retractor::benchmarks
