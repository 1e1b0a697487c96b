#include "planner/plan/opened_wound.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/material/material.h"
#include "fem/statics/hook.h"
#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening.h"
#include "planner/approach/hook_patches.h"
#include "planner/wall/supports.h"
#include "planner/wall/wall_pressure.h"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace retractor::planner {

namespace {

    /// A costovertebral joint gives by 1.1 to 1.6 mm under 28 N, 18 to 26 N/mm (Lebschy 2024, J Biomech 163:111923):
    /// this modulus over a rib's section of about 90 mm^2 and kJointReachMm less the fixed gap, about 9 mm.
    constexpr double kJointModulusMPa = 2.2;

    /// The wall's materials as the solver takes them: by label, and one more "label" for the joints.
    struct ElasticWall {
        mesh::TetMesh mesh;
        std::vector<fem::Material> materials;
    };

    ElasticWall elastic_wall(const mesh::TetMesh& wall, const mesh::LabelVolume& labels, const Case& planned_case,
        std::span<const Label> fixed_labels)
    {
        ElasticWall elastic { wall, materials_as_solved(planned_case) };
        if (fixed_labels.empty())
            return elastic;
        const auto joint_label = static_cast<Label>(elastic.materials.size());
        elastic.materials.push_back({ .name = "costovertebral joint",
            .youngs_modulus_MPa = kJointModulusMPa,
            .poissons_ratio = 0.40,
            .density_tonne_per_mm3 = 1.1e-9,
            .source = "Lebschy 2024, J Biomech 163:111923" });
        const std::vector<bool> is_joint = joint_elements(wall, labels, fixed_labels);
        for (std::size_t t = 0; t < is_joint.size(); ++t)
            if (is_joint[t])
                elastic.mesh.labels[t] = joint_label;
        return elastic;
    }

    /// With the organs that stay where they are.
    fem::ContactOptions contact_of(const PlannedField& field, Patient& patient)
    {
        fem::ContactOptions contact;
        for (const mesh::LabelInfo& info : patient.planned_case().label_table)
            if (stays_in_place(info, field.approach, patient))
                contact.fixed.push_back(*patient.organ(info.name));
        return contact;
    }

    Points lip_points(const PlannedField& field)
    {
        std::set<VertexId> vertices;
        for (const mesh::LipFace& lip : field.lips)
            for (const VertexId v : mesh::face_vertices(field.wall, lip.face))
                vertices.insert(v);
        return field.wall.vertices(std::vector<VertexId>(vertices.begin(), vertices.end()), Eigen::all);
    }

    /// Of the wall's materials under the laws that hyperelastic tissue has them by.
    std::vector<std::pair<std::string, std::string>> laws_of(const fem::ElasticProblem& problem)
    {
        std::vector<std::pair<std::string, std::string>> laws;
        for (const Label label : fem::labels_met(problem.mesh)) {
            const fem::Material& material = problem.material_of_label[label];
            const std::pair<std::string, std::string> law { material.name, fem::law_in_words(material) };
            if (std::find(laws.begin(), laws.end(), law) == laws.end())
                laws.push_back(law);
        }
        return laws;
    }

    SolutionMetrics solution_metrics(const PlannedField& field, const SolverSettings& choice)
    {
        SolutionMetrics solution { .choice = choice, .nodes = field.problem.mesh.vertex_count() };
        if (choice.elasticity == fem::Elasticity::hyperelastic)
            solution.laws = laws_of(field.problem);
        return solution;
    }

} // namespace

bool is_usable(const fem::OpeningResult& opening)
{
    // Slivers turned over at the rims of hooks do not move a wound of many thousand elements: they are counted, said
    // and left. More of them than this share, and the wound is no state that tissue can be in.
    constexpr double kMostInverted = 0.002;
    return opening.status == fem::OpeningStatus::converged
        || (opening.status == fem::OpeningStatus::inverted
            && opening.inverted_elements <= kMostInverted * static_cast<double>(opening.strain.size()));
}

