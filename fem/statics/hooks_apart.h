#pragma once
// Hooks on facing lips must not be drawn through each other: lips cannot pass. Patches are looked at as planes that
// move as a whole; what the tissue between hooks does is contact.h's. Units mm, N; frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstddef>
#include <span>
#include <vector>

namespace retractor::fem {

/// Two hooks of opposite sides whose patches lie opposite each other at rest.
struct FacingHooks {
    std::size_t a = 0, b = 0; ///< their places among the hooks
    Vec3 normal = Vec3::UnitX(); ///< unit, from a's lip to b's
    double gap_mm = 0.0; ///< between the lips at rest, >= 0
    double round_off_mm = 0.0; ///< of patches of their size
};

/// @pre the hooks' nodes are in the mesh.
std::vector<FacingHooks> facing_hooks(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks);

/// By how far two hooks that have moved so, mm, have passed through each other; negative: what is left between them.
double crossing_mm(const FacingHooks& pair, const Vec3& moved_a, const Vec3& moved_b);

/// @throws InputError naming two hooks of opposite sides that would pass through each other, and by how far.
/// @pre as facing_hooks().
void check_hooks_apart(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks);

/// Draws hooks that have passed through each other back to where their lips meet, straight apart: along the lips they
/// go where they were going.
/// @param gives_way per hook, >= 0: the shares in which the hooks of a pair are drawn back; both 0: they stay.
/// @param moved per hook, mm; changed. @return the pairs that were drawn back.
std::vector<FacingHooks> draw_back(
    std::span<const FacingHooks> facing, std::span<const double> gives_way, std::vector<Vec3>& moved);

struct RestApart {
    HookRest rest;
    std::vector<FacingHooks> meeting; ///< pairs that hold each other back
};

/// rest_of_hooks() with hooks that stop where their lips meet, and press on each other there without friction. Those
/// that prescribe where they go give way to each other alike. @param R, r as there; not used where all prescribe.
RestApart rest_of_hooks_apart(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, std::vector<HookDrive> drives,
    std::span<const FacingHooks> facing);

} // namespace retractor::fem
