#include "planner/plan.h"

#include "fem/hook.h"
#include "mesh/base/error.h"
#include "mesh/skeleton.h"
#include "mesh/wound_surface.h"
#include "planner/explanation.h"
#include "planner/supports.h"
#include "planner/wall_beyond.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <map>
#include <set>
#include <thread>
#include <utility>

namespace retractor {

namespace {

    /// A bone across fewer of the lines of sight is no obstacle.
    constexpr double kSmallestBoneShare = 0.01;

    /// Appends "stage: seconds" to the metrics when it goes out of scope.
    class StageTimer {
    public:
        StageTimer(FieldMetrics& metrics, std::string stage)
            : metrics_(metrics)
            , stage_(std::move(stage))
        {
        }
        StageTimer(const StageTimer&) = delete;
        StageTimer& operator=(const StageTimer&) = delete;
        ~StageTimer() { metrics_.seconds.emplace_back(stage_, watch_.seconds()); }

    private:
        FieldMetrics& metrics_;
        std::string stage_;
        Stopwatch watch_;
    };

    std::vector<Label> label_ids(const LabelTable& table, const std::vector<std::string>& names)
    {
        std::vector<Label> ids;
        for (const std::string& name : names) {
            const LabelInfo* info = find_label(table, name);
            if (info == nullptr)
                throw InputError("there is no label of this name", name);
            ids.push_back(info->id);
        }
        return ids;
    }

    bool contains(const std::vector<std::string>& names, const std::string& name)
    {
        return std::find(names.begin(), names.end(), name) != names.end();
    }

    /// P1 elements lock and fold when they are nearly incompressible; the wall is planned with at most this ratio.
    constexpr double kLargestPoissonsRatio = 0.45;

    /// A costovertebral joint gives by 1.1 to 1.6 mm under 28 N, 18 to 26 N/mm (Lebschy 2024, J Biomech 163:111923):
    /// this modulus over a rib's section of about 90 mm^2 and kJointReachMm less the fixed gap, about 9 mm.
    constexpr double kJointModulusMPa = 2.2;

    /// The wall's materials as the solver takes them: by label, and one more "label" for the joints.
    struct ElasticWall {
        TetMesh mesh;
        std::vector<Material> materials;
    };

