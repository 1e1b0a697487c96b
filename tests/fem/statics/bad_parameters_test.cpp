// Zero, negative and infinite numbers and NaN as parameters of the finite elements and springs: each is refused.

#include "fem/interactive/online_opening.h"
#include "fem/material/hyperelasticity.h"
#include "fem/model/loads.h"
#include "fem/model/pre_strain.h"
#include "fem/springs/edge_springs.h"
#include "fem/statics/hook_drive.h"
#include "fem/statics/opening.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/reference_problems.h"
#include "tests/support/refusals.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/spring_dynamics.h"
#include "tests/verification/framework/tension.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

namespace retractor::fem {
namespace bad_parameters_test {

    using namespace test_support;

    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();

    Material tissue(double youngs_modulus = 0.04, double poissons_ratio = 0.45, double density = 1e-9)
    {
        return { "tissue", youngs_modulus, poissons_ratio, density, "a test" };
    }

    test_support::SpoiltCalls bad_materials()
    {
        test_support::SpoiltCalls all;
        const auto opened_with = [](const Material& m) {
            return [m] {
                const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0);
                const Opening opening(mesh, std::vector<Material>(2, m), { { 0, 1, 2 }, {} });
            };
        };
        all.sound.emplace_back(opened_with(tissue()));
        for (const Material& m : { tissue(0.0), tissue(-1.0), tissue(kNan), tissue(kInfinite), tissue(1.0, 0.5),
                 tissue(1.0, 0.7), tissue(1.0, -1.0), tissue(1.0, kNan), tissue(1.0, 0.3, 0.0), tissue(1.0, 0.3, -1e-9),
                 tissue(1.0, 0.3, kNan) })
            all.spoilt.emplace_back(opened_with(m));
        return all;
    }

    test_support::SpoiltCalls bad_laws()
    {
        test_support::SpoiltCalls all;
        const auto checked = [](const Hyperelastic& law) { return [law] { check_hyperelastic(law); }; };
        for (const Hyperelastic& law :
            std::initializer_list<Hyperelastic> { NeoHookean { 1.0, 1.0 }, MooneyRivlin { 1.0, 0.0, 1.0 },
                HolzapfelGasserOgden { 1.0, 1.0, 1.0, 0.1, 1.0 }, Guccione { 1.0, 8.0, 2.0, 4.0, 1.0 } })
            all.sound.emplace_back(checked(law));
        const auto add = [&](const Hyperelastic& law) { all.spoilt.emplace_back(checked(law)); };
        for (const double bad : { 0.0, -1.0, kNan }) {
            add(NeoHookean { bad, 1.0 });
            add(MooneyRivlin { bad, 0.0, 1.0 });
            add(MooneyRivlin { 1.0, 0.0, bad });
            add(HolzapfelGasserOgden { bad, 1.0, 1.0, 0.1, 1.0 });
            add(HolzapfelGasserOgden { 1.0, 1.0, bad, 0.1, 1.0 });
            add(HolzapfelGasserOgden { 1.0, 1.0, 1.0, 0.1, bad });
            add(Guccione { bad, 8.0, 2.0, 4.0, 1.0 });
            add(Guccione { 1.0, bad, 2.0, 4.0, 1.0 });
            add(Guccione { 1.0, 8.0, 2.0, 4.0, bad });
        }
        return all;
    }

