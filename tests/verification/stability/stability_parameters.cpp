// Numbers that are none: zero, negative, NaN parameters; time steps at and beyond the bound of the spring model.

#include "tests/verification/stability/stability_families.h"

#include "fem/edge_springs.h"
#include "fem/hook_drive.h"
#include "fem/opening.h"
#include "fem/pre_strain.h"
#include "fem/spring_dynamics.h"
#include "fem/spring_relaxation.h"
#include "mesh/base/error.h"
#include "mesh/cut_session.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/stability.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>

namespace retractor {

namespace {

    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();

    Material tissue(double youngs_modulus = 0.04, double poissons_ratio = 0.45, double density = 1e-9)
    {
        return { "tissue", youngs_modulus, poissons_ratio, density, "verification" };
    }

    SpoiltCalls bad_materials()
    {
        SpoiltCalls all;
        const auto opened_with = [](const Material& m) {
            return [m] {
                const TetMesh mesh = kuhn_box(1, 1, 1, 1.0);
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

    SpoiltCalls bad_laws()
    {
        SpoiltCalls all;
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

    SpoiltCalls bad_openings()
    {
        const TetMesh mesh = kuhn_box(2, 2, 2, 1.0);
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
        SpoiltCalls all { { with(held, {}, moved({ kNan, 0, 0 })), with(held, {}, moved({ 0, 0, kInfinite })),
                              with(held, {}, { "hook", 1, {}, Vec3(0, 0, 1) }),
                              with(held, {}, { "hook", 1, { -1 }, Vec3(0, 0, 1) }),
                              with(held, {}, { "hook", 1, { 27 }, Vec3(0, 0, 1) }), with({ { 99 }, {} }, {}, good),
                              with({ { 0, 1, 2 }, { { 5, 0.0 } } }, {}, good),
                              with({ { 0, 1, 2 }, { { 5, kNan } } }, {}, good), with(held, { .load_steps = 0 }, good),
                              with(held, { .tolerance = kNan }, good), with(held, { .tolerance = 0.0 }, good) },
            { with(held, {}, good), [=] { const FollowerPressure pressure(mesh, boundary_faces(mesh), 0.01); },
                [] { check_drive({ .grip_N_per_mm = 1.0, .force_limit_N = 1.0 }, "hook"); },
                [] { check_drive({ .force_N = Vec3(1, 0, 0) }, "hook"); } } };
        TetMesh holed = mesh;
        holed.vertices(3, 1) = kNan;
        all.spoilt.emplace_back([=] { const Opening opening(holed, materials, held); });
        all.spoilt.emplace_back([=] { const FollowerPressure pressure(mesh, boundary_faces(mesh), kNan); });
        for (const double bad : { 0.0, -1.0, kNan }) {
            all.spoilt.emplace_back([=] { check_drive({ .grip_N_per_mm = bad }, "hook"); });
            all.spoilt.emplace_back([=] { check_drive({ .force_limit_N = bad }, "hook"); });
        }
        all.spoilt.emplace_back([] { check_drive({ .force_N = Vec3(kNan, 0, 0) }, "hook"); });
        return all;
    }

    SpoiltCalls bad_cuts()
    {
        SpoiltCalls all;
        const IncisedBlock block;
        const Blade good = incision_blade(block);
        const auto add = [&](const std::function<void(Blade&)>& spoil) {
            Blade blade = good;
            spoil(blade);
            all.spoilt.emplace_back([blade, block] { (void)cut(uncut_block(block), blade); });
        };
        all.sound.emplace_back([good, block] { (void)cut(uncut_block(block), good); });
        for (const double bad : { 0.0, -1.0, kNan })
            add([=](Blade& b) { b.depth_mm = bad; });
        add([](Blade& b) { b.line.resize(1); });
        add([](Blade& b) { b.line[1] = b.line[0]; });
        add([](Blade& b) { b.line[1].x() = kNan; });
        add([](Blade& b) { b.directions[0].setZero(); });
        add([](Blade& b) { b.directions[0].setConstant(kNan); });
        add([](Blade& b) { b.directions[0] = b.line[1] - b.line[0]; });
        return all;
    }

    SpoiltCalls bad_tensions()
    {
        SpoiltCalls all;
        const auto strained = [](double strain, const Vec3& along) {
            return [=] {
                (void)pre_stress({ PreStrainKind::uniaxial_stress, strain, along, Vec3::UnitZ() }, tissue());
            };
        };
        const auto sprung = [](double calibration, double youngs_modulus, double density) {
            return [=] {
                const TetMesh mesh = kuhn_box(1, 1, 1, 1.0);
                const SpringNetwork network(
                    mesh, std::vector<Material>(2, tissue(youngs_modulus)), {}, { .calibration = calibration });
                const SpringDynamics dynamics(network, std::vector<Material>(2, tissue(0.04, 0.45, density)), 0.0);
            };
        };
        all.sound = { strained(0.02, Vec3::UnitX()), sprung(1.0, 0.04, 1e-9) };
        for (const double bad : { -0.01, 0.6, kNan })
            all.spoilt.emplace_back(strained(bad, Vec3::UnitX()));
        all.spoilt.emplace_back(strained(0.02, Vec3(kNan, 0, 0)));
        for (const double bad : { 0.0, -1.0, kNan }) {
            all.spoilt.emplace_back(sprung(bad, 0.04, 1e-9));
            all.spoilt.emplace_back(sprung(1.0, bad, 1e-9));
            all.spoilt.emplace_back(sprung(1.0, 0.04, bad));
        }
        return all;
    }

    struct Springs {
        TetMesh mesh = kuhn_box(4, 4, 4, 2.0);
        std::vector<Material> materials = std::vector<Material>(2, tissue());
        SpringNetwork network { mesh, materials };
        Springs()
        {
            std::vector<VertexId> bottom;
            for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
                if (mesh.vertices(v, 2) < 1e-9)
                    bottom.push_back(v);
            network.fix(bottom);
        }
    };

    std::string step_text(const StabilityBound& bound)
    {
        std::array<char, 96> text {};
        (void)std::snprintf(text.data(), text.size(), "bound %.4g us; certain one %.4g us", 1e6 * bound.stable_step,
            2e6 / bound.gershgorin_frequency);
        return text.data();
    }

    /// Plucked and left to swing without damping: the motion stays bounded.
    void swing(StabilityRow& row, double share)
    {
        Springs springs;
        SpringDynamics dynamics(springs.network, springs.materials, 0.0);
        const Eigen::Index n = dynamics.displacement().size();
        Eigen::VectorXd plucked(n);
        for (Eigen::Index i = 0; i < n; ++i)
            plucked[i] = 1e-3 * std::sin(1.0 + 12.9898 * static_cast<double>(i)); // mm, all frequencies
        dynamics.set_state(plucked, Eigen::VectorXd::Zero(n));
        const double dt = share * dynamics.bound().stable_step;
        double most = 0.0;
        constexpr int kSteps = 3000;
        for (int i = 0; i < kSteps; ++i) {
            dynamics.step(dt);
            most = std::max(most, dynamics.displacement().cwiseAbs().maxCoeff());
        }
        row.quantity = "largest excursion over the pluck, after 3,000 steps";
        row.error = most / plucked.cwiseAbs().maxCoeff();
        row.bound = 20.0; // many modes meet; an unstable step grows by powers of ten
        row.residual = 0.0; // nothing is solved
        row.unconditioned = Unconditioned::explicit_steps;
        row.reason = step_text(dynamics.bound());
    }

    void step_by(StabilityRow& row, const std::function<double(const StabilityBound&)>& dt)
    {
        Springs springs;
        SpringDynamics dynamics(springs.network, springs.materials, 0.0);
        row.unconditioned = Unconditioned::explicit_steps;
        dynamics.step(dt(dynamics.bound()));
        row.residual = row.error = 0.0;
    }

} // namespace

StabilityCase bad_parameters_case()
{
    return { "zero, negative, NaN parameters", "each is refused, naming the value and the place",
        [](const Job&) {
            return std::vector<StabilityRow> { all_refused("zero, negative, NaN: materials", "input", bad_materials()),
                all_refused("zero, negative, NaN: hyperelastic laws", "input", bad_laws()),
                all_refused("zero, negative, NaN: supports, hooks, options, loads", "input", bad_openings()),
                all_refused("zero, negative, NaN: blades", "input", bad_cuts()),
                all_refused("zero, negative, NaN: tension and springs", "input", bad_tensions()) };
        } };
}

StabilityCase spring_step_case()
{
    return { "time steps of springs", "up to the bound the motion stays bounded; beyond it the step is refused",
        [](const Job&) {
            std::vector<StabilityRow> rows;
            for (const auto& [name, share] : { std::pair { "half the bound", 0.5 },
                     std::pair { "0.99 of the bound", 0.99 }, std::pair { "the bound itself", 1.0 } })
                rows.push_back(attempt(std::string("time step: ") + name, "springs, explicit",
                    [s = share](StabilityRow& row) { swing(row, s); }));
            using Bound = const StabilityBound&;
            const auto refused = [&](const char* name, const std::function<double(Bound)>& dt) {
                rows.push_back(expect_refusal(std::string("time step: ") + name, "springs, explicit",
                    "where the explicit scheme is stable", [&](StabilityRow& row) { step_by(row, dt); }));
            };
            refused("1.01 of the bound", [](Bound b) { return 1.01 * b.stable_step; });
            refused("ten times the bound", [](Bound b) { return 10.0 * b.stable_step; });
            refused("NaN", [](Bound) { return kNan; });
            refused("zero", [](Bound) { return 0.0; });
            refused("negative", [](Bound b) { return -b.stable_step; });
            return rows;
        } };
}

} // namespace retractor
