#pragma once
// The scene of bench.json's open_bench: a box, its planned incision, and hooks on the skin beside it.

#include "fem/interactive/online_opening.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/benchmarks/framework/bench_bodies.h"

#include <string>
#include <vector>

namespace retractor::benchmarks {

inline constexpr int kOpenSceneHooks = 8;

struct OpenScene {
    std::string name;
    mesh::TetMesh mesh; ///< not cut
    mesh::Blade blade; ///< its line has a point at each freehand step
    std::vector<fem::Material> materials; ///< by label
    fem::Supports supports;
    std::vector<fem::OnlineHook> hooks; ///< driven to their full displacement, both sides in turn
    mesh::CutOptions cut {};
};

/// @throws InputError on a name other than 12k, 67k, 96k, 175k.
OpenScene open_scene_of_box(const std::string& name);
/// The thorax phantom's wall (bench_thorax()), all its tissues and supports, and the middle 100 mm of its median
/// incision through the wall, with hooks on the skin. @throws SolverError when cancelled.
OpenScene open_scene_of_thorax(const Job& job);
/// "thorax" or a box.
OpenScene open_scene(const std::string& name, const Job& job);

} // namespace retractor::benchmarks
