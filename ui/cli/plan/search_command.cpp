#include "ui/cli/commands.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "planner/measures/comparison.h"
#include "planner/measures/risk_distances.h"
#include "planner/search/found_approach.h"
#include "planner/search/incision_search.h"
#include "planner/search/search_plans.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/staged_results.h"
#include "ui/cli/plan/comparison_text.h"
#include "ui/plan_scene/case_picture.h"
#include "ui/plan_scene/search_map.h"
#include "ui/results/field_files.h"
#include "ui/scene/vtk/render.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    struct SearchOptions {
        std::string case_file, target, side = "both", spaces, length, out;
        std::vector<std::string> weights, retracted;
        std::string retractor, hooks;
        double opening_mm = 0.0;
        double from_risk_mm = planner::SearchLimits {}.from_risk_mm;
        double least_seen_percent = 100.0 * planner::SearchLimits {}.least_seen;
        unsigned seed = 0;
        std::size_t drafts = 5;
        double draft_s = planner::kDraftTimeS;
        bool anywhere = false, no_saw = false, full = false, keep = false;
    };

    planner::SearchRequest request_of(const SearchOptions& options, planner::Patient& patient)
    {
        planner::SearchRequest request;
        if (!options.target.empty()) {
            request.target = parse_target(options.target);
        } else if (const auto target = default_target(patient)) {
            request.target = *target;
        } else {
            throw InputError("the case has no label of role target: name one", "--target");
        }
        planner::SearchLimits& limits = request.limits;
        if (!options.length.empty())
            std::tie(limits.shortest_mm, limits.longest_mm) = parse_span(options.length, "--length");
        if (!options.spaces.empty())
            std::tie(limits.highest_space, limits.lowest_space) = parse_spaces(options.spaces);
        limits.left = options.side != "right";
        limits.right = options.side != "left";
        limits.saw = !options.no_saw;
        limits.from_risk_mm = options.from_risk_mm;
        request.weights = parse_weights(options.weights);
        limits.least_seen = 0.01 * options.least_seen_percent;
        request.opening_mm = options.opening_mm;
        request.retractor = options.retractor;
        request.hooks = options.hooks;
        request.retracted = options.retracted;
        request.sizing = patient.planned_case().sizing;
        request.anywhere = options.anywhere;
        request.seed = options.seed;
        request.draft_s = options.draft_s > 0.0 ? std::optional(options.draft_s) : std::nullopt;
        return request;
    }

    /// The proposals as `retractor compare` compares them.
    std::vector<ComparedField> compared(const planner::SearchPlans& plans)
    {
        std::vector<ComparedField> fields;
        for (const planner::PlannedProposal& planned : plans.best_first)
            fields.push_back({ .candidate = planned.candidate,
                .name = planned.proposal.words + " (" + planned.proposal.approach.name + ")" });
        return fields;
    }

    std::vector<planner::Proposal> best_of(const planner::SearchPlans& plans)
    {
        std::vector<planner::Proposal> best;
        for (std::size_t n = 0; n < std::min(planner::kBestProposals, plans.best_first.size()); ++n)
            best.push_back(plans.best_first[n].proposal);
        return best;
    }

    // ---- answer ----------------------------------------------------------------------------------------------------

    Json incision_document(const planner::FoundIncision& incision)
    {
        const planner::FieldMetrics& field = incision.candidate.field;
        Json points = Json::array();
        for (const Vec3& point : incision.points)
            points.push_back({ point.x(), point.y(), point.z() });
        Json nearest = nullptr;
        if (!field.at_risk.empty())
            nearest = { { "name", field.at_risk.front().name }, { "distance_mm", field.at_risk.front().distance_mm },
                { "is_assumed", field.at_risk.front().is_assumed } };
        return { { "place", planner::place_in_words(incision) }, { "length_mm", incision.length_mm },
            { "opening_mm", incision.opening_mm }, { "points_without_force", incision.points_of_100 },
            { "seen_of_what_can_be_seen", field.seen_best_eye },
            { "reached_of_what_can_be_seen", field.reached_by_two_instruments },
            { "coaxiality_deg", field.coaxiality_deg }, { "points_mm", points }, { "nearest_at_risk", nearest } };
    }

    /// ", heart 0.4 mm from the saw, may cut left mammary artery (assumed place)"; empty: nothing is near.
    std::string near_risk_text(const planner::FoundIncision& incision)
    {
        constexpr double kNearMm = 2.0;
        const std::string tool = incision.kind == planner::FoundIncision::Kind::sternum ? "saw" : "blade";
        std::string text;
        std::vector<std::string> cut;
        for (const planner::RiskDistance& risk : incision.candidate.field.at_risk) {
            if (risk.is_assumed && !(risk.distance_mm > 0.0))
                cut.push_back(planner::risk_name(risk));
            else if (risk.distance_mm < kNearMm)
                text += ", " + planner::risk_name(risk) + " " + in_words(risk.distance_mm, 1) + " mm from the " + tool;
        }
        return cut.empty() ? text : text + ", may cut " + joined(cut);
    }

    std::string sweep_text(const planner::IncisionSearch& search)
    {
        const double per_minute = 60.0 * static_cast<double>(search.tried.size()) / std::max(search.seconds, 1e-3);
        std::string text = formatted("%zu incisions tried by rays in %.0f s (%.0f a minute), as holes in the wall at "
                                     "rest; the score is without the force:\n",
            search.tried.size(), search.seconds, per_minute);
        for (std::size_t n = 0; n < search.found.size(); ++n) {
            const planner::FoundIncision& incision = search.found[n];
            const planner::FieldMetrics& field = incision.candidate.field;
            text += formatted("%2zu. %3.0f points  seen %3.0f %%, 2 instruments %3.0f %%, %2.0f deg off the straight "
                              "view  %s\n",
                n + 1, incision.points_of_100, 100.0 * field.seen_best_eye, 100.0 * field.reached_by_two_instruments,
                field.coaxiality_deg, (planner::place_in_words(incision) + near_risk_text(incision)).c_str());
        }
        constexpr int kHighSpace = 2;
        if (std::ranges::any_of(search.found,
                [](const planner::FoundIncision& one) { return one.space && one.space->number <= kHighSpace; }))
            text += "Other structures without a label are not considered: vessels and nerves of the arm cross the "
                    "first two spaces.\n";
        return text;
    }

    void write_results(const std::filesystem::path& folder, planner::Patient& patient,
        const planner::IncisionSearch& search, const planner::SearchPlans& plans, const Json& document, const Job& job)
    {
        constexpr int kWidth = 2000, kHeight = 1000;
        StagedResults staged(folder);
        std::vector<MappedIncision> incisions;
        const std::vector<planner::Proposal> best = best_of(plans);
        for (std::size_t n = 0; n < best.size(); ++n) {
            const planner::Proposal& proposal = best[n];
            const auto same = std::ranges::find_if(incisions, [&](const MappedIncision& other) {
                return (other.points.front() - proposal.approach.incision.front()).norm() < 1.0
                    && (other.points.back() - proposal.approach.incision.back()).norm() < 1.0;
            });
            if (same != incisions.end()) // opened less wide
                same->sign += ", " + planner::compared_letter(n);
            else
                incisions.push_back({ .sign = planner::compared_letter(n),
                    .words = planner::place_in_words(proposal.incision),
                    .points = proposal.approach.incision });
        }
        OffscreenRenderer renderer(make_offscreen_context(), job);
        write_png(staged.folder() / "search-map.png",
            renderer.render(search_map(patient, search, incisions, kWidth, kHeight)));
        write_file_atomically(staged.folder() / "search.json", document.dump(2) + "\n");
        refuse_if_cancelled(job);
        staged.publish("search.json");
    }

    /// Adds plans to the answer. @param title of the text; @param key of the document
    void add_planned(Outcome& outcome, const planner::SearchPlans& plans, const planner::Weights& weights,
        const std::string& title, const char* key)
    {
        outcome.text += "\n" + title + ", best first:\n";
        const std::vector<ComparedField> fields = compared(plans);
        if (!fields.empty())
            outcome.text += comparison_text(fields, weights, Marks::leader);
        else if (!plans.failed.empty())
            outcome.text += "No incision of these can be proposed. Try a smaller --opening, another --retractor or "
                            "--hooks, or more --drafts.\n";
        for (const std::string& why : plans.failed)
            outcome.text += "no proposal: " + why + "\n";
        for (const std::string& place : plans.not_planned)
            outcome.text += "not planned, as the time for drafts (--draft-time) was over: " + place + "\n";
        outcome.document[key] = fields.empty() ? Json::object() : comparison_document(fields, weights);
        outcome.document[key]["no_proposal"] = plans.failed;
        outcome.document[key]["not_planned"] = plans.not_planned;
    }

    Outcome sweep_outcome(const planner::IncisionSearch& search, const planner::SearchRequest& request)
    {
        Outcome outcome { .document = { { "target", planner::target_name(request.target) }, { "seed", request.seed },
                              { "tried", search.tried.size() }, { "seconds", search.seconds },
                              { "incisions", Json::array() }, { "not_tried", search.missing } },
            .text = sweep_text(search) };
        for (const planner::FoundIncision& incision : search.found)
            outcome.document["incisions"].push_back(incision_document(incision));
        for (const std::string& missing : search.missing)
            outcome.text += "no incision: " + missing + "\n";
        return outcome;
    }

    /// Adds the best five to the case file. @returns their names there
    std::vector<std::string> keep_best(const std::string& case_file, const planner::SearchPlans& plans)
    {
        planner::Case present = open_case(case_file); // the window may have changed it meanwhile
        std::vector<std::string> kept = planner::add_proposals(present, best_of(plans));
        planner::write_case(present);
        return kept;
    }

    Outcome search(const SearchOptions& options, const Job& job)
    {
        const planner::Case planned_case = open_case(options.case_file);
        planner::Patient patient(planned_case, job);
        const planner::SearchRequest request = request_of(options, patient);
        std::optional<OutFolder> folder;
        if (!options.out.empty())
            folder.emplace(options.out);
        const planner::IncisionSearch found = planner::search_incisions(patient, request, job);
        refuse_if_cancelled(job);
        if (found.found.empty())
            throw InputError(planner::why_nothing_found(found, request), options.case_file);
        Outcome outcome = sweep_outcome(found, request);
        std::vector<std::string> refused;
        const std::vector<planner::Proposal> proposals
            = planner::proposals_of(patient, found, request, options.drafts, refused);
        for (const std::string& why : refused)
            outcome.text += "does not fit: " + why + "\n";
        outcome.document["does_not_fit"] = refused;
        const Stopwatch watch;
        planner::SearchPlans plans = planner::draft_plans(planned_case, proposals, options.drafts, found, request, job);
        refuse_if_cancelled(job);
        outcome.document["draft_seconds"] = watch.seconds();
        add_planned(outcome, plans, request.weights, formatted("Draft plans (%.0f s)", watch.seconds()), "drafts");
        if (options.full && !plans.best_first.empty()) {
            plans = planner::full_plans(planned_case, plans, found, request, job);
            refuse_if_cancelled(job);
            add_planned(outcome, plans, request.weights, "Full plans of the best", "plans");
        }
        if (folder) {
            write_results(options.out, patient, found, plans, outcome.document, job);
            outcome.text += "wrote " + options.out + "/search-map.png and search.json\n";
        }
        if (options.keep && !plans.best_first.empty()) {
            const std::vector<std::string> kept = keep_best(options.case_file, plans);
            outcome.document["kept"] = kept;
            outcome.text += "added to the case: " + joined(kept)
                + "\nplan them with retractor plan, then compare; they hold the pericardium aside, as no template "
                  "between "
                  "ribs but the mini-thoracotomies does\n";
        }
        outcome.exit_code = plans.best_first.empty() ? 1 : 0;
        return outcome;
    }

} // namespace

