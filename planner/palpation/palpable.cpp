#include "planner/palpation/palpable.h"

#include "mesh/base/error.h"
#include "mesh/base/memory.h"
#include "mesh/base/text_format.h"
#include "mesh/generation/hybrid_model.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/wall_shell.h"
#include "planner/palpation/palpable_hold.h"
#include "planner/palpation/palpable_sites.h"
#include "planner/plan/plan_forecast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <set>

namespace retractor::planner {

namespace {

    constexpr Label kUsual = 1, kStiff = 2;
    constexpr double kVesselWall = 2.0, kWallEdge = 5.0; ///< mm
    constexpr const char* kVessel = "vessel";

    void check_range(double value, double low, double high, const char* where, const char* field)
    {
        if (value >= low && value <= high)
            return;
        std::array<char, 96> limits {};
        std::snprintf(limits.data(), limits.size(), "must lie between %g and %g, not at %g", low, high, value);
        throw InputError(limits.data(), where, { field });
    }

    void check_request(const mesh::LabelVolume& labels, const PalpableRequest& request)
    {
        if (request.structure.empty())
            throw InputError(
                "names what to palpate; there are " + names_of(labels.table), "structure", { "structure" });
        for (const std::string& name : request.structure)
            label_of(labels, name, "structure");
        if (request.wall_mm && *request.wall_mm != 0.0)
            check_range(*request.wall_mm, 0.5, 20.0, "thickness of the wall (mm; 0: solid)", "wall_mm");
        if (request.edge_mm)
            check_range(*request.edge_mm, 1.0, 40.0, "length of the edges (mm)", "edge_mm");
        if (request.youngs_modulus_MPa)
            check_range(*request.youngs_modulus_MPa, 1e-4, 1e4, "Young's modulus (MPa)", "youngs_modulus_MPa");
        if (request.poissons_ratio)
            check_range(*request.poissons_ratio, 0.0, 0.495, "Poisson's ratio", "poissons_ratio");
        for (const StiffPlace& place : request.stiff) {
            check_range(place.youngs_modulus_MPa, 1e-4, 1e4, "Young's modulus of a stiff place (MPa)", "stiff");
            if (place.where.is_site())
                throw InputError("a stiff place is a label or a ball, not a site on a label", "stiff", { "stiff" });
            if (!place.where.is_sphere())
                label_of(labels, place.where.label, "stiff");
            else if (!(place.where.centre.allFinite() && place.where.radius_mm > 0.0))
                throw InputError("a ball has a finite centre and a positive radius", "stiff", { "stiff" });
        }
        std::set<std::string> names;
        for (const auto& [name, point] : request.sites)
            if (name.empty() || !point.allFinite() || !names.insert(name).second)
                throw InputError("sites have names of their own and finite points", "site " + name, { "sites" });
    }

    bool is_hollow(const mesh::LabelVolume& labels, const PalpableRequest& request)
    {
        if (request.wall_mm)
            return *request.wall_mm > 0.0;
        return std::all_of(request.structure.begin(), request.structure.end(),
            [&](const std::string& name) { return label_of(labels, name, "structure").material.starts_with(kVessel); });
    }

    bool holds_blood(const mesh::LabelVolume& labels, const PalpableRequest& request)
    {
        return std::all_of(request.structure.begin(), request.structure.end(), [&](const std::string& name) {
            const std::string& material = label_of(labels, name, "structure").material;
            return material.starts_with(kVessel) || material == "heart";
        });
    }

    /// The structure alone, for the mesher. A hollow structure becomes a single label.
    mesh::LabelVolume structure_alone(const mesh::LabelVolume& labels, const PalpableRequest& request, bool hollow)
    {
        mesh::LabelVolume alone { labels.grid, labels.voxels, {} };
        std::vector<Label> becomes(std::size_t { std::numeric_limits<Label>::max() } + 1, 0);
        for (std::size_t s = 0; s < request.structure.size(); ++s) {
            mesh::LabelInfo info = label_of(labels, request.structure[s], "structure");
            if (becomes[info.id] != 0)
                throw InputError("is named twice", "structure " + request.structure[s], { "structure" });
            if (std::find(labels.voxels.begin(), labels.voxels.end(), info.id) == labels.voxels.end())
                throw InputError("has no voxel", "structure " + request.structure[s], { "structure" });
            const Label id = hollow ? kUsual : static_cast<Label>(s + 1);
            becomes[info.id] = id;
            info.id = id;
            info.role = mesh::Role::wall;
            if (!hollow || s == 0)
                alone.table.push_back(info);
        }
        for (Label& voxel : alone.voxels)
            voxel = becomes[voxel];
        return alone;
    }

