#include "planner/plan/found_region.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::planner {

namespace {

    /// Regions are whole multiples of this length, so that small changes of a case give the same mesh.
    constexpr double kStepMm = 5.0;
    /// A region that reaches this share of the wall's extent is the whole wall: the rest would save few elements.
    constexpr double kNearlyWhole = 0.85;
    constexpr int kMostRegions = 3; ///< drafts of regions smaller than the whole wall

    class Search {
    public:
        explicit Search(const DraftOfRegion& draft)
            : draft_(draft)
        {
        }

        FoundRegion run(double whole_mm)
        {
            const std::optional<RegionDraft> largest = largest_draft(whole_mm);
            if (!largest)
                return std::move(found_);
            const double extent = std::min(found_.region_mm, largest->farthest_mm);
            double wanted = std::max(kFirstRegionMm, kStepMm * std::ceil(largest->moving_mm / kStepMm));
            for (int n = 0; n < kMostRegions && wanted < kNearlyWhole * extent; ++n) {
                const RegionDraft smaller = make(wanted);
                if (smaller.status != RegionDraft::Status::done)
                    return std::move(found_); // the larger draft has an answer, so this is a cancellation or bad luck
                set_force_change(*largest, smaller);
                if (smaller.rim_motion_mm <= kStillRimMm) {
                    found_.region_mm = wanted;
                    found_.measures.ended_by = RegionEnd::still;
                    return std::move(found_);
                }
                wanted = kStepMm * std::ceil(kGentleGrowth * wanted / kStepMm);
            }
            if (found_.measures.ended_by == RegionEnd::memory && !found_.measures.force_change)
                compare_with_smaller(*largest);
            return std::move(found_);
        }

    private:
        static constexpr double kGentleGrowth = 1.25; ///< the draft of the whole wall has told nearly how far

        RegionDraft make(double region_mm)
        {
            RegionDraft draft = draft_(region_mm);
            ++found_.measures.drafts;
            found_.cancelled = found_.cancelled || draft.status == RegionDraft::Status::cancelled;
            return draft;
        }

        /// The draft of the largest region that fits the memory; sets found_ to this region.
        std::optional<RegionDraft> largest_draft(double whole_mm)
        {
            found_.region_mm = std::max(whole_mm, kFirstRegionMm);
            found_.measures.ended_by = RegionEnd::whole;
            while (true) {
                RegionDraft draft = make(found_.region_mm);
                if (draft.status == RegionDraft::Status::done)
                    return draft;
                if (draft.status != RegionDraft::Status::memory) {
                    found_.region_mm = kFirstRegionMm;
                    found_.measures.ended_by = RegionEnd::failure;
                    found_.measures.message = std::move(draft.message);
                    return std::nullopt;
                }
                if (!shrink_region(found_))
                    return std::nullopt;
            }
        }

        void set_force_change(const RegionDraft& larger, const RegionDraft& smaller)
        {
            if (larger.force_N > 0.0)
                found_.measures.force_change = std::abs(smaller.force_N - larger.force_N) / larger.force_N;
        }

        void compare_with_smaller(const RegionDraft& largest)
        {
            if (found_.region_mm <= kFirstRegionMm)
                return;
            const RegionDraft smaller = make(std::max(kFirstRegionMm, found_.region_mm / kRegionGrowth));
            if (smaller.status == RegionDraft::Status::done)
                set_force_change(largest, smaller);
        }

        const DraftOfRegion& draft_;
        FoundRegion found_;
    };

} // namespace

FoundRegion find_region(double whole_mm, const DraftOfRegion& draft)
{
    RETRACTOR_ASSERT(whole_mm > 0.0 && draft);
    return Search(draft).run(whole_mm);
}

bool shrink_region(FoundRegion& found)
{
    found.measures.ended_by = RegionEnd::memory;
    if (found.region_mm <= kFirstRegionMm)
        return false;
    found.region_mm = std::max(kFirstRegionMm, found.region_mm / kRegionGrowth);
    return true;
}

} // namespace retractor::planner
