// Validation problems 3 and 4: thick-walled tubes under inner pressure, plane strain.

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/element/tet_element.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/ring.h"
#include "tests/verification/framework/vessel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

namespace retractor::verification {

namespace {

    constexpr double kSoft = 0.5, kNormal = 1.0, kSclerotic = 3.0; // MPa; the last two are those of the beating aorta

    std::string with_number(const std::string& text, double number)
    {
        char buffer[32];
        (void)std::snprintf(buffer, sizeof buffer, "%g", number);
        return text + buffer;
    }

    // bound of elements that do not lock, and of P1 where it does not lock
    constexpr double kClose = 2e-3, kSlow = 0.01;

    const OrderRule kLocking { .asks = OrderRule::Asks::fall, .why = "plain P1 locks, and is too stiff by far" };

    /// Order of P2 in the displacement: in incompressible material its pressures have one order less than its
    /// strains.
    double quadratic_order(double nu) { return nu < 0.48 ? 3.0 : 2.0; }

    struct Resolution {
        int around, through;
    };
    std::vector<Resolution> resolutions(VerificationElement element, bool fine)
    {
        std::vector<Resolution> all { { 12, 1 }, { 24, 2 }, { 48, 4 } };
        if (element != VerificationElement::p2 || fine)
            all.push_back({ 96, 8 });
        if (element != VerificationElement::p2 && fine)
            all.push_back({ 192, 16 });
        return all;
    }

    struct Vessel {
        double E, nu; ///< MPa
        std::string name() const
        {
            return (E == kSoft ? std::string() : with_number(", E ", E)) + with_number(", nu ", nu);
        }
    };

    double exact_displacement(const Vessel& vessel) { return vessel_displacement(vessel.E, vessel.nu, kPulse); }

    /// The pressure: the pulse, or for nonlinear laws a thousandth of the pulse, because the closed form holds for
    /// small strain.
    constexpr double kSmall = 1e-3;
    double pulse(const VerificationLaw& law) { return law.model == fem::Elasticity::linear ? kPulse : kSmall * kPulse; }

    VerificationSolve press_tube(
        const QuarterTube& tube, VerificationElement element, const VerificationLaw& law, const Job& job)
    {
        fem::ElasticBody body = make_body(tube.mesh, element, law);
        body.set_loads({ {}, { fem::FollowerPressure(tube.mesh, tube.inner_faces, pulse(law)) } });
        return solve_problem(body, tube.held.prescribed, {}, { .load_steps = 1, .tolerance = 1e-8 }, job);
    }

    /// A row for each mesh, coarse to fine.
    /// @param measure fills in the compared quantity.
    std::vector<VerificationRow> pressed_series(const std::string& problem, VerificationElement element,
        const VerificationLaw& law, const VerificationOptions& options, const Job& job,
        const std::function<void(VerificationRow&, const QuarterTube&, const Eigen::VectorXd& u)>& measure)
    {
        std::vector<VerificationRow> series;
        for (const Resolution& r : coarsest(resolutions(element, options.fine), options)) {
            const QuarterTube tube
                = quarter_tube(nodes_per_tet(element), kVesselInner, kVesselOuter, r.around, r.through, 1);
            const VerificationSolve solve = press_tube(tube, element, law, job);
            VerificationRow row = make_row(problem, element, law, tube.mesh, solve);
            measure(row, tube, solve.equilibrium.displacement);
            row.size = 1.0 / r.through;
            series.push_back(row);
        }
        return series;
    }

    std::vector<VerificationRow> pressed_tube(
        VerificationElement element, const Vessel& vessel, const VerificationOptions& options, const Job& job)
    {
        const double nu = vessel.nu;
        std::vector<VerificationRow> series = pressed_series("pressed tube" + vessel.name(), element,
            linear_law(vessel.E, nu), options, job,
            [&](VerificationRow& row, const QuarterTube& tube, const Eigen::VectorXd& u) {
                compare(row, "inner wall's displacement, mm", inner_displacement(tube, u), exact_displacement(vessel));
            });
        constexpr double kLocks = 0.495; // Poisson's ratio beyond which P1 shows no order on these meshes
        std::vector<VerificationRow> judged;
        if (element == VerificationElement::p1)
            append_series(judged, series, 2.0, nu < kLocks ? kSlow : kNoBound, nu < kLocks ? OrderRule {} : kLocking);
        else
            append_series(judged, series, element == VerificationElement::p2 ? quadratic_order(nu) : 2.0, kClose);
        return judged;
    }

