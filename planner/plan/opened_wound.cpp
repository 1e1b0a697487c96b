#include "planner/plan/opened_wound.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/material/material.h"
#include "fem/statics/frame_opening.h"
#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/hook_patches.h"
#include "planner/approach/retractors.h"
#include "planner/measures/verdict.h"
#include "planner/plan/contact_where_needed.h"
#include "planner/wall/supports.h"
#include "planner/wall/ten_node_elements.h"
#include "planner/wall/wall_pressure.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace retractor::planner {

namespace {

    /// Lets blades hold the tissue whose contact has no equilibrium.
    void hold_with_blades(PlannedField& field)
    {
        field.problem = problem_with_fixed_hooks(field);
        if (field.approach.retractor)
            field.approach.retractor->hold = HookHold::fixed;
        for (HookSpec& hook : field.approach.hooks)
            hook.hold = HookHold::fixed;
        field.contact_was_lost = true;
    }

    /// Makes blades of the hooks that are in contact.
    void add_blades(PlannedField& field, const mesh::LabelTable& table)
    {
        std::vector<Label> skeleton;
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_skeleton(info))
                skeleton.push_back(info.id);
        std::vector<mesh::TetFace> bone;
        for (std::size_t h = 0; h < field.approach.hooks.size(); ++h) {
            const HookSpec& spec = field.approach.hooks[h];
            if (spec.hold != HookHold::contact)
                continue;
            if (bone.empty())
                bone = fem::surface_of_labels(field.wall, skeleton);
            std::vector<mesh::TetFace> lip;
            for (const mesh::LipFace& face : field.lips)
                if (face.side == spec.side)
                    lip.push_back(face.face);
            const PatchPlace place = patch_place(field.approach, spec);
            fem::add_blade(field.problem, h, lip, bone,
                { .name = spec.name,
                    .middle = place.centre,
                    .along = place.along,
                    .deep = place.depth,
                    .outward = spec.direction,
                    .width_mm = spec.patch_width_mm,
                    .height_mm = spec.patch_height_mm });
        }
    }

    /// Material name and hyperelastic law of each material of the wall, each pair once.
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
        SolutionMetrics solution {
            .choice = choice, .mesh = field.approach.sizing, .nodes = field.problem.mesh.vertex_count()
        };
        if (choice.elasticity == fem::Elasticity::hyperelastic)
            solution.laws = laws_of(field.problem);
        return solution;
    }

} // namespace

bool has_condensed_region(const PlannedField& field) { return field.opening.far && field.opening.far->kept; }