bool has_linear_condensed_region(const PlannedField& field) { return field.opening.far && field.opening.far->kept; }

std::vector<std::uint8_t> near_elements(const PlannedField& field, double near_mm)
{
    const mesh::TetMesh& mesh = field.problem.mesh;
    std::vector<std::uint8_t> near = fem::elements_near(mesh, lip_points(field), near_mm);
    std::vector<std::uint8_t> seeds(mesh.vertex_count(), 0);
    for (const fem::HookPatch& hook : field.problem.hooks)
        for (const VertexId v : hook.nodes)
            seeds[static_cast<std::size_t>(v)] = 1;
    for (const fem::FaceTraction& load : field.problem.loads)
        for (const VertexId v : mesh.tet(load.face.tet))
            seeds[static_cast<std::size_t>(v)] = 1;
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        for (const VertexId v : mesh.tet(t))
            near[static_cast<std::size_t>(t)] |= seeds[static_cast<std::size_t>(v)];
    return near;
}

std::vector<fem::HookDrive> drives_of(const Approach& approach)
{
    std::vector<fem::HookDrive> drives;
    bool all_prescribe = true;
    for (const HookSpec& spec : approach.hooks) {
        drives.push_back(drive_of(spec));
        all_prescribe = all_prescribe && spec.pull.prescribes();
    }
    return all_prescribe ? std::vector<fem::HookDrive>() : drives;
}

Job as_stage(const Job& job, std::string stage)
{
    Job named = job;
    if (job.on_progress)
        named.on_progress
            = [&job, stage = std::move(stage)](std::string_view, double fraction) { job.report(stage, fraction); };
    return named;
}

fem::OpeningOptions opening_options(const SolverSettings& choice)
{
    fem::OpeningOptions options;
    options.elasticity = choice.elasticity;
    options.locking_free = choice.element == ElementKind::locking_free;
    return options;
}

OpenedWall open_wall(const PlannedField& field, double near_mm, std::span<const fem::HookDrive> drives,
    fem::OpeningOptions options, const Job& job)
{
    OpenedWall opened;
    if (near_mm > 0.0) {
        options.near = near_elements(field, near_mm);
        opened.near_tets
            = static_cast<std::size_t>(std::count(options.near.begin(), options.near.end(), std::uint8_t { 1 }));
    }
    const fem::ElasticProblem& problem = field.problem;
    opened.hooks = problem.hooks;
    if (drives.empty()) {
        fem::Opening opening(problem, options);
        opened.opening = opening.open(problem.hooks, job);
    } else {
        fem::DrivenOpening driven = fem::open_driven(problem, drives, options, job);
        opened.opening = std::move(driven.opening);
        opened.hooks = std::move(driven.hooks);
        opened.yielded = std::move(driven.yielded);
    }
    fem::OpeningResult& result = opened.opening;
    if (result.status == fem::OpeningStatus::cancelled)
        return opened;
    if (problem.mesh.nodes_per_tet == 10)
        opened.ten_node = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
    result.displacement.conservativeResize(field.wall.vertices.rows(), 3); // without midpoints, which come last
    if (result.far && result.far->kept)
        result.far->displacement_change.conservativeResize(field.wall.vertices.rows(), 3);
    return opened;
}

