#include "mesh/base/atomic_file.h"
#include "mesh/base/text_format.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"

#include "fem/statics/driven_opening.h"
#include "mesh/base/error.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/find_division.h"
#include "planner/approach/hooks.h"
#include "planner/approach/incision_guide.h"
#include "planner/approach/retractors.h"
#include "planner/case/case_io.h"
#include "planner/case/opening_protocol.h"
#include "planner/case/patient.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

namespace retractor::ui::cli {

namespace {

    constexpr double kLongestSpaceMm = 500.0; // of a division; as in check_division()
    constexpr const char* kBothDivisions = "both"; ///< value of --division
    constexpr double kLongestWaitS = 3600.0; // between two turns; as in check_opening_protocol()
    constexpr double kLongestMm = 2000.0; // length of an incision or a depth; longer than any patient

    struct ApproachOptions {
        std::string case_file, name, title, template_name, target, hooks, loose = "held", division, retractor,
                                                                          retractor_table;
        std::vector<std::string> points, retracted, ablations;
        double length_mm = 0.0, depth_mm = 0.0, opening_mm = 0.0;
        std::optional<double> edge_mm, coarse_mm, region_mm, forwards_mm, backwards_mm, rack_force_N, turn_every_s;
        planner::HookPull pull {};
        bool right = false, opening_given = false;
    };

    Json division_document(const planner::Division& division)
    {
        Json json { { "extent", to_string(division.extent) } };
        if (division.forwards_mm)
            json["forwards_mm"] = *division.forwards_mm;
        if (division.backwards_mm)
            json["backwards_mm"] = *division.backwards_mm;
        return json;
    }

    /// "as far as is safe", or "20 mm".
    std::string distance_text(const std::optional<double>& distance_mm)
    {
        return distance_mm ? in_words(*distance_mm) + " mm" : "as far as is safe";
    }

    Json approach_document(const planner::Approach& approach)
    {
        Json ablations = Json::array();
        for (const planner::AblationSpec& ablation : approach.ablations)
            ablations.push_back(Json::parse(planner::ablation_to_json(ablation)));
        Json document { { "name", approach.name }, { "called", planner::spoken_name(approach) },
            { "template", approach.template_name }, { "incision_length_mm", planner::incision_length(approach) },
            { "depth_mm", approach.depth_mm }, { "hooks", approach.hooks.size() }, { "retracted", approach.retracted },
            { "ablations", ablations }, { "loose_pieces", to_string(approach.loose_pieces) },
            { "division", division_document(approach.division) }, { "rationale", approach.rationale } };
        if (approach.retractor)
            document["retractor"] = planner::retractor_text(*approach.retractor);
        if (approach.opening_protocol)
            document["opening_protocol"] = planner::opening_protocol_text(*approach.opening_protocol);
        return document;
    }

    std::string approach_line(const planner::Approach& approach)
    {
        std::string text = formatted("%-18s %-16s incision %4.0f mm, depth %3.0f mm, %starget %s\n",
            approach.name.c_str(), approach.template_name.c_str(), planner::incision_length(approach),
            approach.depth_mm, approach.retractor ? "" : formatted("%zu hooks, ", approach.hooks.size()).c_str(),
            planner::target_name(approach.target).c_str());
        if (!approach.title.empty())
            text += "  called " + approach.title + "\n";
        if (const planner::Division& division = approach.division; division.extent == planner::DivisionExtent::full)
            text += "  divides intercostal muscle and pleura beyond the skin: forwards "
                + distance_text(division.forwards_mm) + ", backwards " + distance_text(division.backwards_mm) + "\n";
        else if (planner::divides_sternum(division.extent))
            text += std::string("  saws the sternum across under the skin, to ")
                + (division.extent == planner::DivisionExtent::sternum_right       ? "its right edge"
                        : division.extent == planner::DivisionExtent::sternum_left ? "its left edge"
                                                                                   : "both edges")
                + "\n";
        for (const planner::AblationSpec& ablation : approach.ablations)
            text += "  removes " + planner::ablation_text(ablation, planner::incision_length(approach)) + "\n";
        if (!approach.ablations.empty() || approach.loose_pieces != planner::LoosePieces::held)
            text += "  loose pieces are " + std::string(to_string(approach.loose_pieces)) + "\n";
        if (approach.retractor)
            text += "  opened by a retractor: " + planner::retractor_text(*approach.retractor) + ", blades of "
                + in_words(approach.retractor->blade_width_mm) + " x " + in_words(approach.retractor->blade_depth_mm)
                + " mm\n";
        if (approach.opening_protocol)
            text += "  opened by " + planner::opening_protocol_text(*approach.opening_protocol) + "\n";
        return text;
    }

