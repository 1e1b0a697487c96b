#include "planner/search/search_plans.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/time_limit.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/divided_bones.h"
#include "planner/case/case_io.h"
#include "planner/case/draft_case.h"
#include "planner/measures/verdict.h"
#include "planner/plan/plan.h"
#include "planner/search/held_open.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kNarrowerShare = 2.0 / 3.0, kWiderShare = 4.0 / 3.0; ///< of the opening, in the second round

    std::vector<FoundIncision> best_of(std::vector<FoundIncision> found, std::size_t count)
    {
        const auto sternum
            = std::ranges::find(found, FoundIncision::Kind::sternum, [](const FoundIncision& one) { return one.kind; });
        if (count > 1 && sternum != found.end() && sternum - found.begin() >= std::ptrdiff_t(count))
            std::rotate(found.begin() + std::ptrdiff_t(count) - 1, sternum, sternum + 1);
        return found;
    }

    /// Plans with what could not be solved, which may be opened less wide.
    struct Round {
        SearchPlans plans {};
        std::vector<Proposal> unsolved {};
    };

    /// The reason why a plan is no proposal; empty: it is one.
    std::string objection(const PlannedField& field, const IncisionSearch& search, double least_seen)
    {
        if (!is_measured(field))
            return field.message;
        if (std::string why = why_not_to_use(field.metrics); !why.empty())
            return why;
        const double seen = field.metrics.seen_best_eye * field.metrics.best_eye.bound_area_mm2
            / std::max(search.largest_bound_mm2, field.metrics.best_eye.bound_area_mm2);
        return seen < least_seen
            ? "shows " + two_digits(100.0 * seen) + " % of what could be seen from anywhere with the wall removed ("
                + two_digits(100.0 * field.metrics.seen_best_eye) + " % of what its own eyes could see)"
            : std::string();
    }

    void add_plans(Round& round, std::vector<Proposal> proposals, std::vector<PlannedField> fields, Patient& patient,
        const IncisionSearch& search, double least_seen)
    {
        for (std::size_t n = 0; n < fields.size(); ++n) {
            Proposal& proposal = proposals[n];
            if (fields[n].status == PlanStatus::cancelled) {
                round.plans.not_planned.push_back(proposal.words);
                continue;
            }
            if (const std::string why = objection(fields[n], search, least_seen); !why.empty()) {
                round.plans.failed.push_back(proposal.words + ": " + why);
                if (!is_measured(fields[n]) || !why_not_to_use(fields[n].metrics).empty())
                    round.unsolved.push_back(std::move(proposal));
                continue;
            }
            Candidate candidate { .field = std::move(fields[n].metrics),
                .divided_bones = divided_bones(*patient.labels(), proposal.approach) };
            round.plans.best_first.push_back({ std::move(proposal), std::move(candidate) });
        }
    }

    Case case_with(Case group, const std::vector<Proposal>& proposals)
    {
        group.approaches.clear();
        for (const Proposal& proposal : proposals)
            add_approach(group, proposal.approach);
        return group;
    }

    /// Plans all approaches. One that cannot be planned does not stop the others: its message tells why.
    std::vector<PlannedField> plans_of(Patient& patient, const Job& job, const PlanChecks& checks)
    {
        std::vector<PlanAttempt> attempts(patient.planned_case().approaches.size());
        static_cast<void>(patient.labels()); // a cancelled job may read none, and nothing can be planned without
        if (job.cancelled())
            for (PlanAttempt& attempt : attempts)
                attempt.field.status = PlanStatus::cancelled;
        else
            attempts = plan_each(patient, job, checks);
        std::vector<PlannedField> fields;
        for (std::size_t n = 0; n < attempts.size(); ++n) {
            if (!attempts[n].failure.empty()) {
                attempts[n].field = {};
                attempts[n].field.status = PlanStatus::nothing_to_mesh;
                attempts[n].field.message = attempts[n].failure;
                attempts[n].field.approach = patient.planned_case().approaches[n];
            }
            fields.push_back(std::move(attempts[n].field));
        }
        return fields;
    }

    void add_planned(Round& round, const Case& group, std::vector<Proposal> proposals, const PlanChecks& checks,
        const IncisionSearch& search, double least_seen, const Job& job)
    {
        check_plan(group, checks);
        Patient patient(group, job);
        std::vector<PlannedField> fields = plans_of(patient, job, checks);
        add_plans(round, std::move(proposals), std::move(fields), patient, search, least_seen);
    }

    void add_drafts(Round& round, const Case& planned_case, std::vector<Proposal> proposals,
        const IncisionSearch& search, double least_seen, const Job& job)
    {
        Case group = case_with(planned_case, proposals);
        make_draft(group);
        add_planned(
            round, group, std::move(proposals), { .error_bars = false, .draft = true }, search, least_seen, job);
    }

    std::vector<RankedField> ranking_of(const SearchPlans& plans, const Weights& weights)
    {
        std::vector<Candidate> candidates;
        for (const PlannedProposal& planned : plans.best_first)
            candidates.push_back(planned.candidate);
        return ranked(candidates, weights);
    }

    /// The best one opened as wide by another retractor.
    std::vector<Proposal> by_another_retractor(const Round& round, const SearchRequest& request)
    {
        const std::vector<RankedField> ranking = ranking_of(round.plans, request.weights);
        if (ranking.empty())
            return {};
        Proposal proposal = round.plans.best_first[ranking.front().index].proposal;
        OpenedBy opened = opening_of(proposal.incision, request);
        opened.retractor = other_retractor(proposal.incision, request);
        if (opened.retractor.empty())
            return {};
        try {
            proposal.approach = opened_by(std::move(proposal.approach), opened);
        } catch (const InputError&) {
            return {}; // its blades do not fit here
        }
        proposal.approach.name += "_" + opened.retractor;
        proposal.words += ", opened by a " + instrument_name(opened.retractor);
        return { std::move(proposal) };
    }

    /// The same incision opened otherwise; nothing where it cannot be.
    std::optional<Proposal> opened_as_wide(Proposal proposal, double opening_mm, const SearchRequest& request)
    {
        OpenedBy opened = opening_of(proposal.incision, request);
        opened.opening_mm = opening_mm;
        try {
            proposal.approach = opened_by(std::move(proposal.approach), opened);
        } catch (const InputError&) {
            return std::nullopt;
        }
        proposal.incision.opening_mm = opening_mm;
        proposal.approach.name += "_opened_" + in_words(opening_mm) + "mm";
        proposal.words += ", opened " + in_words(opening_mm) + " mm";
        return proposal;
    }

    /// The best one opened wider, at most as an incision of its length gets; nothing where the request says how wide.
    std::optional<Proposal> wider(const Round& round, const SearchRequest& request)
    {
        const std::vector<RankedField> ranking = ranking_of(round.plans, request.weights);
        if (ranking.empty() || request.opening_mm > 0.0)
            return std::nullopt;
        const Proposal& best = round.plans.best_first[ranking.front().index].proposal;
        const double opening_mm
            = std::floor(std::min(kWiderShare * best.incision.opening_mm, kWidestShare * best.incision.length_mm));
        if (opening_mm <= best.incision.opening_mm)
            return std::nullopt;
        return opened_as_wide(best, opening_mm, request);
    }

    /// The best two opened less wide. Where fewer could be solved, the first that could not.
    std::vector<Proposal> narrower(const Round& round, const SearchRequest& request)
    {
        constexpr std::size_t kVaried = 2;
        std::vector<Proposal> wide;
        for (const RankedField& ranked : ranking_of(round.plans, request.weights))
            if (wide.size() < kVaried)
                wide.push_back(round.plans.best_first[ranked.index].proposal);
        for (const Proposal& unsolved : round.unsolved)
            if (wide.size() < kVaried)
                wide.push_back(unsolved);
        std::vector<Proposal> proposals;
        for (Proposal& proposal : wide) {
            const double opening_mm = std::round(kNarrowerShare * proposal.incision.opening_mm);
            if (opening_mm < 1.0)
                continue; // to 0 mm would be to leave the wound shut
            if (std::optional<Proposal> opened = opened_as_wide(std::move(proposal), opening_mm, request))
                proposals.push_back(*std::move(opened));
        }
        return proposals;
    }

    std::string drafts_in_words(std::size_t drafts, const char* of)
    {
        return std::to_string(drafts) + (drafts == 1 ? " draft of " : " drafts of ") + of;
    }

    /// A job that reports what is drafted in place of the stages of single plans, of which two run at a time. With a
    /// limit the finished fraction is that of the time.
    /// @pre `job`, `watch` and `what` outlive the result
    Job naming_drafts(
        const Job& job, const Stopwatch& watch, const std::string& what, const std::optional<double>& limit_s)
    {
        Job named = job;
        named.on_progress = [&job, &watch, &what, limit_s](std::string_view, double fraction) {
            job.report(what, limit_s && *limit_s > 0.0 ? std::min(watch.seconds() / *limit_s, 1.0) : fraction);
        };
        return named;
    }

    void sort_by_score(SearchPlans& plans, const Weights& weights)
    {
        std::vector<PlannedProposal> sorted;
        for (const RankedField& ranked : ranking_of(plans, weights))
            sorted.push_back(plans.best_first[ranked.index]);
        plans.best_first = std::move(sorted);
    }

} // namespace

