#pragma once
// An elastic problem as an input deck for CalculiX (ccx), and what ccx printed read back: a second opinion by another
// program on the same mesh, element, supports, hooks and loads. Linear, no contact. Units mm, N, MPa.
//
// C3D4 or C3D10 by the mesh; node order and quadrature are ours. One *ELASTIC material per label. A bed is three
// SPRING1 elements per node. Loads are forces at nodes (*CLOAD).
// Displacements of all nodes and reactions of the held ones go to the .dat file, with seven digits [Dhondt, CalculiX
// CrunchiX user's manual 2.20, *NODE PRINT].

#include "fem/statics/elastic_problem.h"

#include <string>
#include <string_view>

namespace retractor::fem {

/// The whole deck; the same text for the same problem. Node i is vertex i - 1, element i tetrahedron i - 1.
/// @throws InputError as check_problem() does.
std::string calculix_deck(const ElasticProblem& problem);

struct CalculixAnswer {
    Points displacement; ///< n x 3, mm
    Points reaction; ///< n x 3, N: what holds a prescribed node where it is, beside its loads; zero at the others
};

/// @param dat the text of ccx's .dat file.
/// @throws InputError naming the line that cannot be read, or the first node of an element or a support that has no
/// number: an answer that ends early is no answer.
CalculixAnswer read_calculix_answer(std::string_view dat, const ElasticProblem& problem);

} // namespace retractor::fem
