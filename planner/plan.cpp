#include "planner/plan.h"

#include "fem/driven_opening.h"
#include "fem/error_estimate.h"
#include "fem/hook.h"
#include "fem/local_problem.h"
#include "fem/near_field.h"
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
#include <limits>
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

    void remark(std::string& message, const std::string& text)
    {
        if (!text.empty())
            message += (message.empty() ? "" : "; ") + text;
    }

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
            // Beyond it four-node elements lock and fold.
            material.poissons_ratio
                = std::min(material.poissons_ratio, largest_poissons_ratio(planned_case.solution.element));
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

    /// Takes over what was cut; returns false (with status and message set) when the blade does not meet it.
    bool take_cut(PlannedField& field, CutWall& cut)
    {
        field.cut_report = cut.report;
        if (cut.status != CutStatus::done) {
            field.status = cut.status == CutStatus::cancelled ? PlanStatus::cancelled : PlanStatus::cut_missed;
            field.message = cut.message;
            return false;
        }
        remark(field.message, cut.message);
        field.wall = std::move(cut.wall);
        field.lips = std::move(cut.lips);
        field.hooks = std::move(cut.hooks);
        field.pieces = std::move(cut.pieces);
        field.metrics.removed = std::move(cut.removed);
        field.metrics.removed_skin_mm2 = cut.removed_skin_mm2;
        field.metrics.loose_pieces = std::move(cut.loose);
        return true;
    }

    /// A wound without an edge on the skin cannot be measured: refused before it is opened.
    void check_lips(const PlannedField& field, const std::array<std::string, 2>& took_lip)
    {
        for (const std::size_t side : { 0U, 1U })
            if (!took_lip[side].empty() || !field.metrics.removed.empty())
                try {
                    static_cast<void>(wound_edges(field.wall, field.lips, SweptBlade(blade_of(field.approach))));
                } catch (const InputError& error) {
                    if (error.where() != (side == 0 ? "left lip" : "right lip"))
                        continue;
                    throw InputError(std::string(error.what())
                            + (took_lip[side].empty()
                                    ? "; an ablation may have taken it (" + removed_text(field.metrics.removed)
                                        + "): ablate less there, or choose another incision"
                                    : ": the loose piece that was removed took it along (" + took_lip[side]
                                        + "); let loose pieces be held or rigid (retractor approach add --loose), or "
                                          "choose another incision"),
                        error.where());
                }
    }

    /// What move_rigid_pieces() adds after the wound is solved: the pieces, and the answer without it.
    struct RigidPieces {
        std::vector<std::vector<VertexId>> vertices;
        Points solved; ///< the displacement in which they are held; empty when there are none
    };

    /// With the organs that stay where they are.
    ContactOptions contact_of(const PlannedField& field, Patient& patient)
    {
        ContactOptions contact;
        for (const LabelInfo& info : patient.planned_case().label_table)
            if (info.role != Role::wall && !contains(field.approach.retracted, info.name)
                && patient.has_voxels(info.name))
                contact.fixed.push_back(*patient.organ(info.name));
        return contact;
    }

    /// A part of the wall, solved in place of the whole.
    struct OpenedPart {
        Eigen::VectorXd ten_node {}; ///< as solved, at all nodes; of four-node elements: empty
        LocalProblem part; ///< empty for the whole wall
        std::vector<HookPatch> hooks; ///< where they are
        std::vector<bool> yielded; ///< per hook, where some do not simply go where they are told
        std::size_t near_tets = 0; ///< nonlinear ones, where the rest was to be linear
        OpeningResult opening; ///< on the whole wall's vertices and elements; nothing moves beyond the part
    };

    /// Slivers turned over at the rims of hooks do not move a wound of many thousand elements: they are counted, said
    /// and left. More of them than this share, and the wound is no state that tissue can be in.
    constexpr double kMostInverted = 0.002;

    bool is_usable(const OpeningResult& opening)
    {
        return opening.status == OpeningStatus::converged
            || (opening.status == OpeningStatus::inverted
                && opening.inverted_elements <= kMostInverted * static_cast<double>(opening.strain.size()));
    }

    Points lip_points(const PlannedField& field)
    {
        std::set<VertexId> vertices;
        for (const LipFace& lip : field.lips)
            for (const VertexId v : face_vertices(field.wall, lip.face))
                vertices.insert(v);
        return field.wall.vertices(std::vector<VertexId>(vertices.begin(), vertices.end()), Eigen::all);
    }

    Points on_the_whole(const Points& displacement, const LocalProblem& part, const TetMesh& whole)
    {
        Points all = Points::Zero(whole.vertices.rows(), 3);
        for (Eigen::Index v = 0; v < displacement.rows(); ++v) // corners come first, and may be all there are
            all.row(part.vertex_of[static_cast<std::size_t>(v)]) = displacement.row(v);
        return all;
    }

    /// How much of the wall is solved, and how much of that nonlinearly; 0: all of it. mm, from the lips.
    struct Extent {
        double within_mm = 0.0, near_mm = 0.0;
    };

    /// Near the lips, and whatever a hook holds.
    std::vector<std::uint8_t> near_elements(const PlannedField& field, double near_mm)
    {
        const TetMesh& mesh = field.problem.mesh;
        std::vector<std::uint8_t> near = elements_near(mesh, lip_points(field), near_mm);
        std::vector<std::uint8_t> hooked(mesh.vertex_count(), 0);
        for (const HookPatch& hook : field.problem.hooks)
            for (const VertexId v : hook.nodes)
                hooked[static_cast<std::size_t>(v)] = 1;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const VertexId v : mesh.tet(t))
                near[static_cast<std::size_t>(t)] |= hooked[static_cast<std::size_t>(v)];
        return near;
    }

    /// Of the approach's hooks; empty where all of them simply go where they are told.
    std::vector<HookDrive> drives_of(const Approach& approach)
    {
        std::vector<HookDrive> drives;
        bool all_prescribe = true;
        for (const HookSpec& spec : approach.hooks) {
            HookDrive drive { .displacement = spec.opening_mm * spec.direction };
            if (spec.pull.force_N)
                drive.force_N = *spec.pull.force_N * spec.direction;
            drive.force_limit_N = spec.pull.force_limit_N.value_or(drive.force_limit_N);
            drive.grip_N_per_mm = spec.pull.grip_N_per_mm.value_or(drive.grip_N_per_mm);
            all_prescribe = all_prescribe && spec.pull.prescribes();
            drives.push_back(drive);
        }
        return all_prescribe ? std::vector<HookDrive>() : drives;
    }

    /// @param drives empty: the hooks go where field.problem says.
    OpenedPart open_part(const PlannedField& field, const Extent& extent, std::span<const HookDrive> drives,
        OpeningOptions options, const Job& job)
    {
        OpenedPart opened;
        const bool local = extent.within_mm > 0.0;
        if (local)
            opened.part = local_problem(field.problem, lip_points(field), extent.within_mm);
        if (extent.near_mm > 0.0) {
            options.near = near_elements(field, extent.near_mm);
            opened.near_tets
                = static_cast<std::size_t>(std::count(options.near.begin(), options.near.end(), std::uint8_t { 1 }));
        }
        const ElasticProblem& problem = local ? opened.part.problem : field.problem;
        opened.hooks = problem.hooks;
        if (drives.empty()) {
            Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
            opened.opening = opening.open(problem.hooks, job);
        } else {
            DrivenOpening driven = open_driven(problem, drives, options, job);
            opened.opening = std::move(driven.opening);
            opened.hooks = std::move(driven.hooks);
            opened.yielded = std::move(driven.yielded);
        }
        OpeningResult& result = opened.opening;
        if (result.status == OpeningStatus::cancelled)
            return opened;
        if (problem.mesh.nodes_per_tet == 10)
            opened.ten_node = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
        if (local) {
            result.displacement = on_the_whole(result.displacement, opened.part, field.problem.mesh);
            std::vector<double> strain(field.wall.tet_count(), 0.0);
            for (std::size_t t = 0; t < opened.part.tet_of.size(); ++t)
                strain[static_cast<std::size_t>(opened.part.tet_of[t])] = result.strain[t];
            result.strain = std::move(strain);
        }
        result.displacement.conservativeResize(field.wall.vertices.rows(), 3); // without midpoints, which come last
        if (result.far && result.far->kept)
            result.far->displacement_change.conservativeResize(field.wall.vertices.rows(), 3);
        return opened;
    }

    struct OpenedWound {
        RigidPieces rigid;
        LocalProblem part; ///< empty: the whole wall was solved
        std::optional<ContactOptions> contact; ///< it was solved with
        Eigen::VectorXd ten_node {}; ///< the answer of ten-node elements at all their nodes; of four-node ones: empty
    };

    /// Of the wall's materials under the laws that hyperelastic tissue has them by.
    std::vector<std::pair<std::string, std::string>> laws_of(const ElasticProblem& problem)
    {
        std::vector<std::pair<std::string, std::string>> laws;
        for (const Label label : labels_met(problem.mesh)) {
            const Material& material = problem.material_of_label[label];
            const std::pair<std::string, std::string> law { material.name,
                std::string(law_name(hyperelastic_law(material))) };
            if (std::find(laws.begin(), laws.end(), law) == laws.end())
                laws.push_back(law);
        }
        return laws;
    }

    SolutionMetrics solution_metrics(const PlannedField& field, const SolutionChoice& choice)
    {
        SolutionMetrics solution { .choice = choice, .nodes = field.problem.mesh.vertex_count() };
        if (choice.elasticity == Elasticity::hyperelastic)
            solution.laws = laws_of(field.problem);
        return solution;
    }

    OpeningOptions opening_options(const SolutionChoice& choice)
    {
        OpeningOptions options;
        options.elasticity = choice.elasticity;
        options.locking_free = choice.element == ElementKind::locking_free;
        return options;
    }

    OpenedWound open_wound(PlannedField& field, Patient& patient, const LabelVolume& labels,
        std::span<const Label> fixed_labels, CutWall cut, const LocalPlan& local, const Job& job)
    {
        const Case& planned_case = patient.planned_case();
        const SolutionChoice& choice = planned_case.solution;
        OpeningOptions options = opening_options(choice);
        if (planned_case.contact)
            options.contact = contact_of(field, patient);
        ElasticWall elastic = elastic_wall(field.wall, labels, planned_case, fixed_labels);
        field.problem = { std::move(elastic.mesh), std::move(elastic.materials), std::move(cut.supports), field.hooks };
        if (choice.element == ElementKind::p2)
            field.problem = with_midpoints(field.problem);
        field.metrics.solution = solution_metrics(field, choice);
        OpenedPart opened
            = open_part(field, { local.within_mm, choice.near_mm }, drives_of(field.approach), options, job);
        // From here on the hooks are held where they came to rest: estimates, comparisons and exports are of that.
        for (std::size_t h = 0; h < field.hooks.size(); ++h)
            field.hooks[h].displacement = field.problem.hooks[h].displacement = opened.hooks[h].displacement;
        for (std::size_t h = 0; h < opened.part.problem.hooks.size(); ++h)
            opened.part.problem.hooks[h].displacement = opened.hooks[h].displacement;
        field.yielded = std::move(opened.yielded);
        field.opening = std::move(opened.opening);
        field.metrics.solution.near_tets = opened.near_tets;
        if (local.within_mm > 0.0)
            field.metrics.local.emplace(LocalMetrics { .within_mm = local.within_mm,
                .tets = opened.part.problem.mesh.tet_count(),
                .rim_vertices = opened.part.rim_vertices });
        if (options.contact)
            field.metrics.contact = ContactMetrics { field.opening.contact.touching, field.opening.contact.penetration,
                field.opening.contact.force_N, field.opening.contact_overlap_mm };
        if (field.opening.status == OpeningStatus::cancelled) {
            field.status = PlanStatus::cancelled;
        } else if (!is_usable(field.opening)) {
            field.status
                = field.opening.status == OpeningStatus::inverted ? PlanStatus::inverted : PlanStatus::not_converged;
            remark(field.message, field.opening.message);
        }
        OpenedWound wound { { .vertices = std::move(cut.rigid), .solved = {} }, std::move(opened.part),
            std::move(options.contact), std::move(opened.ten_node) };
        if (field.opening.status == OpeningStatus::cancelled || wound.rigid.vertices.empty())
            return wound;
        wound.rigid.solved = field.opening.displacement;
        move_rigid_pieces(field.wall, wound.rigid.vertices, field.opening.displacement);
        return wound;
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
            remark(
                field.message, "the sphere lies in the " + organ->name + ", which is not counted as blocking its view");
        field.metrics.working_distance_mm = distance.value_or((field.geometry.centre - aim).norm());
    }

    bool has_linear_far_field(const PlannedField& field) { return field.opening.far && field.opening.far->kept; }

    /// What a plan's numbers are taken from.
    struct Answer {
        Points displacement {}; ///< of the wall's vertices
        std::vector<Vec3> hook_forces_N {};
    };

    /// Answers by other elements, which the error of the field's is told by.
    struct OtherAnswers {
        std::string message {}; ///< why there are none; empty: there are
        Answer other {};
        double factor = 1.0; ///< the error, over the difference from that
        /// Where ten-node elements are the other: plain four-node ones, and what ten-node ones lack over the
        /// difference from these.
        std::optional<Answer> plain {};
        double lacking = 0.0;
        std::optional<EnergyBars> energy {};
    };

    /// Why a share of ten_node_share() tells no error; empty: it does.
    std::string without_share(double share)
    {
        return share <= kMostShare ? "" // not of what is no number either
                                   : "these elements are too large or too flat to tell how far ten-node "
                                     "ones are off; ask for a finer mesh";
    }

    /// What ten-node elements would say, to first order.
    OtherAnswers finer_answer(
        const PlannedField& field, const OpenedWound& wound, const SolutionChoice& choice, const Job& job)
    {
        const Points& solved = wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved;
        const bool local = field.metrics.local.has_value();
        const ElasticProblem& problem = local ? wound.part.problem : field.problem;
        const auto whole = [&](const Points& u) { return local ? on_the_whole(u, wound.part, field.wall) : u; };
        ErrorEstimate finer = estimate_error(problem, choice.elasticity,
            local ? Points(solved(wound.part.vertex_of, Eigen::all)) : solved, job, wound.contact);
        OtherAnswers answers { .message = finer.message };
        if (finer.status != EstimateStatus::done) {
            if (has_linear_far_field(field) && field.opening.inverted_elements > 0)
                answers.message += ", perhaps by the linear far field: nonlinear farther out they would not be";
            return answers;
        }
        answers.other = { whole(finer.displacement), std::move(finer.hook_forces_N) };
        if (choice.element == ElementKind::locking_free) {
            answers.lacking = ten_node_share(with_midpoints(problem), choice.elasticity, finer.ten_node, finer.plain);
            answers.message = without_share(answers.lacking);
            answers.plain = Answer { whole(finer.plain), std::move(finer.plain_forces_N) };
            return answers;
        }
        answers.factor = 1.0 / kErrorShare;
        // Of the equations that were solved: not with a linear far field or a penalty.
        if (!has_linear_far_field(field) && !wound.contact)
            answers.energy = EnergyBars { finer.energy_error / std::sqrt(kErrorShare), finer.algebraic_error };
        return answers;
    }

    /// What plain elements say on the corners of ten-node ones: finer ones than these would take too long.
    OtherAnswers coarser_answer(
        const PlannedField& field, const OpenedWound& wound, const SolutionChoice& choice, const Job& job)
    {
        const bool local = field.metrics.local.has_value();
        const ElasticProblem& problem = local ? wound.part.problem : field.problem;
        const ElasticProblem coarse = without_midpoints(problem);
        OpeningOptions options { .elasticity = choice.elasticity };
        options.contact = wound.contact;
        if (has_linear_far_field(field))
            options.near = near_elements(field, choice.near_mm);
        options.far_tolerance = std::numeric_limits<double>::infinity(); // it is linear there, as in the answer
        Opening opening(coarse.mesh, coarse.material_of_label, coarse.supports, options);
        OpeningResult result = opening.open(coarse.hooks, job);
        if (!is_usable(result))
            return { .message = "the four-node answer to compare with: " + result.message };
        OtherAnswers answers;
        answers.factor = ten_node_share(problem, choice.elasticity, wound.ten_node, result.displacement);
        answers.message = without_share(answers.factor);
        answers.other
            = { local ? on_the_whole(result.displacement, wound.part, field.wall) : std::move(result.displacement),
                  std::move(result.hook_forces_N) };
        return answers;
    }

    /// Opening and forces of an answer, and of each hook's force the way to another's.
    struct Numbers {
        double width_mm = 0.0, area_mm2 = 0.0, side_N[2] = { 0.0, 0.0 };
    };

    Numbers numbers_of(const PlannedField& field, const OpenedWound& wound, Answer& answer)
    {
        move_rigid_pieces(field.wall, wound.rigid.vertices, answer.displacement);
        const WoundEdges edges = wound_edges(field.wall, field.lips, SweptBlade(blade_of(field.approach)));
        const OpeningGeometry geometry = opening_geometry(edges, field.wall, answer.displacement);
        Numbers numbers { .width_mm = geometry.width_mm, .area_mm2 = geometry.area_mm2 };
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            numbers.side_N[field.hooks[i].side > 0 ? 0 : 1] += answer.hook_forces_N[i].norm();
        return numbers;
    }

    void fill_bars(ErrorBars& bars, const PlannedField& field, const OpenedWound& wound, OtherAnswers answers)
    {
        Answer own { field.opening.displacement, field.opening.hook_forces_N };
        const auto add = [&](Answer& a, Answer& b, double factor, double of_opening) {
            const Numbers of_a = numbers_of(field, wound, a), of_b = numbers_of(field, wound, b);
            bars.opening_width_mm += of_opening * std::abs(of_a.width_mm - of_b.width_mm);
            bars.opening_area_mm2 += of_opening * std::abs(of_a.area_mm2 - of_b.area_mm2);
            bars.hook_forces_N.resize(field.hooks.size(), 0.0);
            for (std::size_t i = 0; i < field.hooks.size(); ++i)
                bars.hook_forces_N[i] += factor * (a.hook_forces_N[i] - b.hook_forces_N[i]).norm();
            for (std::size_t side = 0; side < 2; ++side)
                bars.side_forces_N[side] += factor * std::abs(of_a.side_N[side] - of_b.side_N[side]);
        };
        add(own, answers.other, answers.factor, std::max(answers.factor, kLeastOpeningShare));
        if (answers.plain)
            add(*answers.plain, answers.other, answers.lacking, std::max(answers.lacking, kLeastOpeningShare));
        bars.hook_force_N = std::max(bars.side_forces_N[0], bars.side_forces_N[1]);
        bars.energy = answers.energy;
    }

    /// What finer elements would change in opening and forces, as bars. Nothing here can undo the plan.
    void estimate_errors(PlannedField& field, const OpenedWound& wound, const SolutionChoice& choice, const Job& job)
    {
        FieldMetrics& m = field.metrics;
        ErrorBars& bars = m.error.emplace();
        if (!is_usable(field.opening)) {
            bars.message = field.opening.status == OpeningStatus::inverted
                ? "elements of the opened wound are inside out"
                : "the wound was not opened as asked";
            return;
        }
        const Stopwatch watch;
        try {
            OtherAnswers answers = choice.element == ElementKind::p2 ? coarser_answer(field, wound, choice, job)
                                                                     : finer_answer(field, wound, choice, job);
            if (job.cancelled())
                field.status = PlanStatus::cancelled;
            bars.message = answers.message;
            if (bars.message.empty())
                fill_bars(bars, field, wound, std::move(answers));
        } catch (const Error& error) {
            bars.message = error.what();
        }
        bars.seconds = watch.seconds();
    }

    /// The numbers that leaving out a part of the wall changes.
    struct Measures {
        double width_mm = 0.0, area_mm2 = 0.0, force_N = 0.0;
    };

    double larger_side(const PlannedField& field, const std::vector<Vec3>& forces)
    {
        double per_side[2] = { 0.0, 0.0 };
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            per_side[field.hooks[i].side > 0 ? 0 : 1] += forces[i].norm();
        return std::max(per_side[0], per_side[1]);
    }

    Measures measures_of(const PlannedField& field, const RigidPieces& rigid, OpeningResult& opening)
    {
        move_rigid_pieces(field.wall, rigid.vertices, opening.displacement);
        const WoundEdges edges = wound_edges(field.wall, field.lips, SweptBlade(blade_of(field.approach)));
        const OpeningGeometry geometry = opening_geometry(edges, field.wall, opening.displacement);
        return { geometry.width_mm, geometry.area_mm2, larger_side(field, opening.hook_forces_N) };
    }

    /// What a linear far field is off, by the law of the tissue there.
    void judge_far_field(PlannedField& field, const RigidPieces& rigid)
    {
        if (!field.opening.far)
            return;
        const LinearFarField& far = *field.opening.far;
        FarFieldMetrics& metrics = field.metrics.solution.far.emplace();
        metrics.linear = far.kept;
        metrics.linear_share = far.share;
        if (!far.kept)
            return;
        OpeningResult changed;
        changed.displacement = field.opening.displacement + far.displacement_change;
        for (std::size_t i = 0; i < field.hooks.size(); ++i)
            changed.hook_forces_N.push_back(field.opening.hook_forces_N[i] + far.hook_force_changes_N[i]);
        const Measures there = measures_of(field, rigid, changed);
        metrics.opening_width_mm = std::abs(there.width_mm - field.geometry.width_mm);
        metrics.opening_area_mm2 = std::abs(there.area_mm2 - field.geometry.area_mm2);
        metrics.hook_force_N = std::abs(there.force_N - larger_side(field, field.opening.hook_forces_N));
    }

    /// Of the largest displacement.
    double difference_at_lips(const PlannedField& field, const Points& whole)
    {
        double worst = 0.0;
        for (const LipFace& lip : field.lips)
            for (const VertexId v : face_vertices(field.wall, lip.face))
                worst = std::max(worst, (field.opening.displacement.row(v) - whole.row(v)).norm());
        const double largest = whole.rowwise().norm().maxCoeff();
        return largest > 0.0 ? worst / largest : 0.0;
    }

    /// Compares with a smaller part: half the distance, or, where a hook reaches beyond that, three quarters.
    void estimate_local_error(const PlannedField& field, const RigidPieces& rigid, const Measures& here,
        const OpeningOptions& options, LocalMetrics& local, const Job& job)
    {
        constexpr double kSmaller[] = { 0.5, 0.75 };
        for (const double share : kSmaller) {
            try {
                OpenedPart smaller = open_part(field, { share * local.within_mm }, {}, options, job);
                local.smaller_mm = share * local.within_mm;
                if (!is_usable(smaller.opening)) {
                    local.message = "the smaller part was not opened as asked";
                    return;
                }
                const Measures there = measures_of(field, rigid, smaller.opening);
                const double rest = share / (1.0 - share); // of an error that falls with one over the distance
                local.opening_width_mm = rest * std::abs(here.width_mm - there.width_mm);
                local.opening_area_mm2 = rest * std::abs(here.area_mm2 - there.area_mm2);
                local.hook_force_N = rest * std::abs(here.force_N - there.force_N);
                local.message.clear();
                return;
            } catch (const InputError& error) { // a hook reaches beyond it: perhaps not beyond a larger part
                local.message = std::string(error.what()) + "; ask for --check";
            } catch (const Error& error) { // the plan itself is good
                local.message = std::string("the smaller part was not solved: ") + error.what();
                return;
            }
        }
    }

    /// The whole wall, all of it as the choice has it near the lips.
    WholeMetrics compare_with_whole(
        const PlannedField& field, const RigidPieces& rigid, const OpeningOptions& options, const Job& job)
    {
        const Stopwatch watch;
        WholeMetrics measured;
        try {
            OpeningResult whole = open_part(field, {}, {}, options, job).opening;
            if (is_usable(whole)) {
                const Measures there = measures_of(field, rigid, whole);
                measured.opening_width_mm = there.width_mm;
                measured.opening_area_mm2 = there.area_mm2;
                measured.hook_force_N = there.force_N;
                measured.lips_difference = difference_at_lips(field, whole.displacement);
            } else
                measured.message = whole.message;
        } catch (const Error& error) { // the plan itself is good
            measured.message = std::string("not solved: ") + error.what();
        }
        measured.seconds = watch.seconds();
        return measured;
    }

    /// What leaving out the rest of the wall may have changed: estimated, and measured where that was asked for.
    void judge_localisation(PlannedField& field, const RigidPieces& rigid, const OpeningOptions& options,
        const LocalPlan& plan, const Job& job)
    {
        LocalMetrics& local = *field.metrics.local;
        const Measures here { field.geometry.width_mm, field.geometry.area_mm2,
            larger_side(field, field.opening.hook_forces_N) };
        if (!is_usable(field.opening)) {
            local.message = "the wound was not opened as asked";
            return;
        }
        const Stopwatch watch;
        if (local.rim_vertices > 0)
            estimate_local_error(field, rigid, here, options, local, job);
        local.seconds = watch.seconds();
        if (plan.check && !job.cancelled())
            local.whole = compare_with_whole(field, rigid, options, job);
        if (job.cancelled())
            field.status = PlanStatus::cancelled;
    }

    std::string status_text(const PlannedField& field)
    {
        switch (field.opening.status) {
        case OpeningStatus::converged:
            return "converged";
        case OpeningStatus::inverted:
            return is_usable(field.opening) ? "converged" : "inverted, though " + field.opening.message;
        case OpeningStatus::not_converged:
        case OpeningStatus::cancelled:
            break;
        }
        return field.opening.message; // begins with what happened
    }

    /// The middle, at rest, of the element that has the percentile's strain. None where nothing is strained.
    std::optional<Vec3> place_of_strain(const PlannedField& field)
    {
        const auto& strain = field.opening.strain;
        const auto at = std::find(strain.begin(), strain.end(), field.opening.strain_p99);
        if (at == strain.end() || !(field.opening.strain_p99 > 0.0))
            return std::nullopt;
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : field.wall.tet(static_cast<TetId>(at - strain.begin())).first(4))
            middle += 0.25 * field.wall.vertices.row(v).transpose();
        return middle;
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
            const HookSpec& spec = field.approach.hooks[i];
            m.hooks.push_back({ .name = field.hooks[i].name,
                .side = field.hooks[i].side,
                .force_N = force,
                .moved_mm = field.hooks[i].displacement.norm(),
                .asked_mm = spec.opening_mm,
                .pull = spec.pull,
                .yielded = !field.yielded.empty() && field.yielded[i] });
            per_side[field.hooks[i].side > 0 ? 0 : 1] += force;
        }
        m.hook_force_N = std::max(per_side[0], per_side[1]);
        m.strain_p99 = field.opening.strain_p99;
        m.strain_p99_at = place_of_strain(field);
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

