#include "tests/benchmarks/palpation/palpation_error.h"

#include "haptics/condensed/condensed_tissue.h"
#include "planner/session/tissue_choice.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/palpation/palpation_bench.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::benchmarks {

namespace {

    constexpr double kSide = 36.0, kHeight = 18.0; // mm
    constexpr double kModulus = 0.02, kRatio = 0.45; // MPa and dimensionless: muscle at rest
    constexpr double kFingerRadius = 8.0, kPressDepth = 3.0; // radius and depth of the fingertip, mm
    constexpr double kPressTick = 1e-3; // s
    constexpr int kLookEvery = 16; // ticks

    /// A block on its bottom, with sites in the middle of its top and aside, where springs are not calibrated.
    datasets::PalpationScene block(double spacing)
    {
        const int across = static_cast<int>(std::lround(kSide / spacing)),
                  high = static_cast<int>(std::lround(kHeight / spacing));
        datasets::PalpationScene scene;
        scene.name = "block";
        scene.body.mesh = mesh::kuhn_box(across, across, high, spacing);
        const mesh::TetMesh& mesh = scene.body.mesh;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            scene.body.roles.push_back(
                mesh.vertices(v, 2) == 0.0 ? datasets::VertexRole::fixed : datasets::VertexRole::free);
        scene.body.youngs_modulus.assign(mesh.tet_count(), kModulus);
        scene.body.poissons_ratio.assign(mesh.tet_count(), kRatio);
        scene.sites = { { "centre", Vec3(0.5 * kSide, 0.5 * kSide, kHeight), Vec3::UnitZ() },
            { "aside", Vec3(0.5 * kSide + 7.0, 0.5 * kSide - 5.0, kHeight), Vec3::UnitZ() } };
        return scene;
    }

    haptics::Fingertip tip_at(const datasets::TouchSite& site, double depth)
    {
        return { site.point + (kFingerRadius - depth) * site.outward, Vec3::Zero(), kFingerRadius };
    }

    /// Presses a site until the tissue has settled, then lifts off. @return the force along the site's normal, N.
    double settled_force(haptics::TissueResponse& tissue, const datasets::TouchSite& site, double& time)
    {
        constexpr int kDown = 300, kStay = 700, kMeasured = 100;
        Points deformed;
        haptics::FingerContact contact;
        double sum = 0.0;
        const auto tick = [&](int i, double depth) {
            const haptics::Fingertip tip = tip_at(site, depth);
            tissue.tick(time, kPressTick, { &tip, 1 }, { &contact, 1 });
            time += kPressTick;
            if (i % kLookEvery == 0)
                tissue.follow(deformed);
        };
        for (int i = 0; i < kDown + kStay; ++i) {
            tick(i, kPressDepth - (kPressDepth + 2.0) * std::max(0.0, 1.0 - static_cast<double>(i) / kDown));
            if (i >= kDown + kStay - kMeasured)
                sum += contact.force.dot(site.outward) / kMeasured;
        }
        for (int i = 0; i < kDown; ++i)
            tick(i, kPressDepth - (kPressDepth + 2.0) * static_cast<double>(i + 1) / kDown);
        return sum;
    }

    struct Forces {
        double centre = 0.0, aside = 0.0;
    };

    Forces forces_of(haptics::TissueResponse& tissue, const datasets::PalpationScene& scene)
    {
        double time = 0.0;
        Forces forces;
        forces.centre = settled_force(tissue, scene.sites[0], time);
        forces.aside = settled_force(tissue, scene.sites[1], time);
        return forces;
    }

    double deform_ms(haptics::TissueResponse& tissue)
    {
        constexpr int kFrames = 60;
        std::vector<double> ms;
        Points deformed;
        haptics::FingerContact contact;
        const datasets::PalpationScene scene = block(kHeight); // used for its sites only
        for (int i = 0; i < kFrames; ++i) {
            const haptics::Fingertip tip = tip_at(scene.sites[0], kPressDepth * i / kFrames);
            tissue.tick(i * kPressTick, kPressTick, { &tip, 1 }, { &contact, 1 });
            const Stopwatch watch;
            tissue.follow(deformed);
            ms.push_back(1e3 * watch.seconds());
        }
        return median(ms);
    }

