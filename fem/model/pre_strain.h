#pragma once
// Tension that tissue is under before it is cut, and what of it a wound sets free. Units mm, N, MPa; frame patient LPS.
//
// What a CT shows is the body in tension and in equilibrium: its rest positions are those of the stressed tissue, and
// whatever forces the pre-stress leaves unbalanced there (at the free skin, where two tissues meet) something that is
// not modelled holds. So nothing moves until a blade has passed; then each face of the wound loses the traction that
// the tissue beyond it exerted, and that alone opens the wound: the load on a lip is -sigma0 n, n the outward normal.
// Linear superposition makes this exact for a linear body; its limits: what the pre-stress does besides (removed tissue
// that leaves no lip, a change of the supports) is not felt, and sigma0 is the stress at rest, whatever opens later.

#include "fem/material/material.h"
#include "fem/material/tissue_tension.h"
#include "fem/model/loads.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::fem {

/// Whether the two ways in the tissue's plane differ, so that one must be named.
bool needs_pull(const PreStrain& tension);

/// Ranges and directions of a pre-strain, whatever the material. The pull may lie along a normal that is not given.
/// @throws InputError with where() "along", "across", "direction" or "normal".
void check_pre_strain(const PreStrain& tension);

/// The stress (MPa) of one tissue with its own normal, or the one given when that is zero.
/// @throws InputError on NaN, a strain out of range, a direction that is missing or along the normal.
Mat3 pre_stress(const PreStrain& tension, const Material& material, const Vec3& normal_there = Vec3::Zero());

/// One stress per element. @param material_of_label, tension_of_label by label; labels beyond the second have none.
/// @throws InputError naming the label.
std::vector<Mat3> pre_stress(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
    std::span<const PreStrain> tension_of_label);

/// Per element the outward normal of its label's free surface, carried inwards by averages over neighbours of the same
/// label; zero where no part of the label's piece is free. With `seeds`: of the free surface of these labels alone,
/// carried on through all tissue. Four-node elements.
/// @param held a face with all its corners among these is no free surface, but where the body was cut off.
std::vector<Vec3> surface_normals(
    const mesh::TetMesh& mesh, std::span<const Label> seeds = {}, std::span<const VertexId> held = {});

/// What opens the wound: the tractions -sigma0 n on the faces of the lips.
/// @throws InputError on a face out of range, a wrong number of stresses.
std::vector<FaceTraction> released_tractions(
    const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips, std::span<const Mat3> stress_of_element);

/// The same as nodal loads (three per node). P1 and P2. @throws InputError as above.
Eigen::VectorXd release_forces(
    const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips, std::span<const Mat3> stress_of_element);

} // namespace retractor::fem
