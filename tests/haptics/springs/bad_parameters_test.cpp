// Zero, negative and infinite numbers and NaN as parameters of devices and touched tissue: each is refused.

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/condensed/elastic_template.h"
#include "haptics/device/hand_path.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/recording/replay.h"
#include "haptics/servo/servo.h"
#include "haptics/spheres/sphere_tissue.h"
#include "haptics/springs/spring_tissue.h"
#include "tests/support/refusals.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace retractor::haptics {
namespace bad_touch_parameters_test {

    using namespace test_support;

    constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    constexpr std::array<double, 4> kBad { 0.0, -1.0, kNoNumber, kInfinite };

    TriMesh ball() { return test_support::ball_surface(Vec3::Zero(), 10.0, 8); }

    test_support::SpoiltCalls bad_devices()
    {
        test_support::SpoiltCalls calls;
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
                SphereTissue tissue({ { "ball", ball(), fill_with_spheres(ball(), 3.0), 0.02 } }, {});
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

    test_support::SpoiltCalls bad_springs_and_spheres()
    {
        test_support::SpoiltCalls calls;
        const auto law
            = [&](const ElementLaw& made) { calls.spoilt.emplace_back([made] { check_element_law(made); }); };
        const auto sheet
            = [&](const SheetOptions& made) { calls.spoilt.emplace_back([made] { (void)make_spring_sheet(made); }); };
        const auto spheres = [&](const std::function<void(SphereOrgan&, SphereLaw&, double&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                const TriMesh surface = ball();
                SphereOrgan organ { "ball", surface, fill_with_spheres(surface, 3.0), 0.02 };
                SphereLaw sphere_law;
                double blend = 0.01;
                spoil(organ, sphere_law, blend);
                const SphereTissue tissue({ organ }, sphere_law, blend);
            });
        };
        const auto filling
            = [&](double radius) { calls.spoilt.emplace_back([=] { (void)fill_with_spheres(ball(), radius); }); };
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

    test_support::SpoiltCalls bad_condensed_tissue()
    {
        test_support::SpoiltCalls calls;
        const auto tissue = [&](const std::function<void(datasets::ElasticModel&, CondensedOptions&)>& spoil) {
            calls.spoilt.emplace_back([spoil] {
                datasets::AortaParameters parameters {
                    .shape = datasets::AortaParameters::Shape::tube, .length_mm = 40.0, .along = 4
                };
                parameters.region.length_mm = 0.0;
                datasets::ElasticModel model = datasets::make_aorta_phantom(parameters).body;
                CondensedOptions options { .element = TouchElement::p1 };
                spoil(model, options);
                const CondensedTissue made(std::move(model), PulsePressure::aortic(), options);
            });
        };
        const auto phantom = [&](double inner_radius_mm) {
            calls.spoilt.emplace_back([=] {
                datasets::AortaParameters parameters;
                parameters.inner_radius_mm = inner_radius_mm;
                (void)datasets::make_aorta_phantom(parameters);
            });
        };
        const auto edited = [&](double youngs_modulus) {
            calls.spoilt.emplace_back([=] {
                datasets::ElasticModel model = datasets::make_aorta_phantom({}).body;
                (void)apply(ElasticTemplate { .youngs_modulus = youngs_modulus }, model);
            });
        };
        tissue([](datasets::ElasticModel&, CondensedOptions&) {});
        phantom(datasets::AortaParameters {}.inner_radius_mm);
        edited(1.0);
        calls.spoilt.emplace_back([] { (void)PulsePressure::aortic(75.0, 80.0, 120.0); });
        calls.spoilt.emplace_back([] { (void)PulsePressure::constant(100.0); });
        calls.sound.swap(calls.spoilt); // nothing was spoilt so far
        for (const double bad : kBad) {
            tissue([=](datasets::ElasticModel& m, CondensedOptions&) { m.youngs_modulus[7] = bad; });
            tissue([=](datasets::ElasticModel&, CondensedOptions& o) { o.contact_node_spacing = bad; });
            tissue([=](datasets::ElasticModel&, CondensedOptions& o) { o.force_gain = bad; });
            tissue([=](datasets::ElasticModel&, CondensedOptions& o) { o.blend = bad; });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::aortic(bad); });
            phantom(bad);
            edited(bad);
        }
        for (const double bad : { 0.5, 0.7, -1.0, kNoNumber })
            tissue([=](datasets::ElasticModel& m, CondensedOptions&) { m.poissons_ratio[7] = bad; });
        for (const double bad : { kNoNumber, kInfinite }) {
            tissue([=](datasets::ElasticModel&, CondensedOptions& o) { o.rest_pressure = bad; });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::constant(bad); });
            calls.spoilt.emplace_back([=] { (void)PulsePressure::aortic(75.0, 80.0, bad); });
        }
        calls.spoilt.emplace_back([] { (void)PulsePressure::aortic(75.0, 120.0, 80.0); });
        tissue([](datasets::ElasticModel& m, CondensedOptions&) {
            m.roles.assign(m.roles.size(), datasets::VertexRole::free);
        });
        tissue([](datasets::ElasticModel& m, CondensedOptions&) { m.mesh.vertices(3, 1) = kNoNumber; });
        return calls;
    }

    TEST(BadTouchParameters, OfHandsServoAndMappingAreRefused) { test_support::expect_all_refused(bad_devices()); }

    TEST(BadTouchParameters, OfSpringsAndSpheresAreRefused)
    {
        test_support::expect_all_refused(bad_springs_and_spheres());
    }

    TEST(BadTouchParameters, OfCondensedElementsAreRefused)
    {
        test_support::expect_all_refused(bad_condensed_tissue());
    }

} // namespace bad_touch_parameters_test
} // namespace retractor::haptics
