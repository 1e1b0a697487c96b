#include "planner/plan/contact_where_needed.h"

#include "fem/error_estimation/error_estimate.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/time_limit.h"
#include "mesh/base/triangle.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace retractor::planner {

namespace {

    /// Search distance of the test, mm. A point is followed behind a face down to this depth.
    constexpr double kTestReachMm = 12.0;

    /// Lungs, and cavities without an organ: a lung collapses, and air gives way.
    bool is_full_of_air(const mesh::LabelInfo& label) { return label.material == "lung"; }

    /// The surface without triangles that have no area, which contact refuses.
    TriMesh with_areas(const TriMesh& surface)
    {
        TriMesh kept = surface;
        std::erase_if(
            kept.triangles, [&](const auto& triangle) { return !(triangle_area(surface.vertices, triangle) > 0.0); });
        kept.labels.clear();
        return kept;
    }

    ContactMetrics of_solution(const fem::OpeningResult& opening, const ContactSurfaces& surfaces)
    {
        const fem::Contact::State& state = opening.contact;
        return { .touching = state.touching,
            .largest_penetration_mm = state.penetration,
            .at = state.place,
            .with = state.fixed ? surfaces.names.at(*state.fixed) : std::string(),
            .force_N = state.force_N,
            .overlap_at_rest_mm = opening.contact_overlap_mm };
    }

    ContactMetrics of_test(const Penetration& found, bool needed)
    {
        ContactMetrics metrics { .needed = needed, .computed = false };
        metrics.largest_penetration_mm = found.depth_mm;
        metrics.at = found.at;
        metrics.with = found.with;
        metrics.overlap_at_rest_mm = found.overlap_at_rest_mm;
        return metrics;
    }

    ContactMetrics not_tested(std::string message)
    {
        ContactMetrics metrics { .computed = false };
        metrics.message = std::move(message);
        return metrics;
    }

    fem::ElasticProblem with_four_nodes(const fem::ElasticProblem& problem)
    {
        return problem.mesh.nodes_per_tet == 10 ? fem::without_midpoints(problem) : problem;
    }

    std::optional<std::size_t> that_gives_way(const ContactSurfaces& surfaces, const Penetration& found)
    {
        const auto at
            = static_cast<std::size_t>(std::ranges::find(surfaces.names, found.with) - surfaces.names.begin());
        return at < surfaces.gives_way_mm.size() && found.depth_mm > surfaces.tolerance_mm
                && found.depth_mm <= surfaces.gives_way_mm[at]
            ? std::optional(at)
            : std::nullopt;
    }

    void leave_out(ContactSurfaces& surfaces, std::size_t at)
    {
        const auto n = static_cast<std::ptrdiff_t>(at);
        surfaces.options.fixed.erase(surfaces.options.fixed.begin() + n);
        surfaces.names.erase(surfaces.names.begin() + n);
        if (!surfaces.gives_way_mm.empty())
            surfaces.gives_way_mm.erase(surfaces.gives_way_mm.begin() + n);
    }

    struct ContactTest {
        ContactMetrics metrics;
        ContactSurfaces pressed; ///< without the organs that give way
    };

    /// Tests a solution without contact.
    /// @param corners the problem with four-node elements
    ContactTest test_of(
        const fem::OpeningResult& opening, const fem::ElasticProblem& corners, const ContactSurfaces& surfaces)
    {
        if (!is_usable(opening))
            return { not_tested("the wound did not open as requested"), surfaces };
        try {
            Points moved = Points::Zero(corners.mesh.vertices.rows(), 3); // nodes without elements stay
            const Eigen::Index rows = std::min(moved.rows(), opening.displacement.rows());
            moved.topRows(rows) = opening.displacement.topRows(rows);
            ContactSurfaces pressed = surfaces;
            const Penetration deepest = find_penetration(corners, surfaces, moved);
            Penetration found = deepest;
            // What gives way may hide a smaller depth of what does not.
            while (const auto organ = that_gives_way(pressed, found)) {
                leave_out(pressed, *organ);
                found = find_penetration(corners, pressed, moved);
            }
            const bool needed = found.depth_mm > surfaces.tolerance_mm;
            return { of_test(needed ? found : deepest, needed), std::move(pressed) };
        } catch (const Error& error) { // the wound itself is solved
            return { not_tested(error.what()), surfaces };
        }
    }

