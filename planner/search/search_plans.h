#pragma once
// Plans the incisions that a search has found, because rays through a hole in the wall know no force. Units mm; frame
// patient LPS.

#include "mesh/base/job.h"
#include "planner/case/case.h"
#include "planner/measures/ranking.h"
#include "planner/search/found_approach.h"
#include "planner/search/incision_search.h"

#include <cstddef>
#include <string>
#include <vector>

namespace retractor::planner {

/// Proposals that are kept, and planned in full.
inline constexpr std::size_t kBestProposals = 5;

/// An incision with its approach.
struct Proposal {
    FoundIncision incision {};
    Approach approach {};
    std::string words {}; ///< its place, and how wide it is opened where that is not usual
};

/// The best incisions of a search with their approaches, and in any case the sternum, which is another operation.
/// @param refused what does not fit the patient, with the reason
std::vector<Proposal> proposals_of(Patient& patient, const IncisionSearch& search, const SearchRequest& request,
    std::size_t count, std::vector<std::string>& refused);

struct PlannedProposal {
    Proposal proposal {};
    Candidate candidate {}; ///< as planned
};

struct [[nodiscard]] SearchPlans {
    SearchStatus status = SearchStatus::done;
    std::vector<PlannedProposal> best_first {};
    std::vector<std::string> failed {}; ///< what was planned and is no proposal, with the reason
    std::vector<std::string> not_planned {}; ///< places for which the time for drafts was too short
};

/// Draft plans of the first proposals; then of the two best opened less wide, of the best opened by another retractor,
/// and of the best opened wider (unless the request says how wide), because what an opening costs is known only then.
/// Where none of these can be proposed, the next ones follow. What is not planned within SearchRequest::draft_s is
/// named in SearchPlans::not_planned.
/// @throws InputError as check_plan() does, and on a negative time
SearchPlans draft_plans(const Case& planned_case, const std::vector<Proposal>& proposals, std::size_t at_a_time,
    const IncisionSearch& search, const SearchRequest& request, const Job& job = {});

/// Plans of the best drafts on one mesh each, with error bars. @throws InputError as check_plan() does
SearchPlans full_plans(const Case& planned_case, const SearchPlans& drafts, const IncisionSearch& search,
    const SearchRequest& request, const Job& job = {});

/// The case with these approaches too, each under a free name. @returns their names
std::vector<std::string> add_proposals(Case& planned_case, const std::vector<Proposal>& proposals);

/// Why a search has found nothing.
std::string why_nothing_found(const IncisionSearch& search, const SearchRequest& request);

} // namespace retractor::planner
