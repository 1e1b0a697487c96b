#pragma once
// Writes an elastic problem as an input deck for CalculiX (ccx) and reads the printed answer of ccx: a check by
// another program on the same mesh, elements, supports, hooks and loads. Linear, without contact. Units mm, N, MPa.
//
// Elements are C3D4 or C3D10, as in the mesh; node order and quadrature are the same as here. Each label has one
// *ELASTIC material. A bed is three SPRING1 elements per node. Each edge of a hinge has an extra
// node, whose x is tied to the edge's turn by an *EQUATION and held by a SPRING1 element: the hinge's stiffness at
// rest, without the stop. Loads are nodal forces (*CLOAD). The .dat file contains the displacements of all nodes and
// the reactions of the held nodes with seven digits [Dhondt, CalculiX CrunchiX user's manual 2.20, *NODE PRINT].

#include "fem/statics/elastic_problem.h"

#include <string>
#include <string_view>

namespace retractor::fem {

/// The whole deck. The same problem always gives the same text. Vertex i is node i + 1, and
/// tetrahedron i is element i + 1.
/// @throws InputError as check_problem() does.
std::string calculix_deck(const ElasticProblem& problem);

struct CalculixAnswer {
    Points displacement; ///< n x 3, mm
    /// n x 3, N: reactions of the prescribed nodes, without the loads at these nodes; zero at other nodes
    Points reaction;
};

/// Reads the answer of ccx.
/// @param dat the text of ccx's .dat file.
/// @throws InputError naming a line that cannot be read, or the first node of an element or support without numbers:
/// a file that ends early is not an answer.
CalculixAnswer read_calculix_answer(std::string_view dat, const ElasticProblem& problem);

} // namespace retractor::fem
