// Meshes a bar of voxels (20 x 20 x 60 mm), pulls it 1 mm longer and compares the force with E A u / L.
#include "fem/statics/opening.h"
#include "mesh/generation/hybrid_model.h"

#include <cmath>
#include <cstdio>

extern "C" int openblas_get_num_threads(void); // of the BLAS below retractor::fem

int main()
{
    // Nobody asks for more here: OPENBLAS_NUM_THREADS is not set.
    if (const int threads = openblas_get_num_threads(); threads != 1) {
        std::printf("BLAS begins with %d threads instead of one\n", threads);
        return 1;
    }
    retractor::mesh::LabelVolume bar;
    bar.grid.size = { 14, 14, 34 }; // two voxels of air all round
    bar.grid.spacing.setConstant(2.0);
    bar.voxels.assign(bar.grid.voxel_count(), 0);
    for (int k = 2; k < 32; ++k)
        for (int j = 2; j < 12; ++j)
            for (int i = 2; i < 12; ++i)
                bar.voxels[bar.grid.offset(i, j, k)] = 1;
    bar.table = { { 1, "bar", "rubber", retractor::mesh::Role::wall } };

    const retractor::mesh::TetMesh mesh = retractor::mesh::build_hybrid_model(bar, { .coarse_edge_mm = 6.0 }).wall;
    const double bottom = mesh.vertices.col(2).minCoeff(), top = mesh.vertices.col(2).maxCoeff();
    retractor::fem::Supports supports;
    retractor::fem::HookPatch hook { .name = "top", .side = 1, .nodes = {}, .displacement = { 0.0, 0.0, 1.0 } };
    for (retractor::VertexId v = 0; v < mesh.vertices.rows(); ++v) {
        if (mesh.vertices(v, 2) < bottom + 1.0)
            supports.fixed.push_back(v);
        if (mesh.vertices(v, 2) > top - 1.0)
            hook.nodes.push_back(v);
    }
    const std::vector<retractor::fem::Material> materials(2, { "rubber", 1.0, 0.0, 1e-9, "an example" });
    retractor::fem::Opening opening(mesh, materials, supports, { .elasticity = retractor::fem::Elasticity::linear });
    const auto result = opening.open(std::vector { hook });

    const double expected = 1.0 * (20.0 * 20.0) * 1.0 / 60.0; // N
    const double force = result.hook_forces_N.at(0).norm();
    std::printf("%zu tetrahedra, %.3f N, by hand %.3f N\n", mesh.tet_count(), force, expected);
    // The mesher rounds the bar's edges, and both ends are held over a millimetre.
    const bool good
        = result.status == retractor::fem::OpeningStatus::converged && std::abs(force / expected - 1.0) < 0.1;
    return good ? 0 : 1;
}