std::vector<std::uint8_t> near_elements(const PlannedField& field, double near_mm)
{
    const mesh::TetMesh& mesh = field.problem.mesh;
    std::vector<std::uint8_t> near = fem::elements_near(mesh, lip_points(field.wall, field.lips), near_mm);
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

namespace {

    /// Residual of ten-node elements. It leaves 0.1 % of the hook forces (fem::OpeningOptions::tolerance), which is
    /// little beside the discretisation error of several percent, and takes half of the Newton steps of the default.
    constexpr double kTenNodeTolerance = 1e-3;

    /// Blades in contact bear small forces on many nodes. The residual above would leave 2 % of them.
    constexpr double kContactTolerance = 3e-4;

    /// Blades in contact: the error of their forces that this leaves is about 1 % (EquilibriumOptions).
    constexpr double kContactEnergyTolerance = 1e-4;

    /// Balance of a retractor: above the error that the residual, or friction known to 0.5 % (equilibrium.h), leaves in
    /// the forces of its blades, and a seventh of the bar that a plan is asked for.
    constexpr double kTenNodeBalance = 5e-3, kContactBalance = 2e-2;
    constexpr double kStartBalance = 0.1, kStartTolerance = 0.01; ///< of a state from which other elements begin
    /// A frame that tilts further than 20 degrees is held: no surgeon lets it. Plans of phantoms tilt it by 2 to 10.
    constexpr double kMostTilted = 0.35; // rad

    void set_tolerances(fem::OpeningOptions& options, const fem::ElasticProblem& problem)
    {
        const bool contact = !problem.blades.empty();
        if (!contact && problem.mesh.nodes_per_tet != 10)
            return;
        options.tolerance = std::max(options.tolerance, contact ? kContactTolerance : kTenNodeTolerance);
        options.energy_tolerance = contact ? kContactEnergyTolerance : 0.0;
    }

    /// Flags the labels whose material is neither bone nor cartilage, whose moments and forces are measured.
    std::vector<std::uint8_t> soft_labels(const fem::ElasticProblem& problem)
    {
        std::vector<std::uint8_t> soft(problem.material_of_label.size(), 0);
        for (const Label label : fem::labels_met(problem.mesh)) {
            const std::string& material = problem.material_of_label[label].name;
            soft[label] = material != "bone" && material != "cartilage" ? 1 : 0;
        }
        return soft;
    }

    /// Gives stiffened elements stiffer copies of their materials, under labels that the table does not have: later
    /// solutions of the problem are then of the same tissue.
    void take_stiffened(
        fem::ElasticProblem& problem, std::span<const fem::StiffenedElement> stiffened, const mesh::LabelTable& table)
    {
        mesh::LabelFlags is_known(mesh::kLabelCount, 0);
        for (const mesh::LabelInfo& info : table)
            is_known[info.id] = 1;
        for (const Label label : fem::labels_met(problem.mesh))
            is_known[label] = 1;
        std::size_t next = 1;
        std::map<std::pair<Label, double>, Label> copies; // of each label and factor
        for (const fem::StiffenedElement& element : stiffened) {
            Label& label = problem.mesh.labels[static_cast<std::size_t>(element.tet)];
            const auto [copy, is_new] = copies.try_emplace({ label, element.factor }, Label { 0 });
            if (is_new) {
                while (next < mesh::kLabelCount && is_known[next] != 0)
                    ++next;
                RETRACTOR_ASSERT(next < mesh::kLabelCount);
                fem::Material stiffer = problem.material_of_label[label];
                stiffer.youngs_modulus_MPa *= element.factor;
                problem.material_of_label.resize(std::max(problem.material_of_label.size(), next + 1));
                problem.material_of_label[next] = std::move(stiffer);
                copy->second = static_cast<Label>(next++);
            }
            label = copy->second;
        }
    }

    /// A retractor that the tissue holds, or a hand where the tissue does not.
    /// @param direction_is_held a hand holds it from the beginning
    fem::FrameOptions balance_of(const fem::ElasticProblem& problem, bool direction_is_held = false)
    {
        fem::FrameOptions how {
            .most_turned = kMostTilted, .direction_is_held = direction_is_held, .hold_without_balance = true
        };
        how.may_stiffen = soft_labels(problem);
        if (!problem.blades.empty())
            how.tolerance = kContactBalance;
        else if (problem.mesh.nodes_per_tet == 10)
            how.tolerance = kTenNodeBalance;
        return how;
    }

    /// A displacement at the corners of ten-node elements, and its means at their midpoints.
    Points at_midpoints(const mesh::TetMesh& mesh, const Points& corners)
    {
        RETRACTOR_ASSERT(mesh.nodes_per_tet == 10);
        Points all(mesh.vertices.rows(), 3);
        all.topRows(corners.rows()) = corners;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                if (mesh::is_straight(mesh.tet(t), e))
                    continue;
                const auto& [a, b] = mesh::kTetEdges[e];
                all.row(mesh.tet(t)[4 + e]) = 0.5
                    * (corners.row(mesh.tet(t)[static_cast<std::size_t>(a)])
                        + corners.row(mesh.tet(t)[static_cast<std::size_t>(b)]));
            }
        return all;
    }

    /// Whether blades in contact hold the wound, and each bears on a bone that the cut goes through.
    bool blades_bear_on_cut_bone(const PlannedField& field, const mesh::LabelTable& table)
    {
        mesh::LabelFlags is_cut(mesh::kLabelCount, 0);
        for (const mesh::LipFace& lip : field.lips)
            is_cut[field.wall.labels[static_cast<std::size_t>(lip.face.tet)]] = 1;
        const auto bears_on_cut = [&](const HookSpec& hook) {
            return std::ranges::any_of(hook.bears_on, [&](const std::string& name) {
                const mesh::LabelInfo* bone = mesh::find_label(table, name);
                return bone != nullptr && is_cut[bone->id] != 0;
            });
        };
        return !field.problem.blades.empty() && std::ranges::all_of(field.approach.hooks, bears_on_cut);
    }

    /// Marks the elements all of whose edges have midpoints.
    std::vector<std::uint8_t> elements_with_midpoints(const mesh::TetMesh& mesh)
    {
        std::vector<std::uint8_t> marked(mesh.tet_count(), 1);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (mesh::is_straight(mesh.tet(t), e))
                    marked[static_cast<std::size_t>(t)] = 0;
        return marked;
    }

    /// Opens a wall of ten-node elements from the solution of four-node elements at their corners. Most Newton steps
    /// are then made with a matrix of an eighth of the size.
    void open_from_corners(OpenedWall& opened, const fem::ElasticProblem& problem, fem::OpeningOptions options,
        const StageTest& goes_on, const Job& job)
    {
        set_tolerances(options, problem);
        const fem::ElasticProblem corners = fem::without_midpoints(problem);
        fem::OpeningResult coarse
            = fem::Opening(corners, options).open(corners.hooks, as_stage(job, "opening, four-node elements"));
        if (coarse.status == fem::OpeningStatus::cancelled) {
            opened.opening = std::move(coarse);
            return;
        }
        if (!is_usable(coarse)) {
            opened.opening = fem::Opening(problem, options).open(problem.hooks, job);
            return;
        }
        if (goes_on && !goes_on(coarse)) {
            opened.ended_by_test = true;
            opened.coarse = std::move(coarse);
            return;
        }
        fem::Opening opening(problem, options);
        opening.start_from(at_midpoints(problem.mesh, coarse.displacement));
        opened.opening = opening.open(problem.hooks, job);
        // From a start with elements turned over Newton's method may end in a state that loading does not reach.
        if (!is_usable(opened.opening) && opened.opening.status != fem::OpeningStatus::cancelled)
            opened.opening = fem::Opening(problem, options).open(problem.hooks, job);
        opened.coarse = std::move(coarse);
    }

    /// The problem with hooks that hold the tissue in place of blades in contact. @param problem four-node elements
    fem::ElasticProblem holding_hooks(fem::ElasticProblem problem, const PlannedField& field)
    {
        problem.mesh.vertices.conservativeResize(field.wall.vertices.rows(), 3);
        problem.blades.clear();
        problem.hooks = field.hooks;
        return problem;
    }

    fem::RackDrive rack_drive_of(const RetractorSpec& retractor)
    {
        if (retractor.force_N)
            return { .force_N = retractor.force_N };
        return { .distance_mm = retractor.opening_mm };
    }

    void take_retractor(OpenedWall& opened, const fem::BladeFrame& frame, fem::FrameOpening found)
    {
        opened.retractor = PlacedRetractor { .frame = frame,
            .state = found.state,
            .loads = found.loads,
            .stiffness = found.stiffness,
            .residual_force_N = found.residual_force_N.norm(),
            .residual_moment_Nmm = found.residual_moment_Nmm.norm(),
            .direction_is_held = found.direction_is_held,
            .rack_force_N = found.rack_force_N,
            .openings = found.openings };
        opened.opening = std::move(found.opening);
        opened.hooks = std::move(found.blades);
    }

    /// The balance of the retractor in tissue that is linear and held by the blades: one factorisation finds it. The
    /// nonlinear balance lies within a few degrees of it, and hardly lies nearer to where the retractor was at rest.
    /// Linear tissue may let the retractor turn without end; then this is the state nearest to balance before that.
    std::optional<fem::FrameStart> linear_start(
        const fem::ElasticProblem& held, const fem::BladeFrame& frame, const fem::RackDrive& drive, const Job& job)
    {
        const fem::OpeningOptions linear { .elasticity = fem::Elasticity::linear };
        const fem::FrameOpening found = fem::open_with_frame(
            held, frame, drive, linear, { .tolerance = kStartBalance, .most_turned = kMostTilted }, job);
        if (found.opening.status == fem::OpeningStatus::cancelled
            || std::abs(Eigen::AngleAxisd(found.state.rotation).angle()) > kMostTilted)
            return std::nullopt;
        return fem::FrameStart { .state = found.state, .displacement = {}, .stiffness = {} };
    }

    /// Opens four-node elements with a retractor. Blades in contact begin where the retractor is in balance with blades
    /// that hold the tissue: a frame that has not turned with its wound yet presses with many times the force.
    /// @param held_force_N set as OpenedWall::held_force_N
    fem::FrameOpening open_four_node(const fem::ElasticProblem& problem, const PlannedField& field,
        const fem::RackDrive& drive, const fem::OpeningOptions& options, fem::FrameOptions how, double& held_force_N,
        const Job& job)
    {
        const fem::BladeFrame frame = blade_frame_of(field.approach);
        if (problem.blades.empty() && options.elasticity == fem::Elasticity::linear)
            return fem::open_with_frame(problem, frame, drive, options, how, job);
        const fem::ElasticProblem hold = problem.blades.empty() ? problem : holding_hooks(problem, field);
        const std::optional<fem::FrameStart> linear
            = linear_start(hold, frame, drive, as_stage(job, "opening, linear"));
        if (problem.blades.empty())
            return fem::open_with_frame(problem, frame, drive, options, how, job, linear);
        const Job named = as_stage(job, "opening, blades that hold");
        fem::FrameOptions roughly = how;
        roughly.tolerance = std::max(kStartBalance, how.tolerance);
        roughly.may_stiffen.clear();
        fem::OpeningOptions rough = options;
        rough.tolerance = std::max(kStartTolerance, options.tolerance);
        fem::FrameOpening held = fem::open_with_frame(hold, frame, drive, rough, roughly, named, linear);
        if (held.opening.status == fem::OpeningStatus::cancelled)
            return held;
        if (!is_usable(held.opening))
            return fem::open_with_frame(problem, frame, drive, options, how, job);
        for (const fem::BladeLoad& load : held.loads)
            held_force_N = std::max(held_force_N, load.force_N.norm());
        fem::ElasticProblem placed = problem;
        placed.hooks = fem::blades_at(frame, held.state, problem.hooks);
        how.direction_is_held = held.direction_is_held;
        return fem::open_with_frame(problem, frame, drive, options, how, job,
            fem::FrameStart { held.state, fem::with_blade_nodes(placed, held.opening.displacement), {} });
    }

    /// The balance of the retractor in four-node elements.
    /// @param start an opening of the same elements from which the search begins, or nullptr: it begins at rest, as it
    /// does where this start leads to no balance
    /// @param problem four-node elements
    /// @param held_force_N set as OpenedWall::held_force_N
    fem::FrameOpening open_four_node_from(const OpenedWall* start, const fem::ElasticProblem& problem,
        const PlannedField& field, const fem::RackDrive& drive, const fem::OpeningOptions& options,
        const fem::FrameOptions& how, double& held_force_N, const Job& job)
    {
        if (start != nullptr && start->retractor && start->coarse) {
            fem::FrameOptions as_start = how;
            as_start.direction_is_held = start->retractor->direction_is_held;
            fem::FrameOpening found = fem::open_with_frame(problem, blade_frame_of(field.approach), drive, options,
                as_start, job, fem::FrameStart { start->retractor->state, start->coarse->displacement, {} });
            if (is_usable(found.opening) || found.opening.status == fem::OpeningStatus::cancelled)
                return found;
        }
        return open_four_node(problem, field, drive, options, how, held_force_N, job);
    }

    /// Opens a wall with a retractor. Ten-node elements begin where the retractor is in balance in four-node elements.
    /// @param start an opening without contact that a test ended, from which the four-node elements begin; or nullptr
    void open_with_retractor(OpenedWall& opened, const PlannedField& field, fem::OpeningOptions options,
        const OpenedWall* start_of_four_node, const StageTest& goes_on, const Job& job)
    {
        const fem::BladeFrame frame = blade_frame_of(field.approach);
        const fem::RackDrive drive = rack_drive_of(*field.approach.retractor);
        const fem::ElasticProblem& problem = field.problem;
        set_tolerances(options, problem);
        if (problem.mesh.nodes_per_tet != 10 || options.elasticity == fem::Elasticity::linear)
            return take_retractor(opened, frame,
                open_four_node(problem, field, drive, options, balance_of(problem), opened.held_force_N, job));
        fem::FrameOptions how = balance_of(problem), roughly = how;
        roughly.tolerance = kStartBalance;
        roughly.may_stiffen.clear();
        fem::FrameOpening coarse = open_four_node_from(start_of_four_node, fem::without_midpoints(problem), field,
            drive, options, roughly, opened.held_force_N, as_stage(job, "opening, four-node elements"));
        if (coarse.opening.status == fem::OpeningStatus::cancelled)
            return take_retractor(opened, frame, std::move(coarse));
        if (is_usable(coarse.opening) && goes_on && !goes_on(coarse.opening)) {
            take_retractor(opened, frame, std::move(coarse));
            opened.ended_by_test = true;
            opened.coarse = std::move(opened.opening);
            opened.opening = {};
            return;
        }
        if (!problem.blades.empty() && !is_usable(coarse.opening))
            return take_retractor(opened, frame, std::move(coarse)); // contact does not converge from rest
        std::optional<fem::FrameStart> start;
        how.direction_is_held = is_usable(coarse.opening) && coarse.direction_is_held;
        if (is_usable(coarse.opening))
            start = fem::FrameStart { coarse.state, at_midpoints(problem.mesh, coarse.opening.displacement) };
        fem::FrameOpening fine = fem::open_with_frame(problem, frame, drive, options, how, job, start);
        // As in open_from_corners(): from a start with elements turned over the search may go astray.
        if (start && problem.blades.empty() && !is_usable(fine.opening)
            && fine.opening.status != fem::OpeningStatus::cancelled)
            fine = fem::open_with_frame(problem, frame, drive, options, how, job);
        const bool as_coarse = fine.direction_is_held == coarse.direction_is_held; // else another operation
        opened.coarse_turn = fine.state.rotation * coarse.state.rotation.transpose();
        take_retractor(opened, frame, std::move(fine));
        if (start && as_coarse)
            opened.coarse = std::move(coarse.opening);
    }

    /// Opens a wall from a solution of the same problem.
    void open_from(OpenedWall& opened, const PlannedField& field, const OpenedWall& start, fem::OpeningOptions options,
        const Job& job)
    {
        const fem::ElasticProblem& problem = field.problem;
        set_tolerances(options, problem);
        fem::ElasticProblem placed = problem;
        placed.hooks = start.hooks;
        const Points from = start.ten_node.size() != 0
            ? Points(Eigen::Map<const Points>(start.ten_node.data(), start.ten_node.size() / 3, 3))
            : fem::with_blade_nodes(placed, start.opening.displacement);
        if (start.retractor) {
            const PlacedRetractor& retractor = *start.retractor;
            take_retractor(opened, retractor.frame,
                fem::open_with_frame(problem, retractor.frame, rack_drive_of(*field.approach.retractor), options,
                    balance_of(problem, retractor.direction_is_held), job,
                    fem::FrameStart { retractor.state, from, retractor.stiffness }));
            return;
        }
        fem::Opening opening(problem, options);
        opening.start_from(from);
        opened.opening = opening.open(problem.hooks, job);
    }

} // namespace