    constexpr double kVoxels = 1.25; ///< smallest smoothing width in voxels; single voxels are no shape

    /// A Gaussian blur along one axis of the grid. At the image's border the voxels of the border continue.
    void blur_along(std::vector<float>& values, const std::array<int, 3>& size, std::size_t axis, double sigma_voxels)
    {
        const int reach = static_cast<int>(std::ceil(3.0 * sigma_voxels));
        std::vector<float> weights, line(static_cast<std::size_t>(size[axis]));
        for (int d = -reach; d <= reach; ++d)
            weights.push_back(static_cast<float>(std::exp(-0.5 * d * d / (sigma_voxels * sigma_voxels))));
        const float sum = std::accumulate(weights.begin(), weights.end(), 0.0F);
        std::size_t step = 1;
        for (std::size_t a = 0; a < axis; ++a)
            step *= static_cast<std::size_t>(size[a]);
        for (std::size_t start = 0; start < values.size(); ++start) {
            if (start / step % line.size() != 0)
                continue;
            for (std::size_t i = 0; i < line.size(); ++i)
                line[i] = values[start + i * step];
            for (int i = 0; i < size[axis]; ++i) {
                float value = 0.0F;
                for (int d = -reach; d <= reach; ++d)
                    value += weights[static_cast<std::size_t>(d + reach)]
                        * line[static_cast<std::size_t>(std::clamp(i + d, 0, size[axis] - 1))];
                values[start + static_cast<std::size_t>(i) * step] = value / sum;
            }
        }
    }

    /// Smooths a body: removes parts much thinner than `sigma_mm` and fills dents, so that fingers meet organs instead
    /// of voxels. Where labels meet, each point goes to the label with the largest share round it.
    mesh::LabelVolume smoothed(mesh::LabelVolume body, double sigma_mm)
    {
        mesh::ImageGrid& grid = body.grid;
        std::array<int, 3> low = grid.size, high { 0, 0, 0 };
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i)
                    if (body.voxels[grid.offset(i, j, k)] != 0) {
                        const std::array<int, 3> at { i, j, k };
                        for (std::size_t a = 0; a < 3; ++a) {
                            low[a] = std::min(low[a], at[a]);
                            high[a] = std::max(high[a], at[a]);
                        }
                    }
        std::array<int, 3> size {};
        for (std::size_t a = 0; a < 3; ++a) {
            const int margin = 1 + static_cast<int>(std::ceil(3.0 * sigma_mm / grid.spacing[static_cast<int>(a)]));
            low[a] = std::max(0, low[a] - margin);
            size[a] = std::min(grid.size[a] - 1, high[a] + margin) - low[a] + 1;
        }
        const auto each = [&](auto&& act) {
            std::size_t n = 0;
            for (int k = 0; k < size[2]; ++k)
                for (int j = 0; j < size[1]; ++j)
                    for (int i = 0; i < size[0]; ++i)
                        act(body.voxels[grid.offset(low[0] + i, low[1] + j, low[2] + k)], n++);
        };
        const std::size_t count
            = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
        std::vector<float> most(count, 0.0F), sum(count, 0.0F), share(count);
        std::vector<Label> winner(count, 0);
        for (const mesh::LabelInfo& info : body.table) {
            each([&](Label voxel, std::size_t n) { share[n] = voxel == info.id ? 1.0F : 0.0F; });
            for (std::size_t axis = 0; axis < 3; ++axis)
                blur_along(share, size, axis, sigma_mm / grid.spacing[static_cast<int>(axis)]);
            for (std::size_t n = 0; n < count; ++n) {
                sum[n] += share[n];
                if (share[n] > most[n]) {
                    most[n] = share[n];
                    winner[n] = info.id;
                }
            }
        }
        each([&](Label& voxel, std::size_t n) { voxel = sum[n] > 0.5F ? winner[n] : Label { 0 }; });
        if (std::all_of(body.voxels.begin(), body.voxels.end(), [](Label v) { return v == 0; }))
            throw InputError("is too thin to be meshed: thinner than its wall, or than two voxels",
                "structure " + body.table.front().name, { "structure" });
        return body;
    }

    double volume_of(const mesh::LabelVolume& alone)
    {
        return alone.grid.voxel_volume()
            * static_cast<double>(
                std::count_if(alone.voxels.begin(), alone.voxels.end(), [](Label v) { return v != 0; }));
    }

