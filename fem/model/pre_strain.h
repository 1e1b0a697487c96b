#pragma once
// Stress of tissue that is under tension before the cut, and the load that a wound releases. Units mm, N, MPa; frame
// patient LPS.
//
// A CT shows the body under tension and in equilibrium, so the rest positions are those of stressed tissue. Where the
// pre-stress is unbalanced (at the free skin, where two tissues meet), structures outside the model are assumed to
// hold the balance. Nothing moves until a blade has passed. Then each face of the wound loses the traction of the
// tissue beyond the face. The load on a lip is therefore -sigma0 n, with n the outward normal, and no other load
// opens the wound. For a linear body this is exact by superposition. Limits: tissue that is removed without leaving a
// lip, and changes of the supports, release no tension; sigma0 stays the stress at rest, whatever opens later.

#include "fem/material/material.h"
#include "fem/material/tissue_tension.h"
#include "fem/model/loads.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::fem {

/// Whether the two directions in the tissue's plane differ, so that a pull is needed.
bool needs_pull(const PreStrain& tension);

/// Checks the ranges and directions of a pre-strain without a material. A pull along a normal that is not given is
/// not detected.
/// @throws InputError whose where() is "along", "across", "direction" or "normal".
void check_pre_strain(const PreStrain& tension);

/// The pre-stress of one tissue, MPa.
/// @param normal_there normal of the tissue's plane, used when the pre-strain has none.
/// @throws InputError on NaN, on a strain out of range, and on a direction that is missing or along the normal.
Mat3 pre_stress(const PreStrain& tension, const Material& material, const Vec3& normal_there = Vec3::Zero());

/// The outward normal of the free surface nearest to each element of four nodes. Normals spread inwards from the
/// surface of each label by averages over neighbours of the same label. The normal is zero where the label's piece
/// has no free surface.
/// @param seeds when not empty: only the free surface of these labels counts, and its normals spread through all
/// tissue.
/// @param held vertices of the cut-off border: a face with all its corners held is not a free surface.
std::vector<Vec3> surface_normals(
    const mesh::TetMesh& mesh, std::span<const Label> seeds = {}, std::span<const VertexId> held = {});

/// The tractions that open the wound, -sigma0 n on each face of the lips.
/// @throws InputError on a face out of range, or a wrong number of stresses.
std::vector<FaceTraction> released_tractions(
    const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips, std::span<const Mat3> stress_of_element);

} // namespace retractor::fem
