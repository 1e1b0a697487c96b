// Time steps of the springs that fingers press, and numbers that are none where devices and tissue are made.

#include "datasets/aorta_phantom.h"
#include "haptics/condensed_tissue.h"
#include "haptics/elastic_template.h"
#include "haptics/hand_path.h"
#include "haptics/replay.h"
#include "haptics/servo.h"
#include "haptics/simulated_hand.h"
#include "haptics/sphere_tissue.h"
#include "haptics/spring_tissue.h"
#include "tests/verification/cli/touch_cases.h"
#include "ui/cli/ball_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <utility>

namespace retractor {

namespace {

    constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();

    /// Plucked and left to swing without drag or dashpots: the motion stays bounded.
    void swing(StabilityRow& row, double share, double arm_ratio)
    {
        SpringMotion motion(make_spring_sheet(), { .voigt_time = 0.0, .arm_ratio = arm_ratio, .drag = 0.0 });
        const Points rest = motion.positions();
        constexpr double kPluck = 0.01; // mm
        for (VertexId v = 0; v < static_cast<VertexId>(rest.rows()); ++v)
            if (!motion.is_held(v)) // all frequencies
                motion.place(v, motion.position(v) + kPluck * Vec3(std::sin(v), std::cos(3.0 * v), std::sin(2.0 * v)));
        double most = 0.0;
        constexpr int kSteps = 3000;
        for (int i = 0; i < kSteps; ++i) {
            motion.step(share * motion.stable_step());
            most = std::max(most, Points(motion.positions() - rest).cwiseAbs().maxCoeff());
        }
        row.quantity = "largest excursion over the pluck, after 3,000 steps";
        row.error = most / kPluck;
        row.bound = 20.0; // many modes meet; an unstable step grows by powers of ten
        row.residual = 0.0; // nothing is solved
        std::array<char, 64> text {};
        (void)std::snprintf(text.data(), text.size(), "bound %.4g us, certain", 1e6 * motion.stable_step());
        row.reason = text.data();
        row.unconditioned = Unconditioned::explicit_steps;
    }

    void step_by(StabilityRow& row, const std::function<double(double)>& dt)
    {
        row.unconditioned = Unconditioned::explicit_steps;
        SpringMotion motion(make_spring_sheet(), {});
        motion.step(dt(motion.stable_step()));
        row.residual = row.error = 0.0;
    }

    constexpr std::array<double, 4> kBad { 0.0, -1.0, kNoNumber, kInfinite };