    mesh::TetMesh meshed(const mesh::LabelVolume& alone, double edge_mm, const Job& job)
    {
        mesh::MeshSizing sizing;
        sizing.coarse_edge_mm = edge_mm;
        sizing.most_tetrahedra = tetrahedra_limit(available_memory(), ElementKind::p1);
        mesh::HybridModel model = mesh::build_hybrid_model(alone, sizing, job);
        if (model.status == mesh::MeshStatus::nothing_to_mesh)
            throw SolverError("the structure was not meshed: " + model.message
                    + "; thin tissue needs edges shorter than " + in_words(edge_mm, 1) + " mm",
                alone.table.front().name, { "edge_mm" });
        if (model.status != mesh::MeshStatus::done)
            throw SolverError("the structure was not meshed: " + model.message, alone.table.front().name);
        return std::move(model.wall);
    }

    TriMesh boundary_of(const mesh::TetMesh& mesh)
    {
        TriMesh surface { mesh.vertices, {}, {} };
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
            surface.triangles.push_back(mesh::face_vertices(mesh, face));
        return surface;
    }

    void give_elasticity(datasets::PalpationScene& scene, const mesh::LabelVolume& labels,
        const mesh::LabelTable& alone, const fem::MaterialTable& materials, std::span<const BoneStiffness> bones,
        const PalpableRequest& request, std::vector<std::string>& notes)
    {
        datasets::ElasticModel& body = scene.body;
        std::vector<std::array<double, 2>> of(alone.size());
        for (std::size_t s = 0; s < alone.size(); ++s) {
            fem::Material material = fem::find_material(materials, alone[s].material);
            const auto bone = std::find_if(
                bones.begin(), bones.end(), [&](const BoneStiffness& b) { return b.name == alone[s].name; });
            if (bone != bones.end()) {
                material.youngs_modulus_MPa = bone->modulus_MPa;
                material.source = bone->words;
            }
            of[s] = { request.youngs_modulus_MPa.value_or(material.youngs_modulus_MPa),
                request.poissons_ratio.value_or(material.poissons_ratio) };
            notes.push_back(alone[s].name + ": Young's modulus " + in_words(of[s][0], of[s][0] < 0.1 ? 4 : 2)
                + " MPa, Poisson's ratio " + in_words(of[s][1], 2)
                + (request.youngs_modulus_MPa ? ", as asked" : " (" + material.name + ": " + material.source + ")"));
        }
        std::vector<std::size_t> changed(request.stiff.size(), 0);
        for (std::size_t t = 0; t < body.mesh.tet_count(); ++t) {
            const auto& [young, poisson] = of[std::size_t { body.mesh.labels[t] } - 1];
            body.youngs_modulus.push_back(young);
            body.poissons_ratio.push_back(poisson);
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : body.mesh.tet(static_cast<TetId>(t)))
                middle += 0.25 * body.mesh.vertices.row(v).transpose();
            for (std::size_t p = 0; p < request.stiff.size(); ++p) {
                const TargetSpec& where = request.stiff[p].where;
                if (where.is_sphere()
                        ? (middle - where.centre).norm() > where.radius_mm
                        : mesh::label_at(labels, middle) != mesh::find_label(labels.table, where.label)->id)
                    continue;
                body.youngs_modulus.back() = request.stiff[p].youngs_modulus_MPa;
                if (scene.organs.empty())
                    body.mesh.labels[t] = kStiff;
                ++changed[p];
            }
        }
        for (std::size_t p = 0; p < changed.size(); ++p) {
            if (changed[p] == 0)
                throw InputError(
                    "no element of the structure lies there", "stiff place " + std::to_string(p + 1), { "stiff" });
            notes.push_back("stiff-" + std::to_string(p + 1) + ": " + std::to_string(changed[p]) + " elements of "
                + in_words(request.stiff[p].youngs_modulus_MPa, 2) + " MPa");
        }
    }

    std::string name_of(const PalpableRequest& request)
    {
        std::string name;
        for (const std::string& part : request.structure)
            name += (name.empty() ? "" : " and ") + part;
        return name;
    }

    /// Makes the scene's mesh and roles. The outline is smoothed more where no wall fits. @returns the surface that
    /// fingers see
    TriMesh make_wall(datasets::PalpationScene& scene, const mesh::LabelVolume& alone, double wall_mm, double edge_mm,
        bool blood, std::vector<std::string>& notes, const Job& job)
    {
        constexpr double kMore = 1.5;
        constexpr int kTries = 4;
        double smoothing = std::max(wall_mm, kVoxels * alone.grid.spacing.maxCoeff());
        TriMesh outer;
        mesh::WallShell shell;
        for (int tried = 1;; ++tried, smoothing *= kMore) {
            outer = mesh::largest_closed_surface(meshed(smoothed(alone, smoothing), edge_mm, job));
            try {
                shell = mesh::make_wall_shell(outer, wall_mm, kUsual);
                break;
            } catch (const SolverError& error) {
                if (tried == kTries)
                    throw SolverError(error.what(), error.where(), { "wall_mm", "edge_mm" });
            }
        }
        notes.push_back("its outline is smoothed by " + in_words(smoothing, 1)
            + " mm: branches and bumps thinner than that are left out");
        notes.push_back("a wall of " + in_words(wall_mm, 1) + " mm beneath the labelled outline, "
            + (blood ? "blood pressing inside" : "empty inside: no blood presses"));
        if (shell.thinned > 0)
            notes.push_back("the wall is thinner, down to " + in_words(shell.thinnest_mm, 2) + " mm, under "
                + std::to_string(shell.thinned) + " of " + std::to_string(outer.vertices.rows())
                + " vertices, where the vessel is narrow or bends sharply");
        outer.vertices = shell.mesh.vertices.topRows(outer.vertices.rows());
        scene.body.mesh = std::move(shell.mesh);
        scene.body.roles.assign(
            scene.body.mesh.vertex_count(), blood ? datasets::VertexRole::inner_wall : datasets::VertexRole::free);
        std::fill_n(scene.body.roles.begin(), outer.vertices.rows(), datasets::VertexRole::free);
        return outer;
    }

} // namespace

