#include "ui/cli/commands.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/divided_bones.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "planner/measures/comparison.h"
#include "planner/measures/verdict.h"
#include "planner/plan/plan.h"
#include "planner/search/found_approach.h"
#include "planner/search/incision_search.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/staged_results.h"
#include "ui/cli/plan/comparison_text.h"
#include "ui/cli/plan/draft_case.h"
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

    constexpr std::size_t kBest = 5;
    constexpr double kNarrowerShare = 2.0 / 3.0; ///< of the opening, in the second round

    struct SearchOptions {
        std::string case_file, target, side = "both", spaces, length, out;
        std::vector<std::string> weights, retracted;
        std::string retractor, hooks;
        double opening_mm = 0.0;
        double from_risk_mm = planner::SearchLimits {}.from_risk_mm;
        double least_seen_percent = 100.0 * planner::SearchLimits {}.least_seen;
        unsigned seed = 0;
        std::size_t drafts = 5;
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
        return request;
    }

    /// An incision with its approach.
    struct Proposal {
        planner::FoundIncision incision;
        planner::Approach approach;
        std::string words;
    };

    /// The best incisions, and in any case the sternum, which is another operation.
    std::vector<planner::FoundIncision> best_of(std::vector<planner::FoundIncision> found, std::size_t count)
    {
        const auto sternum = std::ranges::find(
            found, planner::FoundIncision::Kind::sternum, [](const planner::FoundIncision& one) { return one.kind; });
        if (count > 1 && sternum != found.end() && sternum - found.begin() >= std::ptrdiff_t(count))
            std::rotate(found.begin() + std::ptrdiff_t(count) - 1, sternum, sternum + 1);
        return found;
    }

    /// Makes approaches of the best incisions. What does not fit the patient is left out, with the reason.
    std::vector<Proposal> proposals_of(planner::Patient& patient, const planner::IncisionSearch& search,
        const planner::SearchRequest& request, std::size_t count, std::vector<std::string>& refused)
    {
        std::vector<Proposal> proposals;
        planner::Case names;
        for (const planner::FoundIncision& incision : best_of(search.found, count)) {
            try {
                planner::Approach approach = planner::approach_of(patient, incision, request);
                approach.name = planner::free_approach_name(names, approach.name);
                names.approaches.push_back(approach);
                proposals.push_back({ incision, std::move(approach), planner::place_in_words(incision) });
            } catch (const InputError& error) {
                refused.push_back(planner::place_in_words(incision) + ": " + error.what());
            }
        }
        return proposals;
    }

    // ---- plans -----------------------------------------------------------------------------------------------------

    /// Proposals with their planned fields, which can all be used.
    struct Planned {
        std::vector<Proposal> proposals;
        std::vector<ComparedField> fields;
        std::vector<Proposal> unsolved; ///< the plan gave no numbers that can be used
        std::vector<std::string> failed; ///< the same in words, and proposals that show too little
    };

    /// The reason why a plan is no proposal; empty: it is one.
    std::string objection(const planner::PlannedField& field, const planner::IncisionSearch& search, double least_seen)
    {
        if (!planner::is_measured(field))
            return field.message;
        if (std::string why = planner::why_not_to_use(field.metrics); !why.empty())
            return why;
        const double seen = field.metrics.seen_best_eye * field.metrics.best_eye.bound_area_mm2
            / std::max(search.largest_bound_mm2, field.metrics.best_eye.bound_area_mm2);
        return seen < least_seen ? "shows " + planner::two_digits(100.0 * seen)
                + " % of what could be seen from anywhere with the wall removed ("
                + planner::two_digits(100.0 * field.metrics.seen_best_eye) + " % of what its own eyes could see)"
                                 : std::string();
    }

    void add_plans(Planned& planned, std::vector<Proposal> proposals, std::vector<planner::PlannedField> fields,
        planner::Patient& patient, const planner::IncisionSearch& search, double least_seen)
    {
        for (std::size_t n = 0; n < fields.size(); ++n) {
            Proposal& proposal = proposals[n];
            if (const std::string why = objection(fields[n], search, least_seen); !why.empty()) {
                planned.failed.push_back(proposal.words + ": " + why);
                if (!planner::is_measured(fields[n]) || !planner::why_not_to_use(fields[n].metrics).empty())
                    planned.unsolved.push_back(std::move(proposal));
                continue;
            }
            planned.fields.push_back(
                { .candidate = { .field = std::move(fields[n].metrics),
                      .divided_bones = planner::divided_bones(*patient.labels(), proposal.approach) },
                    .name = proposal.words + " (" + proposal.approach.name + ")" });
            planned.proposals.push_back(std::move(proposal));
        }
    }

    planner::Case case_with(planner::Case group, const std::vector<Proposal>& proposals)
    {
        group.approaches.clear();
        for (const Proposal& proposal : proposals)
            planner::add_approach(group, proposal.approach);
        return group;
    }

    /// Plans all approaches. One that cannot be planned does not stop the others: its message tells why.
    std::vector<planner::PlannedField> plans_of(
        planner::Patient& patient, const Job& job, const planner::PlanChecks& checks)
    {
        try {
            return planner::plan_all(patient, job, checks);
        } catch (const InputError&) { // one of them; the others follow one by one
        } catch (const SolverError&) {
        }
        std::vector<planner::PlannedField> fields;
        for (const planner::Approach& approach : patient.planned_case().approaches) {
            refuse_if_cancelled(job);
            try {
                fields.push_back(planner::plan_approach(patient, approach, job, checks));
            } catch (const Error& error) {
                planner::PlannedField failed;
                failed.status = planner::PlanStatus::nothing_to_mesh;
                failed.message = error.what();
                failed.approach = approach;
                fields.push_back(std::move(failed));
            }
        }
        return fields;
    }

    void add_drafts(Planned& planned, const planner::Case& planned_case, std::vector<Proposal> proposals,
        const planner::IncisionSearch& search, double least_seen, const Job& job)
    {
        planner::Case group = case_with(planned_case, proposals);
        make_draft(group);
        const planner::PlanChecks checks { .error_bars = false, .draft = true };
        planner::check_plan(group, checks);
        planner::Patient patient(group, job);
        std::vector<planner::PlannedField> fields = plans_of(patient, job, checks);
        refuse_if_cancelled(job);
        add_plans(planned, std::move(proposals), std::move(fields), patient, search, least_seen);
    }

    std::vector<planner::RankedField> ranking_of(const Planned& planned, const planner::Weights& weights)
    {
        std::vector<planner::Candidate> candidates;
        for (const ComparedField& field : planned.fields)
            candidates.push_back(field.candidate);
        return planner::ranked(candidates, weights);
    }

    /// The best two opened less wide, because what an opening costs is known only now. Where fewer could be solved,
    /// the first that could not.
    std::vector<Proposal> narrower(const Planned& planned, const planner::SearchRequest& request)
    {
        constexpr std::size_t kVaried = 2;
        std::vector<Proposal> wide;
        for (const planner::RankedField& ranked : ranking_of(planned, request.weights))
            if (wide.size() < kVaried)
                wide.push_back(planned.proposals[ranked.index]);
        for (const Proposal& unsolved : planned.unsolved)
            if (wide.size() < kVaried)
                wide.push_back(unsolved);
        std::vector<Proposal> proposals;
        for (Proposal& proposal : wide) {
            planner::OpenedBy opened = planner::opening_of(proposal.incision, request);
            opened.opening_mm = std::round(kNarrowerShare * opened.opening_mm);
            try {
                proposal.approach = planner::opened_by(std::move(proposal.approach), opened);
            } catch (const InputError&) {
                continue;
            }
            proposal.incision.opening_mm = opened.opening_mm;
            proposal.approach.name += "_opened_" + in_words(opened.opening_mm) + "mm";
            proposal.words += ", opened " + in_words(opened.opening_mm) + " mm";
            proposals.push_back(std::move(proposal));
        }
        return proposals;
    }

    void sort_by_score(Planned& planned, const planner::Weights& weights)
    {
        Planned sorted { .proposals = {}, .fields = {}, .unsolved = planned.unsolved, .failed = planned.failed };
        for (const planner::RankedField& ranked : ranking_of(planned, weights)) {
            sorted.proposals.push_back(planned.proposals[ranked.index]);
            sorted.fields.push_back(planned.fields[ranked.index]);
        }
        planned = std::move(sorted);
    }

    /// Draft plans of the best incisions, and of some of them opened less wide; the highest score first. Where none of
    /// these can be proposed, the next ones follow.
    Planned draft_plans(const planner::Case& planned_case, const std::vector<Proposal>& proposals,
        std::size_t at_a_time, const planner::IncisionSearch& search, const planner::SearchRequest& request,
        const Job& job)
    {
        constexpr std::size_t kRounds = 3;
        Planned planned;
        const double least_seen = request.limits.least_seen;
        for (std::size_t round = 0; round < kRounds && planned.fields.empty(); ++round) {
            const std::size_t first = std::min(round * at_a_time, proposals.size()),
                              last = std::min(first + at_a_time, proposals.size());
            if (first == last)
                break;
            add_drafts(planned, planned_case,
                { proposals.begin() + std::ptrdiff_t(first), proposals.begin() + std::ptrdiff_t(last) }, search,
                least_seen, job);
            if (std::vector<Proposal> second = narrower(planned, request); !second.empty())
                add_drafts(planned, planned_case, std::move(second), search, least_seen, job);
            planned.unsolved.clear();
        }
        sort_by_score(planned, request.weights);
        return planned;
    }

    /// The best five, each on one mesh, with error bars.
    Planned full_plans(const planner::Case& planned_case, const Planned& drafts, const planner::IncisionSearch& search,
        const planner::SearchRequest& request, const Job& job)
    {
        std::vector<Proposal> best(drafts.proposals.begin(),
            drafts.proposals.begin() + std::ptrdiff_t(std::min(kBest, drafts.proposals.size())));
        const planner::Case group = case_with(planned_case, best);
        const planner::PlanChecks checks { .find_region = true };
        planner::check_plan(group, checks);
        planner::Patient patient(group, job);
        std::vector<planner::PlannedField> fields = plans_of(patient, job, checks);
        refuse_if_cancelled(job);
        Planned full;
        add_plans(full, std::move(best), std::move(fields), patient, search, request.limits.least_seen);
        sort_by_score(full, request.weights);
        return full;
    }

    // ---- answer ----------------------------------------------------------------------------------------------------

    Json incision_document(const planner::FoundIncision& incision)
    {
        const planner::FieldMetrics& field = incision.candidate.field;
        Json points = Json::array();
        for (const Vec3& point : incision.points)
            points.push_back({ point.x(), point.y(), point.z() });
        return { { "place", planner::place_in_words(incision) }, { "length_mm", incision.length_mm },
            { "opening_mm", incision.opening_mm }, { "points_without_force", incision.points_of_100 },
            { "seen_of_what_can_be_seen", field.seen_best_eye },
            { "reached_of_what_can_be_seen", field.reached_by_two_instruments },
            { "coaxiality_deg", field.coaxiality_deg }, { "points_mm", points } };
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
                field.coaxiality_deg, planner::place_in_words(incision).c_str());
        }
        constexpr int kHighSpace = 2;
        if (std::ranges::any_of(search.found,
                [](const planner::FoundIncision& one) { return one.space && one.space->number <= kHighSpace; }))
            text += "Structures without a label are not considered: vessels and nerves of the arm cross the first two "
                    "spaces.\n";
        return text;
    }

    void write_results(const std::filesystem::path& folder, planner::Patient& patient,
        const planner::IncisionSearch& search, const Planned& planned, const Json& document, const Job& job)
    {
        constexpr int kWidth = 2000, kHeight = 1000;
        StagedResults staged(folder);
        std::vector<MappedIncision> incisions;
        for (std::size_t n = 0; n < std::min(kBest, planned.proposals.size()); ++n) {
            const Proposal& proposal = planned.proposals[n];
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
    void add_planned(Outcome& outcome, const Planned& planned, const planner::Weights& weights,
        const std::string& title, const char* key)
    {
        outcome.text += "\n" + title + ", best first:\n";
        outcome.text += planned.fields.empty()
            ? "No incision of these can be proposed. Try a smaller --opening, another "
              "--retractor or --hooks, or more --drafts.\n"
            : comparison_text(planned.fields, weights, Marks::leader);
        for (const std::string& why : planned.failed)
            outcome.text += "no proposal: " + why + "\n";
        outcome.document[key] = planned.fields.empty() ? Json::object() : comparison_document(planned.fields, weights);
        outcome.document[key]["no_proposal"] = planned.failed;
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
    std::vector<std::string> keep_best(const std::string& case_file, const Planned& planned)
    {
        planner::Case present = open_case(case_file); // the window may have changed it meanwhile
        std::vector<std::string> kept;
        for (std::size_t n = 0; n < std::min(kBest, planned.proposals.size()); ++n) {
            planner::Approach approach = planned.proposals[n].approach;
            approach.name = planner::free_approach_name(present, approach.name);
            kept.push_back(approach.name);
            planner::add_approach(present, std::move(approach));
        }
        planner::write_case(present);
        return kept;
    }

    /// Why no incision is proposed.
    std::string nothing_found(const planner::IncisionSearch& search, const planner::SearchRequest& request)
    {
        const auto near
            = std::ranges::count_if(search.tried, [](const planner::TriedPlace& place) { return place.near_risk; });
        return "none of " + std::to_string(search.tried.size()) + " incisions is a proposal: " + std::to_string(near)
            + " lie within " + in_words(request.limits.from_risk_mm)
            + " mm of a structure at risk, the others show less than " + in_words(100.0 * request.limits.least_seen)
            + " % of the target" + (search.missing.empty() ? "" : "; " + joined(search.missing));
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
            throw InputError(nothing_found(found, request), options.case_file);
        Outcome outcome = sweep_outcome(found, request);
        std::vector<std::string> refused;
        const std::vector<Proposal> proposals = proposals_of(patient, found, request, options.drafts, refused);
        for (const std::string& why : refused)
            outcome.text += "does not fit: " + why + "\n";
        outcome.document["does_not_fit"] = refused;
        const Stopwatch watch;
        Planned planned = draft_plans(planned_case, proposals, options.drafts, found, request, job);
        outcome.document["draft_seconds"] = watch.seconds();
        add_planned(outcome, planned, request.weights, formatted("Draft plans (%.0f s)", watch.seconds()), "drafts");
        if (options.full && !planned.fields.empty()) {
            planned = full_plans(planned_case, planned, found, request, job);
            add_planned(outcome, planned, request.weights, "Full plans of the best", "plans");
        }
        if (folder) {
            write_results(options.out, patient, found, planned, outcome.document, job);
            outcome.text += "wrote " + options.out + "/search-map.png and search.json\n";
        }
        if (options.keep && !planned.proposals.empty()) {
            const std::vector<std::string> kept = keep_best(options.case_file, planned);
            outcome.document["kept"] = kept;
            outcome.text += "added to the case: " + joined(kept)
                + "\nplan them with retractor plan, then compare; they hold the pericardium aside, as no template "
                  "between "
                  "ribs but the mini-thoracotomies does\n";
        }
        outcome.exit_code = planned.fields.empty() ? 1 : 0;
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
        ->add_option("--from-risk", options->from_risk_mm, "Distance that the blade keeps from structures at risk, mm")
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
            "Opening between the hooks or blades, mm (default: 40 for the sternum, 30 between ribs); a short incision "
            "opens by half of its length at most. The two best are also planned with two thirds of it")
        ->check(in_range(5.0, 200.0));
    command
        ->add_option("--weights", options->weights,
            "CRITERION=NUMBER, separated by commas: weights of the score; see retractor compare --help")
        ->delimiter(',');
    command->add_option("--drafts", options->drafts, "Number of incisions that are planned as drafts")
        ->check(CLI::Range(1, 40))
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
