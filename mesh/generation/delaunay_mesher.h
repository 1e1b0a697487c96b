#pragma once
// Delaunay refinement of labelled space by CGAL Mesh_3 (Boltcheva, Yvinec and Boissonnat 2009, doi
// 10.1007/978-3-642-04271-3_35), then sliver exudation (Cheng et al. 2000, doi 10.1145/355483.355487). No other module
// uses CGAL. Local frame of mesh/image/label_field.h, mm.

#include "mesh/base/job.h"
#include "mesh/generation/size_field.h"
#include "mesh/generation/surface_seeds.h"
#include "mesh/image/label_field.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::mesh {

struct LocalMesh {
    std::vector<Vec3> vertices; ///< mm
    std::vector<std::array<VertexId, 4>> tets; ///< positive orientation in the local frame
    std::vector<std::uint8_t> labels; ///< label number per element, as LabelField::at
    double refine_seconds = 0.0, optimise_seconds = 0.0;
    bool cancelled = false;
};

/// Meshes the field with the wanted edge lengths, starting from the seeds.
/// @param parallel uses all cores; the mesh then differs from run to run
LocalMesh delaunay_mesh(
    const LabelField& field, const SizeField& size, std::span<const SurfaceSeed> seeds, bool parallel, const Job& job);

} // namespace retractor::mesh