    ElasticWall elastic_wall(
        const TetMesh& wall, const LabelVolume& labels, const Case& planned_case, std::span<const Label> fixed_labels)
    {
        ElasticWall elastic { wall, {} };
        for (const LabelInfo& info : planned_case.label_table) {
            if (elastic.materials.size() <= info.id)
                elastic.materials.resize(static_cast<std::size_t>(info.id) + 1);
            if (info.role != Role::wall)
                continue;
            Material material = find_material(planned_case.materials, info.material);
            material.poissons_ratio = std::min(material.poissons_ratio, kLargestPoissonsRatio);
            elastic.materials[info.id] = std::move(material);
        }
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

    /// Supports found on the uncut mesh, carried over the cut: copies of a fixed vertex are fixed, and so are new
    /// vertices on an edge between two fixed ones. Beds lie on bare bone, which no blade divides.
    Supports supports_after_cut(const Supports& uncut, const MeshDelta& delta, const SlotMap& map)
    {
        std::vector<bool> is_fixed(map.compact_vertex.size(), false);
        for (const VertexId v : uncut.fixed)
            is_fixed[static_cast<std::size_t>(v)] = true;
        for (const MeshDelta::VertexBorn& born : delta.vertices_born)
            if (is_fixed[static_cast<std::size_t>(born.a)] && is_fixed[static_cast<std::size_t>(born.b)])
                is_fixed[static_cast<std::size_t>(born.id)] = true;
        Supports supports;
        for (std::size_t slot = 0; slot < is_fixed.size(); ++slot)
            if (is_fixed[slot] && map.compact_vertex[slot] >= 0)
                supports.fixed.push_back(map.compact_vertex[slot]);
        std::sort(supports.fixed.begin(), supports.fixed.end());
        for (const BeddedVertex& bedded : uncut.bedded)
            if (const VertexId v = map.compact_vertex[static_cast<std::size_t>(bedded.vertex)]; v >= 0)
                supports.bedded.push_back({ v, bedded.stiffness });
        return supports;
    }

    std::vector<LipFace> compact_lips(const std::vector<LipFace>& lips, const SlotMap& map)
    {
        std::vector<LipFace> compact = lips;
        for (LipFace& lip : compact)
            lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
        return compact;
    }

    /// Cuts field.wall; returns false (with status and message set) when the blade does not meet it.
    bool cut_wall(PlannedField& field, TetMesh uncut, const LabelTable& table, Supports& supports, const Job& job)
    {
        CutSession session(std::move(uncut));
        CutOptions options;
        options.uncut_labels = label_ids(table, field.approach.uncut_labels);
        CutResult cut = session.cut(blade_of(field.approach), options, job);
        field.cut_report = cut.report;
        if (cut.status != CutStatus::done) {
            field.status = cut.status == CutStatus::cancelled ? PlanStatus::cancelled : PlanStatus::cut_missed;
            field.message = cut.message;
            return false;
        }
        SlotMap map;
        field.wall = session.compact_mesh(&map);
        field.lips = compact_lips(session.lips(), map);
        supports = supports_after_cut(supports, cut.delta, map);
        return true;
    }

    /// Where a hook sits: on the blade, `along` the incision and below the skin.
    struct HookPlace {
        Vec3 centre, along, depth;
    };

    HookPlace hook_place(const Approach& approach, const HookSpec& spec)
    {
        double rest = spec.along_mm;
        std::size_t i = 0;
        double length = (approach.incision[1] - approach.incision[0]).norm();
        while (rest > length && i + 2 < approach.incision.size()) {
            rest -= length;
            ++i;
            length = (approach.incision[i + 1] - approach.incision[i]).norm();
        }
        const double t = std::clamp(rest / length, 0.0, 1.0);
        const Vec3 depth = ((1.0 - t) * approach.directions[i] + t * approach.directions[i + 1]).normalized();
        const Vec3 on_skin = (1.0 - t) * approach.incision[i] + t * approach.incision[i + 1];
        return { on_skin + spec.depth_mm * depth, (approach.incision[i + 1] - approach.incision[i]) / length, depth };
    }

    /// A hook in front of a bone bears on it: a retractor's blade lies against the rib, with the muscle between them
    /// squeezed flat. Bone vertices under the patch and this far behind it move with the hook; without them the layer
    /// between hook and rib would have to be crushed to nothing before the rib moves.
    constexpr double kBearingMm = 8.0;
    /// Of the patch's width, to either side: the bone is borne on in its middle, so that it can turn on the hook.
    constexpr double kBearingShare = 0.25;

    std::vector<VertexId> bone_vertices(const TetMesh& mesh, const LabelTable& table)
    {
        std::set<VertexId> vertices;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (is_skeleton(*find_label(table, mesh.labels[static_cast<std::size_t>(t)])))
                for (const VertexId v : mesh.tet(t))
                    vertices.insert(v);
        return { vertices.begin(), vertices.end() };
    }

    bool is_behind_patch(const HookSpec& spec, const HookPlace& place, const Vec3& point)
    {
        const Vec3 offset = point - place.centre;
        const double behind = offset.dot(spec.direction);
        return behind >= 0.0 && behind <= kBearingMm
            && std::abs(offset.dot(place.along)) <= kBearingShare * spec.patch_width_mm
            && std::abs(offset.dot(place.depth)) <= 0.5 * spec.patch_height_mm;
    }

    std::vector<HookPatch> hook_patches(const PlannedField& field, const LabelTable& table, const Supports& supports)
    {
        std::map<int, std::vector<std::array<VertexId, 3>>> lip_of_side;
        std::map<int, std::set<VertexId>> vertices_of_side;
        for (const LipFace& lip : field.lips) {
            lip_of_side[lip.side].push_back(face_vertices(field.wall, lip.face));
            vertices_of_side[lip.side].insert(lip_of_side[lip.side].back().begin(), lip_of_side[lip.side].back().end());
        }
        const std::vector<VertexId> bones = bone_vertices(field.wall, table);
        const std::set<VertexId> held(supports.fixed.begin(), supports.fixed.end());
        std::vector<HookPatch> patches;
        for (const HookSpec& spec : field.approach.hooks) {
            const HookPlace place = hook_place(field.approach, spec);
            const std::vector<VertexId> on_lip = hook_patch_nodes(field.wall, lip_of_side[spec.side], place.centre,
                place.along, place.depth, spec.patch_width_mm, spec.patch_height_mm, spec.name);
            std::set<VertexId> nodes(on_lip.begin(), on_lip.end());
            for (const VertexId v : bones)
                if (is_behind_patch(spec, place, field.wall.vertices.row(v).transpose()))
                    nodes.insert(v);
            // Where the cut ends inside the tissue both lips share their vertices: no hook can hold those.
            const std::set<VertexId>& other_lip = vertices_of_side[-spec.side];
            std::erase_if(nodes, [&](VertexId v) { return other_lip.contains(v) || held.contains(v); });
            if (nodes.size() < 3)
                throw InputError("fewer than three free nodes lie under the patch: a hook is never a point",
                    "hook '" + spec.name + "'");
            patches.push_back({ .name = spec.name,
                .side = spec.side,
                .nodes = { nodes.begin(), nodes.end() },
                .displacement = spec.opening_mm * spec.direction });
        }
        return patches;
    }

    void open_wound(PlannedField& field, const Case& planned_case, const LabelVolume& labels,
        std::span<const Label> fixed_labels, Supports supports, const OpeningOptions& options, const Job& job)
    {
        ElasticWall elastic = elastic_wall(field.wall, labels, planned_case, fixed_labels);
        field.hooks = hook_patches(field, planned_case.label_table, supports);
        field.problem = { std::move(elastic.mesh), std::move(elastic.materials), std::move(supports), field.hooks };
        Opening opening(field.problem.mesh, field.problem.material_of_label, field.problem.supports, options);
        field.opening = opening.open(field.hooks, job);
        if (field.opening.status == OpeningStatus::cancelled) {
            field.status = PlanStatus::cancelled;
        } else if (field.opening.status == OpeningStatus::not_converged) {
            field.status = PlanStatus::not_converged;
            field.message = field.opening.message;
        }
    }

    /// The organ that a target given as a sphere lies in: it is operated on, and does not block the view of itself.
    const LabelInfo* organ_of_sphere(Patient& patient, const TargetSpec& target)
    {
        if (!target.is_sphere())
            return nullptr;
        const auto labels = patient.labels();
        const LabelInfo* info = find_label(patient.planned_case().label_table, label_at(*labels, target.centre));
        return info != nullptr && info->role != Role::wall ? info : nullptr;
    }

    std::vector<Occluder> occluders(Patient& patient, const PlannedField& field)
    {
        const Case& planned_case = patient.planned_case();
        const LabelTable& table = planned_case.label_table;
        std::vector<Occluder> all;
        all.push_back({ .name = "wall",
            .surface = deformed_boundary(field.wall, field.opening.displacement),
            .labels = table,
            .material = {},
            .wall = true });
        std::vector<Label> bones;
        for (const LabelInfo& info : table)
            if (info.role == Role::wall && is_skeleton(info))
                bones.push_back(info.id);
        all.push_back({ .name = "bone",
            .surface = tissue_surface(field.wall, field.opening.displacement, bones).surface,
            .labels = table,
            .material = "bone",
            .wall = true });
        all.push_back({ .name = "wall beyond the model",
            .surface = field.remaining_wall,
            .labels = {},
            .material = {},
            .wall = true });
        const LabelInfo* operated_on = organ_of_sphere(patient, field.approach.target);
        for (const LabelInfo& info : table) {
            const bool is_organ = info.role != Role::wall && info.name != field.approach.target.label
                && (operated_on == nullptr || info.id != operated_on->id);
            if (is_organ && !contains(field.approach.retracted, info.name) && patient.has_voxels(info.name))
                all.push_back({ .name = info.name,
                    .surface = *patient.organ(info.name),
                    .labels = {},
                    .material = info.material,
                    .wall = false });
        }
        return all;
    }

    void look_through(PlannedField& field, Patient& patient, const Job& job)
    {
        const SweptBlade blade(blade_of(field.approach));
        const WoundEdges edges = wound_edges(field.wall, field.lips, blade);
        field.geometry = opening_geometry(edges, field.wall, field.opening.displacement);
        const std::shared_ptr<const TriMesh> target = patient.target(field.approach.target);
        const Vec3 aim = surface_centre(*target);
        const ViewSpec& view = field.approach.view;
        const double eye_distance = (field.geometry.centre - aim).norm() + view.eye_distance_mm;
        const ViewCone cone
            = cone_through_opening(field.geometry, aim, eye_distance, view.half_angle_deg, view.eye_count);
        const RayScene scene(*target, occluders(patient, field), job);
        field.exposure = scene.exposure(cone, {}, job);
        if (field.exposure.status == ExposureStatus::cancelled)
            field.status = PlanStatus::cancelled;
        const auto distance = working_distance_mm(field.geometry, *target, aim, cone.axis);
        if (const LabelInfo* organ = organ_of_sphere(patient, field.approach.target))
            field.message += (field.message.empty() ? "" : "; ") + std::string("the sphere lies in the ") + organ->name
                + ", which is not counted as blocking its view";
        field.metrics.working_distance_mm = distance.value_or((field.geometry.centre - aim).norm());
    }

    std::string status_text(const PlannedField& field)
    {
        return field.opening.status == OpeningStatus::converged ? "converged"
                                                                : "not converged: " + field.opening.message;
    }

    void fill_metrics(PlannedField& field, Patient& patient)
    {
        FieldMetrics& m = field.metrics;
        const Exposure& seen = field.exposure;
        m.name = field.approach.name;
        m.target = field.approach.target.is_sphere() ? "sphere" : field.approach.target.label;
        m.visible_fraction = seen.visible_fraction;
        m.visible_fraction_mean_eye = seen.mean_visible_fraction;
        m.visible_fraction_central_eye = seen.central_eye_fraction;
        m.visible_fraction_wall_removed = seen.visible_fraction_unobstructed;
        m.eye_distance_mm = seen.cone.eye_distance_mm;
        m.cone_half_angle_deg = seen.cone.half_angle_deg;
        m.eyes = seen.cone.eyes;
        m.target_samples = static_cast<int>(seen.samples);
        for (const SightShare& blocker : seen.blocked_by) {
            const LabelInfo* info = find_label(patient.planned_case().label_table, blocker.name);
            m.blockers.push_back({ blocker.name, blocker.share, info != nullptr && is_skeleton(*info) });
        }
        for (const SightShare& bone : seen.bone_in_sight)
            if (bone.share >= kSmallestBoneShare)
                m.bone_in_sight.push_back(bone.name);
        m.retracted = field.approach.retracted;
        m.opening_area_mm2 = field.geometry.area_mm2;
        m.opening_width_mm = field.geometry.width_mm;
        m.incision_length_mm = field.geometry.incision_length_mm;
        m.cut_depth_mm = field.approach.depth_mm;
        double per_side[2] = { 0.0, 0.0 };
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const double force = field.opening.hook_forces_N[i].norm();
            m.hooks.push_back({ field.hooks[i].name, field.hooks[i].side, force });
            per_side[field.hooks[i].side > 0 ? 0 : 1] += force;
        }
        m.hook_force_N = std::max(per_side[0], per_side[1]);
        m.strain_p99 = field.opening.strain_p99;
        m.inverted_elements = field.opening.inverted_elements;
        m.max_volume_ratio = field.opening.max_volume_ratio;
        m.residual = field.opening.residual;
        m.mechanics_status = status_text(field);
        m.tets = field.wall.tet_count();
        m.explanation = explain_field(field, patient.frame());
    }

