#include "tests/benchmarks/opening/gape_pictures.h"

#include "datasets/phantoms/phantom.h"
#include "fem/model/pre_strain.h"
#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/generation/hybrid_model.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/label_surface.h"
#include "mesh/surface/wound_surface.h"
#include "planner/approach/approach_templates.h"
#include "planner/wall/supports.h"
#include "planner/wall/unmeshed_wall.h"
#include "tests/verification/framework/element_stress.h"
#include "ui/results/field_files.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/render.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

namespace retractor::benchmarks {

namespace {

    constexpr std::array<double, 3> kStrains { 0.02, 0.04, 0.06 };
    constexpr const char* kTemplate = "intercostal:4";
    constexpr double kChestCutLength = 110.0, kRegion = 80.0, kRegionEdge = 4.0;
    constexpr double kBodySmoothing = 4.0;
    constexpr int kWidth = 1000, kHeight = 900;

    /// The phantom with its incision and its cut wall.
    struct CutChest {
        datasets::Phantom phantom;
        planner::Approach approach;
        mesh::MeshSizing sizing;
        mesh::TetMesh wall;
        std::vector<fem::Material> materials; ///< by label
        std::vector<VertexId> held; ///< held vertices: skeleton and border of the region
        Vec3 inward, across; ///< unit directions: of the blade, and from lip to lip
        std::unique_ptr<mesh::CutSession> session;
        mesh::CutResult cut;
    };

    CutChest cut_chest(const Job& job)
    {
        CutChest chest { .phantom = datasets::make_thorax_phantom({}, job),
            .approach = {},
            .sizing = {},
            .wall = {},
            .materials = {},
            .held = {},
            .inward = Vec3::Zero(),
            .across = Vec3::Zero(),
            .session = {},
            .cut = {} };
        const mesh::LabelVolume& labels = chest.phantom.labels;
        planner::ApproachRequest request;
        request.template_name = kTemplate;
        request.target.label = "aneurysm";
        request.length_mm = kChestCutLength;
        request.sizing.region_mm = kRegion;
        request.sizing.corridor_edge_mm = kRegionEdge;
        chest.approach = planner::approach_from_template(labels, planner::find_anatomy(labels), request);
        chest.sizing = planner::mesh_sizing_of(chest.approach, labels.table);
        mesh::HybridModel model = mesh::build_hybrid_model(labels, chest.sizing, job);
        if (model.status != mesh::MeshStatus::done)
            throw SolverError("the phantom's wall was not meshed: " + model.message);
        chest.wall = std::move(model.wall);
        for (const Vec3& direction : chest.approach.directions)
            chest.inward += direction;
        chest.inward.normalize();
        const auto& line = chest.approach.incision;
        chest.across = (line.back() - line.front()).cross(chest.inward).normalized();

        mesh::CutOptions options;
        std::vector<bool> hard;
        for (const mesh::LabelInfo& info : labels.table) {
            if (chest.materials.size() <= info.id) {
                chest.materials.resize(static_cast<std::size_t>(info.id) + 1);
                hard.resize(chest.materials.size());
            }
            if (info.role != mesh::Role::wall)
                continue;
            chest.materials[info.id] = fem::find_material(fem::default_materials(), info.material);
            hard[info.id] = mesh::is_skeleton(info);
            if (hard[info.id])
                options.uncut_labels.push_back(info.id);
        }
        chest.held = planner::wall_supports(chest.wall, labels, {}, {}, true);
        for (TetId t = 0; t < static_cast<TetId>(chest.wall.tet_count()); ++t)
            if (hard[chest.wall.labels[static_cast<std::size_t>(t)]])
                chest.held.insert(chest.held.end(), chest.wall.tet(t).begin(), chest.wall.tet(t).end());
        chest.session = std::make_unique<mesh::CutSession>(chest.wall);
        chest.cut = chest.session->cut(planner::blade_of(chest.approach), options, job);
        if (chest.cut.status != mesh::CutStatus::done)
            throw SolverError("the phantom's wall was not cut: " + chest.cut.message);
        return chest;
    }

    /// Tension across the cut in all soft tissue, in the plane of the wall; in skin in the plane of the skin.
    std::vector<Mat3> tension(const CutChest& chest, double strain)
    {
        std::vector<fem::PreStrain> of_label(chest.materials.size());
        for (const mesh::LabelInfo& info : chest.phantom.labels.table)
            if (info.role == mesh::Role::wall && !mesh::is_skeleton(info))
                of_label[info.id] = { fem::PreStrainKind::uniaxial_stress, strain, chest.across,
                    info.material == "skin" ? Vec3(Vec3::Zero()) : Vec3(-chest.inward) };
        return verification::stress_of_elements(chest.wall, chest.materials, of_label);
    }

    bool in_skin(const CutChest& chest, const fem::SpringNetwork& springs, VertexId v)
    {
        const mesh::LabelInfo* skin = mesh::find_label(chest.phantom.labels.table, "skin");
        const auto around = springs.elements(v);
        return skin != nullptr
            && std::any_of(around.begin(), around.end(), [&](TetId t) { return springs.label(t) == skin->id; });
    }

    double skin_gape(const CutChest& chest, const fem::SpringNetwork& springs)
    {
        const Points now = springs.positions();
        double widest = 0.0;
        for (const mesh::MeshDelta::VertexBorn& born : chest.cut.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && in_skin(chest, springs, born.a)
                && in_skin(chest, springs, born.id))
                widest = std::max(widest, (now.row(born.a) - now.row(born.id)).norm());
        return widest;
    }

