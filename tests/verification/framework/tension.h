#pragma once
// The gape of a wound under tension: linear finite elements with initial stress, the closed form for a sheet, and the
// mesh of such a sheet. The closed form is the reference for finite elements and springs. Units mm, N, MPa.

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

/// Computes the linear response of a cut body to the tension that is released at its lips (released_tractions()). P1
/// and P2.
/// @param held_displacement displacement of the fixed nodes (n x 3, other rows unused); empty: zero
/// @throws InputError on bad materials or stresses and on supports that are not in the mesh; SolverError on a piece
/// without support
ReleasedWound release_wound(const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips,
    std::span<const Mat3> stress_of_element, std::span<const fem::Material> material_of_label,
    const fem::Supports& supports, const Points& held_displacement = {}, const Job& job = {});

/// Scale factor for the stiffness of all springs on a mesh. With this factor, springs store the same energy as linear
/// finite elements with Poisson's ratio 1/4 and the given Young's moduli, when the ends `held` are stretched uniformly
/// along `pull` and all else is free. The factor is about 1 where edges point in all directions; structured meshes are
/// stiffer along their edges.
/// @param symmetry vertices in a symmetry plane across z, which keep their z. A thin sheet must be kept from bending,
/// because conjugate gradients converge very slowly on bending.
/// @throws InputError as release_wound(), on a vertex that is not in the mesh, and when the held vertices do not
/// stretch the body
double spring_calibration(const mesh::TetMesh& mesh, std::span<const fem::Material> material_of_label,
    std::span<const VertexId> held, const Vec3& pull, std::span<const VertexId> symmetry = {}, const Job& job = {});

/// A flat round sheet with a straight cut through its middle. The mesh follows confocal elliptic coordinates. These are
/// conformal, so that equilateral triangles stay nearly equilateral; triangles are small at the tips and large far
/// away. The rim moves as in an infinite sheet, so that the sheet acts as an infinite sheet.
struct SheetProblem {
    double cut_length = 80.0; ///< mm, along x, through the origin
    double radius = 100.0; ///< mm, radius of the rim
    int around = 64; ///< number of cells round the cut; a multiple of four
    double thickness() const; ///< mm, along z, upwards from the middle plane: one cell at the middle of the cut
};

/// The uncut sheet with one label (1): one layer of prisms, each divided into three elements.
/// @throws InputError on sizes out of range
mesh::TetMesh sheet_mesh(const SheetProblem& sheet);
/// The blade of the cut: along the mesh edges from tip to tip, through the sheet.
mesh::Blade sheet_blade(const SheetProblem& sheet);
/// The vertices on the rim, which are held, and the vertices in the middle plane z = 0, which keep their z by symmetry.
/// The mesh may be cut or uncut.
std::vector<VertexId> sheet_rim(const SheetProblem& sheet, const mesh::TetMesh& mesh);
std::vector<VertexId> sheet_middle_plane(const mesh::TetMesh& mesh);

/// Displacement round a straight cut in an infinite sheet whose lips lose the traction `stress` across the cut: plane
/// stress, by Westergaard's function stress (z / sqrt(z^2 - a^2) - 1) (Westergaard 1939; Tada, Paris, Irwin 2000, 5.1).
/// The gape at the middle is 4 stress a / E.
Vec3 sheet_displacement(
    double cut_length, double stress, double youngs_modulus_MPa, double poissons_ratio, const Vec3& at);

/// Gape at the middle of a through cut of length L in a large sheet, plane stress: 2 e L under uniaxial stress, 2 e L /
/// (1 - nu^2) with the width held, 2 (e + nu a) L / (1 - nu^2) biaxial, 2 e L / (1 - nu) equibiaxial (Inglis 1913). By
/// superposition, only the stress across the cut counts.
/// @param strain e, across the cut
/// @param along_cut a, the strain along the cut; biaxial only
/// @throws InputError on another kind
double sheet_gape(
    fem::PreStrainKind kind, double strain, double cut_length, double poissons_ratio, double along_cut = 0.0);

} // namespace retractor::verification
