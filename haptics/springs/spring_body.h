#pragma once
// Mass-spring tissue as plain data: the 25 x 25 sheet of Tang et al. 2020 (doi 10.1016/j.cmpb.2020.105344), and the
// edges of any tetrahedral organ. Units mm, N, s, tonne. Frame: the scene's.

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

/// Particles, the springs between them, and their supports.
struct SpringBody {
    TriMesh surface; ///< the vertices are all particles, inner particles too
    std::vector<TissueSpring> springs;
    std::vector<double> mass; ///< per particle, tonne
    std::vector<std::uint8_t> held; ///< per particle: 1 = does not move
    std::vector<VertexId> touchable; ///< particles that a finger can meet, in rising order
};

/// The defaults are the sheet of Tang et al. 2020: structural springs of length 1, shear springs of length sqrt 2, bend
/// springs of length 2. The paper gives a mass of 0.01 without a unit; 0.01 g is the mass of a tissue column of 1 mm x
/// 1 mm x 10 mm.
struct SheetOptions {
    int columns = 25, rows = 25; ///< number of particles in each direction, at least 3
    double spacing = 1.0; ///< mm
    double particle_mass = 1e-8; ///< tonne
    double stiffness = 0.075; ///< of every spring, N/mm
    /// Strain by which springs are shorter than the distance of their particles, 0 to 1; a slack sheet yields freely
    /// across its plane, a stretched sheet does not.
    double pre_strain = 0.0;
};

/// Makes a sheet in the plane z = 0, centred on the origin, particles row by row; the upper side faces +z. The four
/// edges are held.
/// @throws InputError naming the option that is out of range
SpringBody make_spring_sheet(const SheetOptions& options = {});

/// Makes springs of the edges of a four-node mesh, with a Young's modulus per element (MPa) and one density
/// (tonne/mm^3). Each element adds E V / L^2 times `calibration` to its six edges (Van Gelder 1998,
/// doi 10.1080/10867651.1998.10487496) and a quarter of its mass to each corner. Central forces fix Poisson's ratio
/// near 1/4, so the material's ratio is not used. (The edge springs of fem/ also have braces inside elements, which no
/// pair of particles can carry.)
/// @throws InputError as check_mesh(), on ten-node elements, a vertex out of range, or a modulus, density or
/// calibration that is not positive
SpringBody make_spring_organ(const mesh::TetMesh& mesh, std::span<const double> modulus_of_element, double density,
    std::span<const VertexId> held, double calibration = 1.0);

/// @throws InputError naming the fault: sizes that do not match, NaN, a mass, stiffness or length that is not positive,
/// an index out of range, or a spring from a particle to itself
void check_spring_body(const SpringBody& body);

} // namespace retractor::haptics