std::vector<Proposal> proposals_of(Patient& patient, const IncisionSearch& search, const SearchRequest& request,
    std::size_t count, std::vector<std::string>& refused)
{
    std::vector<Proposal> proposals;
    Case names;
    for (const FoundIncision& incision : best_of(search.found, count)) {
        try {
            Approach approach = approach_of(patient, incision, request);
            approach.name = free_approach_name(names, approach.name);
            names.approaches.push_back(approach);
            proposals.push_back({ incision, std::move(approach), place_in_words(incision) });
        } catch (const InputError& error) {
            refused.push_back(place_in_words(incision) + ": " + error.what());
        }
    }
    return proposals;
}

SearchPlans draft_plans(const Case& planned_case, const std::vector<Proposal>& proposals, std::size_t at_a_time,
    const IncisionSearch& search, const SearchRequest& request, const Job& job)
{
    constexpr std::size_t kRounds = 3;
    Round round;
    SearchPlans& plans = round.plans;
    const double least_seen = request.limits.least_seen;
    std::optional<TimeLimit> limit;
    if (request.draft_s && !(*request.draft_s >= 0.0))
        throw InputError("the time for drafts is not zero or more", "draft_s");
    if (request.draft_s)
        limit.emplace(job, *request.draft_s);
    const Stopwatch watch;
    std::string what;
    const Job drafting = naming_drafts(limit ? limit->job() : job, watch, what, request.draft_s);
    for (std::size_t n = 0; n < kRounds && plans.best_first.empty(); ++n) {
        const std::size_t first = std::min(n * at_a_time, proposals.size()),
                          last = std::min(first + at_a_time, proposals.size());
        if (first == last)
            break;
        what = drafts_in_words(last - first, "incisions found by lines of sight");
        add_drafts(round, planned_case,
            { proposals.begin() + std::ptrdiff_t(first), proposals.begin() + std::ptrdiff_t(last) }, search, least_seen,
            drafting);
        std::vector<Proposal> second = narrower(round, request);
        for (Proposal& proposal : by_another_retractor(round, request))
            second.push_back(std::move(proposal));
        if (std::optional<Proposal> proposal = wider(round, request))
            second.push_back(*std::move(proposal));
        what = drafts_in_words(second.size(), "the best, opened otherwise");
        if (!second.empty())
            add_drafts(round, planned_case, std::move(second), search, least_seen, drafting);
        round.unsolved.clear();
    }
    plans.status = job.cancelled() ? SearchStatus::cancelled : SearchStatus::done;
    sort_by_score(plans, request.weights);
    return std::move(plans);
}

