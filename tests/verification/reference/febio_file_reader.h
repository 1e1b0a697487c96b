#pragma once
// The FEBio files that this program writes (fem/io/febio_file.h), read back: the tests compare what comes back with
// what was written. Units mm, N, MPa.

#include "fem/statics/elastic_problem.h"

#include <string>
#include <string_view>

namespace retractor::verification {

/// Reads what fem::febio_file() wrote: mesh, labels, materials by label (name, E, nu, density), supports, beds, hooks.
/// Sides of hooks, sources of materials and the order of beds are not in the file: sides are read as 0, beds rise by
/// vertex.
/// @throws InputError naming the line of what is missing, of a kind that fem::febio_file() does not write, or not XML.
fem::ElasticProblem read_febio_file(std::string_view text);

/// The first difference between two problems in what a file can hold, in words; empty: there is none, to the last bit.
std::string first_difference(const fem::ElasticProblem& a, const fem::ElasticProblem& b);

} // namespace retractor::verification