OpenedWall open_wall(const PlannedField& field, double near_mm, std::span<const fem::HookDrive> drives,
    fem::OpeningOptions options, const Job& job, const OpenedWall* start, const StageTest& goes_on)
{
    OpenedWall opened;
    if (near_mm > 0.0) {
        options.near = near_elements(field, near_mm);
        opened.near_tets
            = static_cast<std::size_t>(std::count(options.near.begin(), options.near.end(), std::uint8_t { 1 }));
    }
    const fem::ElasticProblem& problem = field.problem;
    opened.hooks = problem.hooks;
    if (start != nullptr)
        opened.held_force_N = start->held_force_N;
    const bool linear = options.elasticity == fem::Elasticity::linear; // one solve, with any start
    const bool all_blades = problem.blades.size() == problem.hooks.size();
    if ((options.contact && !all_blades) || !drives.empty() || near_mm > 0.0)
        start = nullptr;
    if (start != nullptr && !start->ended_by_test) {
        open_from(opened, field, *start, options, job);
    } else if (field.approach.retractor && !problem.hooks.empty()) {
        open_with_retractor(opened, field, options, start, goes_on, job);
    } else if (drives.empty() && problem.mesh.nodes_per_tet == 10 && near_mm == 0.0 && !linear) {
        open_from_corners(opened, problem, options, goes_on, job);
    } else if (drives.empty()) {
        fem::Opening opening(problem, options);
        opened.opening = opening.open(problem.hooks, job);
    } else {
        fem::DrivenOpening driven = fem::open_driven(problem, drives, options, job);
        opened.opening = std::move(driven.opening);
        opened.hooks = std::move(driven.hooks);
        opened.yielded = std::move(driven.yielded);
    }
    fem::OpeningResult& result = opened.opening;
    if (result.status == fem::OpeningStatus::cancelled || opened.ended_by_test)
        return opened;
    if (problem.mesh.nodes_per_tet == 10)
        opened.ten_node = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
    result.displacement.conservativeResize(field.wall.vertices.rows(), 3); // without midpoints, which come last
    if (result.far && result.far->kept)
        result.far->displacement_change.conservativeResize(field.wall.vertices.rows(), 3);
    return opened;
}

