#include "ui/cli/touchable_phantoms.h"

#include "datasets/abdomen_phantom.h"
#include "haptics/surface_locator.h"
#include "mesh/base/error.h"
#include "mesh/hybrid_model.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace retractor::cli {

namespace {

    TouchSite site_on(const char* name, const TriMesh& surface, const Vec3& from)
    {
        const NearestOnSurface at = nearest_on_surface(from, surface.vertices, surface.triangles);
        const auto& [a, b, c] = surface.triangles[at.triangle];
        const Vec3 pa = surface.vertices.row(a).transpose(), pb = surface.vertices.row(b).transpose(),
                   pc = surface.vertices.row(c).transpose();
        return { name, at.point, (pb - pa).cross(pc - pa).normalized() };
    }

    TriMesh boundary(const TetMesh& mesh)
    {
        TriMesh surface { mesh.vertices, {}, {} };
        for (const TetFace& face : boundary_faces(mesh))
            surface.triangles.push_back(face_vertices(mesh, face));
        return surface;
    }

} // namespace

PalpationScene make_liver_scene(double edge_mm, const Job& job)
{
    if (!(edge_mm >= 4.0 && edge_mm <= 40.0))
        throw InputError("a liver is meshed with edges of 4 to 40 mm, got " + std::to_string(edge_mm), "--edge");
    AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(2.5, 2.5, 2.5);
    const Phantom phantom = make_liver_phantom(parameters, job);
    MeshSizing sizing;
    sizing.coarse_edge_mm = edge_mm;
    HybridModel model = build_hybrid_model(phantom.labels, sizing, job);
    if (model.status != MeshStatus::done)
        throw SolverError("the liver was not meshed: " + model.message);
    PalpationScene scene;
    scene.name = "liver";
    scene.body.mesh = std::move(model.wall);
    const TetMesh& mesh = scene.body.mesh;
    constexpr double kBare = 12.0; // mm: the bare area, by which a liver hangs at the diaphragm
    const double back = mesh.vertices.col(1).maxCoeff() - kBare;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        scene.body.roles.push_back(mesh.vertices(v, 1) > back ? VertexRole::fixed : VertexRole::free);
    scene.body.youngs_modulus.assign(mesh.tet_count(), 0.0054);
    scene.body.poissons_ratio.assign(mesh.tet_count(), 0.49);
    const TriMesh surface = boundary(mesh);
    const Vec3 low = mesh.vertices.colwise().minCoeff().transpose(),
               high = mesh.vertices.colwise().maxCoeff().transpose();
    const auto front = [&](double share, double up) {
        return Vec3(low.x() + share * (high.x() - low.x()), low.y() - 20.0, low.z() + up * (high.z() - low.z()));
    };
    scene.sites = { site_on("right-lobe", surface, front(0.3, 0.5)), site_on("left-lobe", surface, front(0.75, 0.65)) };
    return scene;
}

PalpationScene make_sheet_scene()
{
    PalpationScene scene;
    scene.name = "sheet";
    scene.body.mesh = kuhn_box(12, 12, 4, 2.0);
    TetMesh& mesh = scene.body.mesh;
    mesh.vertices.rowwise() -= Eigen::RowVector3d(12.0, 12.0, 8.0);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        const bool side = std::abs(mesh.vertices(v, 0)) == 12.0 || std::abs(mesh.vertices(v, 1)) == 12.0;
        scene.body.roles.push_back(side ? VertexRole::fixed : VertexRole::free);
    }
    scene.body.youngs_modulus.assign(mesh.tet_count(), 0.02);
    scene.body.poissons_ratio.assign(mesh.tet_count(), 0.45);
    scene.sites = { { "centre", Vec3::Zero(), Vec3::UnitZ() } };
    return scene;
}

} // namespace retractor::cli
