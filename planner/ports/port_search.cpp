#include "planner/ports/port_search.h"

#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/intercostal_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr int kSamples = 400; ///< on the target: 2.5 percentage points for a share of a half
    constexpr double kStepDeg = 10.0;
    constexpr double kNarrowestMm = 9.0; ///< a space for a trocar of 10 mm spreads a little (ours)

    double degrees(double radians) { return 180.0 / std::numbers::pi * radians; }

    double angle_at(const Vec3& at, const Vec3& one, const Vec3& other)
    {
        return degrees(std::acos(std::clamp((one - at).normalized().dot((other - at).normalized()), -1.0, 1.0)));
    }

    std::vector<Port> places_of(Patient& patient, const PortRequest& request)
    {
        const std::shared_ptr<const mesh::LabelVolume> labels = patient.labels();
        const BodyProbe probe(*labels);
        std::vector<Port> ports;
        for (int number = request.highest_space; number <= request.lowest_space; ++number) {
            std::optional<IntercostalSpace> space;
            try {
                space = find_intercostal_space(probe, *patient.anatomy(), request.left, number);
            } catch (const InputError&) { // its ribs are not labelled
                continue;
            }
            double next = request.from_deg;
            for (const SpacePlace& place : space->places) {
                if (place.angle_deg < next || place.angle_deg > request.to_deg)
                    continue;
                next = place.angle_deg + kStepDeg;
                const auto skin = probe.first_skin_along(place.middle, place.outward);
                if (!place.open || place.gap_mm < kNarrowestMm || !skin)
                    continue;
                const Vec3 on_skin = place.middle + *skin * place.outward;
                if (const auto wall = probe.wall_thickness(on_skin, -place.outward))
                    ports.push_back({ request.left, number, place.angle_deg, on_skin, *wall });
            }
        }
        return ports;
    }

    struct Instrument {
        const Port* port = nullptr;
        std::vector<bool> reached;
    };

    /// A shaft from the target to its handle, without the tip, at which instruments meet by purpose.
    std::pair<Vec3, Vec3> shaft(const Vec3& tip, const Vec3& skin, double from_tip_mm, double outside_mm)
    {
        const Vec3 outward = (skin - tip).normalized();
        return { tip + from_tip_mm * outward, skin + outside_mm * outward };
    }

    double between_instruments(const PortScene& scene, const Port& a, const Port& b)
    {
        return angle_at(scene.middle(), a.skin, b.skin);
    }

    /// The smallest distance between the surfaces of scope and shafts.
    double nearest_shafts(const PortScene& scene, const PortPlan& plan, const PortSizes& sizes)
    {
        constexpr double kWorkMm = 30.0; // at the target
        const auto scope = shaft(plan.view.tip, plan.scope.skin, 0.0, sizes.outside_mm);
        const auto one = shaft(scene.middle(), plan.instruments[0].skin, kWorkMm, sizes.outside_mm),
                   other = shaft(scene.middle(), plan.instruments[1].skin, kWorkMm, sizes.outside_mm);
        const double beside_scope = std::min(distance_of_pieces(scope, one), distance_of_pieces(scope, other))
            - 0.5 * (sizes.scope_mm + sizes.shaft_mm);
        return std::min(beside_scope, distance_of_pieces(one, other) - sizes.shaft_mm);
    }

    /// Half for what is seen, half for what can be worked on; less where the instruments stand badly to each other.
    double points_of(const PortPlan& plan)
    {
        const double off = std::abs(plan.between_deg - kBestBetweenDeg) / (kMostBetweenDeg - kBestBetweenDeg);
        return 100.0 * (0.5 * plan.seen + 0.5 * plan.worked_on) * (1.0 - 0.3 * std::min(1.0, off));
    }

    bool ports_apart(const Port& a, const Port& b) { return (a.skin - b.skin).norm() >= kPortsApartMm; }

    /// The best pair of instruments beside a scope; nothing where no pair has room.
    std::optional<PortPlan> best_pair(const PortScene& scene, const Port& scope, const ScopeView& view,
        const std::vector<Instrument>& instruments, std::size_t bound, const PortSizes& sizes)
    {
        std::optional<PortPlan> best;
        for (std::size_t i = 0; i < instruments.size(); ++i) {
            const Port& a = *instruments[i].port;
            if (!ports_apart(scope, a))
                continue;
            for (std::size_t j = i + 1; j < instruments.size(); ++j) {
                const Port& b = *instruments[j].port;
                const double between = between_instruments(scene, a, b);
                if (between < kLeastBetweenDeg || between > kMostBetweenDeg || !ports_apart(a, b)
                    || !ports_apart(scope, b))
                    continue;
                std::size_t both = 0;
                for (std::size_t s = 0; s < scene.samples().size(); ++s)
                    both += view.sees[s] && instruments[i].reached[s] && instruments[j].reached[s] ? 1 : 0;
                PortPlan plan { .scope = scope,
                    .view = view,
                    .middle = scene.middle(),
                    .instruments = { a, b },
                    .between_deg = between };
                plan.seen = static_cast<double>(view.seen) / static_cast<double>(bound);
                plan.worked_on = static_cast<double>(both) / static_cast<double>(bound);
                if (both == 0) // looking alone is no operation
                    continue;
                plan.points = points_of(plan);
                if (best && plan.points <= best->points)
                    continue;
                plan.nearest_shafts_mm = nearest_shafts(scene, plan, sizes);
                if (plan.nearest_shafts_mm < kShaftsApartMm)
                    continue;
                for (std::size_t n = 0; n < 2; ++n) {
                    plan.working_length_mm[n] = (plan.instruments[n].skin - scene.middle()).norm();
                    plan.from_view_deg[n] = angle_at(scene.middle(), view.tip, plan.instruments[n].skin);
                }
                best = plan;
            }
        }
        return best;
    }

    void check_request(const PortRequest& request)
    {
        check_optics(request.optics);
        if (!(request.highest_space >= 1 && request.highest_space <= request.lowest_space
                && request.lowest_space <= 11))
            throw InputError("give spaces from 1 to 11, the smaller number first", "spaces");
    }

} // namespace