    std::string place_of(const Approach& approach, const Error& error)
    {
        return "approach " + approach.name + (error.where().empty() ? "" : ": " + error.where());
    }

} // namespace

PlannedField plan_approach(Patient& patient, const Approach& approach, const Job& job, const OpeningOptions& options)
{
    check_approach(approach);
    PlannedField field;
    field.approach = approach;
    const Case& planned_case = patient.planned_case();
    const auto labels = patient.labels();
    const MeshSizing sizing = mesh_sizing_of(approach, planned_case.label_table);
    const std::vector<Label> fixed_labels = label_ids(planned_case.label_table, planned_case.supports.labels);
    Supports supports;
    {
        const StageTimer timer(field.metrics, "mesh");
        HybridModel model = build_hybrid_model(*labels, sizing, job);
        field.mesh_statistics = model.statistics;
        if (model.status != MeshStatus::done) {
            field.status = model.status == MeshStatus::cancelled ? PlanStatus::cancelled : PlanStatus::nothing_to_mesh;
            field.message = model.message;
            return field;
        }
        field.message = std::move(model.message);
        field.wall = std::move(model.wall);
    }
    {
        const StageTimer timer(field.metrics, "cut");
        supports.fixed = wall_supports(
            field.wall, *labels, fixed_labels, sizing.whole_labels, planned_case.supports.region_border);
        supports.bedded = girdle_beds(field.wall, *labels, sizing.whole_labels);
        if (!cut_wall(field, std::move(field.wall), planned_case.label_table, supports, job))
            return field;
    }
    {
        const StageTimer timer(field.metrics, "open");
        open_wound(field, planned_case, *labels, fixed_labels, std::move(supports), options, job);
        if (field.status == PlanStatus::cancelled)
            return field;
    }
    {
        const StageTimer timer(field.metrics, "expose");
        field.remaining_wall
            = wall_beyond_region(*patient.body(), *labels, sizing, field.wall, field.opening.displacement, job);
        look_through(field, patient, job);
    }
    if (field.status != PlanStatus::cancelled)
        fill_metrics(field, patient);
    return field;
}

std::vector<PlannedField> plan_all(Patient& patient, const Job& job, const OpeningOptions& options)
{
    const std::vector<Approach>& approaches = patient.planned_case().approaches;
    std::vector<PlannedField> fields(approaches.size());
    std::vector<std::exception_ptr> failures(approaches.size());
    std::atomic<std::size_t> next { 0 };
    const auto work = [&] {
        for (std::size_t i = next.fetch_add(1); i < approaches.size(); i = next.fetch_add(1)) {
            try {
                fields[i] = plan_approach(patient, approaches[i], job, options);
            } catch (const InputError& error) {
                failures[i] = std::make_exception_ptr(InputError(error.what(), place_of(approaches[i], error)));
                next.store(approaches.size());
            } catch (const SolverError& error) {
                failures[i] = std::make_exception_ptr(SolverError(error.what(), place_of(approaches[i], error)));
                next.store(approaches.size());
            } catch (...) {
                failures[i] = std::current_exception();
                next.store(approaches.size());
            }
        }
    };
    const std::size_t workers = std::min<std::size_t>({ 2, approaches.size(),
        std::max(1U, std::thread::hardware_concurrency()), static_cast<std::size_t>(std::max(1, job.threads)) });
    {
        std::vector<std::jthread> threads;
        for (std::size_t w = 1; w < workers; ++w)
            threads.emplace_back(work);
        work();
    }
    for (const std::exception_ptr& failure : failures)
        if (failure)
            std::rethrow_exception(failure);
    return fields;
}

} // namespace retractor