Eigen::VectorXd displacement_at_nodes(const PlannedField& field, const OpenedWound& wound)
{
    if (wound.ten_node.size() != 0)
        return wound.ten_node;
    const Points all = fem::with_blade_nodes(
        field.problem, wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved);
    return Eigen::Map<const Eigen::VectorXd>(all.data(), all.size());
}

Eigen::VectorXd displacement_at_nodes(const OpenedWall& opened)
{
    if (opened.ten_node.size() != 0)
        return opened.ten_node;
    const Points& solved = opened.opening.displacement;
    return Eigen::Map<const Eigen::VectorXd>(solved.data(), solved.size());
}

OpenedWall reopen_wall(
    const PlannedField& field, const OpenedWound& wound, double share, const SolverSettings& choice, const Job& job)
{
    RETRACTOR_ASSERT(share >= 0.0 && share <= 1.0 && choice.near_mm == 0.0);
    fem::OpeningOptions options = opening_options(choice);
    options.contact = wound.contact;
    const fem::ElasticProblem& problem = field.problem;
    const Eigen::VectorXd full = displacement_at_nodes(field, wound);
    Points start = share * Eigen::Map<const Points>(full.data(), full.size() / 3, 3);
    const Job named = as_stage(job, "smaller opening");
    OpenedWall opened;
    opened.hooks = problem.hooks;
    if (field.retractor && !problem.hooks.empty()) {
        fem::FrameState state = field.retractor->state;
        state.distance *= share;
        state.translation *= share;
        for (double& turn : state.turn)
            turn *= share;
        state.rotation = Eigen::Quaterniond::Identity()
                             .slerp(share, Eigen::Quaterniond(field.retractor->state.rotation))
                             .toRotationMatrix();
        const fem::RackDrive drive { .distance_mm = state.distance };
        fem::FrameOptions how = balance_of(problem, field.retractor->direction_is_held);
        how.hold_without_balance = false; // it is compared with the whole opening
        take_retractor(opened, field.retractor->frame,
            fem::open_with_frame(problem, field.retractor->frame, drive, options, how, named,
                fem::FrameStart { state, std::move(start), field.retractor->stiffness }));
    } else {
        for (fem::HookPatch& hook : opened.hooks)
            hook.displacement *= share;
        set_tolerances(options, problem);
        fem::Opening opening(problem, options);
        opening.start_from(start);
        opened.opening = opening.open(opened.hooks, named);
    }
    fem::OpeningResult& result = opened.opening;
    if (problem.mesh.nodes_per_tet == 10 && result.displacement.rows() > 0)
        opened.ten_node = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
    return opened;
}