std::string place_in_words(const Port& port)
{
    constexpr std::array<std::pair<double, const char*>, 6> kLines { { { 75.0, "posterior axillary line" },
        { 90.0, "mid-axillary line" }, { 110.0, "anterior axillary line" }, { 135.0, "midclavicular line" },
        { 155.0, "parasternal line" }, { 60.0, "behind the posterior axillary line" } } };
    const auto nearest
        = std::ranges::min_element(kLines, {}, [&](const auto& line) { return std::abs(line.first - port.angle_deg); });
    return std::string(port.left ? "left " : "right ") + ordinal(std::to_string(port.space)) + " space, "
        + nearest->second;
}

PortSearch find_ports(Patient& patient, const PortRequest& request, std::size_t count, const Job& job)
{
    check_request(request);
    const Stopwatch watch;
    PortSearch search;
    const std::vector<Port> ports = places_of(patient, request);
    if (ports.empty())
        throw InputError(std::string("no intercostal space of the ") + (request.left ? "left" : "right")
                + " side has room for a port",
            "spaces");
    const PortScene scene(patient, request.target, request.left, request.aside, kSamples, job);
    search.ports = ports.size();
    std::vector<std::pair<const Port*, ScopeView>> scopes;
    std::vector<Instrument> instruments;
    std::size_t bound = 0;
    for (std::size_t n = 0; n < ports.size(); ++n) {
        if (job.cancelled())
            return search;
        job.report("ports", static_cast<double>(n) / static_cast<double>(ports.size()));
        const ScopeView view = scene.best_scope(ports[n].skin, ports[n].wall_mm, request.optics, request.sizes);
        bound = std::max(bound, view.bound);
        if (view.seen > 0)
            scopes.emplace_back(&ports[n], view);
        Instrument instrument { .port = &ports[n], .reached = scene.reached(ports[n].skin, request.sizes) };
        if (std::ranges::count(instrument.reached, true) > 0)
            instruments.push_back(std::move(instrument));
    }
    search.scopes = scopes.size();
    search.instruments = instruments.size();
    for (const auto& [port, view] : scopes)
        if (auto plan = best_pair(scene, *port, view, instruments, bound, request.sizes))
            search.found.push_back(std::move(*plan));
    std::ranges::sort(search.found, std::greater {}, &PortPlan::points);
    if (search.found.size() > count)
        search.found.resize(count);
    search.seconds = watch.seconds();
    return search;
}

} // namespace retractor::planner
