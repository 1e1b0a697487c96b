#pragma once
// A hyperelastic body of one tissue.

#include "fem/model/elastic_body.h"

#include <cstdint>
#include <vector>

namespace retractor::verification {

/// One law everywhere.
inline fem::HyperelasticTissue uniform_tissue(const mesh::TetMesh& mesh, const fem::Hyperelastic& law)
{
    return { { law }, std::vector<std::int32_t>(mesh.tet_count(), 0), {} };
}

} // namespace retractor::verification