    void check_ablated_label(const mesh::LabelTable& table, const std::string& label, const std::string& where)
    {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        if (label.empty() || (info != nullptr && info->role == mesh::Role::wall))
            return;
        std::string known;
        for (const mesh::LabelInfo& other : table)
            if (other.role == mesh::Role::wall)
                known += (known.empty() ? "" : ", ") + other.name;
        throw InputError(
            (info != nullptr ? "only tissue of the wall can be removed, and \"" + label + "\" is not part of the wall"
                             : "there is no label \"" + label + "\"")
                + "; the wall has: " + (known.empty() ? "none" : known),
            where);
    }

    std::vector<planner::AblationSpec> parse_ablations(const ApproachOptions& options, const mesh::LabelTable& table)
    {
        std::vector<planner::AblationSpec> ablations;
        for (const std::string& text : options.ablations) {
            ablations.push_back(parse_ablation(text));
            check_ablated_label(table, ablations.back().label, "--ablate " + text);
        }
        return ablations;
    }

    /// Checks that every ablation lies along the incision.
    void check_ablations_along(const ApproachOptions& options, const planner::Approach& approach)
    {
        const double length = planner::incision_length(approach);
        for (std::size_t n = 0; n < approach.ablations.size(); ++n) {
            const planner::AblationSpec& ablation = approach.ablations[n];
            if (ablation.along_from_mm.value_or(0.0) >= 0.0 && ablation.along_to_mm.value_or(length) <= length)
                continue;
            throw InputError(
                formatted("positions along the incision are 0 to %.1f mm", length), "--ablate " + options.ablations[n]);
        }
    }

    planner::Approach approach_from_options(
        const ApproachOptions& options, planner::Patient& patient, std::string& remark)
    {
        planner::ApproachRequest request;
        request.name = options.name;
        request.target = parse_target(options.target);
        request.left = !options.right;
        request.length_mm = options.length_mm;
        request.sizing = patient.planned_case().sizing;
        request.sizing.corridor_edge_mm = options.edge_mm.value_or(request.sizing.corridor_edge_mm);
        request.sizing.coarse_edge_mm = options.coarse_mm.value_or(request.sizing.coarse_edge_mm);
        if (options.region_mm)
            request.sizing.region_mm = options.region_mm;
        if (options.points.empty()) {
            request.template_name = options.template_name;
            return planner::approach_from_template(*patient.labels(), *patient.anatomy(), request);
        }
        std::vector<Vec3> points;
        for (const std::string& text : options.points)
            points.push_back(parse_point(text, "--points"));
        const planner::PointsApproach by_points
            = planner::approach_from_points(*patient.labels(), points, request, options.depth_mm);
        double furthest = 0.0;
        for (const double moved : by_points.moved_mm)
            furthest = std::max(furthest, moved);
        remark = formatted("the points were moved onto the skin, by at most %.1f mm\n", furthest);
        return by_points.approach;
    }

    /// The division that the options give; nothing where --division is not given.
    std::optional<planner::Division> division_from_options(const ApproachOptions& options)
    {
        const auto extent
            = planner::division_extent_from_string(options.division == kBothDivisions ? "full" : options.division);
        const bool sternal = options.template_name.starts_with("hemisternotomy");
        if (options.division == kBothDivisions && sternal)
            return std::nullopt; // the template's own, and below the skin alone
        const bool has_distance = options.forwards_mm.has_value() || options.backwards_mm.has_value();
        if (has_distance && extent != planner::DivisionExtent::full)
            throw InputError(
                "a distance beyond the skin needs --division full", options.forwards_mm ? "--forwards" : "--backwards");
        if (!extent)
            return std::nullopt;
        return planner::Division {
            .extent = *extent, .forwards_mm = options.forwards_mm, .backwards_mm = options.backwards_mm
        };
    }