ContactOpening solve_or_hold(PlannedField& field, const std::function<ContactOpening()>& solve)
{
    constexpr double kStifferInFourNodes = 2.0; // forces over those of ten-node elements (docs/method/verification.md)
    ContactOpening solved = solve();
    if (field.problem.blades.empty() || solved.opened.opening.status == fem::OpeningStatus::cancelled
        || is_usable(solved.opened.opening))
        return solved;
    if (const double held_N = solved.opened.held_force_N; held_N > kStifferInFourNodes * kImpossibleForceN) {
        solved.opened.opening.message += formatted("; blades that hold the tissue would bear %.0f N, and no retractor "
                                                   "pulls with more than %.0f N",
            held_N, kImpossibleForceN);
        return solved;
    }
    hold_with_blades(field);
    return solve();
}

OpenedWall opened_wall_of(const PlannedField& field, const OpenedWound& wound)
{
    OpenedWall opened { .ten_node = wound.ten_node,
        .coarse = wound.coarse,
        .coarse_turn = wound.coarse_turn,
        .hooks = field.problem.hooks,
        .yielded = field.yielded,
        .near_tets = field.metrics.solution.near_tets,
        .opening = field.opening,
        .retractor = field.retractor,
        .touchable = wound.touchable };
    if (!wound.rigid.vertices.empty())
        opened.opening.displacement = wound.rigid.solved;
    return opened;
}

