#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/staged_results.h"
#include "ui/cli/plan/field_table.h"
#include "ui/cli/plan/saved_plans.h"
#include "ui/results/field_files.h"

#include "fem/error_estimation/error_estimate.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "planner/approach/find_division.h"
#include "planner/case/draft_case.h"
#include "planner/decision/decisions.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/plan.h"
#include "planner/wall/parted_bones.h"
#include "planner/wall/wall_pressure.h"
#include "planner/wall/wall_tension.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/plan/second_opinion.h"
#include "ui/movie/plan_movie.h"
#include "ui/plan_scene/case_picture.h"
#include "ui/scene/vtk/offscreen.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <tuple>

#include <unistd.h>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr double kFarthestMm = 1e4; // from the lips: no patient reaches beyond

    constexpr const char* kMapsHelp
        = "Also draw numbers as colours, separated by commas: strain, pressure (of the blades), risk (distance to "
          "structures at risk), sight (which part of the target is seen), eyes (from where), reach (of a finger and of "
          "two instruments)";

    struct PlanOptions {
        std::string case_file, approach, target, out, views, maps, size, backend, elasticity, element;
        bool without_names = false;
        std::string reference, contact;
        std::vector<std::string> pressures, stiffness;
        std::optional<std::string> export_formats;
        double reference_limit_s = 600.0;
        std::optional<double> near_mm; ///< where it was given, also 0
        std::optional<double> edge_mm;
        std::optional<std::string> accuracy; ///< where it was given
        std::optional<double> time_s; ///< where it was given
        unsigned mesh_seed = 0;
        bool check_far = false; ///< PlanChecks::linear_region
        bool draft = false;
        bool injury_options = false; ///< PlanChecks::injury_options
        bool render = false;
        bool play = false; ///< a movie instead of pictures
        bool frames = false; ///< the movie's pictures, too
        bool parallel = false;
    };

    void refuse_without_wall(const planner::Case& planned_case, const std::string& case_file)
    {
        if (!planner::has_soft_wall(planned_case.label_table))
            throw InputError("no label has the role wall, and bones alone are not a wall: there is nothing to cut. To "
                             "look at the case, use retractor render --views slices,overview",
                case_file + "#/labels/table");
    }

    /// The export formats: "ccx", "feb" or both.
    std::vector<std::string> export_formats(const PlanOptions& options)
    {
        if (!options.export_formats)
            return {};
        std::vector<std::string> formats = split(*options.export_formats, ',');
        if (formats.empty())
            throw InputError("no format is named; there are ccx, feb", "--export");
        for (const std::string& format : formats)
            if (format != "ccx" && format != "feb")
                throw InputError("there is no format \"" + format + "\"; there are ccx, feb", "--export");
        return formats;
    }

    /// Refuses tissue that FEBio files cannot hold: they are written for neo-Hookean tissue without tension. A law that
    /// the plan does not use is no obstacle.
    void refuse_unwritable_tissue(const planner::Case& planned_case, const PlanOptions& options)
    {
        const std::vector<std::string> formats = export_formats(options);
        if (std::find(formats.begin(), formats.end(), "feb") == formats.end())
            return;
        if (planner::under_pressure(planned_case))
            throw InputError("FEBio files cannot contain the pressure on the wall: omit feb, or remove the pressure "
                             "(--pressure LABEL=0)",
                "--export");
        for (const mesh::LabelInfo& info : planned_case.label_table) {
            if (info.role != mesh::Role::wall)
                continue;
            const fem::Material& material = fem::find_material(planned_case.materials, info.material);
            if (planner::under_tension(material))
                throw InputError("FEBio files cannot contain the tension of the material \"" + material.name
                        + "\": omit feb, or remove the tension (retractor tension)",
                    "--export");
            if (material.law && planned_case.solution.elasticity == fem::Elasticity::hyperelastic)
                throw InputError("FEBio files contain only neo-Hookean tissue, but the material \"" + material.name
                        + "\" has the law " + std::string(fem::law_name(material.law->law))
                        + ": omit feb, or plan with another elasticity",
                    "--export");
        }
    }

    /// Replaces the pressures of these labels in the case.
    void set_pressures(planner::Case& planned_case, const std::vector<std::string>& texts)
    {
        std::vector<planner::PressureSpec> given;
        const auto of = [](const std::string& label) {
            return [&label](const planner::PressureSpec& spec) { return spec.label == label; };
        };
        for (const std::string& text : texts) {
            given.push_back(planner::pressure_from_text(text));
            const std::string& label = given.back().label;
            if (std::count_if(given.begin(), given.end(), of(label)) > 1)
                throw InputError("the label \"" + label + "\" is given twice", "--pressure");
            std::erase_if(planned_case.pressures, of(label));
        }
        planned_case.pressures.insert(planned_case.pressures.end(), given.begin(), given.end());
    }

    /// Factors of the texts "skin=1.5". @throws InputError as check_stiffness_factors(), and on a text of another form
    planner::StiffnessFactors stiffness_factors(
        const planner::Case& planned_case, const std::vector<std::string>& texts)
    {
        planner::StiffnessFactors factors;
        for (const std::string& text : texts) {
            const std::string where = "--stiffness " + text;
            const std::size_t equals = text.find('=');
            if (equals == std::string::npos || equals == 0)
                throw InputError("a factor is NAME=NUMBER", where);
            if (!factors.emplace(text.substr(0, equals), parse_numbers(text.substr(equals + 1), 1, where).front())
                     .second)
                throw InputError("this stiffness is given twice", where);
        }
        try {
            planner::check_stiffness_factors(planned_case, factors);
        } catch (const InputError& error) {
            throw InputError(error.what(), "--stiffness " + error.where());
        }
        return factors;
    }

    planner::PlanChecks checks_of(const PlanOptions& options)
    {
        return { .linear_region = options.check_far,
            .error_bars = !options.draft,
            .draft = options.draft,
            .injury_options = options.injury_options,
            .find_region = !options.draft };
    }

    /// The accuracy of a plan: the option's, else the case's, else the default. Nothing where none is asked, and for a
    /// draft.
    std::optional<planner::AccuracyGoal> asked_accuracy(
        const PlanOptions& options, const planner::SolverSettings& solution)
    {
        std::optional<planner::AccuracyGoal> goal = solution.accuracy.value_or(planner::AccuracyGoal {});
        if (options.accuracy)
            goal = parse_accuracy(*options.accuracy, *goal);
        if (options.draft) {
            if (options.accuracy && goal)
                throw InputError("a draft promises no accuracy: leave out --draft or --accuracy", "--accuracy");
            return std::nullopt;
        }
        if (goal)
            goal->time_s = options.time_s.value_or(goal->time_s);
        return goal;
    }

    /// The case of the file with only the chosen approach, or with all, as the options change it. Options that
    /// contradict each other are refused before the patient is read.
    planner::Case chosen_case(const PlanOptions& options, planner::Case planned_case)
    {
        refuse_without_wall(planned_case, options.case_file);
        if (!options.approach.empty())
            planned_case.approaches = { planner::find_approach(planned_case, options.approach) };
        if (!options.contact.empty())
            planned_case.contact = planner::contact_mode_from_string(options.contact).value();
        planner::SolverSettings& solution = planned_case.solution; // settings without an option stay as in the case
        if (!options.elasticity.empty())
            solution.elasticity = planner::elasticity_from_string(options.elasticity).value();
        if (!options.element.empty() && options.draft)
            throw InputError("a draft has elements of its own: leave out --draft or --element", "--element");
        if (!options.element.empty())
            solution.element = planner::element_from_string(options.element).value();
        solution.near_mm = options.near_mm.value_or(solution.near_mm);
        if (options.draft) {
            const planner::ContactMode asked = planned_case.contact;
            planner::make_draft(planned_case);
            if (!options.contact.empty())
                planned_case.contact = asked;
        }
        set_pressures(planned_case, options.pressures);
        for (planner::Approach& approach : planned_case.approaches) {
            planner::SizingSpec& sizing = approach.sizing;
            sizing.corridor_edge_mm = options.edge_mm.value_or(sizing.corridor_edge_mm);
            sizing.coarse_edge_mm = std::max(sizing.coarse_edge_mm, sizing.corridor_edge_mm);
            sizing.mesh_seed = options.mesh_seed;
        }
        planner::check_plan(planned_case, checks_of(options));
        refuse_unwritable_tissue(planned_case, options);
        if (planned_case.approaches.empty())
            throw InputError("the case has no approach yet: add one with retractor approach add",
                options.case_file + "#/approaches");
        return planned_case;
    }

    FieldViews picture_request(const PlanOptions& options, const planner::Case& planned_case)
    {
        const auto [width, height] = parse_size(options.size.empty() ? "1280x960" : options.size);
        FieldViews request { .views = options.views.empty() ? planned_case.views : split(options.views, ','),
            .width = width,
            .height = height,
            .names = !options.without_names };
        if (std::erase(request.views, "kept") > 0) {
            request.kept = planner::read_decisions(planner::decisions_file(planned_case)).views;
            std::erase_if(request.kept, [&](const planner::NamedView& view) {
                return !view.opened
                    || std::none_of(planned_case.approaches.begin(), planned_case.approaches.end(),
                        [&](const planner::Approach& approach) { return approach.name == view.approach; });
            });
            if (request.kept.empty())
                throw InputError("no view of an opened field is kept: keep one in the window with Shift+V", "--views");
        }
        for (const std::string& map : split(options.maps, ','))
            request.maps.push_back(field_map_from_string(map));
        for (const std::string& view : request.views)
            if (std::find(std::begin(planner::kViewNames), std::end(planner::kViewNames), view)
                == std::end(planner::kViewNames))
                throw InputError(
                    "there is no view \"" + view + "\"; there are surgeon, overview, slices, kept", "--views");
        return request;
    }

    enum class Rounds {
        one,
        to_accuracy, ///< finer and finer meshes, until the accuracy is reached
    };

    planner::PlanChecks checks_of(const PlanOptions& options, Rounds rounds, const planner::Case& planned_case)
    {
        planner::PlanChecks checks = checks_of(options);
        if (rounds == Rounds::to_accuracy)
            checks.accuracy = asked_accuracy(options, planned_case.solution);
        const double asked_s = checks.accuracy ? checks.accuracy->time_s : options.time_s.value_or(0.0);
        checks.opening_time_s = std::max(checks.opening_time_s, asked_s);
        planner::check_plan(planned_case, checks);
        return checks;
    }

    /// The common beginning of plan and render. Wrong options are refused before the long work.
    struct PlannedCase {
        PlannedCase(const PlanOptions& options, Rounds rounds, const Job& job)
            : in_file(open_case(options.case_file))
            , patient(chosen_case(options, in_file), job)
            , request(picture_request(options, patient.planned_case()))
            , checks(checks_of(options, rounds, patient.planned_case()))
            , folder(options.out)
            , made(folder)
        {
            patient.set_stiffness_factors(stiffness_factors(patient.planned_case(), options.stiffness));
            drawn = rounds == Rounds::one
                ? saved_or_planned(patient, job, checks)
                : DrawnFields { .fields = plan_all(patient, job, checks), .saved = {}, .remarks = {} };
            refuse_if_cancelled(job);
        }
        planner::Case in_file; ///< without the options' changes
        planner::Patient patient;
        FieldViews request;
        planner::PlanChecks checks;
        fs::path folder;
        OutFolder made;
        DrawnFields drawn;
    };

    /// The field's problem for programs without contact and without elements of which some edges are straight.
    fem::ElasticProblem problem_for_other_programs(const planner::PlannedField& field)
    {
        const fem::ElasticProblem problem = planner::problem_with_fixed_hooks(field);
        return field.metrics.solution.choice.element == planner::ElementKind::mixed
            ? with_midpoints(fem::without_midpoints(problem))
            : problem;
    }

    void ask_for_second_opinions(
        const PlanOptions& options, const fs::path& ccx, std::vector<planner::PlannedField>& fields, const Job& job)
    {
        const auto limit = std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options.reference_limit_s));
        for (planner::PlannedField& field : fields)
            if (planner::is_measured(field))
                field.metrics.second_opinion = second_opinion(
                    problem_for_other_programs(field), ccx, options.out, field.approach.name, limit, job);
    }

    /// The problem without the laws that its elasticity does not use.
    fem::ElasticProblem as_solved(const planner::PlannedField& field)
    {
        fem::ElasticProblem problem = problem_for_other_programs(field);
        if (field.metrics.solution.choice.elasticity != fem::Elasticity::hyperelastic)
            for (fem::Material& material : problem.material_of_label)
                material.law.reset();
        return problem;
    }

    /// A remark on the elasticity of a deck, when it differs from the plan's.
    std::string export_remark(const std::string& format, const planner::PlannedField& field)
    {
        const fem::Elasticity elasticity = field.metrics.solution.choice.elasticity;
        if (format == "feb" && elasticity != fem::Elasticity::hyperelastic)
            return " (neo-Hookean, of the same small-strain stiffness: the plan is "
                + std::string(planner::to_string(elasticity)) + ")";
        if (format == "ccx" && elasticity != fem::Elasticity::linear)
            return " (linear: the plan is " + std::string(planner::to_string(elasticity)) + ")";
        return {};
    }

    /// The files of the opened wounds for other programs.
    struct Decks {
        std::string text; ///< a line for each: its file, or why it is not written
        Json written = Json::array(); ///< their files
        Json refused = Json::array(); ///< of each: approach, format, and the reason
    };

    /// Writes a deck of each measured field. What a format cannot hold does not stop the others.
    Decks write_decks(const std::vector<std::string>& formats, const std::vector<planner::PlannedField>& fields,
        const StagedResults& staged)
    {
        Decks decks;
        for (const std::string& format : formats)
            for (const planner::PlannedField& field : fields) {
                if (!planner::is_measured(field))
                    continue;
                const std::string& name = field.approach.name;
                const fs::path earlier
                    = staged.published(staged.folder() / (name + (format == "feb" ? ".feb" : ".inp")));
                try {
                    const fs::path deck = export_problem(as_solved(field), format, staged.folder(), name);
                    const std::string file = staged.published(deck).string();
                    decks.text += file + export_remark(format, field) + "\n";
                    decks.written.push_back(file);
                } catch (const InputError& error) {
                    const std::string reason = error.what() + (" (" + error.where() + ")");
                    decks.text += name + " is not written for " + (format == "feb" ? "FEBio" : "CalculiX") + ": "
                        + reason + (fs::exists(earlier) ? "; " + earlier.string() + " is of an earlier plan" : "")
                        + "\n";
                    decks.refused.push_back({ { "approach", name }, { "format", format }, { "reason", reason } });
                }
            }
        return decks;
    }

    /// Writes the files of a plan. @param saved the sentence that says what is saved with the case
    Outcome write_plan(const PlanOptions& options, const std::vector<std::string>& formats, PlannedCase& planned,
        const std::string& saved, const Job& job)
    {
        auto& [in_file, patient, request, checks, folder, made, drawn] = planned;
        std::vector<planner::PlannedField>& fields = drawn.fields;
        planner::Provenance computed = provenance_now(patient.planned_case());
        computed.stiffness = planner::stiffness_text(patient.stiffness_factors());
        StagedResults staged(folder);
        write_field_meshes(staged.folder(), patient, fields);
        const Decks decks = write_decks(formats, fields, staged);
        if (options.render) {
            const std::vector<planner::ReportPicture> pictures
                = render_fields(staged.folder(), patient, fields, request, job);
            refuse_if_cancelled(job);
            write_field_report(staged.folder() / "report.html", patient, computed, fields, pictures);
        }
        Outcome outcome;
        const std::vector<std::string> kept = keep_earlier_metrics(folder, staged.folder(), fields);
        outcome.document = write_metrics(staged.folder(), computed, patient, fields);
        staged.publish("metrics.json");
        if (!formats.empty()) {
            outcome.document["exports"] = decks.written;
            outcome.document["not_exported"] = decks.refused;
        }
        outcome.text = field_table(fields) + decks.text + saved;
        if (!kept.empty()) {
            const std::string file = (folder / "metrics-earlier.json").string();
            outcome.text += file + " keeps the earlier results of " + joined(kept) + "\n";
            outcome.document["earlier_results"] = file;
        }
        if (const fs::path report = folder / "report.html"; !options.render && fs::exists(report))
            outcome.text += report.string() + " and its pictures show an earlier plan (add --render to renew them)\n";
        outcome.exit_code = decks.refused.empty() ? exit_code_of(fields) : 1;
        return outcome;
    }

    Outcome plan(const PlanOptions& options, const Job& job)
    {
        // Missing programs and wrong options are reported before the long work.
        const fs::path ccx = options.reference.empty() ? fs::path() : find_calculix();
        const std::vector<std::string> formats = export_formats(options);
        PlannedCase planned(options, Rounds::to_accuracy, job);
        std::vector<planner::PlannedField>& fields = planned.drawn.fields;
        if (!ccx.empty())
            ask_for_second_opinions(options, ccx, fields, job);
        const bool hurried = options.time_s
            && *options.time_s < planned.in_file.solution.accuracy.value_or(planner::AccuracyGoal {}).time_s;
        std::string saved;
        if (!options.accuracy && !hurried && options.stiffness.empty()) // a hurried plan takes no better one's place
            saved = save_plans(planned.in_file, planned.patient.planned_case(), fields);
        try {
            return write_plan(options, formats, planned, saved, job);
        } catch (const IoError&) { // the long work is not lost with the disk
            const std::string reason = to_string(current_failure());
            Outcome unwritten;
            unwritten.text = field_table(fields) + saved + "the files of the plan are not written: " + reason + "\n";
            unwritten.document["not_written"] = reason;
            unwritten.exit_code = 1;
            return unwritten;
        }
    }

    Outcome picture_outcome(const std::vector<planner::ReportPicture>& pictures)
    {
        Outcome outcome;
        outcome.document["pictures"] = Json::array();
        for (const planner::ReportPicture& picture : pictures) {
            outcome.document["pictures"].push_back({ { "approach", picture.approach },
                { "file", picture.file.string() }, { "caption", picture.caption } });
            outcome.text += picture.file.string() + "\n";
        }
        return outcome;
    }

    Outcome render_fields_of(const PlanOptions& options, const Job& job)
    {
        PlannedCase planned(options, Rounds::one, job);
        auto& [in_file, patient, request, checks, folder, made, drawn] = planned;
        std::vector<planner::PlannedField>& fields = drawn.fields;
        const std::vector<planner::ReportPicture> pictures = render_fields(folder, patient, fields, request, job);
        refuse_if_cancelled(job);
        Outcome outcome = picture_outcome(pictures);
        outcome.text += drawn.remarks;
        for (const auto& [name, date] : drawn.saved) {
            outcome.text += name + ": drawn from the plan of " + date + ", saved with the case\n";
            outcome.document["saved_plans"][name] = date;
        }
        if (const Json refused = refused_document(fields); !refused.empty())
            outcome.document["refused"] = refused;
        outcome.exit_code = exit_code_of(fields);
        if (outcome.exit_code != 0)
            outcome.text += field_table(fields);
        return outcome;
    }

    void refuse_what_needs_a_plan(const FieldViews& request)
    {
        if (!request.maps.empty())
            throw InputError("maps show numbers of a planned field: add a view of it, such as surgeon", "--maps");
        if (!request.kept.empty())
            throw InputError("kept views show a planned field: leave --target and --views slices out", "--views");
    }

    /// Renders the slices of approaches, which need no plan.
    Outcome render_slices_of(const PlanOptions& options, const Job& job)
    {
        planner::Patient patient(chosen_case(options, open_case(options.case_file)), job);
        const FieldViews request = picture_request(options, patient.planned_case());
        refuse_what_needs_a_plan(request);
        if (!patient.has_ct())
            throw InputError("slices need a CT, and the case has none", options.case_file + "#/ct");
        make_folder(options.out);
        const std::vector<planner::ReportPicture> pictures = render_slices(options.out, patient, request, job);
        refuse_if_cancelled(job);
        return picture_outcome(pictures);
    }

    /// Renders the case without an approach, or without a wall for a plan.
    Outcome render_case(const PlanOptions& options, planner::Case planned_case, const Job& job)
    {
        const bool asked = !options.views.empty();
        FieldViews request = picture_request(options, planned_case);
        refuse_what_needs_a_plan(request);
        if (!asked)
            request.views = { "overview", "slices" };
        for (const std::string& view : request.views)
            if (view == "surgeon") {
                refuse_without_wall(planned_case, options.case_file);
                throw InputError("the surgeon's view needs an approach, and the case has none yet: add one with "
                                 "retractor approach add",
                    options.case_file + "#/approaches");
            }
        planner::Patient patient(std::move(planned_case), job);
        const std::optional<planner::TargetSpec> target
            = options.target.empty() ? default_target(patient) : parse_target(options.target);
        if (!patient.has_ct()) {
            if (asked && std::find(request.views.begin(), request.views.end(), "slices") != request.views.end())
                throw InputError("slices need a CT, and the case has none", options.case_file + "#/ct");
            std::erase(request.views, "slices");
        }
        make_folder(options.out);
        const std::vector<planner::ReportPicture> pictures
            = render_case_views(options.out, patient, target, request, job);
        refuse_if_cancelled(job);
        return picture_outcome(pictures);
    }

    /// Plays the plans as a movie.
    Outcome render_movie(const PlanOptions& options, const Job& job)
    {
        if (!options.views.empty() || !options.maps.empty())
            throw InputError(
                "a movie shows its own views: leave this option out", options.maps.empty() ? "--views" : "--maps");
        MovieSettings settings;
        if (!options.size.empty())
            std::tie(settings.width, settings.height) = parse_size(options.size);
        check_movie(settings);
        PlannedCase planned(options, Rounds::one, job);
        auto& [in_file, patient, request, checks, folder, made, drawn] = planned;
        const fs::path file = folder / "movie.webm", frames = options.frames ? folder / "frames" : fs::path();
        const planner::Case& planned_case = patient.planned_case();
        const MovieContent content { .planned_case = planned_case,
            .fields = drawn.fields,
            .decisions = planner::read_decisions(planner::decisions_file(planned_case)) };
        if (!write_movie(file, frames, patient, content, settings, make_offscreen_context(), job))
            refuse_if_cancelled(job);
        Outcome outcome;
        outcome.document["movie"] = file.string();
        outcome.text = file.string() + "\n";
        if (options.frames) {
            outcome.document["frames"] = frames.string();
            outcome.text += frames.string() + ": every frame as a picture\n";
        }
        outcome.text += drawn.remarks;
        outcome.exit_code = exit_code_of(drawn.fields);
        if (outcome.exit_code != 0)
            outcome.text += field_table(drawn.fields);
        return outcome;
    }

    Outcome render(const PlanOptions& options, const Job& job)
    {
        if (options.frames && !options.play)
            throw InputError("there are frames only of a movie: add --play", "--frames");
        planner::Case planned_case = open_case(options.case_file);
        if (options.play && !options.target.empty())
            throw InputError("a movie shows the approaches, each with its own target", "--target");
        if (!options.approach.empty())
            static_cast<void>(
                planner::find_approach(planned_case, options.approach)); // refuses a name that does not exist
        if (planned_case.approaches.empty() || !planner::has_soft_wall(planned_case.label_table)
            || !options.target.empty()) {
            if (options.play)
                throw InputError("a movie needs an approach, and a wall to open", options.case_file);
            return render_case(options, std::move(planned_case), job);
        }
        if (options.play)
            return render_movie(options, job);
        if (const auto views = split(options.views, ','); views == std::vector<std::string> { "slices" })
            return render_slices_of(options, job);
        return render_fields_of(options, job);
    }

    Json statistics_document(const mesh::MeshStatistics& s, const mesh::LabelTable& table)
    {
        Json fit = Json::array();
        for (const mesh::LabelFit& label : s.fit) {
            const mesh::LabelInfo* info = mesh::find_label(table, label.label);
            fit.push_back({ { "label", info != nullptr ? info->name : std::to_string(label.label) },
                { "voxel_volume_mm3", label.voxel_volume_mm3 }, { "mesh_volume_mm3", label.mesh_volume_mm3 },
                { "corridor_voxel_volume_mm3", label.corridor_voxel_volume_mm3 },
                { "corridor_mesh_volume_mm3", label.corridor_mesh_volume_mm3 } });
        }
        return { { "vertices", s.vertices }, { "tets", s.tets }, { "total_volume_error", s.total_volume_error },
            { "surface_distance_mean_mm", s.surface_distance_mean_mm },
            { "surface_distance_p95_mm", s.surface_distance_p95_mm }, { "dihedral_worst_deg", s.dihedral_worst_deg },
            { "dihedral_p01_deg", s.dihedral_p01_deg }, { "pieces", s.pieces }, { "rib_pieces", s.rib_pieces },
            { "refine_seconds", s.refine_seconds }, { "optimise_seconds", s.optimise_seconds },
            { "total_seconds", s.total_seconds }, { "bytes", s.bytes }, { "labels", fit } };
    }

    Outcome mesh(const PlanOptions& options, const Job& job)
    {
        planner::Case planned_case = open_case(options.case_file);
        refuse_without_wall(planned_case, options.case_file);
        planner::Patient patient(planned_case, job);
        mesh::MeshSizing sizing;
        std::string name = "wall";
        if (!options.approach.empty()) {
            planner::Approach approach = planner::find_approach(planned_case, options.approach);
            planner::find_division(approach, patient);
            sizing = planner::mesh_sizing_of(approach, planned_case.label_table);
            name = options.approach + "-uncut";
        } else {
            sizing.coarse_edge_mm = planned_case.sizing.coarse_edge_mm;
        }
        sizing.deterministic = !options.parallel;
        const mesh::HybridModel model = planner::build_wall(*patient.labels(), sizing, job);
        Outcome outcome;
        if (model.status != mesh::MeshStatus::done) {
            outcome.document = { { "error", model.message }, { "where", options.case_file } };
            outcome.text = model.message + "\n";
            outcome.exit_code = 1;
            return outcome;
        }
        outcome.document = statistics_document(model.statistics, patient.planned_case().label_table);
        outcome.document["frame"] = "LPS";
        outcome.document["message"] = model.message;
        if (!options.out.empty()) {
            const fs::path folder = options.out;
            make_folder(folder);
            mesh::write_vtu(folder / (name + ".vtu"), model.wall);
            write_file_atomically(folder / (name + "-statistics.json"), outcome.document.dump(2) + "\n");
        }
        outcome.text = outcome.document.dump(2) + "\n";
        return outcome;
    }

    void add_solution_options(CLI::App& command, PlanOptions& options)
    {
        command
            .add_option("--elasticity", options.elasticity,
                "Elasticity of the tissue: linear is quick, but tissue swells where hooks pull far; corotational "
                "allows large rotations; hyperelastic uses the law of each material in case.json, or neo-Hookean "
                "tissue where there is none (default: the case's solution, else corotational)")
            ->check(CLI::IsMember({ "linear", "corotational", "hyperelastic" }));
        command
            .add_option("--element", options.element,
                "Finite element: p1 (four nodes, limits Poisson's ratios to 0.45), locking-free (four nodes, any "
                "ratio), p2 (ten nodes, any ratio) or mixed (ten nodes at bone and lips, four elsewhere, "
                "ratios as p1) (default: the case's solution; a new case has mixed)")
            ->check(CLI::IsMember({ "p1", "locking-free", "p2", "mixed" }));
        command
            .add_option("--near", options.near_mm,
                "Distance from the lips, mm, within which the tissue is computed nonlinearly; tissue beyond is "
                "computed linearly. 0: the whole wall is computed alike (--elasticity, --element and --near are also "
                "\"solution\" in case.json)")
            ->check(in_range(0.0, kFarthestMm));
        command.add_flag("--draft", options.draft,
            "A quick look: four-node elements on a coarse mesh, without error bars, and without contact between wall "
            "and organs unless --contact is given. Forces may be half or twice those of a full plan");
        command
            .add_option(
                "--edge", options.edge_mm, "Edge length (mm) of the mesh round the incision (default: the approach's)")
            ->check(in_range(0.5, 50.0));
        command
            .add_option("--mesh-seed", options.mesh_seed,
                "Another mesh of the same edge lengths for each number; what differs between two meshes is chance")
            ->check(in_range(0.0, 1e6))
            ->capture_default_str();
        command
            .add_option("--pressure", options.pressures,
                "LABEL=kPa: pressure of this structure on the wall where the two meet (gas in a cavity, blood in a "
                "vessel; negative: suction). The label must not belong to the wall. The pressure follows the surface "
                "as the wall deforms. Repeat the option for several labels (also \"pressures\" in case.json)")
            ->allow_extra_args(false);
        command
            .add_flag("--contact{on}", options.contact,
                "Contact of the lips with each other and of the wall with organs: on, off, or auto, which computes "
                "contact where surfaces would pass through each other (write --contact=off; default: \"contact\" in "
                "case.json, else auto)")
            ->check(CLI::IsMember({ "auto", "on", "off" }));
    }

    /// Starts the executable beside this one for the other kind of context. A process draws with one kind only.
    void switch_backend(const std::string& backend, char** argv)
    {
        if (backend.empty() || backend == make_offscreen_context()->backend())
            return;
        const fs::path self = fs::read_symlink("/proc/self/exe");
        const fs::path other = self.parent_path() / (backend == "egl" ? "retractor-egl" : "retractor");
        ::execv(other.c_str(), argv);
        throw IoError(
            "cannot start the program that draws with " + backend + ": " + std::strerror(errno), other.string());
    }

} // namespace