OpenedWound open_wound(PlannedField& field, Patient& patient, const mesh::LabelVolume& labels,
    std::span<const Label> fixed_labels, CutWall cut, const Job& job)
{
    const Case& planned_case = patient.planned_case();
    const SolverSettings& choice = planned_case.solution;
    fem::OpeningOptions options = opening_options(choice);
    if (planned_case.contact)
        options.contact = contact_of(field, patient);
    ElasticWall elastic = elastic_wall(field.wall, labels, planned_case, fixed_labels);
    field.problem = { .mesh = std::move(elastic.mesh),
        .material_of_label = std::move(elastic.materials),
        .supports = std::move(cut.supports),
        .hooks = field.hooks,
        .loads = std::move(cut.released),
        .pressures = {} };
    for (WallPressure& pressure : wall_pressures(field.wall, labels, planned_case, cut.wound)) {
        field.metrics.pressures.push_back(
            pressure_metrics(field.wall, pressure, choice.elasticity != fem::Elasticity::linear));
        field.problem.pressures.push_back(std::move(pressure.acts));
    }
    if (choice.element == ElementKind::p2)
        field.problem = with_midpoints(field.problem);
    field.metrics.solution = solution_metrics(field, choice);
    OpenedWall opened = open_wall(field, choice.near_mm, drives_of(field.approach), options, job);
    // From here on the hooks are held where they came to rest: exports are of that, and so are the answers that
    // estimates begin with.
    for (std::size_t h = 0; h < field.hooks.size(); ++h)
        field.hooks[h].displacement = field.problem.hooks[h].displacement = opened.hooks[h].displacement;
    field.yielded = std::move(opened.yielded);
    field.opening = std::move(opened.opening);
    field.metrics.solution.near_tets = opened.near_tets;
    if (options.contact)
        field.metrics.contact = ContactMetrics { field.opening.contact.touching, field.opening.contact.penetration,
            field.opening.contact.force_N, field.opening.contact_overlap_mm };
    if (field.opening.status == fem::OpeningStatus::cancelled) {
        field.status = PlanStatus::cancelled;
    } else if (!is_usable(field.opening)) {
        field.status
            = field.opening.status == fem::OpeningStatus::inverted ? PlanStatus::inverted : PlanStatus::not_converged;
    }
    OpenedWound wound { { .vertices = std::move(cut.rigid), .solved = {} }, std::move(options.contact),
        std::move(opened.ten_node) };
    if (field.opening.status == fem::OpeningStatus::cancelled || wound.rigid.vertices.empty())
        return wound;
    wound.rigid.solved = field.opening.displacement;
    move_rigid_pieces(field.wall, wound.rigid.vertices, field.opening.displacement);
    return wound;
}

std::vector<bool> pushing_hooks(const Approach& approach, const std::vector<Vec3>& forces_N)
{
    constexpr double kNothing = 1e-3; // of the largest: what nonlinear rest leaves of no force
    double largest = 0.0;
    for (const Vec3& force : forces_N)
        largest = std::max(largest, force.norm());
    std::vector<bool> pushing;
    for (std::size_t i = 0; i < forces_N.size(); ++i) {
        const Vec3 direction = approach.hooks[i].direction.normalized();
        const double along = forces_N[i].dot(direction), across = (forces_N[i] - along * direction).norm();
        pushing.push_back(-along > std::max(across, kNothing * largest));
    }
    return pushing;
}

std::array<double, 2> side_forces(const PlannedField& field, const std::vector<Vec3>& forces_N)
{
    const std::vector<bool> pushing = pushing_hooks(field.approach, field.opening.hook_forces_N);
    std::array<double, 2> of_side {};
    for (std::size_t i = 0; i < forces_N.size(); ++i)
        if (!pushing[i])
            of_side[field.hooks[i].side > 0 ? 0 : 1] += forces_N[i].norm();
    return of_side;
}

WoundMeasures measures_of(
    const PlannedField& field, const RigidPieces& rigid, Points& displacement, const std::vector<Vec3>& hook_forces_N)
{
    move_rigid_pieces(field.wall, rigid.vertices, displacement);
    const WoundEdges edges = wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach)));
    const OpeningGeometry geometry = opening_geometry(edges, field.wall, displacement);
    return { geometry.width_mm, geometry.area_mm2, side_forces(field, hook_forces_N) };
}

WoundMeasures measures_of(const PlannedField& field)
{
    return { field.geometry.width_mm, field.geometry.area_mm2, side_forces(field, field.opening.hook_forces_N) };
}

} // namespace retractor::planner
