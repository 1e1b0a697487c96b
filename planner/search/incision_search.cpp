#include "planner/search/incision_search.h"

#include "mesh/base/assert.h"
#include "mesh/base/each_on_threads.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/retractors.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/risk_distances.h"
#include "planner/search/aperture_score.h"
#include "planner/search/held_open.h"
#include "planner/search/incision_lines.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <thread>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kGridMm = 15.0, kLengthGridMm = 30.0; ///< of the places and lengths over a space
    constexpr int kSkinPlaces = 1500; ///< of incisions anywhere
    /// On the target: of the grid, of the steps from its best places, and of the last steps.
    constexpr int kSamples = 120, kFineSamples = 480, kFinestSamples = 2000;
    constexpr std::size_t kStarts = 12; ///< places from which steps are taken
    constexpr std::size_t kPolished = 4; ///< places from which the last steps are taken
    constexpr double kFirstStepMm = 8.0, kFirstLastStepMm = 8.0, kSmallestStepMm = 0.75;
    /// Places of the grid that are nearer to a better one lead to the same incision.
    constexpr double kApartOverSpaceMm = 60.0, kApartOnSkinMm = 30.0;
    constexpr double kLeastOpeningMm = 5.0;

    /// Numbers between 0 and 1 that a seed shifts, spread evenly.
    double shifted(std::size_t n, unsigned seed, double generator)
    {
        constexpr double kGoldenShare = 0.6180339887498949;
        const double x = generator * static_cast<double>(n + 1) + kGoldenShare * seed;
        return x - std::floor(x);
    }
    constexpr double kGenerators[] = { 0.7548776662466927, 0.5698402909980532, 0.8191725133961645 };

    /// An incision to try.
    struct Trial {
        std::optional<std::size_t> line {}; ///< over a space; not set: a straight line on the skin
        double along_mm = 0.0; ///< of the middle along the line
        Vec3 middle = Vec3::Zero(), inward = Vec3::Zero(); ///< on the skin
        double turn_deg = 0.0; ///< of the straight line, from the patient's long axis
        double length_mm = 0.0;
    };

    struct Tried {
        Trial trial;
        FoundIncision incision;
        std::vector<ApertureSection> sections;
    };

    FoundIncision::Kind kind_of(ApertureKind kind)
    {
        if (kind == ApertureKind::sternum)
            return FoundIncision::Kind::sternum;
        return kind == ApertureKind::skin ? FoundIncision::Kind::skin : FoundIncision::Kind::space;
    }

    InputError without_landmarks(const InputError& error)
    {
        return InputError(std::string(error.what())
                + "; without landmarks an incision can be searched anywhere on the skin, and not between ribs",
            error.where(), { "anywhere" });
    }

    /// Refuses a target that is cut, before thousands of trials.
    void check_target(const mesh::LabelTable& table, const TargetSpec& target)
    {
        if (const mesh::LabelInfo* info = mesh::find_label(table, target.label);
            !target.is_sphere() && info != nullptr && mesh::is_wall(*info))
            throw InputError(
                "\"" + target.label + "\" is a part of the wall, which is cut: choose an organ, or a sphere", "target",
                { "target" });
    }

    /// The patient's axes. A search anywhere does without landmarks.
    AnatomicalFrame frame_of(Patient& patient, bool anywhere)
    {
        try {
            return patient.frame();
        } catch (const InputError& error) {
            if (!anywhere)
                throw without_landmarks(error);
            return {
                .origin = Vec3::Zero(), .superior = Vec3::UnitZ(), .anterior = -Vec3::UnitY(), .left = Vec3::UnitX()
            };
        }
    }

    /// The score, 0 to 100, without its factor: what rays call seen is a share of something else, and what is enough of
    /// the target is not enough of that.
    double score_by_rays(const Candidate& candidate, const Weights& weights)
    {
        const Score score = score_of(candidate, weights);
        return score.factor > 0.0 ? score.points / score.factor : 0.0;
    }

    /// Does f(0) to f(count - 1) on the job's threads, with progress.
    void run_parallel(std::size_t count, const Job& job, const std::function<void(std::size_t)>& f)
    {
        std::atomic<std::size_t> done { 0 };
        const auto cores = static_cast<int>(std::thread::hardware_concurrency());
        each_on_threads(count, std::min(job.threads, cores), job, [&](std::size_t n) {
            f(n);
            job.report("incisions by rays", static_cast<double>(done.fetch_add(1) + 1) / static_cast<double>(count));
        });
    }

    struct Search {
        Patient& patient;
        const SearchRequest& request;
        const Job& job;
        Weights weights;
        BodyProbe probe;
        AnatomicalFrame frame;
        ApertureScorer scorer;
        std::vector<IncisionLine> lines {};
        double largest_bound_mm2 = 0.0; ///< of all incisions of the grid; 0: not known yet

        Search(Patient& of, const SearchRequest& asked, const Job& accompanying)
            : patient(of)
            , request(asked)
            , job(accompanying)
            , weights(weights_without_force(asked.weights))
            , probe(*of.labels())
            , frame(frame_of(of, asked.anywhere))
            , scorer(of, asked.target, asked.view, asked.retracted, accompanying)
        {
        }

        double width_of(double length_mm, ApertureKind kind) const
        {
            const double usual = kind == ApertureKind::sternum ? kSternumOpeningMm : kRibOpeningMm;
            return std::min(request.opening_mm > 0.0 ? request.opening_mm : usual, kWidestShare * length_mm);
        }

        /// Scores sections; nothing where the target lies in the opening.
        std::optional<FoundIncision> score(const std::vector<ApertureSection>& sections, double length_mm,
            ApertureKind kind, const std::vector<SurfaceSample>& samples)
        {
            FoundIncision incision;
            incision.kind = kind_of(kind);
            incision.length_mm = length_mm;
            incision.opening_mm = width_of(length_mm, kind);
            const ApertureWidth width = hole_width(incision, thickness_at_aperture(sections), request);
            try {
                incision.candidate = scorer.score(sections, width, kind, samples);
            } catch (const InputError&) {
                return std::nullopt;
            }
            const FieldMetrics& field = incision.candidate.field;
            incision.own_seen = field.seen_best_eye;
            incision.own_reached = field.reached_by_two_instruments;
            incision.near_risk = is_near_risk(incision);
            for (const ApertureSection& section : sections)
                incision.points.push_back(section.skin);
            const std::size_t last = incision.points.size() - 1;
            incision.middle = 0.5 * (incision.points[last / 2] + incision.points[last - last / 2]);
            rescale(incision);
            return incision;
        }

        /// A saw through the sternum runs on a foot behind the bone, so the heart may lie against it; nothing at risk
        /// may lie in its way.
        bool is_near_risk(const FoundIncision& incision) const
        {
            const auto is_too_near = [&](const RiskDistance& risk) {
                return !risk.is_assumed
                    && (incision.kind == FoundIncision::Kind::sternum ? !(risk.distance_mm > 0.0)
                                                                      : risk.distance_mm < request.limits.from_risk_mm);
            };
            return std::ranges::any_of(incision.candidate.field.at_risk, is_too_near);
        }

        bool is_proposal(const FoundIncision& incision) const
        {
            return !incision.near_risk && incision.candidate.field.seen_best_eye >= request.limits.least_seen;
        }

        /// Turns the shares of what this incision's eyes could see into shares of the largest area known.
        void rescale(FoundIncision& incision) const
        {
            FieldMetrics& field = incision.candidate.field;
            const double share
                = largest_bound_mm2 > 0.0 ? std::min(1.0, field.best_eye.bound_area_mm2 / largest_bound_mm2) : 1.0;
            field.seen_best_eye = share * incision.own_seen;
            field.reached_by_two_instruments = share * incision.own_reached;
            incision.points_of_100 = score_by_rays(incision.candidate, weights);
        }

        void take_bound(const FoundIncision& incision)
        {
            largest_bound_mm2 = std::max(largest_bound_mm2, incision.candidate.field.best_eye.bound_area_mm2);
        }

        /// Measures the distances from structures at risk on their whole surfaces, as plans do, and those from assumed
        /// vessels. Those of the saw from labels are measured so already.
        void measure_risks(FoundIncision& incision, const std::vector<ApertureSection>& sections)
        {
            const ApertureKind kind
                = incision.kind == FoundIncision::Kind::sternum ? ApertureKind::sternum : ApertureKind::skin;
            std::vector<RiskDistance>& risks = incision.candidate.field.at_risk;
            try {
                if (kind != ApertureKind::sternum)
                    risks = scorer.exact_risks(sections);
                const std::vector<RiskDistance> assumed = scorer.assumed_risks(sections, kind);
                risks.insert(risks.end(), assumed.begin(), assumed.end());
                risks = nearest_risks(std::move(risks));
            } catch (const InputError&) { // a blade that folds over itself is refused when its approach is made
                return;
            }
            incision.near_risk = is_near_risk(incision);
            rescale(incision);
        }

        std::optional<Tried> try_incision(const Trial& trial, const std::vector<SurfaceSample>& samples)
        {
            return trial.line ? over_space(trial, samples) : on_skin(trial, samples);
        }

        std::optional<Tried> over_space(const Trial& trial, const std::vector<SurfaceSample>& samples)
        {
            const IncisionLine& line = lines[*trial.line];
            const auto sections = sections_between(
                line, trial.along_mm - 0.5 * trial.length_mm, trial.along_mm + 0.5 * trial.length_mm);
            if (!sections)
                return std::nullopt;
            auto incision = score(*sections, trial.length_mm, kind_over(*line.space), samples);
            if (!incision)
                return std::nullopt;
            incision->space = line.space;
            incision->along_mm = trial.along_mm;
            incision->angle_deg = angle_round_chest_deg(frame, incision->middle);
            return Tried { trial, *std::move(incision), *sections };
        }

        /// The direction of a straight line, square to the blade.
        Vec3 along_of(const Trial& trial) const
        {
            const Vec3 axis = std::abs(frame.superior.dot(trial.inward)) < 0.9 ? frame.superior : frame.anterior;
            const Vec3 up = (axis - trial.inward.dot(axis) * trial.inward).normalized();
            return Eigen::AngleAxisd(trial.turn_deg * std::numbers::pi / 180.0, trial.inward) * up;
        }

        std::optional<Tried> on_skin(const Trial& trial, const std::vector<SurfaceSample>& samples)
        {
            // The skin bends: a shorter straight line has the length that is asked on the skin.
            double straight_mm = trial.length_mm;
            std::optional<IncisionLine> line;
            for (int n = 0; n < 3; ++n) {
                line = line_on_skin(probe, trial.middle, trial.inward, along_of(trial), straight_mm);
                if (!line || std::abs(line->places.back().along_mm - trial.length_mm) < 0.5)
                    break;
                straight_mm *= trial.length_mm / line->places.back().along_mm;
            }
            if (!line)
                return std::nullopt;
            std::vector<ApertureSection> sections;
            for (const LinePlace& place : line->places)
                sections.push_back(place.wall);
            auto incision = score(sections, line->places.back().along_mm, ApertureKind::skin, samples);
            if (!incision)
                return std::nullopt;
            return Tried { trial, *std::move(incision), std::move(sections) };
        }
    };

    // ---- what is tried ---------------------------------------------------------------------------------------------

    void check_limits(const SearchRequest& request)
    {
        const SearchLimits& limits = request.limits;
        const auto refuse = [](const std::string& why, const char* where) { throw InputError(why, where, { where }); };
        if (!(limits.shortest_mm > 0.0 && limits.longest_mm >= limits.shortest_mm && limits.longest_mm <= 1000.0))
            refuse("the lengths must be above 0, in order and at most 1000 mm, not " + in_words(limits.shortest_mm)
                    + " to " + in_words(limits.longest_mm),
                "length_mm");
        if (!(limits.highest_space >= 1 && limits.lowest_space <= 11 && limits.highest_space <= limits.lowest_space))
            refuse("the spaces must be 1 to 11 and in order, not " + std::to_string(limits.highest_space) + " to "
                    + std::to_string(limits.lowest_space),
                "spaces");
        if (!(request.opening_mm == 0.0 || request.opening_mm >= kLeastOpeningMm) || !std::isfinite(request.opening_mm))
            refuse("the opening must be at least " + in_words(kLeastOpeningMm) + " mm", "opening_mm");
        if (!(limits.from_risk_mm >= 0.0 && std::isfinite(limits.from_risk_mm)))
            refuse("the distance from structures at risk must be at least 0 mm", "from_risk_mm");
        if (!(limits.least_seen >= 0.0 && limits.least_seen <= 1.0))
            refuse("the least share that is seen must be 0 to 100 %", "least_seen");
        if (!request.retractor.empty())
            static_cast<void>(find_retractor(built_in_retractors(), request.retractor));
        if (!request.anywhere && !limits.left && !limits.right && !limits.saw)
            refuse("neither side and not the sternum: nothing is left to try", "side");
    }

    /// The lines over all spaces that the limits allow.
    void find_lines(Search& search, const Anatomy& anatomy, std::vector<std::string>& missing)
    {
        const SearchLimits& limits = search.request.limits;
        std::vector<SpaceNumber> spaces;
        for (const bool left : { true, false })
            for (int number = limits.highest_space; number <= limits.lowest_space; ++number)
                if (left ? limits.left : limits.right)
                    spaces.push_back({ left, number });
        std::vector<std::optional<IncisionLine>> found(spaces.size());
        std::vector<std::string> why(spaces.size());
        run_parallel(spaces.size(), search.job, [&](std::size_t n) {
            try {
                found[n] = line_over_space(search.probe, anatomy, spaces[n].left, spaces[n].number);
            } catch (const InputError& error) {
                why[n] = space_name(spaces[n].left, spaces[n].number) + ": " + error.what();
            }
        });
        for (std::size_t n = 0; n < spaces.size(); ++n) {
            if (found[n])
                search.lines.push_back(*std::move(found[n]));
            else if (!why[n].empty())
                missing.push_back(why[n]);
        }
    }

    std::shared_ptr<const Anatomy> landmarks_of(Patient& patient)
    {
        try {
            return patient.anatomy();
        } catch (const InputError& error) {
            throw without_landmarks(error);
        }
    }

    /// The shortest length, and a grid that the seed shifts.
    std::vector<double> lengths_of(const SearchRequest& request)
    {
        const SearchLimits& limits = request.limits;
        std::vector<double> lengths { limits.shortest_mm };
        const double shift = shifted(0, request.seed, kGenerators[0]) * kLengthGridMm;
        for (double length = limits.shortest_mm + shift; length <= limits.longest_mm; length += kLengthGridMm)
            lengths.push_back(length);
        return lengths;
    }

    std::vector<Trial> trials_over_spaces(const Search& search)
    {
        std::vector<Trial> trials;
        for (std::size_t line = 0; line < search.lines.size(); ++line)
            for (const double length : lengths_of(search.request)) {
                const double last = search.lines[line].places.back().along_mm - 0.5 * length;
                const double shift = shifted(1, search.request.seed, kGenerators[1]) * kGridMm;
                for (double along = 0.5 * length + shift; along < last; along += kGridMm)
                    trials.push_back({ .line = line, .along_mm = along, .length_mm = length });
                for (const double end : { 0.5 * length, last })
                    if (end > 0.0 && last >= 0.5 * length)
                        trials.push_back({ .line = line, .along_mm = end, .length_mm = length });
            }
        return trials;
    }

    /// Places spread evenly over the skin, with directions and lengths.
    std::vector<Trial> trials_on_skin(const Search& search)
    {
        constexpr double kOutsideMm = 5.0;
        const mesh::LabelVolume& labels = search.probe.labels();
        const SearchLimits& limits = search.request.limits;
        std::vector<Trial> trials;
        const std::shared_ptr<const TriMesh> body = search.patient.body();
        for (const SurfaceSample& sample : surface_samples(*body, 2 * kSkinPlaces)) {
            const Vec3 outward
                = unit_normal(body->vertices, body->triangles[static_cast<std::size_t>(sample.triangle)]);
            const Vec3 border = labels.grid.index(sample.position + kOutsideMm * outward);
            const bool inside_image = (border.array() >= 0.0).all() && border.x() <= labels.grid.size[0] - 1
                && border.y() <= labels.grid.size[1] - 1 && border.z() <= labels.grid.size[2] - 1;
            if (!inside_image || mesh::label_at(labels, sample.position + kOutsideMm * outward) != 0)
                continue; // the image ends here, or this is the inner side of the wall
            const std::size_t n = trials.size();
            Trial trial { .middle = sample.position, .inward = -search.probe.skin_normal(sample.position) };
            trial.turn_deg = 180.0 * shifted(n, search.request.seed, kGenerators[0]);
            trial.length_mm = limits.shortest_mm
                + (limits.longest_mm - limits.shortest_mm) * shifted(n, search.request.seed, kGenerators[1]);
            trial.middle += (shifted(n, search.request.seed, kGenerators[2]) - 0.5) * kGridMm * search.along_of(trial);
            trials.push_back(trial);
        }
        return trials;
    }

    TriedPlace place_of(const FoundIncision& incision, const SearchLimits& limits)
    {
        return { .middle = incision.middle,
            .points_of_100 = incision.points_of_100,
            .near_risk = incision.near_risk,
            .shows_little = incision.candidate.field.seen_best_eye < limits.least_seen };
    }

    // ---- steps -----------------------------------------------------------------------------------------------------

    std::vector<Trial> neighbours_of(const Search& search, const Trial& from, double step_mm)
    {
        constexpr double kDegPerMm = 2.0; // the ends of an incision of 60 mm move by the step
        const SearchLimits& limits = search.request.limits;
        std::vector<Trial> neighbours;
        for (const double sign : { 1.0, -1.0 }) {
            Trial length = from;
            length.length_mm = std::clamp(from.length_mm + sign * 2.0 * step_mm, limits.shortest_mm, limits.longest_mm);
            if (length.length_mm != from.length_mm)
                neighbours.push_back(length);
            Trial moved = from;
            if (from.line) {
                moved.along_mm += sign * step_mm;
                neighbours.push_back(moved);
                continue;
            }
            const Vec3 along = search.along_of(from), across = from.inward.cross(along);
            for (const Vec3& direction : { along, across }) {
                moved.middle = from.middle + sign * step_mm * direction;
                neighbours.push_back(moved);
            }
            Trial turned = from;
            turned.turn_deg += sign * kDegPerMm * step_mm;
            neighbours.push_back(turned);
            // Where turning and moving gain only together.
            for (const double other : { 1.0, -1.0 }) {
                Trial both = from;
                both.middle += 0.7 * step_mm * (sign * along + other * across);
                both.turn_deg += sign * other * 0.7 * kDegPerMm * step_mm;
                neighbours.push_back(both);
            }
        }
        return neighbours;
    }

    /// Steps to better incisions; the steps are halved until they are small.
    /// @param places receives all that was tried @return the best; nothing where the start is none on these samples
    std::optional<Tried> step_to_best(Search& search, const Tried& start, double first_mm,
        const std::vector<SurfaceSample>& samples, std::vector<TriedPlace>& places)
    {
        constexpr int kStepsEach = 8;
        std::optional<Tried> best = search.try_incision(start.trial, samples);
        if (!best || !search.is_proposal(best->incision))
            return std::nullopt;
        for (double step_mm = first_mm; step_mm > kSmallestStepMm; step_mm *= 0.5) {
            bool moved = true;
            for (int step = 0; moved && step < kStepsEach && !search.job.cancelled(); ++step) {
                moved = false;
                for (const Trial& trial : neighbours_of(search, best->trial, step_mm)) {
                    std::optional<Tried> next = search.try_incision(trial, samples);
                    if (!next)
                        continue;
                    places.push_back(place_of(next->incision, search.request.limits));
                    if (search.is_proposal(next->incision)
                        && next->incision.points_of_100 > best->incision.points_of_100) {
                        best = std::move(next);
                        moved = true;
                    }
                }
            }
        }
        return best;
    }

    bool is_better(const Tried& a, const Tried& b) { return a.incision.points_of_100 > b.incision.points_of_100; }

    bool lead_to_the_same(const Tried& a, const Tried& b)
    {
        const double apart = (a.incision.middle - b.incision.middle).norm();
        if (!a.trial.line || !b.trial.line)
            return apart < kApartOnSkinMm;
        return a.trial.line == b.trial.line && apart < kApartOverSpaceMm;
    }

    /// The best, and those that lead elsewhere. @param tried highest score first
    std::vector<Tried> starts_of(const std::vector<Tried>& tried)
    {
        std::vector<Tried> starts;
        for (const Tried& one : tried) {
            if (starts.size() == kStarts)
                break;
            if (std::ranges::none_of(starts, [&](const Tried& start) { return lead_to_the_same(one, start); }))
                starts.push_back(one);
        }
        return starts;
    }

    /// Steps from several places. @returns where they end, the best first; those that have come together once
    std::vector<Tried> step_from(Search& search, const std::vector<Tried>& starts, double first_mm,
        const std::vector<SurfaceSample>& samples, std::vector<TriedPlace>& places)
    {
        std::vector<std::optional<Tried>> ends(starts.size());
        std::vector<std::vector<TriedPlace>> tried(starts.size());
        run_parallel(starts.size(), search.job,
            [&](std::size_t n) { ends[n] = step_to_best(search, starts[n], first_mm, samples, tried[n]); });
        std::vector<Tried> best;
        for (std::size_t n = 0; n < starts.size(); ++n) {
            if (ends[n])
                best.push_back(*std::move(ends[n]));
            places.insert(places.end(), tried[n].begin(), tried[n].end());
        }
        std::ranges::stable_sort(best, is_better);
        return starts_of(best);
    }

    /// The midline of the sternum, whose place and length are given; nothing, with the reason, where it has no
    /// template.
    std::optional<Tried> try_sternum(
        Search& search, std::vector<std::string>& missing, const std::vector<SurfaceSample>& samples)
    {
        try {
            ApproachRequest request;
            request.template_name = "median";
            request.target = search.request.target;
            const Approach approach
                = approach_from_template(*search.patient.labels(), *search.patient.anatomy(), request);
            std::vector<ApertureSection> sections;
            for (std::size_t n = 0; n < approach.incision.size(); ++n)
                sections.push_back({ .skin = approach.incision[n],
                    .inner = approach.incision[n] + approach.wall_thickness_mm[n] * approach.directions[n] });
            auto incision = search.score(sections, incision_length(approach), ApertureKind::sternum, samples);
            if (!incision)
                throw InputError("the target lies in the opening");
            return Tried { {}, *std::move(incision), std::move(sections) };
        } catch (const InputError& error) {
            missing.push_back(std::string("sternum: ") + error.what());
            return std::nullopt;
        }
    }

    /// The grid, without what is no proposal. @param places receives all of it
    std::vector<Tried> try_grid(Search& search, const std::vector<Trial>& trials, std::vector<TriedPlace>& places)
    {
        const std::vector<SurfaceSample> samples = search.scorer.samples(kSamples);
        std::vector<std::optional<Tried>> results(trials.size());
        run_parallel(
            trials.size(), search.job, [&](std::size_t n) { results[n] = search.try_incision(trials[n], samples); });
        for (const std::optional<Tried>& result : results)
            if (result)
                search.take_bound(result->incision);
        std::vector<Tried> tried;
        for (std::optional<Tried>& result : results) {
            if (!result)
                continue;
            search.rescale(result->incision);
            places.push_back(place_of(result->incision, search.request.limits));
            if (search.is_proposal(result->incision))
                tried.push_back(*std::move(result));
        }
        std::ranges::stable_sort(tried, is_better);
        return tried;
    }

    /// Spaces over which no trial was possible.
    void name_missing_spaces(const Search& search, const std::vector<Trial>& trials, std::vector<std::string>& missing)
    {
        std::vector<bool> has_room(search.lines.size(), false);
        for (const Trial& trial : trials)
            if (trial.line && !has_room[*trial.line])
                has_room[*trial.line] = sections_between(search.lines[*trial.line],
                    trial.along_mm - 0.5 * trial.length_mm, trial.along_mm + 0.5 * trial.length_mm)
                                            .has_value();
        for (std::size_t n = 0; n < search.lines.size(); ++n)
            if (const SpaceNumber& space = *search.lines[n].space; !has_room[n])
                missing.push_back(space_name(space.left, space.number) + ": no room for an incision of "
                    + in_words(search.request.limits.shortest_mm) + " mm");
    }

    std::string sternum_objection(const FoundIncision& sternum, const Search& search)
    {
        if (sternum.near_risk)
            return "sternum: the saw passes through the " + readable(sternum.candidate.field.at_risk.front().name);
        return "sternum: shows less than " + in_words(100.0 * search.request.limits.least_seen) + " % of the target";
    }

    /// What the search ends with: shares of the same area, and exact distances from structures at risk.
    void finish(Search& search, std::vector<Tried>& best, std::vector<FoundIncision>& found)
    {
        for (const Tried& one : best)
            search.take_bound(one.incision);
        run_parallel(
            best.size(), search.job, [&](std::size_t n) { search.measure_risks(best[n].incision, best[n].sections); });
        for (Tried& one : best)
            if (search.is_proposal(one.incision))
                found.push_back(std::move(one.incision));
        std::ranges::stable_sort(
            found, [](const FoundIncision& a, const FoundIncision& b) { return a.points_of_100 > b.points_of_100; });
    }

} // namespace

