#pragma once
// Mass-spring tissue as plain data: the 25 x 25 sheet of [Tang et al. 2020, doi 10.1016/j.cmpb.2020.105344] and the
// edges of any tetrahedral organ. Units mm, N, s, tonne; the frame is the scene's.

#include "fem/material/material.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::haptics {

struct TissueSpring {
    VertexId a = 0, b = 0;
    double length = 0.0; ///< at rest, mm
    double stiffness = 0.0; ///< N/mm
};

/// Particles, the springs between them, and what keeps them in place.
struct SpringBody {
    TriMesh surface; ///< its vertices are the particles (all of them, inner ones too)
    std::vector<TissueSpring> springs;
    std::vector<double> mass; ///< per particle, tonne
    std::vector<std::uint8_t> held; ///< per particle: 1 stays where it is
    std::vector<VertexId> touchable; ///< the particles a finger can meet, rising
};

/// Which edges of a sheet stay where they are.
enum class SheetEdges {
    fixed, ///< all four
    free, ///< none: under gravity the sheet falls
    one_side, ///< the side of largest y: it hangs like a curtain
};

/// The defaults are the source's sheet: structural springs of length 1, shear sqrt 2, bend 2; its mass of 0.01 has no
/// unit: 0.01 g is what a column of tissue 1 mm x 1 mm x 10 mm weighs.
struct SheetOptions {
    int columns = 25, rows = 25; ///< particles, each at least 3
    double spacing = 1.0; ///< mm
    double particle_mass = 1e-8; ///< tonne
    double stiffness = 0.075; ///< N/mm, of every spring
    double pre_strain = 0.0; ///< springs are shorter than their places ask by this strain: a slack sheet yields freely
                             ///< across its plane, a stretched one does not; 0 to 1
    SheetEdges edges = SheetEdges::fixed;
};

/// How many springs of each kind a sheet has.
struct SheetSprings {
    int structural = 0, shear = 0, bend = 0;
    int total() const { return structural + shear + bend; }
};
/// 25 x 25: 1,200 + 1,152 + 1,150 = 3,502.
SheetSprings sheet_springs(int columns, int rows);

/// In the plane z = 0, centred on the origin, row by row; its upper side faces +z.
/// @throws InputError naming the option that is out of range.
SpringBody make_spring_sheet(const SheetOptions& options = {});

/// One spring along x between two particles, the first of which is held: what a rheometer sees.
SpringBody make_spring_element(double length_mm, double stiffness_N_per_mm, double particle_mass_tonne);

/// The edges of a four-node mesh; each element gives its six edges E V / L^2 [Van Gelder 1998, doi
/// 10.1080/10867651.1998.10487496] times `calibration`, and a quarter of its mass to each corner. Central forces fix
/// Poisson's ratio near 1/4, so the material's own is not used. (fem/edge_springs.h has braces inside elements too,
/// which have no place among particles.)
/// @throws InputError as check_mesh(), on ten-node elements, a label without a material, a vertex out of range, or a
/// calibration that is not positive.
SpringBody make_spring_organ(const mesh::TetMesh& mesh, std::span<const fem::Material> material_of_label,
    std::span<const VertexId> held, double calibration = 1.0);

/// The same with a Young's modulus per element and one density (tonne/mm^3).
SpringBody make_spring_organ(const mesh::TetMesh& mesh, std::span<const double> modulus_of_element, double density,
    std::span<const VertexId> held, double calibration = 1.0);

/// @throws InputError naming what is wrong: sizes that do not fit, NaN, a mass, stiffness or length that is not
/// positive, an index out of range, a spring from a particle to itself.
void check_spring_body(const SpringBody& body);

} // namespace retractor::haptics