OpenedWound open_wound(PlannedField& field, Patient& patient, const Case& planned_case, const mesh::LabelVolume& labels,
    CutWall cut, const Job& job, const OpenedWall* start)
{
    const SolverSettings& choice = planned_case.solution;
    field.problem = { .mesh = field.wall,
        .material_of_label = materials_as_solved(patient, choice.element),
        .supports = std::move(cut.supports),
        .hooks = field.hooks,
        .loads = std::move(cut.released),
        .pressures = {} };
    scale_springs(patient.stiffness_factors(), planned_case.label_table, field.problem);
    for (WallPressure& pressure : wall_pressures(field.wall, labels, planned_case, cut.wound)) {
        field.metrics.pressures.push_back(
            pressure_metrics(field.wall, pressure, choice.elasticity != fem::Elasticity::linear));
        field.problem.pressures.push_back(std::move(pressure.acts));
    }
    add_blades(field, planned_case.label_table);
    if (choice.element == ElementKind::p2)
        field.problem = with_midpoints(field.problem);
    else if (choice.element == ElementKind::mixed)
        field.problem = with_midpoints(field.problem,
            ten_node_elements(field.wall, field.lips, planned_case.label_table,
                blades_bear_on_cut_bone(field, planned_case.label_table) ? SoftLips::four_nodes : SoftLips::ten_nodes));
    field.metrics.solution = solution_metrics(field, choice);
    const std::vector<fem::HookDrive> drives = drives_of(field.approach);
    const OpenOnce open = [&](const std::optional<fem::ContactOptions>& contact, const OpenedWall* from,
                              const StageTest& goes_on, const Job& part) {
        fem::OpeningOptions options = opening_options(choice);
        options.contact = contact;
        const Job named = contact ? as_stage(part, "opening with contact") : part;
        return open_wall(field, choice.near_mm, drives, std::move(options), named, from, goes_on);
    };
    ContactSurfaces surfaces;
    if (planned_case.contact != ContactMode::never)
        surfaces = contact_surfaces(planned_case.label_table, field.approach, patient);
    std::optional<ContactOpening> from_start;
    const bool all_blades = field.problem.blades.size() == field.problem.hooks.size(); // as open_wall() asks
    if (start != nullptr && planned_case.contact == ContactMode::automatic && start->touchable && all_blades)
        from_start = open_touching_from(*start, field.problem, surfaces, open, job);
    else if (start != nullptr && planned_case.contact != ContactMode::always)
        from_start = open_without_contact_from(*start, field.problem, planned_case.contact, surfaces, open, job);
    ContactOpening solved = from_start ? *std::move(from_start) : solve_or_hold(field, [&] {
        return open_with_contact(field.problem, planned_case.contact, surfaces, open, choice.near_mm == 0.0, job);
    });
    OpenedWall& opened = solved.opened;
    field.metrics.contact = std::move(solved.contact);
    RETRACTOR_ASSERT(opened.hooks.size() == field.hooks.size());
    // From here on the hooks are fixed at their equilibrium: exports and estimates start from this state.
    for (std::size_t h = 0; h < field.hooks.size(); ++h)
        for (fem::HookPatch* hook : { &field.hooks[h], &field.problem.hooks[h] }) {
            hook->displacement = opened.hooks[h].displacement;
            hook->rotation = opened.hooks[h].rotation;
            hook->pivot = opened.hooks[h].pivot;
        }
    field.retractor = std::move(opened.retractor);
    field.yielded = std::move(opened.yielded);
    field.opening = std::move(opened.opening);
    take_stiffened(field.problem, field.opening.stiffened, planned_case.label_table);
    field.metrics.solution.near_tets = opened.near_tets;
    if (field.opening.status == fem::OpeningStatus::cancelled) {
        field.status = PlanStatus::cancelled;
    } else if (!is_usable(field.opening)) {
        field.status
            = field.opening.status == fem::OpeningStatus::inverted ? PlanStatus::inverted : PlanStatus::not_converged;
    }
    OpenedWound wound { .rigid = { .vertices = std::move(cut.rigid), .solved = {} },
        .contact = {},
        .touchable = std::move(opened.touchable),
        .ten_node = std::move(opened.ten_node),
        .coarse = std::move(opened.coarse),
        .coarse_turn = opened.coarse_turn };
    if (field.metrics.contact && field.metrics.contact->computed)
        wound.contact = std::move(surfaces.options);
    if (field.opening.status == fem::OpeningStatus::cancelled || wound.rigid.vertices.empty())
        return wound;
    wound.rigid.solved = field.opening.displacement;
    move_rigid_pieces(field.wall, wound.rigid.vertices, field.opening.displacement);
    return wound;
}

