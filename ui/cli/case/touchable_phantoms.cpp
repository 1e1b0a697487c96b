#include "ui/cli/case/touchable_phantoms.h"

#include "datasets/phantoms/abdomen_phantom.h"
#include "haptics/spheres/surface_locator.h"
#include "mesh/base/error.h"
#include "mesh/generation/hybrid_model.h"

#include <Eigen/Geometry>

#include <array>
#include <limits>

namespace retractor::ui::cli {

namespace {

    datasets::TouchSite site_on(const std::string& name, const TriMesh& surface, const Vec3& from)
    {
        const haptics::NearestOnSurface at = haptics::nearest_on_surface(from, surface.vertices, surface.triangles);
        const auto& [a, b, c] = surface.triangles[at.triangle];
        const Vec3 pa = surface.vertices.row(a).transpose(), pb = surface.vertices.row(b).transpose(),
                   pc = surface.vertices.row(c).transpose();
        return { name, at.point, (pb - pa).cross(pc - pa).normalized() };
    }

    /// A site at the foremost point of the surface at x, z.
    datasets::TouchSite site_in_front(const std::string& name, const TriMesh& surface, double x, double z)
    {
        datasets::TouchSite site { name, Vec3(x, std::numeric_limits<double>::infinity(), z), Vec3(0.0, -1.0, 0.0) };
        for (const auto& triangle : surface.triangles) {
            std::array<Vec3, 3> at;
            for (std::size_t i = 0; i < 3; ++i)
                at[i] = surface.vertices.row(triangle[i]).transpose();
            const Vec3 normal = (at[1] - at[0]).cross(at[2] - at[0]).normalized();
            const auto cross = [&](const Vec3& a, const Vec3& b) {
                return (b.x() - a.x()) * (z - a.z()) - (b.z() - a.z()) * (x - a.x());
            };
            const bool inside = cross(at[0], at[1]) >= 0.0 && cross(at[1], at[2]) >= 0.0 && cross(at[2], at[0]) >= 0.0;
            if (!inside || normal.y() >= 0.0)
                continue;
            const double y = at[0].y() - (normal.x() * (x - at[0].x()) + normal.z() * (z - at[0].z())) / normal.y();
            if (y < site.point.y()) {
                site.point.y() = y;
                site.outward = normal;
            }
        }
        return site;
    }

    TriMesh boundary(const mesh::TetMesh& mesh)
    {
        TriMesh surface { mesh.vertices, {}, {} };
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
            surface.triangles.push_back(mesh::face_vertices(mesh, face));
        return surface;
    }

    /// @throws SolverError naming the organ when it cannot be meshed
    mesh::TetMesh meshed(const std::string& organ, const mesh::LabelVolume& labels, double edge_mm, const Job& job)
    {
        mesh::MeshSizing sizing;
        sizing.coarse_edge_mm = edge_mm;
        mesh::HybridModel model = mesh::build_hybrid_model(labels, sizing, job);
        if (model.status != mesh::MeshStatus::done)
            throw SolverError("the " + organ + " was not meshed: " + model.message);
        return std::move(model.wall);
    }

} // namespace

datasets::PalpationScene make_liver_scene(double edge_mm, const Job& job)
{
    if (!(edge_mm >= 4.0 && edge_mm <= 40.0))
        throw InputError("a liver is meshed with edges of 4 to 40 mm, got " + std::to_string(edge_mm), "--edge");
    datasets::AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(2.5, 2.5, 2.5);
    const datasets::Phantom phantom = datasets::make_liver_phantom(parameters, job);
    datasets::PalpationScene scene;
    scene.name = "liver";
    scene.body.mesh = meshed(scene.name, phantom.labels, edge_mm, job);
    const mesh::TetMesh& mesh = scene.body.mesh;
    constexpr double kBare = 12.0; // mm: the bare area, with which a liver hangs from the diaphragm
    const double back = mesh.vertices.col(1).maxCoeff() - kBare;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        scene.body.roles.push_back(
            mesh.vertices(v, 1) > back ? datasets::VertexRole::fixed : datasets::VertexRole::free);
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

datasets::PalpationScene make_abdomen_scene(double edge_mm, const Job& job)
{
    if (!(edge_mm >= 8.0 && edge_mm <= 40.0))
        throw InputError("an abdomen is meshed with edges of 8 to 40 mm, got " + std::to_string(edge_mm), "--edge");
    datasets::AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(3.0, 3.0, 3.0);
    datasets::Phantom phantom = datasets::make_abdomen_phantom(parameters, job);
    for (mesh::LabelInfo& info : phantom.labels.table)
        info.role = mesh::Role::wall;
    datasets::PalpationScene scene;
    scene.name = "abdomen";
    scene.body.mesh = meshed(scene.name, phantom.labels, edge_mm, job);
    const mesh::TetMesh& mesh = scene.body.mesh;
    const mesh::LabelTable& table = phantom.labels.table;
    scene.body.roles.assign(mesh.vertex_count(), datasets::VertexRole::free);
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const std::string& organ = mesh::find_label(table, mesh.labels[t])->name;
        // Liver and bowel at rest, muscle for walls: fem/material/material.h's sources.
        const double modulus = organ == "liver" ? 0.0054 : organ == "bowel" ? 0.003 : 0.04;
        scene.body.youngs_modulus.push_back(modulus);
        scene.body.poissons_ratio.push_back(0.48);
        if (organ == "spine")
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                scene.body.roles[static_cast<std::size_t>(v)] = datasets::VertexRole::fixed;
    }
    for (const auto& [label, name] : { std::pair { "liver", "liver" }, { "stomach", "stomach" }, { "bowel", "bowel" },
             { "abdominal_wall", "skin" } })
        scene.organs.push_back({ mesh::find_label(table, label)->id, name });
    const TriMesh skin = boundary(mesh);
    // Three fingers of each hand: over the liver, where the liver lies against the wall, and over the stomach.
    constexpr std::array<std::array<double, 2>, 6> kFingers { { { -80.0, 10.0 }, { -55.0, 30.0 }, { -25.0, 50.0 },
        { 30.0, -15.0 }, { 55.0, -5.0 }, { 75.0, 25.0 } } }; // x, z, mm
    for (std::size_t f = 0; f < kFingers.size(); ++f)
        scene.sites.push_back(site_in_front(
            (f < 3 ? "liver-" : "stomach-") + std::to_string(f % 3 + 1), skin, kFingers[f][0], kFingers[f][1]));
    return scene;
}

datasets::PalpationScene make_sheet_scene()
{
    datasets::PalpationScene scene;
    scene.name = "sheet";
    scene.body.mesh = mesh::kuhn_box(12, 12, 4, 2.0);
    mesh::TetMesh& mesh = scene.body.mesh;
    mesh.vertices.rowwise() -= Eigen::RowVector3d(12.0, 12.0, 8.0);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        const bool side = std::abs(mesh.vertices(v, 0)) == 12.0 || std::abs(mesh.vertices(v, 1)) == 12.0;
        scene.body.roles.push_back(side ? datasets::VertexRole::fixed : datasets::VertexRole::free);
    }
    scene.body.youngs_modulus.assign(mesh.tet_count(), 0.02);
    scene.body.poissons_ratio.assign(mesh.tet_count(), 0.45);
    scene.sites = { { "centre", Vec3::Zero(), Vec3::UnitZ() } };
    scene.sheet_particles = 25;
    return scene;
}

} // namespace retractor::ui::cli
