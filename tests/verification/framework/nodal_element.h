#pragma once
// Four-node tetrahedra with strain and volume averaged round each node [Gee, Dohrmann, Key, Wall 2009, doi
// 10.1002/nme.2493]. FEBio has this element as ut4 with isochoric stabilisation. The element is too soft in bending.
// FEBio's published results te02 and te03 were computed with this element.

#include "fem/element/locking_free.h"

namespace retractor::verification {

/// One domain of the elements of one law round each node, in the order of the nodes. Each domain is a patch of its
/// own.
std::vector<fem::AveragingDomain> nodal_domains(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume);

} // namespace retractor::verification