void add_mesh_command(Commands& commands)
{
    auto options = std::make_shared<PlanOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "mesh", "Mesh the wall of a case with tetrahedra and report how well the mesh fits the labels");
    command->footer("Example: retractor mesh case.json --approach median --out mesh");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option(
        "--approach", options->approach, "Refine round this approach's incision (default: coarse everywhere)");
    command->add_option("--out", options->out, "Folder for the VTU and the statistics");
    command->add_flag("--parallel", options->parallel, "Use all cores; the mesh then differs a little from run to run");
    commands.on(command, [options](const Job& job) { return mesh(*options, job); });
}

void add_plan_command(Commands& commands)
{
    auto options = std::make_shared<PlanOptions>();
    CLI::App* command = commands.app.add_subcommand("plan", "Cut, open and measure the approaches of a case");
    command->footer("Example: retractor plan case.json --out plan --render\n"
                    "Example: retractor plan case.json --out plan --accuracy 10%,1 --time 1800\n"
                    "Example: retractor plan case.json --out plan --reference ccx --export ccx\n"
                    "Example: retractor plan case.json --out plan --elasticity hyperelastic --near 40 --check\n"
                    "Example: retractor plan case.json --out plan --pressure lung_left=1.3");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--approach", options->approach, "Only this approach (default: all)");
    command->add_option("--out", options->out, "Folder for metrics.json, VTU and VTP files")->required();
    add_solution_options(*command, *options);
    command->add_option("--accuracy", options->accuracy,
        "FORCE%[,MM]: plan again on finer meshes until the force's error bar is at most this share of the force and "
        "the opening's bar at most MM. none: one mesh (default: the case's solution, else 15%,2; also "
        "\"accuracy\" of \"solution\" in case.json)");
    command
        ->add_option("--stiffness", options->stiffness,
            "NAME=FACTOR, separated by commas: stiffness of a material of the wall, or of the springs \"costovertebral "
            "joint\" and \"bed of the shoulder girdle\", in multiples of the case's. Such a plan is not saved with the "
            "case (retractor sensitivity plans with many)")
        ->delimiter(',');
    command
        ->add_option("--time", options->time_s,
            "Time (s) for the meshes of one approach: a finer mesh that would take longer is not tried (default: the "
            "case's solution, else 600). A wound that finds no equilibrium ends after 1800 s, or after this time "
            "where that is longer")
        ->check(in_range(planner::kShortestSearchS, planner::kLongestSearchS));
    command->add_flag("--injury-options", options->injury_options,
        "Where a bone would break: also solve the largest opening without a fracture, and plan the approach once more "
        "with this bone divided. Takes about as long again");
    CLI::Option* draws = command->add_flag("--render", options->render, "Also draw the views and write report.html");
    command->add_option("--maps", options->maps, kMapsHelp)->needs(draws);
    command
        ->add_option("--reference", options->reference,
            "Solve the opened wound again with another program and report the difference: ccx (CalculiX, linear, with "
            "the same mesh, supports and hooks)")
        ->check(CLI::IsMember({ "ccx" }));
    command->add_option("--reference-limit", options->reference_limit_s, "Time limit for the other program, s")
        ->capture_default_str()
        ->check(in_range(0.001, 1e6));
    command->add_option("--export", options->export_formats,
        "Also write the opened wound as a deck: ccx (CalculiX, .inp), feb (FEBio 4, .feb), or both, separated by a "
        "comma. FEBio files hold no joints of ribs with the spine and no hooks that turn");
    command->add_flag(
        "--check", options->check_far, "With --near: also solve all of the wall nonlinearly and state the difference");
    commands.on(command, [options](const Job& job) { return plan(*options, job); });
}