Palpable make_palpable(const mesh::LabelVolume& labels, const fem::MaterialTable& materials,
    const PalpableRequest& request, const Job& job, std::span<const BoneStiffness> bones)
{
    check_request(labels, request);
    const Stopwatch watch;
    const bool hollow = is_hollow(labels, request);
    const mesh::LabelVolume alone = structure_alone(labels, request, hollow);
    Palpable made;
    datasets::PalpationScene& scene = made.scene;
    scene.name = name_of(request);
    constexpr double kElementsAcross = 10.0;
    const double edge = request.edge_mm.value_or(
        hollow ? kWallEdge : std::clamp(std::cbrt(volume_of(alone)) / kElementsAcross, 3.0, 20.0));
    TriMesh surface;
    if (hollow)
        surface = make_wall(
            scene, alone, request.wall_mm.value_or(kVesselWall), edge, holds_blood(labels, request), made.notes, job);
    else {
        scene.body.mesh = meshed(smoothed(alone, kVoxels * labels.grid.spacing.maxCoeff()), edge, job);
        scene.body.roles.assign(scene.body.mesh.vertex_count(), datasets::VertexRole::free);
        surface = boundary_of(scene.body.mesh);
        if (alone.table.size() > 1)
            for (const mesh::LabelInfo& info : alone.table)
                scene.organs.push_back({ info.id, info.name });
    }
    give_elasticity(scene, labels, alone.table, materials, bones, request, made.notes);
    hold_surface(scene, surface, labels, request, hollow, made.notes);
    if (hollow) // the supports of a wall's outside also hold its inside
        for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
            if (scene.body.roles[static_cast<std::size_t>(v)] == datasets::VertexRole::fixed)
                scene.body.roles[static_cast<std::size_t>(v + surface.vertices.rows())] = datasets::VertexRole::fixed;
    refuse_floating(scene, made.notes);
    if (!hollow)
        surface = boundary_of(scene.body.mesh); // some vertices may be removed
    add_sites(scene, surface, labels, request);
    if (scene.sites.empty())
        throw InputError("no place is free to be pressed: less must hold the structure", scene.name, { "held" });
    datasets::check_elastic_model(scene.body);
    if (job.cancelled())
        throw SolverError("cancelled", scene.name);
    record_part(job, "palpable structure", watch,
        static_cast<std::size_t>(scene.body.mesh.vertices.size()) * sizeof(double)
            + scene.body.mesh.nodes.size() * sizeof(VertexId));
    return made;
}

Palpable make_palpable(Patient& patient, const PalpableRequest& request, const Job& job)
{
    const Case& planned_case = patient.planned_case();
    const auto is_bone = [&](const std::string& name) {
        const mesh::LabelInfo* info = mesh::find_label(planned_case.label_table, name);
        return info != nullptr && mesh::is_skeleton(*info);
    };
    const auto labels = patient.labels();
    // Only bones need the CT.
    if (std::any_of(request.structure.begin(), request.structure.end(), is_bone))
        return make_palpable(*labels, planned_case.materials, request, job, *patient.bone_stiffness());
    return make_palpable(*labels, planned_case.materials, request, job);
}

} // namespace retractor::planner