void check_local(const Case& planned_case, const LocalPlan& local)
{
    check_solution(planned_case.solution, planned_case.contact, local.within_mm > 0.0);
    if (!(local.within_mm >= 0.0) || !std::isfinite(local.within_mm))
        throw InputError("the distance within which the wall is solved must be finite and not negative", "--local");
    if (local.within_mm > 0.0 && planned_case.contact)
        throw InputError("contact needs the whole wall: leave one of the two out", "--local, --contact");
    if (local.check && local.within_mm == 0.0 && planned_case.solution.near_mm == 0.0)
        throw InputError("there is nothing to check: the whole wall is solved alike", "--check");
}

PlannedField plan_approach(Patient& patient, const Approach& approach, const Job& job, const LocalPlan& local)
{
    const Case& planned_case = patient.planned_case();
    const SolutionChoice& choice = planned_case.solution;
    check_approach(approach);
    check_local(planned_case, local);
    PlannedField field;
    field.approach = approach;
    const auto labels = patient.labels();
    const MeshSizing sizing = mesh_sizing_of(approach, planned_case.label_table);
    const std::vector<Label> fixed_labels = label_ids(planned_case.label_table, planned_case.supports.labels);
    CutWall cut;
    OpenedWound wound;
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
        Supports supports = supports_of(field.wall, *labels, planned_case, sizing);
        if (supports.fixed.empty())
            remark(field.message,
                "nothing but the hooks holds this wall: name what does in case.json, \"supports\" (the spine, or the "
                "border of the region)");
        cut = cut_wall(std::move(field.wall), approach, planned_case.label_table, std::move(supports), job);
        if (!take_cut(field, cut))
            return field;
        check_lips(field, cut.took_lip);
    }
    {
        const StageTimer timer(field.metrics, "open");
        wound = open_wound(field, patient, *labels, fixed_labels, std::move(cut), local, job);
        if (field.status == PlanStatus::cancelled)
            return field;
    }
    {
        const StageTimer timer(field.metrics, "expose");
        field.remaining_wall
            = wall_beyond_region(*patient.body(), *labels, sizing, field.wall, field.opening.displacement, job);
        look_through(field, patient, job);
    }
    if (field.status != PlanStatus::cancelled) {
        const StageTimer timer(field.metrics, "estimate error");
        estimate_errors(field, wound, choice, job);
    }
    if (field.status != PlanStatus::cancelled)
        judge_far_field(field, wound.rigid);
    if (field.status != PlanStatus::cancelled && field.metrics.local) {
        const StageTimer timer(field.metrics, "judge localisation");
        judge_localisation(field, wound.rigid, opening_options(choice), local, job);
    }
    if (field.status != PlanStatus::cancelled && local.check && choice.near_mm > 0.0) {
        const StageTimer timer(field.metrics, "compare with the whole");
        field.metrics.solution.whole = compare_with_whole(field, wound.rigid, opening_options(choice), job);
        if (job.cancelled())
            field.status = PlanStatus::cancelled;
    }
    if (field.status != PlanStatus::cancelled)
        fill_metrics(field, patient);
    return field;
}

std::vector<PlannedField> plan_all(Patient& patient, const Job& job, const LocalPlan& local)
{
    const std::vector<Approach>& approaches = patient.planned_case().approaches;
    std::vector<PlannedField> fields(approaches.size());
    std::vector<std::exception_ptr> failures(approaches.size());
    std::atomic<std::size_t> next { 0 };
    const auto work = [&] {
        for (std::size_t i = next.fetch_add(1); i < approaches.size(); i = next.fetch_add(1)) {
            try {
                fields[i] = plan_approach(patient, approaches[i], job, local);
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