    /// Under a thousandth of the pulse corotational elements follow the closed form up to squares of the strain.
    void add_corotational(std::vector<VerificationRow>& rows, VerificationElement element,
        const VerificationOptions& options, const Job& job)
    {
        const Vessel vessel { kSoft, 0.45 };
        VerificationLaw law = linear_law(vessel.E, vessel.nu);
        law.model = fem::Elasticity::corotational;
        law.name = "corotational";
        VerificationOptions three = options;
        three.meshes = std::min<std::size_t>(three.meshes, 3);
        std::vector<VerificationRow> series = pressed_series("pressed tube, small, nu 0.45", element, law, three, job,
            [&](VerificationRow& row, const QuarterTube& tube, const Eigen::VectorXd& u) {
                compare(row, "inner wall's displacement, mm", inner_displacement(tube, u),
                    kSmall * exact_displacement(vessel));
            });
        append_series(rows, series, element == VerificationElement::p2 ? quadratic_order(vessel.nu) : 2.0,
            element == VerificationElement::p1 ? kSlow : kClose,
            { .floor = 0.1 * kSmall, .why = "squares of the strain, which the closed form leaves out" });
    }

    /// Mean of the hoop stress at the middle of the inner wall's faces.
    double hoop_stress(const QuarterTube& tube, const fem::Lame& l, const Eigen::VectorXd& u)
    {
        const mesh::TetMesh& mesh = tube.mesh;
        double sum = 0.0;
        for (const mesh::TetFace& face : tube.inner_faces) {
            const auto nodes = mesh.tet(face.tet);
            fem::NodeGradients rest(mesh.nodes_per_tet, 3), moved(mesh.nodes_per_tet, 3);
            for (std::size_t a = 0; a < nodes.size(); ++a) {
                rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
                moved.row(static_cast<Eigen::Index>(a)) = u.segment<3>(3 * nodes[a]).transpose();
            }
            fem::QuadraturePoint middle { { 1.0 / 3, 1.0 / 3, 1.0 / 3, 1.0 / 3 }, 1.0 };
            middle.barycentric[static_cast<std::size_t>(face.corner)] = 0.0;
            const Mat3 gradient = moved.transpose() * fem::shape_gradients(rest, middle).gradients;
            const Mat3 strain = 0.5 * (gradient + gradient.transpose());
            const Vec3 at = rest.transpose() * fem::shape_values(mesh.nodes_per_tet, middle.barycentric);
            const Vec3 hoop = Vec3(-at.y(), at.x(), 0.0).normalized();
            sum += 2.0 * l.mu * hoop.dot(strain * hoop) + l.lambda * strain.trace();
        }
        return sum / static_cast<double>(tube.inner_faces.size());
    }

    std::vector<VerificationRow> hoop_stresses(
        VerificationElement element, double nu, const VerificationOptions& options, const Job& job)
    {
        const VerificationLaw law = linear_law(kSoft, nu);
        std::vector<VerificationRow> series = pressed_series(with_number("hoop stress, nu ", nu), element, law, options,
            job, [&](VerificationRow& row, const QuarterTube& tube, const Eigen::VectorXd& u) {
                compare(row, "at the inner wall, over the pressure", hoop_stress(tube, law.lame, u) / kPulse,
                    (kVesselInner * kVesselInner + kVesselOuter * kVesselOuter)
                        / (kVesselOuter * kVesselOuter - kVesselInner * kVesselInner));
            });
        std::vector<VerificationRow> judged;
        const bool quadratic = element == VerificationElement::p2;
        append_series(judged, series, quadratic ? 2.0 : 1.0, quadratic ? 2e-3 : 0.03);
        return judged;
    }

    double stretched_pressure(double li)
    {
        const double ratio = kVesselInner / kVesselOuter;
        const double lo = std::sqrt(1 + ratio * ratio * (li * li - 1));
        return std::log(li / lo) + 0.5 * (1 / (lo * lo) - 1 / (li * li));
    }