    ui::cli::Json row_of(haptics::TissueResponse& tissue, const datasets::PalpationScene& scene,
        const Forces& reference, double build_ms, std::size_t ticks)
    {
        ui::cli::Json row { { "model", std::string(tissue.name()) }, { "scene", "block" },
            { "vertices", tissue.surface().vertices.rows() }, { "fingers", 1 } };
        const Forces forces = forces_of(tissue, scene);
        const auto press = [&](double time, std::span<haptics::Fingertip> fingers) {
            fingers[0] = tip_at(scene.sites[0], kPressDepth * (1.0 - std::cos(2.0 * std::numbers::pi * time)) - 1.0);
        };
        const TickCost cost = time_ticks(tissue, press, ticks);
        row["force_us_mean"] = cost.mean_us;
        row["force_us_p999"] = cost.p999_us;
        row["deform_ms_median"] = deform_ms(tissue);
        row["rel_diff_same_mesh"] = nullptr;
        row["rel_error_vs_reference"] = forces.aside / reference.aside - 1.0;
        row["rel_error_at_calibration"] = forces.centre / reference.centre - 1.0;
        row["force_N"] = forces.aside;
        row["fps"] = nullptr;
        row["ticks"] = cost.ticks;
        row["missed"] = cost.missed;
        row["build_ms"] = build_ms;
        return row;
    }

    haptics::CondensedOptions elements(haptics::TouchElement element)
    {
        haptics::CondensedOptions options;
        options.element = element;
        options.fingertip = haptics::FingertipShape::sphere;
        options.rest_pressure = 0.0;
        return options;
    }

    /// The reference: ten-node elements with edges of 2 mm, every surface node a contact node.
    Forces refined(const Job& job)
    {
        constexpr double kFine = 2.0, kStations = 0.9; // mm
        const datasets::PalpationScene scene = block(kFine);
        haptics::CondensedOptions options = elements(haptics::TouchElement::p2);
        options.contact_node_spacing = kStations;
        options.patch_limit = 128;
        options.fetch_all_below = 0;
        haptics::CondensedTissue tissue(scene.body, haptics::PulsePressure::constant(0.0), options, job);
        for (const datasets::TouchSite& site : scene.sites) {
            const haptics::Fingertip tip = tip_at(site, kPressDepth);
            tissue.prepare({ &tip, 1 });
        }
        return forces_of(tissue, scene);
    }

} // namespace

ui::cli::Json palpation_error_rows(std::size_t ticks, const Job& job)
{
    job.report("error against time: reference", 0.0);
    const Forces reference = refined(job);
    ui::cli::Json rows = ui::cli::Json::array();
    for (const double spacing : { 4.5, 3.0 }) {
        const datasets::PalpationScene scene = block(spacing);
        Forces four_node;
        for (const auto& [element, name] : { std::pair { haptics::TouchElement::p1, "p1" },
                 { haptics::TouchElement::locking_free, "locking-free" }, { haptics::TouchElement::p2, "p2" } }) {
            job.report("error against time: elements", 0.0);
            const Stopwatch watch;
            haptics::CondensedTissue tissue(scene.body, haptics::PulsePressure::constant(0.0), elements(element), job);
            const double build_ms = 1e3 * watch.seconds();
            rows.push_back(row_of(tissue, scene, reference, build_ms, ticks));
            rows.back()["element"] = name;
            if (element == haptics::TouchElement::p1)
                four_node.aside = rows.back().at("force_N").get<double>();
        }
        for (const bool calibrated : { false, true }) {
            job.report("error against time: springs", 0.0);
            planner::TissueChoice choice { .model = "springs",
                .radius_mm = kFingerRadius,
                .depth_mm = kPressDepth,
                .calibration = calibrated ? 0.0 : 1.0 };
            const Stopwatch watch;
            const planner::ChosenTissue springs = planner::make_tissue(scene, choice, job);
            const double build_ms = 1e3 * watch.seconds();
            rows.push_back(row_of(*springs.response, scene, reference, build_ms, ticks));
            rows.back()["element"] = calibrated ? "calibrated" : "as edges";
            rows.back()["rel_diff_same_mesh"] = rows.back().at("force_N").get<double>() / four_node.aside - 1.0;
            rows.back()["calibration"]
                = calibrated ? planner::measured_calibration(scene, kFingerRadius, kPressDepth, job) : 1.0;
            rows.back()["note"] = springs.notes[0];
        }
    }
    for (const std::size_t spheres : { 600U, 1880U }) {
        job.report("error against time: spheres", 0.0);
        const datasets::PalpationScene scene = block(4.5);
        const Stopwatch watch;
        const planner::ChosenTissue filled
            = planner::make_tissue(scene, { .model = "spheres", .radius_mm = kFingerRadius, .spheres = spheres }, job);
        const double build_ms = 1e3 * watch.seconds();
        rows.push_back(row_of(*filled.response, scene, reference, build_ms, ticks));
        rows.back()["vertices"] = spheres;
        rows.back()["note"] = filled.notes[0];
    }
    return rows;
}

} // namespace retractor::benchmarks