    /// @param both whether the command can add an approach for each extent
    CLI::Option* add_division_options(CLI::App& command, ApproachOptions& options, bool both)
    {
        std::vector<std::string> extents { "skin", "full", "sternum-right", "sternum-left", "sternum-across" };
        if (both)
            extents.emplace_back(kBothDivisions);
        CLI::Option* division
            = command
                  .add_option("--division", options.division,
                      std::string("What is divided beyond the skin incision: skin (nothing), full (intercostal muscle "
                                  "and pleura beyond both ends of the incision), or sternum-right, sternum-left, "
                                  "sternum-across (the sternum from the incision's lower end to its right edge, its "
                                  "left edge or both)")
                          + (both ? "; both adds two approaches, NAME and NAME_skin, whose forces and openings the "
                                    "report compares. Default: the template's own; with points skin"
                                  : ""))
                  ->check(CLI::IsMember(extents));
        command
            .add_option("--forwards", options.forwards_mm,
                "With --division full: distance beyond the incision towards the sternum, mm (default: as far as is "
                "safe)")
            ->check(in_range(0.0, kLongestSpaceMm));
        command
            .add_option("--backwards", options.backwards_mm,
                "With --division full: distance beyond the incision towards the spine, mm (default: as far as is safe)")
            ->check(in_range(0.0, kLongestSpaceMm));
        return division;
    }

    void check_hook_options(const ApproachOptions& options)
    {
        planner::check_pull(options.pull, "hooks: ");
        if (options.turn_every_s && !(options.opening_mm > 0.0))
            throw InputError("only an opening is made in turns of the crank: add --opening", "--turn-every");
        if (options.pull.force_N && options.opening_mm > 0.0)
            throw InputError(
                "a hook takes either a force or an opening, not both: remove one", "--opening, --hook-force");
        if (!options.pull.force_N && !options.pull.prescribes() && !(options.opening_mm > 0.0))
            throw InputError("hooks with a force limit or a soft grip need an opening: add --opening",
                options.pull.force_limit_N ? "--hook-limit" : "--hook-grip");
    }

    void check_retractor_options(const ApproachOptions& options)
    {
        if (options.retractor.empty()) {
            if (options.rack_force_N)
                throw InputError("only a retractor has a rack: add --retractor, or give --hook-force", "--rack-force");
            if (!options.retractor_table.empty())
                throw InputError("a table of retractors needs --retractor KIND", "--retractors");
            return;
        }
        if (!options.pull.prescribes())
            throw InputError("an approach has either hooks or a retractor, not both: leave out the options of hooks "
                             "(a retractor takes --opening or --rack-force)",
                "--retractor");
        if (options.rack_force_N.has_value() == (options.opening_mm > 0.0))
            throw InputError(
                "a retractor takes either an opening or a force: give one of the two", "--opening, --rack-force");
    }

    /// Hooks or the rack of an approach are opened by half a turn of the crank at a time, as often as the option says.
    void set_opening_protocol(
        planner::Case& planned_case, const std::string& approach, const std::optional<double>& turn_every_s)
    {
        if (turn_every_s)
            planner::find_approach(planned_case, approach).opening_protocol
                = planner::OpeningProtocol { .wait_s = *turn_every_s };
    }

    void set_retractor(planner::Case& planned_case, const std::string& approach, const ApproachOptions& options)
    {
        const planner::RetractorDrive drive { options.opening_mm, options.rack_force_N };
        if (options.retractor_table.empty())
            return planner::set_retractor(planned_case, approach,
                planner::find_retractor(planner::built_in_retractors(), options.retractor), drive);
        const std::vector<planner::RetractorKind> table = planner::read_retractors(options.retractor_table);
        planner::set_retractor(planned_case, approach, planner::find_retractor(table, options.retractor), drive);
    }