    test_support::SpoiltCalls bad_openings()
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 1.0);
        const std::vector<Material> materials(2, tissue());
        const auto with = [=](const Supports& supports, const OpeningOptions& options, const HookPatch& hook) {
            return [=] {
                Opening opening(mesh, materials, supports, options);
                (void)opening.open(std::vector<HookPatch> { hook });
            };
        };
        const Supports held { { 0, 1, 2, 3 }, {} };
        const HookPatch good { "hook", 1, { 24, 25, 26 }, Vec3(0, 0, 0.1) };
        const auto moved = [&](const Vec3& by) {
            HookPatch hook = good;
            hook.displacement = by;
            return hook;
        };
        test_support::SpoiltCalls all {
            { with(held, {}, moved({ kNan, 0, 0 })), with(held, {}, moved({ 0, 0, kInfinite })),
                with(held, {}, { "hook", 1, {}, Vec3(0, 0, 1) }), with(held, {}, { "hook", 1, { -1 }, Vec3(0, 0, 1) }),
                with(held, {}, { "hook", 1, { 27 }, Vec3(0, 0, 1) }), with({ { 99 }, {} }, {}, good),
                with({ { 0, 1, 2 }, { { 5, 0.0 } } }, {}, good), with({ { 0, 1, 2 }, { { 5, kNan } } }, {}, good),
                with(held, { .load_steps = 0 }, good), with(held, { .tolerance = kNan }, good),
                with(held, { .tolerance = 0.0 }, good) },
            { with(held, {}, good), [=] { const FollowerPressure pressure(mesh, mesh::boundary_faces(mesh), 0.01); },
                [] { check_drive({ .grip_N_per_mm = 1.0, .force_limit_N = 1.0 }, "hook"); },
                [] { check_drive({ .force_N = Vec3(1, 0, 0) }, "hook"); } }
        };
        mesh::TetMesh holed = mesh;
        holed.vertices(3, 1) = kNan;
        all.spoilt.emplace_back([=] { const Opening opening(holed, materials, held); });
        all.spoilt.emplace_back([=] { const FollowerPressure pressure(mesh, mesh::boundary_faces(mesh), kNan); });
        for (const double bad : { 0.0, -1.0, kNan }) {
            all.spoilt.emplace_back([=] { check_drive({ .grip_N_per_mm = bad }, "hook"); });
            all.spoilt.emplace_back([=] { check_drive({ .force_limit_N = bad }, "hook"); });
        }
        all.spoilt.emplace_back([] { check_drive({ .force_N = Vec3(kNan, 0, 0) }, "hook"); });
        return all;
    }

    test_support::SpoiltCalls bad_tensions()
    {
        test_support::SpoiltCalls all;
        const auto strained = [](double strain, const Vec3& along) {
            return [=] {
                (void)pre_stress({ PreStrainKind::uniaxial_stress, strain, along, Vec3::UnitZ() }, tissue());
            };
        };
        const auto sprung = [](double youngs_modulus, double density) {
            return [=] {
                const mesh::CutSession session(mesh::kuhn_box(1, 1, 1, 1.0));
                const SpringNetwork network(session, std::vector<Material>(2, tissue(youngs_modulus)));
                const verification::SpringDynamics dynamics(
                    network, std::vector<Material>(2, tissue(0.04, 0.45, density)), 0.0);
            };
        };
        all.sound = { strained(0.02, Vec3::UnitX()), sprung(0.04, 1e-9) };
        for (const double bad : { -0.01, 0.6, kNan })
            all.spoilt.emplace_back(strained(bad, Vec3::UnitX()));
        all.spoilt.emplace_back(strained(0.02, Vec3(kNan, 0, 0)));
        for (const double bad : { 0.0, -1.0, kNan }) {
            all.spoilt.emplace_back(sprung(bad, 1e-9));
            all.spoilt.emplace_back(sprung(0.04, bad));
        }
        return all;
    }

    TEST(BadParameters, OfMaterialsAreRefused) { test_support::expect_all_refused(bad_materials()); }

    TEST(BadParameters, OfHyperelasticLawsAreRefused) { test_support::expect_all_refused(bad_laws()); }

    TEST(BadParameters, OfSupportsHooksOptionsAndLoadsAreRefused) { test_support::expect_all_refused(bad_openings()); }

    TEST(BadParameters, OfTensionAndSpringsAreRefused) { test_support::expect_all_refused(bad_tensions()); }

    /// A block with an incision that two hooks hold open, solved whole.
    void open_whole(const ElasticProblem& problem)
    {
        Opening opening(problem.mesh, problem.material_of_label, problem.supports,
            { .elasticity = Elasticity::corotational, .tolerance = 1e-6 });
        (void)opening.open(problem.hooks);
    }

    TEST(BadParameters, TensionThatIsNoNumberIsRefused)
    {
        const verification::IncisedBlock block;
        const mesh::TetMesh uncut = verification::uncut_block(block);
        const verification::Incision incision = verification::incise(uncut, verification::incision_blade(block));
        const ElasticProblem problem = verification::hooked_open(block, incision, tissue(), Vec3(0.0, 2.0, 0.5));
        std::vector<mesh::TetFace> lips;
        for (const mesh::LipFace& lip : incision.lips)
            lips.push_back(lip.face);
        const Mat3 tension = 1e-3 * Mat3::Identity(); // MPa
        std::vector<Mat3> stresses(incision.mesh.tet_count(), tension);
        const auto release = [&] {
            (void)verification::release_wound(
                incision.mesh, lips, stresses, problem.material_of_label, problem.supports, {}, Job {});
        };
        EXPECT_EQ(test_support::message_of(release), "");
        stresses[static_cast<std::size_t>(lips.front().tet)](1, 1) = kNan;
        EXPECT_NE(test_support::message_of(release).find("finite"), std::string::npos)
            << test_support::message_of(release);

        Supports bottom;
        for (VertexId v = 0; v < static_cast<VertexId>(uncut.vertex_count()); ++v)
            if (uncut.vertices(v, 2) == 0.0)
                bottom.fixed.push_back(v);
        OnlineOptions options;
        options.stress_of_element.assign(uncut.tet_count(), tension);
        const auto prepare = [&] {
            mesh::CutSession session(uncut);
            const OnlineOpening opening(session, std::vector<Material>(2, tissue()), bottom, {}, options);
        };
        EXPECT_EQ(test_support::message_of(prepare), "");
        options.stress_of_element.back()(0, 2) = kNan;
        EXPECT_NE(test_support::message_of(prepare).find("finite"), std::string::npos)
            << test_support::message_of(prepare);
    }

    TEST(BadParameters, AMeshWithAnElementTwiceIsRefused)
    {
        const verification::IncisedBlock block;
        ElasticProblem problem = verification::hooked_open(block,
            verification::incise(verification::uncut_block(block), verification::incision_blade(block)), tissue(),
            Vec3(0.0, 2.0, 0.5));
        const auto open = [&] { open_whole(problem); };
        EXPECT_EQ(test_support::message_of(open), "");
        constexpr TetId kTwice = 7;
        const auto nodes = problem.mesh.tet(kTwice);
        const std::vector<VertexId> copy(nodes.begin(), nodes.end());
        problem.mesh.nodes.insert(problem.mesh.nodes.end(), copy.begin(), copy.end());
        problem.mesh.labels.push_back(problem.mesh.labels[kTwice]);
        EXPECT_NE(test_support::message_of(open).find("element"), std::string::npos) << test_support::message_of(open);
    }

} // namespace bad_parameters_test
} // namespace retractor::fem