    constexpr double kMu = 1.0 / 3.0; // MPa: E 1, incompressible
    constexpr double kBulk = 1e4 * kMu; // compressed_stretch() includes the volume change in the expected displacement

    /// Stress of mu/2 (J^(-2/3) I1 - 3) + K/2 (ln J)^2 in plane strain.
    RingStress soft_ring(const RingStretch& ring)
    {
        const double J = ring.hoop * ring.radial, scale = std::pow(J, -2.0 / 3.0);
        const double squares = ring.hoop * ring.hoop + ring.radial * ring.radial + 1.0;
        const auto along = [&](double stretch) {
            return kMu * scale * (stretch - squares / (3.0 * stretch)) + kBulk * std::log(J) / stretch;
        };
        return { along(ring.hoop), along(ring.radial) };
    }

    /// Stretch of the inner wall of a tube with the modulus kBulk, under the pressure that stretches an
    /// incompressible tube by li with a free outer wall. The displacement is larger by the relative amount of 1 to
    /// 2e-4, which is more than the error of the finest meshes.
    double compressed_stretch(double li)
    {
        constexpr double kRoom = 1e-3; // largest difference by the bulk modulus, with a margin
        return bore_stretch(
            { kVesselInner, kVesselOuter, soft_ring }, kMu * stretched_pressure(li), li - kRoom, li + kRoom);
    }

    VerificationLaw soft_vessel()
    {
        return hyperelastic_law("neo-Hookean", fem::MooneyRivlin { 0.5 * kMu, 0.0, kBulk });
    }

    constexpr std::array kStretches { 1.1, 1.2, 1.3, 1.5 };

    /// A row for each of kStretches. Each pressure continues from the answer to the pressure before, and includes its
    /// time.
    std::array<VerificationRow, kStretches.size()> stretched_tube(
        VerificationElement element, const Resolution& r, const Job& job)
    {
        const QuarterTube tube
            = quarter_tube(nodes_per_tet(element), kVesselInner, kVesselOuter, r.around, r.through, 1);
        fem::ElasticBody body = make_body(tube.mesh, element, soft_vessel());
        fem::EquilibriumSolver solver;
        VerificationSolve solve;
        solve.equilibrium.displacement = Eigen::VectorXd::Zero(3 * tube.mesh.vertices.rows());
        double before = 0.0; // the pressure before
        std::array<VerificationRow, kStretches.size()> rows;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const Stopwatch watch;
            const double li = kStretches[i], pressure = kMu * stretched_pressure(li);
            body.set_loads({ {}, { fem::FollowerPressure(tube.mesh, tube.inner_faces, pressure) } });
            solve.equilibrium
                = solver.solve(body, tube.held.prescribed, tube.held.target, solve.equilibrium.displacement,
                    { .load_steps = 2, .tolerance = 1e-8, .load_at_start = before / pressure }, job);
            solve.seconds += watch.seconds();
            before = pressure;
            rows[i] = make_row(with_number("stretched tube, stretch ", li), element, soft_vessel(), tube.mesh, solve);
            compare(rows[i], "inner wall's displacement, mm", inner_displacement(tube, solve.equilibrium.displacement),
                (compressed_stretch(li) - 1.0) * kVesselInner);
            rows[i].size = 1.0 / r.through;
        }
        return rows;
    }

    /// One series per stretch.
    std::array<std::vector<VerificationRow>, kStretches.size()> stretched_series(
        VerificationElement element, const VerificationOptions& options, const Job& job)
    {
        std::vector<Resolution> meshes { { 12, 1 }, { 24, 2 }, { 36, 3 } };
        if (options.fine)
            meshes.push_back({ 72, 6 });
        std::array<std::vector<VerificationRow>, kStretches.size()> series;
        for (const Resolution& r : coarsest(meshes, options)) {
            const auto rows = stretched_tube(element, r, job);
            for (std::size_t i = 0; i < rows.size(); ++i)
                series[i].push_back(rows[i]);
        }
        return series;
    }