    /// Solves the wound first without contact, and with contact where it is needed.
    class AutomaticContact {
    public:
        AutomaticContact(const fem::ElasticProblem& problem, const ContactSurfaces& surfaces, const OpenOnce& open,
            bool can_touch, const Job& job)
            : surfaces_(surfaces)
            , open_(open)
            , can_touch_(can_touch)
            , job_(job)
            , corners_(with_four_nodes(problem))
        {
        }

        ContactOpening run()
        {
            OpenedWall without = open_({}, nullptr, can_touch_ ? goes_on() : StageTest(), job_);
            const bool finished = !without.ended_by_test;
            if (finished) {
                if (without.opening.status == fem::OpeningStatus::cancelled)
                    return { .opened = std::move(without) };
                test(without.opening);
                if (!is_needed())
                    return { .opened = std::move(without), .contact = std::move(tested_.metrics) };
            }
            std::string failure;
            if (std::optional<OpenedWall> touching = open_touching(without, failure)) {
                ContactMetrics metrics = of_solution(touching->opening, tested_.pressed);
                metrics.needed = true;
                touching->touchable = tested_.pressed.names;
                return { .opened = *std::move(touching), .contact = std::move(metrics) };
            }
            if (!finished && job_.cancelled() && without.coarse) {
                without.opening = *std::move(without.coarse);
                without.opening.status = fem::OpeningStatus::cancelled;
                return { .opened = std::move(without) };
            }
            if (!finished) {
                without = open_({}, &without, {}, job_);
                test(without.opening);
            }
            if (is_needed())
                tested_.metrics.message = failure;
            return { .opened = std::move(without), .contact = std::move(tested_.metrics) };
        }

    private:
        bool is_needed() const { return tested_.metrics.needed.value_or(false); }

        StageTest goes_on()
        {
            return [this](const fem::OpeningResult& four_node) {
                test(four_node);
                return !is_needed();
            };
        }

        void test(const fem::OpeningResult& opening) { tested_ = test_of(opening, corners_, surfaces_); }

        /// Solves the wound with contact: from the solution without contact, or where this fails, from rest.
        /// @returns nothing, and the reason as `failure`, without an answer
        std::optional<OpenedWall> open_touching(const OpenedWall& without, std::string& failure) const
        {
            if (!can_touch_) {
                failure = "the tissue far from the lips is linear and has no surface for contact";
                return std::nullopt;
            }
            const double before = watch_.seconds();
            TimeLimit limit(job_, std::max(kLeastContactS, kContactTimes * before));
            const StageTest goes_on_to_ten_nodes = [&](const fem::OpeningResult&) {
                limit.restart(std::max(kLeastTenNodeContactS, kTenNodeContactTimes * before));
                return true;
            };
            const Stopwatch watch;
            try {
                OpenedWall opened = open_(tested_.pressed.options, &without, goes_on_to_ten_nodes, limit.job());
                // open_wall() itself has begun at rest where hooks hold nodes, and where only four-node elements were
                // solved.
                const bool was_at_rest = corners_.blades.size() != corners_.hooks.size() || without.ended_by_test;
                if (!was_at_rest && !is_usable(opened.opening) && !limit.job().cancelled())
                    opened = open_(tested_.pressed.options, nullptr, {}, limit.job());
                if (is_usable(opened.opening))
                    return opened;
                failure = "no equilibrium with contact was found: " + opened.opening.message;
            } catch (const Error& error) { // the solution without contact is at hand
                failure = std::string("contact cannot be computed: ") + error.what();
            }
            if (limit.is_over())
                failure = formatted("no equilibrium with contact was found in %.0f s", watch.seconds());
            return std::nullopt;
        }

        const ContactSurfaces& surfaces_;
        const OpenOnce& open_;
        bool can_touch_;
        const Job& job_;
        fem::ElasticProblem corners_; ///< with four-node elements
        Stopwatch watch_;
        ContactTest tested_ { not_tested({}), {} };
    };

} // namespace

double gives_way_mm(const fem::Material& organ)
{
    const double nu = organ.poissons_ratio;
    return std::min(
        kMostGivesWayMm, kBornByOrganN * (1.0 - nu * nu) / (2.0 * organ.youngs_modulus_MPa * kPressedRadiusMm));
}

