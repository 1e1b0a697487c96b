#include "tests/benchmarks/palpation/sphere_scenes.h"

#include "datasets/phantoms/abdomen_phantom.h"
#include "mesh/surface/label_surface.h"
#include "ui/cli/framework/ball_mesh.h"
#include "ui/scene/tissue_colors.h"

#include <algorithm>
#include <array>
#include <memory>

namespace retractor::benchmarks {

namespace {

    constexpr double kSmoothing = 2.0; // mm
    constexpr double kLiverModulus = 0.0054, kMuscleModulus = 0.04, kRatio = 0.49; // MPa: values of default_materials()

    TriMesh label_mesh(const mesh::LabelVolume& labels, const char* name, const Job& job)
    {
        const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
        const std::array<Label, 1> which { info->id };
        TriMesh mesh = mesh::viewing_surface(labels, which, kSmoothing, job);
        mesh.labels.clear();
        return mesh;
    }

    ui::Color plain_color(std::size_t organ)
    {
        constexpr std::array<ui::Color, 4> kColors { { { 0.62, 0.25, 0.20 }, { 0.87, 0.62, 0.55 }, { 0.90, 0.76, 0.64 },
            { 0.6, 0.6, 0.7 } } };
        return kColors[organ % kColors.size()];
    }

    /// Colours by layer: spheres that a finger holds are white; spheres far from the finger keep the organ's colour.
    ui::Color layer_color(const haptics::SphereMotion& motion, std::size_t i)
    {
        const ui::Color base = plain_color(motion.organ_of(i));
        const int layer = motion.layer(i);
        if (layer < 0)
            return base;
        const double share = 1.0 / (1.0 + 0.5 * layer);
        return { base.r + share * (1.0 - base.r), base.g + share * (0.9 - base.g), base.b + share * (0.3 - base.b) };
    }

    ui::SurfaceItem sphere_item(const haptics::SphereMotion& motion, std::size_t organ)
    {
        std::vector<std::size_t> own;
        for (std::size_t i = 0; i < motion.sphere_count(); ++i)
            if (motion.organ_of(i) == organ)
                own.push_back(i);
        Points centres(static_cast<Eigen::Index>(own.size()), 3);
        for (std::size_t k = 0; k < own.size(); ++k)
            centres.row(static_cast<Eigen::Index>(k)) = motion.positions().row(static_cast<Eigen::Index>(own[k]));
        const int divisions = own.size() > 4000 ? 1 : 2;
        ui::SurfaceItem item;
        item.name = motion.organ(organ).name + ", spheres";
        auto mesh
            = std::make_shared<TriMesh>(ui::cli::ball_meshes(centres, motion.organ(organ).filling.radius, divisions));
        const std::size_t triangles_each = mesh->triangles.size() / own.size();
        for (const std::size_t i : own) {
            const auto label = static_cast<Label>(motion.layer(i) + 1);
            mesh->labels.insert(mesh->labels.end(), triangles_each, label);
            item.look_of_label[label] = { .color = layer_color(motion, i) };
        }
        item.mesh = std::move(mesh);
        return item;
    }

} // namespace

TriMesh phantom_liver_surface(const Job& job)
{
    datasets::AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(3.0, 3.0, 3.0);
    const datasets::Phantom phantom = datasets::make_liver_phantom(parameters, job);
    return label_mesh(phantom.labels, "liver", job);
}

haptics::SphereOrgan filled_organ(const std::string& name, const TriMesh& surface, std::size_t wanted,
    const haptics::SphereLaw& law, double modulus_MPa, double ratio)
{
    haptics::SphereOrgan organ { name, surface, haptics::fill_with_count(surface, wanted), 1.0 };
    organ.stiffness = haptics::calibrate_sphere_force(organ.filling.radius, law, modulus_MPa, ratio);
    return organ;
}

std::vector<haptics::SphereOrgan> abdomen_organs(const haptics::SphereLaw& law, const Job& job)
{
    datasets::AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(3.0, 3.0, 3.0);
    const datasets::Phantom phantom = datasets::make_abdomen_phantom(parameters, job);
    constexpr std::size_t kLiverSpheres = 1880; // as in Suzuki and others
    std::vector<haptics::SphereOrgan> organs;
    organs.push_back(
        filled_organ("liver", label_mesh(phantom.labels, "liver", job), kLiverSpheres, law, kLiverModulus, kRatio));
    const double radius = organs[0].filling.radius;
    for (const auto& [name, label] : { std::pair { "stomach", "stomach" }, { "skin", "abdominal_wall" } }) {
        TriMesh surface = label_mesh(phantom.labels, label, job);
        const double factor = label == std::string("stomach") ? 0.8 : 0.75; // thinner parts need smaller spheres
        haptics::SphereOrgan organ { name, surface, haptics::fill_with_spheres(surface, factor * radius), 1.0 };
        organ.stiffness = haptics::calibrate_sphere_force(organ.filling.radius, law, kMuscleModulus, kRatio);
        organs.push_back(std::move(organ));
    }
    return organs;
}

ui::Scene sphere_scene(const haptics::SphereMotion& motion, SphereView view, std::span<const haptics::Fingertip> tips,
    std::span<const std::size_t> hidden_organs)
{
    ui::Scene scene;
    Points deformed;
    motion.deform(deformed);
    for (std::size_t o = 0; o < motion.organ_count(); ++o) {
        if (std::find(hidden_organs.begin(), hidden_organs.end(), o) != hidden_organs.end())
            continue;
        if (view == SphereView::spheres) {
            scene.surfaces.push_back(sphere_item(motion, o));
            continue;
        }
        auto mesh = std::make_shared<TriMesh>();
        mesh->vertices = deformed;
        for (std::size_t t = 0; t < motion.surface().triangles.size(); ++t)
            if (motion.surface().labels[t] == o + 1)
                mesh->triangles.push_back(motion.surface().triangles[t]);
        ui::SurfaceItem item;
        item.name = motion.organ(o).name;
        item.mesh = std::move(mesh);
        const std::string material = item.name == "liver" ? "liver" : item.name == "skin" ? "skin" : "muscle";
        item.look = view == SphereView::textured ? ui::tissue_look(material) : ui::Look { .color = plain_color(o) };
        if (view == SphereView::textured)
            item.look.texture = 1.0;
        scene.surfaces.push_back(std::move(item));
    }
    for (const haptics::Fingertip& tip : tips)
        scene.surfaces.push_back({ .name = "fingertip",
            .mesh = std::make_shared<TriMesh>(ui::cli::ball_mesh(tip.position, tip.radius, 3)),
            .look = { .color = { 0.97, 0.97, 0.97 } } });
    if (const auto box = ui::scene_bounds(scene))
        scene.camera = ui::camera_for_box(*box, Vec3(0.25, 1.0, -0.25), Vec3::UnitZ());
    return scene;
}

} // namespace retractor::benchmarks