    Vec3 middle_of(const std::vector<Vec3>& line)
    {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& point : line)
            sum += point;
        return sum / static_cast<double>(line.size());
    }

    ui::Scene wound_scene(
        const CutChest& chest, const fem::SpringNetwork& springs, const TriMesh& body, const GapePicture& picture)
    {
        mesh::SlotMap map;
        const mesh::TetMesh cut = chest.session->compact_mesh(&map);
        Points displacement(cut.vertices.rows(), 3);
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
            displacement.row(static_cast<Eigen::Index>(v)) = springs.displacement().row(map.vertex_slot[v]);
        const auto looks = ui::tissue_looks(chest.phantom.labels.table);
        ui::Scene scene;
        std::array<char, 96> text {};
        std::snprintf(
            text.data(), text.size(), "%.0f %% tension: gape %.1f mm", 100.0 * picture.strain, picture.gape_mm);
        scene.title = text.data();
        ui::SurfaceItem wall;
        wall.name = "chest wall";
        wall.mesh = std::make_shared<const TriMesh>(mesh::deformed_boundary(cut, displacement));
        wall.look_of_label = looks;
        scene.surfaces.push_back(std::move(wall));
        ui::SurfaceItem rest;
        rest.name = "chest wall beyond the model";
        rest.mesh = std::make_shared<const TriMesh>(
            planner::unmeshed_wall_region(body, chest.phantom.labels, chest.sizing, cut, displacement, 0.0));
        rest.look_of_label = looks;
        if (!rest.mesh->triangles.empty())
            scene.surfaces.push_back(std::move(rest));
        const Vec3 aim = middle_of(chest.approach.incision);
        const Vec3 along = (chest.approach.incision.back() - chest.approach.incision.front()).normalized();
        constexpr double kDistance = 420.0, kAngle = 22.0;
        // The incision runs across the picture, with the head end up.
        Vec3 up = chest.inward.cross(along).normalized();
        if (up.z() < 0.0)
            up = -up;
        // slightly from above, so that light enters the wound
        const Vec3 from = (-chest.inward + 0.25 * up).normalized();
        scene.camera = { .eye = aim + kDistance * from, .aim = aim, .up = up, .view_angle_deg = kAngle };
        return scene;
    }

    ui::Scene opened_scene(
        const CutChest& chest, const TriMesh& body, GapePicture& picture, Points& start, double scale, const Job& job)
    {
        fem::SpringNetwork springs(mesh::CutSession { chest.wall }, chest.materials, tension(chest, picture.strain));
        springs.fix(chest.held);
        springs.apply(chest.cut.delta);
        springs.set_wound(chest.session->lips());
        // start from the answer of the smaller strain
        if (start.rows() > 0)
            springs.set_displacement((scale * start).eval());
        const fem::RelaxResult result = fem::relax(springs, { .tolerance = 1e-2, .max_iterations = 4000 }, job);
        if (job.cancelled())
            throw SolverError("cancelled");
        start = springs.displacement();
        picture.gape_mm = skin_gape(chest, springs);
        picture.seconds = result.seconds;
        std::array<char, 160> text {};
        std::snprintf(text.data(), text.size(),
            "skin gapes %.1f mm; %d iterations in %.1f s, residual %.0e%s, %d elements turned over", picture.gape_mm,
            result.iterations, result.seconds, result.residual,
            result.status == fem::RelaxStatus::converged ? "" : " (not converged)", result.inverted);
        picture.status = text.data();
        return wound_scene(chest, springs, body, picture);
    }

    TriMesh body_surface(const mesh::LabelVolume& labels, const Job& job)
    {
        std::vector<Label> wall;
        for (const mesh::LabelInfo& info : labels.table)
            if (info.role == mesh::Role::wall)
                wall.push_back(info.id);
        return mesh::viewing_surface(labels, wall, kBodySmoothing, job);
    }

} // namespace

std::vector<GapePicture> draw_gapes(const std::filesystem::path& folder, const Job& job)
{
    const CutChest chest = cut_chest(job);
    const TriMesh body = body_surface(chest.phantom.labels, job);
    ui::OffscreenRenderer renderer(ui::make_offscreen_context(), job);
    std::vector<GapePicture> pictures;
    ui::Picture together {
        .width = static_cast<int>(kStrains.size()) * kWidth * 2 / 3, .height = kHeight * 2 / 3, .viewports = {}
    };
    Points displacement;
    for (std::size_t i = 0; i < kStrains.size(); ++i) {
        GapePicture picture { .strain = kStrains[i], .status = {}, .file = {} };
        const ui::Scene scene
            = opened_scene(chest, body, picture, displacement, i == 0 ? 1.0 : kStrains[i] / kStrains[i - 1], job);
        picture.file = folder / ("gape-" + std::to_string(std::lround(100.0 * picture.strain)) + ".png");
        ui::write_png(
            picture.file, renderer.render({ .width = kWidth, .height = kHeight, .viewports = { { .scene = scene } } }));
        const double share = 1.0 / static_cast<double>(kStrains.size()), left = share * static_cast<double>(i);
        together.viewports.push_back({ .left = left, .right = left + share, .scene = scene });
        pictures.push_back(std::move(picture));
    }
    ui::write_png(folder / "gape.png", renderer.render(together));
    return pictures;
}

} // namespace retractor::benchmarks