    /// @param hook_template option that places hooks instead
    void add_retractor_options(CLI::App& command, ApproachOptions& options, CLI::Option* hook_template)
    {
        std::string kinds;
        for (const planner::RetractorKind& kind : planner::built_in_retractors())
            kinds += (kinds.empty() ? "" : ", ") + kind.kind;
        command
            .add_option("--retractor", options.retractor,
                "Open with a retractor instead of hooks: a rigid frame with two blades that the tissue holds. "
                "Kinds: "
                    + kinds)
            ->excludes(hook_template);
        command.add_option("--retractors", options.retractor_table,
            "JSON file with a table of retractors of your own, for --retractor");
        command.add_option("--rack-force", options.rack_force_N,
            "With --retractor: force along the rack at each blade, N; the opening follows from the force (instead of "
            "--opening)");
    }

    void add_hook_options(CLI::App& command, ApproachOptions& options)
    {
        command
            .add_option("--turn-every", options.turn_every_s,
                "With --opening: seconds from one half turn of the crank (7 mm) to the next; a slower opening takes "
                "less "
                "force (default: 10; nearly all faster openings ruptured tissue)")
            ->check(in_range(0.0, kLongestWaitS));
        command.add_option("--hook-force", options.pull.force_N,
            "Force of each hook along its direction, N; the opening follows from the force (instead of --opening)");
        command.add_option("--hook-limit", options.pull.force_limit_N,
            "Largest force of each hook, N; a hook yields (slips) above this force");
        command.add_option("--hook-grip", options.pull.grip_N_per_mm,
            "Stiffness of the grip between each hook and its lip, N/mm (default: the lip follows the hook completely)");
    }

    /// Adds the approach with the hooks or the retractor of the options.
    /// The hooks that are asked for; by default 4, and one on each lip where half of the sternum swings out on its
    /// cartilages: two hooks on it would hold it straight.
    std::string hooks_of(const ApproachOptions& options, const planner::Approach& approach)
    {
        return !options.hooks.empty() ? options.hooks : planner::divides_sternum(approach.division.extent) ? "2" : "4";
    }

    /// Refuses a division of the sternum where the incision does not lie over it.
    void check_sternum_division(const planner::Approach& approach, planner::Patient& patient)
    {
        if (!planner::divides_sternum(approach.division.extent))
            return;
        planner::Approach tried = approach;
        planner::find_division(tried, patient);
        if (tried.division.strokes.empty())
            throw InputError(tried.division.words, "--division");
    }

    const planner::Approach& add_opened(
        planner::Case& planned_case, planner::Approach approach, const ApproachOptions& options)
    {
        const std::string name = approach.name;
        planner::add_approach(planned_case, std::move(approach));
        if (!options.retractor.empty())
            set_retractor(planned_case, name, options);
        else if (options.opening_mm > 0.0 || !options.pull.prescribes())
            planner::set_hooks(planned_case, name, hooks_of(options, planner::find_approach(planned_case, name)),
                options.opening_mm, options.pull);
        set_opening_protocol(planned_case, name, options.turn_every_s);
        return planner::find_approach(planned_case, name);
    }

    Outcome add(const ApproachOptions& options, const Job& job)
    {
        if (options.points.empty() == options.template_name.empty())
            throw InputError("give either --template or --points", "command line");
        planner::Case planned_case = open_case(options.case_file);
        check_retractor_options(options);
        check_hook_options(options);
        const std::optional<planner::Division> division = division_from_options(options);
        std::vector<planner::AblationSpec> ablations = parse_ablations(options, planned_case.label_table);
        planner::Patient patient(planned_case, job);
        Outcome outcome;
        planner::Approach approach = approach_from_options(options, patient, outcome.text);
        if (division && division->extent == planner::DivisionExtent::full
            && planner::divides_sternum(approach.division.extent))
            throw InputError(
                "a hemisternotomy divides no intercostal space: omit the option, or give skin", "--division");
        if (division)
            planner::set_division(approach, *division);
        check_sternum_division(approach, patient);
        if (!options.points.empty())
            if (const std::string crossed = planner::name_crossed_skeleton(approach, *patient.labels());
                !crossed.empty())
                outcome.text += crossed + "\n";
        approach.ablations = std::move(ablations);
        approach.loose_pieces = planner::loose_pieces_from_string(options.loose).value();
        check_ablations_along(options, approach);
        for (const std::string& organ : options.retracted)
            if (std::find(approach.retracted.begin(), approach.retracted.end(), organ) == approach.retracted.end())
                approach.retracted.push_back(organ);
        std::vector<planner::Approach> approaches { std::move(approach) };
        if (options.division == kBothDivisions) {
            approaches.push_back(approaches.front());
            approaches.back().name += "_skin";
            approaches.back().division = { .extent = planner::DivisionExtent::skin };
        }
        Json documents = Json::array();
        for (planner::Approach& each : approaches) {
            const planner::Approach& added = add_opened(planned_case, std::move(each), options);
            documents.push_back(approach_document(added));
            outcome.text += approach_line(added);
        }
        planner::write_case(planned_case);
        outcome.document = documents.size() == 1 ? documents[0] : Json { { "approaches", documents } };
        return outcome;
    }