    SpoiltCalls bad_devices()
    {
        SpoiltCalls calls;
        const auto hand = [&](const std::function<void(SimulatedHandOptions&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                SimulatedHandOptions options;
                spoil(options);
                const SimulatedHand made(options);
            });
        };
        const auto servo = [&](const std::function<void(ServoOptions&, MappingOptions&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                SimulatedHand device(SimulatedHandOptions {});
                SphereTissue tissue({ { "ball", cli::ball_mesh(Vec3::Zero(), 10.0, 2),
                                        fill_with_spheres(cli::ball_mesh(Vec3::Zero(), 10.0, 2), 3.0), 0.02 } },
                    {});
                ServoOptions options;
                MappingOptions mapping;
                spoil(options, mapping);
                const Servo made({ { .device = &device, .mapping = mapping } }, tissue, options);
            });
        };
        const auto path = [&](const HandKey& key) {
            calls.spoilt.emplace_back([key] { const HandPath made(std::vector { key }); });
        };
        const auto replay = [&](std::size_t device) {
            calls.spoilt.emplace_back([device] {
                const MotionRecording still {
                    .devices = { { .name = "still" } }, .times_s = { 0.0 }, .samples = { {} }
                };
                const ReplayDevice made(still, device);
            });
        };
        hand([](SimulatedHandOptions&) {});
        servo([](ServoOptions&, MappingOptions&) {});
        path({});
        replay(0);
        calls.sound.swap(calls.spoilt); // nothing was spoilt so far
        for (const double bad : kBad) {
            hand([=](SimulatedHandOptions& o) { o.hand.grip_stiffness.y() = bad; });
            hand([=](SimulatedHandOptions& o) { o.hand.mass.x() = bad; });
            hand([=](SimulatedHandOptions& o) { o.stylus_mass = bad; });
            servo([=](ServoOptions& o, MappingOptions&) { o.step_s = bad; });
            servo([=](ServoOptions& o, MappingOptions&) { o.fingers = { { .radius = bad } }; });
            servo([=](ServoOptions&, MappingOptions& m) { m.scale = bad; });
            servo([=](ServoOptions&, MappingOptions& m) { m.force_scale = bad; });
        }
        for (const double bad : { -1.0, kNoNumber, kInfinite }) {
            hand([=](SimulatedHandOptions& o) { o.stylus_damping = bad; });
            hand([=](SimulatedHandOptions& o) { o.friction = bad; });
            servo([=](ServoOptions& o, MappingOptions&) { o.force_gain = bad; });
            servo([=](ServoOptions& o, MappingOptions&) { o.coupling.stiffness_share = bad; });
            servo([=](ServoOptions& o, MappingOptions&) { o.coupling.damping_share = bad; });
        }
        hand([](SimulatedHandOptions& o) { o.substeps = 0; });
        servo([](ServoOptions&, MappingOptions& m) { m.scene_from_device.setZero(); });
        servo([](ServoOptions&, MappingOptions& m) { m.scene_centre.x() = kNoNumber; });
        servo([](ServoOptions& o, MappingOptions&) { o.fingers = { { .offset = Vec3(kNoNumber, 0.0, 0.0) } }; });
        path({ .time_s = kNoNumber });
        path({ .position = Vec3(0.0, kNoNumber, 0.0) });
        replay(1);
        calls.spoilt.emplace_back([] { const ReplayDevice device({}, 0); });
        return calls;
    }

    SpoiltCalls bad_springs_and_spheres()
    {
        SpoiltCalls calls;
        const auto law
            = [&](const ElementLaw& made) { calls.spoilt.emplace_back([made] { check_element_law(made); }); };
        const auto sheet
            = [&](const SheetOptions& made) { calls.spoilt.emplace_back([made] { (void)make_spring_sheet(made); }); };
        const auto spheres = [&](const std::function<void(SphereOrgan&, SphereLaw&, double&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                const TriMesh surface = cli::ball_mesh(Vec3::Zero(), 10.0, 2);
                SphereOrgan organ { "ball", surface, fill_with_spheres(surface, 3.0), 0.02 };
                SphereLaw sphere_law;
                double blend = 0.01;
                spoil(organ, sphere_law, blend);
                const SphereTissue tissue({ organ }, sphere_law, blend);
            });
        };
        const auto filling = [&](double radius) {
            calls.spoilt.emplace_back([=] { (void)fill_with_spheres(cli::ball_mesh(Vec3::Zero(), 10.0, 2), radius); });
        };
        const auto springs = [&](const SpringTissueOptions& made) {
            calls.spoilt.emplace_back([=] { const SpringTissue t(make_spring_sheet(), {}, made); });
        };
        law({});
        sheet({});
        spheres([](SphereOrgan&, SphereLaw&, double&) {});
        filling(3.0);
        springs({});
        calls.sound.swap(calls.spoilt); // nothing was spoilt so far
        for (const double bad : kBad) {
            law({ .arm_time = bad });
            sheet({ .spacing = bad });
            sheet({ .particle_mass = bad });
            sheet({ .stiffness = bad });
            filling(bad);
            spheres([=](SphereOrgan& o, SphereLaw&, double&) { o.stiffness = bad; });
            spheres([=](SphereOrgan&, SphereLaw& l, double&) { l.transmission = bad; });
            spheres([=](SphereOrgan&, SphereLaw& l, double&) { l.recovery_time = bad; });
            springs({ .longest_tick = bad });
        }
        for (const double bad : { -1.0, kNoNumber, kInfinite }) {
            law({ .voigt_time = bad });
            law({ .arm_ratio = bad });
            law({ .drag = bad });
            sheet({ .pre_strain = bad });
            spheres([=](SphereOrgan&, SphereLaw&, double& blend) { blend = bad; });
        }
        law({ .gravity = Vec3(0.0, kNoNumber, 0.0) });
        return calls;
    }

    SpoiltCalls bad_condensed_tissue()
    {
        SpoiltCalls calls;
        const auto tissue = [&](const std::function<void(ElasticModel&, CondensedOptions&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                AortaParameters parameters { .shape = AortaParameters::Shape::tube, .length_mm = 40.0, .along = 4 };
                parameters.region.length_mm = 0.0;
                ElasticModel model = make_aorta_phantom(parameters).body;
                CondensedOptions options { .element = TouchElement::p1 };
                spoil(model, options);
                const CondensedTissue made(std::move(model), PulsePressure::aortic(), options);
            });
        };
        const auto phantom = [&](double inner_radius_mm) {
            calls.spoilt.emplace_back([=] {
                AortaParameters parameters;
                parameters.inner_radius_mm = inner_radius_mm;
                (void)make_aorta_phantom(parameters);
            });
        };
        const auto edited = [&](double youngs_modulus) {
            calls.spoilt.emplace_back([=] {
                ElasticModel model = make_aorta_phantom({}).body;
                (void)apply(ElasticTemplate { .youngs_modulus = youngs_modulus }, model);
            });
        };
        tissue([](ElasticModel&, CondensedOptions&) {});
        phantom(AortaParameters {}.inner_radius_mm);
        edited(1.0);
        calls.spoilt.emplace_back([] { (void)PulsePressure::aortic(75.0, 80.0, 120.0); });
        calls.spoilt.emplace_back([] { (void)PulsePressure::constant(100.0); });
        calls.sound.swap(calls.spoilt); // nothing was spoilt so far
        for (const double bad : kBad) {
            tissue([=](ElasticModel& m, CondensedOptions&) { m.youngs_modulus[7] = bad; });
            tissue([=](ElasticModel&, CondensedOptions& o) { o.station_spacing = bad; });
            tissue([=](ElasticModel&, CondensedOptions& o) { o.force_gain = bad; });
            tissue([=](ElasticModel&, CondensedOptions& o) { o.blend = bad; });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::aortic(bad); });
            phantom(bad);
            edited(bad);
        }
        for (const double bad : { 0.5, 0.7, -1.0, kNoNumber })
            tissue([=](ElasticModel& m, CondensedOptions&) { m.poissons_ratio[7] = bad; });
        for (const double bad : { kNoNumber, kInfinite }) {
            tissue([=](ElasticModel&, CondensedOptions& o) { o.rest_pressure = bad; });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::constant(bad); });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::aortic(75.0, 80.0, bad); });
        }
        calls.spoilt.emplace_back([] { (void)PulsePressure::aortic(75.0, 120.0, 80.0); });
        tissue([](ElasticModel& m, CondensedOptions&) { m.roles.assign(m.roles.size(), VertexRole::free); });
        tissue([](ElasticModel& m, CondensedOptions&) { m.mesh.vertices(3, 1) = kNoNumber; });
        return calls;
    }

} // namespace