ContactSurfaces contact_surfaces(const mesh::LabelTable& table, const Approach& approach, Patient& patient)
{
    ContactSurfaces surfaces;
    surfaces.tolerance_mm
        = std::clamp(0.5 * patient.labels()->grid.spacing.maxCoeff(), kPenetrationToleranceMm, kMostToleranceMm);
    const fem::MaterialTable& materials = patient.planned_case().materials;
    for (const mesh::LabelInfo& info : table)
        if (!is_full_of_air(info) && stays_in_place(info, approach, patient)) {
            surfaces.options.fixed.push_back(with_areas(*patient.organ(info.name)));
            surfaces.names.push_back(info.name);
            const auto material = std::ranges::find(materials, info.material, &fem::Material::name);
            surfaces.gives_way_mm.push_back(material == materials.end() ? 0.0 : gives_way_mm(*material));
        }
    return surfaces;
}

Penetration find_penetration(
    const fem::ElasticProblem& problem, const ContactSurfaces& surfaces, const Points& displacement)
{
    RETRACTOR_ASSERT(displacement.rows() == problem.mesh.vertices.rows());
    RETRACTOR_ASSERT(surfaces.names.size() == surfaces.options.fixed.size());
    fem::ContactOptions options = surfaces.options;
    options.reach = kTestReachMm;
    fem::Contact contact(
        problem.mesh, fem::element_parameters(problem.mesh, problem.material_of_label), std::move(options));
    const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
    const double overlap_at_rest = contact.overlap_at_rest();
    contact.follow(u);
    const fem::Contact::State state = contact.state(u);
    return { .depth_mm = state.penetration,
        .at = state.place,
        .with = state.fixed ? surfaces.names[*state.fixed] : std::string(),
        .overlap_at_rest_mm = overlap_at_rest };
}

ContactOpening open_with_contact(const fem::ElasticProblem& problem, ContactMode mode, const ContactSurfaces& surfaces,
    const OpenOnce& open, bool can_touch, const Job& job)
{
    switch (mode) {
    case ContactMode::automatic:
        return AutomaticContact(problem, surfaces, open, can_touch, job).run();
    case ContactMode::always: {
        ContactOpening solved { .opened = open(surfaces.options, nullptr, {}, job) };
        if (solved.opened.opening.status != fem::OpeningStatus::cancelled)
            solved.contact = of_solution(solved.opened.opening, surfaces);
        return solved;
    }
    case ContactMode::never:
        break;
    }
    return { .opened = open({}, nullptr, {}, job) };
}

std::optional<ContactOpening> open_touching_from(const OpenedWall& start, const fem::ElasticProblem& problem,
    const ContactSurfaces& surfaces, const OpenOnce& open, const Job& job)
{
    RETRACTOR_ASSERT(start.touchable);
    ContactSurfaces touchable = surfaces, others = surfaces;
    for (std::size_t n = surfaces.names.size(); n-- > 0;)
        leave_out(std::ranges::count(*start.touchable, surfaces.names[n]) > 0 ? others : touchable, n);
    TimeLimit limit(job, kLeastTenNodeContactS);
    ContactOpening solved;
    try {
        solved.opened = open(touchable.options, &start, {}, limit.job());
    } catch (const Error&) { // the search from rest may have an answer
        return std::nullopt;
    }
    const fem::OpeningResult& opening = solved.opened.opening;
    if (!is_usable(opening))
        return job.cancelled() ? std::optional(std::move(solved)) : std::nullopt;
    if (limit.is_over() && opening.inverted_elements > 0 && !job.cancelled())
        return std::nullopt; // the time was up before they were turned back
    if (!others.names.empty()) {
        const ContactMetrics passed = test_of(opening, with_four_nodes(problem), others).metrics;
        if (passed.needed.value_or(false) && !passed.with.empty())
            return std::nullopt; // an organ gives way no longer
    }
    solved.contact = of_solution(opening, touchable);
    solved.contact->needed = solved.contact->touching > 0;
    solved.opened.touchable = start.touchable;
    return solved;
}

std::optional<ContactOpening> open_without_contact_from(const OpenedWall& start, const fem::ElasticProblem& problem,
    ContactMode mode, const ContactSurfaces& surfaces, const OpenOnce& open, const Job& job)
{
    ContactOpening solved { .opened = open({}, &start, {}, job) };
    if (solved.opened.opening.status == fem::OpeningStatus::cancelled)
        return solved;
    if (!is_usable(solved.opened.opening))
        return std::nullopt;
    if (mode == ContactMode::never)
        return solved;
    solved.contact = test_of(solved.opened.opening, with_four_nodes(problem), surfaces).metrics;
    if (solved.contact->needed.value_or(false))
        return std::nullopt;
    return solved;
}

} // namespace retractor::planner