    Outcome list(const std::string& case_file)
    {
        const planner::Case planned_case = open_case(case_file);
        Outcome outcome;
        outcome.document["approaches"] = Json::array();
        for (const planner::Approach& approach : planned_case.approaches) {
            outcome.document["approaches"].push_back(approach_document(approach));
            outcome.text += approach_line(approach);
        }
        if (planned_case.approaches.empty())
            outcome.text = "The case has no approaches yet; see retractor approach add --help\n";
        return outcome;
    }

    Outcome remove(const std::string& case_file, const std::string& name)
    {
        planner::Case planned_case = open_case(case_file);
        planner::remove_approach(planned_case, name);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document["removed"] = name;
        return outcome;
    }

    Outcome rename(const std::string& case_file, const std::string& name, const std::string& title)
    {
        planner::Case planned_case = open_case(case_file);
        planner::set_title(planned_case, name, title);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document = approach_document(planner::find_approach(planned_case, name));
        outcome.text = approach_line(planner::find_approach(planned_case, name));
        return outcome;
    }

    Outcome divide(const ApproachOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        planner::set_division(
            planner::find_approach(planned_case, options.name), division_from_options(options).value());
        planner::Patient patient(planned_case);
        check_sternum_division(planner::find_approach(planned_case, options.name), patient);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document = approach_document(planner::find_approach(planned_case, options.name));
        outcome.text = approach_line(planner::find_approach(planned_case, options.name));
        return outcome;
    }

    Outcome change_hooks(const ApproachOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        check_retractor_options(options);
        check_hook_options(options);
        if (!options.retractor.empty()) {
            set_retractor(planned_case, options.name, options);
        } else {
            if (!options.pull.force_N && !options.opening_given)
                throw InputError("give --opening or --hook-force", "command line");
            planner::set_hooks(planned_case, options.name,
                hooks_of(options, planner::find_approach(planned_case, options.name)), options.opening_mm,
                options.pull);
        }
        set_opening_protocol(planned_case, options.name, options.turn_every_s);
        planner::write_case(planned_case);
        Outcome outcome;
        outcome.document = approach_document(planner::find_approach(planned_case, options.name));
        outcome.text = approach_line(planner::find_approach(planned_case, options.name));
        return outcome;
    }

    Outcome guide(const ApproachOptions& options, const std::string& out, const Job& job)
    {
        planner::Patient patient(open_case(options.case_file), job);
        const planner::Approach& approach = planner::find_approach(patient.planned_case(), options.name);
        const OutFolder folder(out);
        const std::filesystem::path ribbon = std::filesystem::path(out) / (approach.name + "-guide.stl"),
                                    markup = std::filesystem::path(out) / (approach.name + ".mrk.json");
        mesh::write_stl(ribbon, planner::guide_ribbon(approach));
        write_file_atomically(markup, planner::slicer_markup(approach));
        Outcome outcome;
        outcome.document = { { "name", approach.name }, { "files", { ribbon.string(), markup.string() } },
            { "landmarks", Json::array() } };
        const std::vector<planner::LandmarkDistance> landmarks = planner::landmark_distances(patient, approach);
        for (const planner::LandmarkDistance& landmark : landmarks)
            outcome.document["landmarks"].push_back(
                { { "landmark", landmark.landmark }, { "at_mm", { landmark.at.x(), landmark.at.y(), landmark.at.z() } },
                    { "to_start_mm", landmark.to_start_mm }, { "to_end_mm", landmark.to_end_mm } });
        for (const std::string& sentence : planner::theatre_sentences(patient, approach))
            outcome.text += sentence + "\n";
        if (landmarks.empty())
            outcome.text += "no landmark: the labels show no sternum\n";
        outcome.text += "wrote " + ribbon.string() + " and " + markup.string() + "\n";
        return outcome;
    }