StabilityCase touch_spring_step_case()
{
    return { "time steps of springs under fingers",
        "up to the bound the motion stays bounded; beyond it, or where a tick would need too many, it is refused",
        [](const Job&) {
            std::vector<StabilityRow> rows;
            for (const auto& [name, share] : { std::pair { "half the bound", 0.5 },
                     std::pair { "0.99 of the bound", 0.99 }, std::pair { "the bound itself", 1.0 } })
                for (const auto& [law, arm] :
                    { std::pair { "touched springs", 0.0 }, std::pair { "touched springs, Maxwell arms", 0.8 } })
                    rows.push_back(attempt(std::string("time step: ") + name, law,
                        [&, s = share, a = arm](StabilityRow& row) { swing(row, s, a); }));
            const auto refused = [&](const char* name, const std::function<double(double)>& dt) {
                rows.push_back(expect_refusal(std::string("time step: ") + name, "touched springs",
                    "beyond the springs' stability bound", [&](StabilityRow& row) { step_by(row, dt); }));
            };
            refused("1.01 of the bound", [](double bound) { return 1.01 * bound; });
            refused("ten times the bound", [](double bound) { return 10.0 * bound; });
            refused("NaN", [](double) { return kNoNumber; });
            refused("zero", [](double) { return 0.0; });
            refused("negative", [](double bound) { return -bound; });
            rows.push_back(expect_refusal(
                "springs of 10,000 N/mm", "touched springs", "too stiff for their mass", [](StabilityRow& row) {
                    row.unconditioned = Unconditioned::explicit_steps;
                    const SpringTissue tissue(make_spring_sheet({ .stiffness = 1e4 }), {});
                    row.residual = row.error = 0.0;
                }));
            return rows;
        } };
}

StabilityCase bad_touch_parameters_case()
{
    return { "zero, negative, NaN of devices and touched tissue", "each is refused, naming the value and the place",
        [](const Job&) {
            return std::vector<StabilityRow> {
                all_refused("zero, negative, NaN: hands, servo, mapping", "input", bad_devices()),
                all_refused("zero, negative, NaN: springs, spheres", "input", bad_springs_and_spheres()),
                all_refused("zero, negative, NaN: condensed elements", "input", bad_condensed_tissue()),
            };
        } };
}

std::vector<StabilityCase> touch_cases()
{
    return { device_fault_case(), bone_touch_case(), touch_spring_step_case(), bad_touch_parameters_case() };
}

} // namespace retractor