    /// The pressure beyond which no equilibrium exists.
    VerificationRow tube_limit(VerificationElement element, int around, const Job& job)
    {
        const double limit = std::log(kVesselOuter / kVesselInner), asked = 1.1 * limit; // relative to mu
        const QuarterTube tube = quarter_tube(nodes_per_tet(element), kVesselInner, kVesselOuter, around, 1, 1);
        fem::ElasticBody body = make_body(tube.mesh, element, soft_vessel());
        body.set_loads({ {}, { fem::FollowerPressure(tube.mesh, tube.inner_faces, asked * kMu) } });
        const VerificationSolve solve
            = solve_problem(body, tube.held.prescribed, {}, { .load_steps = 6, .tolerance = 1e-6 }, job);
        VerificationRow row = make_row("tube beyond its limit", element, soft_vessel(), tube.mesh, solve);
        row.error = 0.0; // no convergence is the right answer
        compare(row, "largest pressure with an equilibrium / mu", asked * solve.equilibrium.load, limit);
        row.size = 1.0 / around;
        row.bound = 0.05; // effect of one layer of elements, and of load steps of half a percent
        if (solve.equilibrium.status == fem::EquilibriumStatus::converged)
            row.error = std::numeric_limits<double>::quiet_NaN();
        return row;
    }

} // namespace

VerificationProblem pressed_tube_problem()
{
    return { "pressed tube",
        "thick tube, ri 12.5, ro 14.5, 40 mmHg, linear [Lame]; corotational under a thousandth of it",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const Vessel& vessel :
                { Vessel { kSoft, 0.30 }, Vessel { kSoft, 0.45 }, Vessel { kSoft, 0.49 }, Vessel { kSoft, 0.499 },
                    Vessel { kSoft, 0.4999 }, Vessel { kNormal, 0.48 }, Vessel { kSclerotic, 0.48 } })
                for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                         VerificationElement::nodal, VerificationElement::p2 })
                    if (!job.cancelled())
                        for (VerificationRow& row : pressed_tube(element, vessel, options, job))
                            rows.push_back(std::move(row));
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 })
                if (!job.cancelled())
                    add_corotational(rows, element, options, job);
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 })
                if (!job.cancelled())
                    for (VerificationRow& row : hoop_stresses(element, 0.30, options, job))
                        rows.push_back(std::move(row));
            return rows;
        },
        "hyperelastic laws, which are for finite strain: stretched tube" };
}

VerificationProblem stretched_tube_problem()
{
    return { "stretched tube",
        "the same tube at finite strain, nearly incompressible neo-Hookean: the pressure of the incompressible closed "
        "form, the displacement with what K = 1e4 mu compresses",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            std::array<std::vector<VerificationRow>, kStretches.size()> by_stretch;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 }) {
                if (job.cancelled())
                    break;
                const bool locks = element == VerificationElement::p1;
                // the nodal element locks on coarse meshes
                const double bound = element == VerificationElement::nodal ? kSlow : kClose;
                auto series = stretched_series(element, options, job);
                for (std::size_t i = 0; i < series.size(); ++i)
                    append_series(
                        by_stretch[i], series[i], 2.0, locks ? kNoBound : bound, locks ? kLocking : OrderRule {});
            }
            for (const std::vector<VerificationRow>& stretch : by_stretch)
                rows.insert(rows.end(), stretch.begin(), stretch.end());
            return rows;
        },
        "laws but neo-Hookean, which has the closed form" };
}

VerificationProblem tube_limit_problem()
{
    return { "tube beyond its limit", "above p = mu ln(ro / ri) there is no equilibrium, and a message reports this",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            // With 4 round the quarter, locking-free elements have an equilibrium beyond the limit at most pressures.
            for (const VerificationElement element : { VerificationElement::locking_free, VerificationElement::p2 })
                for (const int around : coarsest(std::vector<int> { 6, 8, 12 }, options))
                    if (!job.cancelled())
                        rows.push_back(tube_limit(element, around, job));
            return rows;
        },
        "plain P1, which locks, and nodal P1, a tenth off on one layer of elements (stretched tube); laws but "
        "neo-Hookean, whose limit is known" };
}

} // namespace retractor::verification