OpenedWound open_wound(PlannedField& field, Patient& patient, const mesh::LabelVolume& labels, CutWall cut,
    const Job& job, const OpenedWall* start)
{
    return open_wound(field, patient, patient.planned_case(), labels, std::move(cut), job, start);
}

void end_unfinished(PlannedField& field, OpenedWound& wound, const std::string& why)
{
    RETRACTOR_ASSERT(field.status == PlanStatus::cancelled && field.opening.status == fem::OpeningStatus::cancelled);
    const Eigen::Index corners = field.wall.vertices.rows();
    Points& displacement = field.opening.displacement; // may be of ten-node elements, whose midpoints come last
    if (displacement.rows() < corners)
        displacement = Points::Zero(corners, 3);
    displacement.conservativeResize(corners, 3);
    field.opening.far.reset();
    field.opening.status = fem::OpeningStatus::not_converged;
    field.opening.message = why + "; " + field.opening.message;
    field.status = PlanStatus::not_converged;
    field.ended_by_time = true;
    if (wound.rigid.vertices.empty())
        return;
    wound.rigid.solved = displacement;
    move_rigid_pieces(field.wall, wound.rigid.vertices, displacement);
}

fem::ElasticProblem problem_with_fixed_hooks(const PlannedField& field)
{
    if (field.problem.blades.empty())
        return field.problem;
    if (field.problem.mesh.nodes_per_tet == 4)
        return holding_hooks(field.problem, field);
    return fem::with_midpoints(
        holding_hooks(fem::without_midpoints(field.problem), field), elements_with_midpoints(field.problem.mesh));
}

std::vector<bool> pushing_hooks(const Approach& approach, const std::vector<Vec3>& forces_N)
{
    constexpr double kNothing = 1e-3; // share of the largest force: residual of a nonlinear equilibrium
    double largest = 0.0;
    for (const Vec3& force : forces_N)
        largest = std::max(largest, force.norm());
    std::vector<bool> pushing;
    RETRACTOR_ASSERT(forces_N.size() <= approach.hooks.size());
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
    RETRACTOR_ASSERT(forces_N.size() <= pushing.size() && forces_N.size() <= field.hooks.size());
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
