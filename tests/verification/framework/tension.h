#pragma once
// How far a wound gapes under tension: linear finite elements with initial stress, the closed form they and the springs
// are measured against, and the sheet it holds for. Units mm, N, MPa.

#include "fem/material/material.h"
#include "fem/model/pre_strain.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/base/job.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <span>
#include <vector>

namespace retractor::verification {

struct [[nodiscard]] ReleasedWound {
    Points displacement; ///< n x 3, mm
    double relative_residual = 0.0; ///< |K u - f| / |f|
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

/// The linear answer of a cut body to the tension set free at its lips: K u = release_forces(). P1 and P2.
/// @param held_displacement where the fixed nodes are moved to (n x 3, others unused), or none.
/// @throws InputError on bad materials or stresses and on supports that are not in the mesh; SolverError on a piece
/// that nothing holds.
ReleasedWound release_wound(const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips,
    std::span<const Mat3> stress_of_element, std::span<const fem::Material> material_of_label,
    const fem::Supports& supports, const Points& held_displacement = {}, const Job& job = {});

/// What the stiffness of all springs on a mesh must be scaled by, that it takes the same energy to stretch the body
/// along `pull` by the ends that are held as linear finite elements take with Poisson's ratio 1/4 (Young's moduli as
/// given): both with `held` prescribed to a uniform strain, everything else free. About 1 where the edges point every
/// way; structured meshes are stiffer along their edges.
/// @param symmetry vertices in a plane of symmetry across z, which keep their z: a thin sheet has to be kept from
/// bending, which conjugate gradients take for ever to find out about.
/// @throws InputError as above, on a vertex that is not in the mesh, or when the held vertices do not stretch the body.
double spring_calibration(const mesh::TetMesh& mesh, std::span<const fem::Material> material_of_label,
    std::span<const VertexId> held, const Vec3& pull, std::span<const VertexId> symmetry = {}, const Job& job = {});

/// A flat round sheet with a straight cut through its middle. In confocal elliptic coordinates, which are conformal,
/// equilateral triangles stay nearly equilateral, and are small at the tips and large far away.
/// The sheet is infinite in effect: its rim is moved as that of an infinite one would be.
struct SheetProblem {
    double cut_length = 80.0; ///< mm, along x, through the origin
    double radius = 100.0; ///< mm, of the rim
    int around = 64; ///< cells round the cut; a multiple of four
    double thickness() const; ///< mm, along z, from the middle plane up: one cell at the middle of the cut
};

/// Uncut, one label (1), one layer of prisms divided into three. @throws InputError on sizes out of range.
mesh::TetMesh sheet_mesh(const SheetProblem& sheet);
/// Along the mesh's own edges from tip to tip, through the sheet.
mesh::Blade sheet_blade(const SheetProblem& sheet);
/// The vertices on the rim, which are held, and those in the middle plane z = 0, which keep their z by symmetry; of the
/// mesh before or after the cut.
std::vector<VertexId> sheet_rim(const SheetProblem& sheet, const mesh::TetMesh& mesh);
std::vector<VertexId> sheet_middle_plane(const mesh::TetMesh& mesh);

/// Displacement round a straight cut in an infinite sheet whose lips lose the traction `stress` across it: plane
/// stress, by Westergaard's function stress (z / sqrt(z^2 - a^2) - 1) [Westergaard 1939; Tada, Paris, Irwin 2000, 5.1].
/// The gape at the middle is 4 stress a / E.
Vec3 sheet_displacement(
    double cut_length, double stress, double youngs_modulus_MPa, double poissons_ratio, const Vec3& at);

/// Opening at the middle of a through cut of this length in a large sheet, plane stress: 2 e L under uniaxial stress,
/// 2 e L / (1 - nu^2) with the width held, 2 (e + nu a) L / (1 - nu^2) biaxial, 2 e L / (1 - nu) equibiaxial
/// [Inglis 1913]: by superposition, only the stress across the cut counts.
/// @param strain across the cut. @param along_cut biaxial: a, the strain along it. @throws InputError on another kind.
double sheet_gape(
    fem::PreStrainKind kind, double strain, double cut_length, double poissons_ratio, double along_cut = 0.0);

} // namespace retractor::verification
