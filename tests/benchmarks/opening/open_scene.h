#pragma once
// The scene of the opening benchmarks: a box, its planned incision, and hooks on the skin beside the incision.

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
    mesh::TetMesh mesh; ///< mesh before the cut
    mesh::Blade blade; ///< blade whose line has a point at each freehand step
    std::vector<fem::Material> materials; ///< by label
    fem::Supports supports;
    std::vector<fem::OnlineHook> hooks; ///< hooks with their full displacement, on both sides in turn
    mesh::CutOptions cut {};
};

/// @throws InputError on a name other than 12k, 67k, 96k, 175k.
OpenScene open_scene_of_box(const std::string& name);
/// The thorax phantom's wall (bench_thorax()) with all its tissues and supports. The incision is the middle 100 mm of
/// the median incision through the wall, with hooks on the skin.
/// @throws SolverError when cancelled.
OpenScene open_scene_of_thorax(const Job& job);
/// The scene of "thorax" or of a box.
OpenScene open_scene(const std::string& name, const Job& job);

} // namespace retractor::benchmarks