void add_search_command(Commands& commands)
{
    auto options = std::make_shared<SearchOptions>();
    CLI::App* command = commands.app.add_subcommand("search",
        "Search for incisions: try thousands by rays, plan the best as drafts, and rank them as compare does");
    command->footer("Example: retractor search C/case.json --target aneurysm --out S\n"
                    "Example: retractor search C/case.json --target heart --side left --spaces 3-6 --length 60-120 "
                    "--no-saw --keep");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--target", options->target,
        "Label name, or x,y,z,r for a sphere, mm (default: the first label of role target)");
    command->add_option("--side", options->side, "Side of the spaces that are tried")
        ->check(CLI::IsMember({ "left", "right", "both" }))
        ->capture_default_str();
    command->add_option("--spaces", options->spaces, "Intercostal spaces that are tried, such as 3-6 (default: all)");
    command->add_option("--length", options->length, "Length of the incision, mm, such as 60-120 (default: 60-180)");
    command->add_flag("--no-saw", options->no_saw, "The sternum is not sawn through");
    command
        ->add_option("--from-risk", options->from_risk_mm,
            "Distance that a knife keeps from structures at risk, mm; a saw through the sternum need not")
        ->check(in_range(0.0, 100.0))
        ->capture_default_str();
    command
        ->add_option("--least-seen", options->least_seen_percent,
            "Share of the target, in %, that a proposal shows at least, of what could be seen from anywhere with the "
            "wall removed")
        ->check(in_range(0.0, 100.0))
        ->capture_default_str();
    command
        ->add_flag("--anywhere", options->anywhere,
            "Straight lines anywhere on the skin, in any direction, instead of spaces and sternum; no bone gives way")
        ->excludes("--side")
        ->excludes("--spaces")
        ->excludes("--no-saw");
    command
        ->add_option("--retract", options->retracted,
            "Organs that are held aside besides lungs, pericardium and fat of the mediastinum, separated by commas")
        ->delimiter(',');
    CLI::Option* hooks = command
                             ->add_option("--hooks", options->hooks,
                                 "Hooks that open the wound (default: the retractor that is usual there)")
                             ->check(CLI::IsMember({ "2", "4", "8", "blade" }));
    command
        ->add_option("--retractor", options->retractor,
            "Retractor that opens the wound, such as finochietto (default: sternal, midcab for short incisions "
            "between ribs, finochietto for long ones)")
        ->excludes(hooks);
    command
        ->add_option("--opening", options->opening_mm,
            "Opening between the hooks or blades, mm (default: " + in_words(planner::kSternumOpeningMm)
                + " for the sternum, " + in_words(planner::kRibOpeningMm)
                + " between ribs); a short incision opens by half of its length at most. The two best are also planned "
                  "with two thirds of it, and the best a third wider unless this is given")
        ->check(in_range(5.0, 200.0));
    command
        ->add_option("--weights", options->weights,
            "CRITERION=NUMBER, separated by commas: weights of the score; see retractor compare --help")
        ->delimiter(',');
    command->add_option("--drafts", options->drafts, "Number of incisions that are planned as drafts")
        ->check(CLI::Range(1, 40))
        ->capture_default_str();
    command
        ->add_option("--draft-time", options->draft_s,
            "Time for the drafts, s; what is not planned by then is named. 0: as long as they take")
        ->check(in_range(0.0, 1e6))
        ->capture_default_str();
    command->add_flag(
        "--full", options->full, "Then plan the best five on one mesh each, with the case's elements and error bars");
    command->add_flag("--keep", options->keep, "Add the best five to the case");
    command->add_option("--seed", options->seed, "Shifts the places that are tried first")->capture_default_str();
    command->add_option(
        "--out", options->out, "Folder for search-map.png (the skin in the colours of the score) and search.json");
    commands.on(command, [options](const Job& job) { return search(*options, job); });
}

} // namespace retractor::ui::cli