Weights weights_without_force(Weights weights)
{
    const auto force
        = std::ranges::find_if(criteria(), [](const Criterion& one) { return std::string_view(one.key) == "force"; });
    RETRACTOR_ASSERT(force != criteria().end());
    weights.at(static_cast<std::size_t>(force - criteria().begin())) = 0.0;
    if (std::ranges::all_of(weights, [](double weight) { return weight == 0.0; }))
        throw InputError("a search by rays knows no forces: give another criterion a weight", "weights");
    return weights;
}

IncisionSearch search_incisions(Patient& patient, const SearchRequest& request, const Job& job)
{
    check_limits(request);
    check_target(patient.planned_case().label_table, request.target);
    const Stopwatch watch;
    IncisionSearch result;
    Search search(patient, request, job);
    const std::vector<SurfaceSample> fine = search.scorer.samples(kFineSamples),
                                     finest = search.scorer.samples(kFinestSamples);
    std::optional<Tried> sternum;
    std::vector<Trial> trials;
    if (request.anywhere) {
        search.scorer.prepare(ApertureKind::skin);
        trials = trials_on_skin(search);
    } else {
        find_lines(search, *landmarks_of(patient), result.missing);
        for (const IncisionLine& line : search.lines)
            search.scorer.prepare(kind_over(*line.space));
        trials = trials_over_spaces(search);
        name_missing_spaces(search, trials, result.missing);
        if (request.limits.saw) {
            search.scorer.prepare(ApertureKind::sternum);
            sternum = try_sternum(search, result.missing, finest);
        }
    }
    if (sternum)
        search.take_bound(sternum->incision);
    const std::vector<Tried> grid = try_grid(search, trials, result.tried);
    const std::vector<Tried> ends = step_from(search, starts_of(grid), kFirstStepMm, fine, result.tried);
    const auto middle = ends.begin() + static_cast<std::ptrdiff_t>(std::min(kPolished, ends.size()));
    std::vector<Tried> best = step_from(search, { ends.begin(), middle }, kFirstLastStepMm, finest, result.tried);
    for (auto rest = middle; rest != ends.end(); ++rest) // scores on other samples would not compare
        if (std::optional<Tried> again = search.try_incision(rest->trial, finest))
            best.push_back(*std::move(again));
    std::ranges::stable_sort(best, is_better);
    best = starts_of(best);
    if (sternum)
        best.push_back(*sternum);
    finish(search, best, result.found);
    if (sternum) {
        result.tried.push_back(place_of(best.back().incision, request.limits));
        if (std::ranges::find(result.found, FoundIncision::Kind::sternum, &FoundIncision::kind) == result.found.end())
            result.missing.emplace_back(sternum_objection(best.back().incision, search));
    }
    result.largest_bound_mm2 = search.largest_bound_mm2;
    result.status = job.cancelled() ? SearchStatus::cancelled : SearchStatus::done;
    result.seconds = watch.seconds();
    return result;
}

} // namespace retractor::planner
