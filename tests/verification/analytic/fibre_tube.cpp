// A tube under inner pressure with two families of fibres that wind round the tube: the fibre direction turns from
// element to element.

#include "tests/verification/analytic/analytic_problems.h"

#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/ring.h"
#include "tests/verification/framework/vessel.h"

#include <cmath>
#include <numbers>
#include <string>

namespace retractor::verification {

namespace {

    constexpr double kMeanPressure = 13.3e-3; // MPa: 100 mmHg
    constexpr fem::HolzapfelGasserOgden kArtery {
        .mu = 0.03, .k1 = 0.06, .k2 = 4.0, .dispersion = 0.1, .bulk = 3.0
    }; // MPa

    double radians(double deg) { return deg * std::numbers::pi / 180.0; }

    /// Derivatives of kArtery's energy by the principal stretches, with axial stretch 1. The two families lie
    /// symmetrically about the circumference, so the principal directions do not turn.
    RingStress wall_stress(const RingStretch& ring, double angle_deg)
    {
        const double round = std::pow(std::cos(radians(angle_deg)), 2), J = ring.hoop * ring.radial;
        const double scale = std::pow(J, -2.0 / 3.0), hoop2 = ring.hoop * ring.hoop;
        const double I1 = scale * (hoop2 + ring.radial * ring.radial + 1.0), I4 = scale * (round * hoop2 + 1.0 - round);
        const double spread = kArtery.dispersion, along = 1.0 - 3.0 * spread;
        const double e = spread * (I1 - 3.0) + along * (I4 - 1.0);
        // derivative of the energy of both families by e
        const double pull = e > 0.0 ? 2.0 * kArtery.k1 * e * std::exp(kArtery.k2 * e * e) : 0.0;
        const double by_I1 = 0.5 * kArtery.mu + pull * spread, by_I4 = pull * along;
        // share: the part of the fibre direction along the stretch
        const auto stress = [&](double stretch, double share) {
            const double mean = 1.0 / (1.5 * stretch);
            return by_I1 * (2.0 * scale * stretch - mean * I1) + by_I4 * (2.0 * scale * share * stretch - mean * I4)
                + kArtery.bulk * std::log(J) / stretch;
        };
        return { stress(ring.hoop, round), stress(ring.radial, 0.0) };
    }

    std::vector<VerificationRow> fibre_tube(
        VerificationElement element, double angle_deg, const VerificationOptions& options, const Job& job)
    {
        VerificationLaw law = hyperelastic_law("Holzapfel-Gasser-Ogden", kArtery);
        law.around = fem::FibresAround { .angle_deg = angle_deg };
        constexpr double kWidest = 1.5; // stretch of the bore: well beyond these walls
        const double expected = kVesselInner
            * (bore_stretch(
                   { kVesselInner, kVesselOuter, [=](const RingStretch& r) { return wall_stress(r, angle_deg); } },
                   kMeanPressure, 1.0, kWidest)
                - 1.0);
        struct Resolution {
            int around, through;
        };
        std::vector<Resolution> meshes { { 12, 1 }, { 24, 2 }, { 48, 4 } };
        if (options.fine)
            meshes.push_back({ 96, 8 });
        std::vector<VerificationRow> series;
        for (const Resolution& r : coarsest(meshes, options)) {
            const QuarterTube tube
                = quarter_tube(nodes_per_tet(element), kVesselInner, kVesselOuter, r.around, r.through, 1);
            fem::ElasticBody body = make_body(tube.mesh, element, law);
            body.set_loads({ {}, { fem::FollowerPressure(tube.mesh, tube.inner_faces, kMeanPressure) } });
            const VerificationSolve solve = solve_problem(body, tube.held.prescribed, {}, { .tolerance = 1e-8 }, job);
            VerificationRow row
                = make_row("tube with fibres round it, at " + std::to_string(std::lround(angle_deg)) + " deg", element,
                    law, tube.mesh, solve);
            compare(row, "inner wall's displacement, mm", inner_displacement(tube, solve.equilibrium.displacement),
                expected);
            row.size = 1.0 / r.through;
            series.push_back(row);
        }
        std::vector<VerificationRow> judged;
        // one fibre direction per element: the error of the angle is proportional to the element size
        constexpr double kOrder = 2.0, kBound = 5e-3;
        append_series(judged, series, kOrder, kBound);
        return judged;
    }

} // namespace

VerificationProblem fibre_tube_problem()
{
    return { "tube with fibres",
        "a tube under 100 mmHg whose fibres wind round it, one direction per element: the radial equation, integrated",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const double angle_deg : { 0.0, 40.0 })
                for (const VerificationElement element :
                    { VerificationElement::p1, VerificationElement::locking_free, VerificationElement::p2 })
                    if (!job.cancelled())
                        for (VerificationRow& row : fibre_tube(element, angle_deg, options, job))
                            rows.push_back(std::move(row));
            return rows;
        },
        "nodal P1, a tenth off on one layer of elements (stretched tube); laws without fibres, and Guccione's, which "
        "has "
        "one family of them" };
}

} // namespace retractor::verification