void add_render_command(Commands& commands)
{
    auto options = std::make_shared<PlanOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "render", "Draw the planned fields of a case without a display; draw the case itself when it has no approach");
    command->footer("Example: retractor render case.json --out pictures --views surgeon,slices --size 1920x1080\n"
                    "Example: retractor render case.json --out movie --play");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--approach", options->approach, "Only this approach (default: all)");
    command->add_option("--target", options->target,
        "Show the case without its approaches, and look at this label, site SITE:LABEL:x,y,z,r or sphere x,y,z,r "
        "(default "
        "when the case has no approach: the first label of role target or at-risk)");
    command->add_option("--out", options->out, "Folder for the PNG files, or the movie")->required();
    command->add_option("--views", options->views,
        "surgeon, overview, slices, kept (opened views that were kept in the window), separated by commas (default: "
        "the case's)");
    command->add_option("--maps", options->maps, kMapsHelp);
    command->add_option(
        "--size", options->size, "Width x height in pixels (default: 1280x960; a movie, as from the window, 1280x720)");
    command->add_flag("--play", options->play,
        "Write movie.webm (VP9) instead of pictures: each approach before the cut, cut, pulled open, seen through "
        "the incision, and what is reached");
    command->add_flag("--frames", options->frames, "With --play: also every frame as a picture, frames/00001.png ..");
    command->add_flag("--no-names", options->without_names, "Leave out the names of structures in the surgeon's view");
    add_solution_options(*command, *options);
    command->add_option("--backend", options->backend, "osmesa or egl")->check(CLI::IsMember({ "osmesa", "egl" }));
    commands.on(command, [&commands, options](const Job& job) {
        switch_backend(options->backend, commands.argv);
        return render(*options, job);
    });
}

} // namespace retractor::ui::cli
