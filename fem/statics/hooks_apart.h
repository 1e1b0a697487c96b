#pragma once
// Keeps hooks on facing lips from passing through each other, since lips cannot pass. A patch counts as a plane that
// moves rigidly; contact.h covers the tissue between hooks. Units mm, N; frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/hook_drive.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstddef>
#include <span>
#include <vector>

namespace retractor::fem {

/// Two hooks on opposite lips whose patches face each other at rest.
struct FacingHooks {
    std::size_t a = 0, b = 0; ///< indices of the two hooks
    Vec3 normal = Vec3::UnitX(); ///< unit vector from the lip of a to the lip of b
    double gap_mm = 0.0; ///< distance between the lips at rest, >= 0
    double round_off_mm = 0.0; ///< round-off of distances between patches of this size
};

/// Finds the pairs of facing hooks. @pre the hooks' nodes are in the mesh
std::vector<FacingHooks> facing_hooks(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks);

/// Overlap (mm) of two hooks after these displacements (mm). A negative value is the gap between the hooks.
double crossing_mm(const FacingHooks& pair, const Vec3& moved_a, const Vec3& moved_b);

/// Checks that no hooks pass through each other.
/// @throws InputError naming two facing hooks that would pass through each other, with the overlap
/// @pre as facing_hooks()
void check_hooks_apart(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks);

/// Moves overlapping hooks back along the normal until their lips meet. Displacements along the lips remain.
/// @param gives_way per hook, >= 0: shares in which the two hooks of a pair move back; a pair with two zeros stays
/// @param moved displacement per hook, mm; changed
/// @return the pairs that were moved back
std::vector<FacingHooks> draw_back(
    std::span<const FacingHooks> facing, std::span<const double> gives_way, std::vector<Vec3>& moved);

struct RestApart {
    HookRest rest;
    std::vector<FacingHooks> meeting; ///< pairs of hooks that stop each other
};

/// Computes rest_of_hooks() with hooks that stop where their lips meet. Meeting hooks press on each other without
/// friction. Two hooks that prescribe their displacement move back by equal shares. Two hooks along which tissue slides
/// go where they are told: whoever drives them keeps them apart.
/// @param R, r as in rest_of_hooks(); not used when all hooks prescribe their displacement
RestApart rest_of_hooks_apart(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, std::vector<HookDrive> drives,
    std::span<const FacingHooks> facing);

} // namespace retractor::fem