SearchPlans full_plans(const Case& planned_case, const SearchPlans& drafts, const IncisionSearch& search,
    const SearchRequest& request, const Job& job)
{
    std::vector<Proposal> best;
    for (std::size_t n = 0; n < std::min(kBestProposals, drafts.best_first.size()); ++n)
        best.push_back(drafts.best_first[n].proposal);
    const Case group = case_with(planned_case, best);
    Round round;
    add_planned(round, group, std::move(best), { .find_region = true }, search, request.limits.least_seen, job);
    round.plans.status = job.cancelled() ? SearchStatus::cancelled : SearchStatus::done;
    sort_by_score(round.plans, request.weights);
    return std::move(round.plans);
}

std::vector<std::string> add_proposals(Case& planned_case, const std::vector<Proposal>& proposals)
{
    std::vector<std::string> names;
    for (const Proposal& proposal : proposals) {
        Approach approach = proposal.approach;
        approach.name = free_approach_name(planned_case, approach.name);
        names.push_back(approach.name);
        add_approach(planned_case, std::move(approach));
    }
    return names;
}

std::string why_nothing_found(const IncisionSearch& search, const SearchRequest& request)
{
    const auto near = std::ranges::count_if(search.tried, [](const TriedPlace& place) { return place.near_risk; });
    std::string text = "none of " + std::to_string(search.tried.size())
        + " incisions is a proposal: " + std::to_string(near) + " lie within " + in_words(request.limits.from_risk_mm)
        + " mm of a structure at risk, the others show less than " + in_words(100.0 * request.limits.least_seen)
        + " % of the target";
    for (const std::string& missing : search.missing)
        text += (&missing == &search.missing.front() ? "; " : ", ") + missing;
    return text;
}

} // namespace retractor::planner