    void add_guide_command(CLI::App& approach, Commands& commands, const std::shared_ptr<ApproachOptions>& options)
    {
        auto out = std::make_shared<std::string>();
        CLI::App* command = approach.add_subcommand("guide",
            "Bring an incision into the theatre: distances from landmarks, a ribbon for the skin to print (STL), and a "
            "curve for 3D Slicer");
        command->footer("Example: retractor approach guide case.json --name median --out G");
        command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
        command->add_option("--name", options->name, "Name of the approach")->required();
        command->add_option("--out", *out, "Folder for NAME-guide.stl and NAME.mrk.json")->required();
        commands.on(command, [options, out](const Job& job) { return guide(*options, *out, job); });
    }

    void add_add_command(CLI::App& approach, Commands& commands, const std::shared_ptr<ApproachOptions>& options)
    {
        CLI::App* add_command
            = approach.add_subcommand("add", "Add an approach from a template, or from points on the skin");
        add_command->footer(
            "Example: retractor approach add case.json --template intercostal:4 --target aneurysm --opening 50\n"
            "         retractor approach add case.json --name mine --points 40,-110,20 55,-100,10 --target "
            "20,-10,30,15\n"
            "         retractor approach add case.json --template intercostal:5 --target aneurysm --opening 50 "
            "--ablate rib_left_6:2,22:40,90 --loose removed\n"
            "         retractor approach add case.json --template intercostal:4 --target aneurysm --opening 50 "
            "--division both");
        add_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
        add_command->add_option("--template", options->template_name,
            "Template of the approach: median, hemisternotomy-j, hemisternotomy-j-left, hemisternotomy-t, "
            "intercostal:N, distal, midcab, right-anterior or right-lateral");
        CLI::Option* points = add_command->add_option("--points", options->points,
            "Points of the incision, x,y,z (mm, patient LPS) on or near the skin, in cutting order");
        add_command
            ->add_option("--target", options->target,
                "Target to see: a label; a site on one, SITE:LABEL:x,y,z,r, such as "
                "\"anastomosis site:heart:31,-20,140,8\", where a valve's annulus may add the normal of its plane, "
                "annulus:LABEL:x,y,z,r,nx,ny,nz; or a sphere x,y,z,r (mm, patient LPS)")
            ->required();
        add_command->add_option("--name", options->name, "Name of the approach (default: the template's)");
        add_command->add_option("--length", options->length_mm, "Length of the incision, mm (default: the template's)")
            ->check(in_range(0.0, kLongestMm));
        add_command
            ->add_option(
                "--depth", options->depth_mm, "With --points: depth of the cut, mm (default: through the wall)")
            ->needs(points)
            ->check(in_range(0.0, kLongestMm));
        add_command
            ->add_option("--retract", options->retracted,
                "Organs to hold aside, NAME,..., in addition to those of the template. They do not block the view")
            ->delimiter(',');
        add_command
            ->add_option("--ablate", options->ablations,
                "Tissue to remove after the cut (repeatable, in this order). LABEL:FROM,TO[:ALONG_FROM,ALONG_TO] saws "
                "a segment out of one label: FROM and TO are mm across the incision (positive: left of the cutting "
                "direction, looking down on the skin), ALONG_FROM and ALONG_TO are mm along the incision (default: its "
                "ends). ball:X,Y,Z,RADIUS[:LABEL] removes a ball, mm (default: all tissue)")
            ->allow_extra_args(false);
        add_command
            ->add_option("--loose", options->loose,
                "Treatment of pieces that lose their support: held (on a soft bed), removed, or rigid (they move with "
                "the tissue beside them)")
            ->capture_default_str()
            ->check(CLI::IsMember({ "held", "removed", "rigid" }));
        add_division_options(*add_command, *options, true);
        add_command->add_flag("--right", options->right, "Intercostal: on the patient's right");
        CLI::Option* hooks = add_command->add_option(
            "--hooks", options->hooks, "Hook template: 2, 4, 8 or blade (default: 4; 2 for a hemisternotomy)");
        add_command
            ->add_option("--opening", options->opening_mm,
                "Distance that opposite hooks or the blades of a retractor open, mm; 0: no hooks yet")
            ->check(in_range(0.0, 2.0 * fem::kFarthestHookMm));
        add_hook_options(*add_command, *options);
        add_retractor_options(*add_command, *options, hooks);
        add_command->add_option("--edge", options->edge_mm,
            "Edge length of the mesh near the incision, mm (default: the value of the case)");
        add_command->add_option("--coarse", options->coarse_mm,
            "Edge length of the mesh far from the incision, mm (default: the value of the case)");
        add_command->add_option("--region", options->region_mm,
            "Mesh only the wall within this distance of the incision, mm, and the bones there up to their ends; 0: the "
            "whole wall (default: as much as moves; 50 mm for plan --draft)");
        commands.on(add_command, [options](const Job& job) { return add(*options, job); });
    }

} // namespace

void add_approach_commands(Commands& commands)
{
    CLI::App* approach
        = commands.app.add_subcommand("approach", "Add, divide, list, rename or remove the approaches of a case");
    approach->require_subcommand(1);
    auto options = std::make_shared<ApproachOptions>();
    add_add_command(*approach, commands, options);

    CLI::App* divide_command
        = approach->add_subcommand("divide", "Choose how far an approach divides the space between two ribs");
    divide_command->footer("Example: retractor approach divide case.json --name intercostal_4 --division full\n"
                           "         retractor approach divide case.json --name intercostal_4 --division full "
                           "--backwards 30");
    divide_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    divide_command->add_option("--name", options->name, "Name of the approach")->required();
    add_division_options(*divide_command, *options, false)->required();
    commands.on(divide_command, [options](const Job&) { return divide(*options); });

    add_guide_command(*approach, commands, options);

    CLI::App* list_command = approach->add_subcommand("list", "List the approaches of a case");
    list_command->footer("Example: retractor approach list case.json");
    list_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    commands.on(list_command, [options](const Job&) { return list(options->case_file); });

    CLI::App* rename_command = approach->add_subcommand(
        "rename", "Say what people call an approach; its plan, cuts, views and choice stay with it");
    rename_command->footer("Example: retractor approach rename case.json --name median --title \"Sternotomy, long\"");
    rename_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    rename_command->add_option("--name", options->name, "Name of the approach")->required();
    rename_command->add_option("--title", options->title, "What people call it; empty: as its template is called")
        ->required();
    commands.on(
        rename_command, [options](const Job&) { return rename(options->case_file, options->name, options->title); });

    CLI::App* remove_command = approach->add_subcommand("remove", "Remove an approach");
    remove_command->footer("Example: retractor approach remove case.json --name median");
    remove_command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    remove_command->add_option("--name", options->name, "Name of the approach")->required();
    commands.on(remove_command, [options](const Job&) { return remove(options->case_file, options->name); });
}

void add_hooks_command(Commands& commands)
{
    auto options = std::make_shared<ApproachOptions>();
    CLI::App* command = commands.app.add_subcommand("hooks", "Place hooks on both lips of an approach, or a retractor");
    command->footer("Example: retractor hooks case.json --approach median --template 4 --opening 60\n"
                    "Example: retractor hooks case.json --approach median --opening 60 --hook-limit 150\n"
                    "Example: retractor hooks case.json --approach median --retractor sternal --opening 60 "
                    "--turn-every 30");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--approach", options->name, "Name of the approach")->required();
    CLI::Option* hooks = command->add_option(
        "--template", options->hooks, "2, 4, 8 or blade (default: 4; 2 where the sternum is sawn across)");
    CLI::Option* opening = command
                               ->add_option("--opening", options->opening_mm,
                                   "Distance that opposite hooks or the blades of a retractor open, mm")
                               ->check(in_range(0.0, 2.0 * fem::kFarthestHookMm));
    add_hook_options(*command, *options);
    add_retractor_options(*command, *options, hooks);
    command->callback([&commands, options, opening] {
        options->opening_given = opening->count() > 0;
        commands.run = [options](const Job&) { return change_hooks(*options); };
    });
}

} // namespace retractor::ui::cli
