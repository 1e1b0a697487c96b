// Validation problem 8: homogeneous states of an incompressible cube. Neo-Hookean in all states; other laws in
// uniaxial tension, where they have a closed form.

#include "tests/verification/analytic/analytic_problems.h"

#include "tests/verification/framework/meshes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kCubeMu = 0.05, kCubeBulk = 500.0; // MPa
    constexpr double kOnFace = 1e-9;

    enum class State { uniaxial, equibiaxial, shear };
    struct Case {
        State state;
        std::string name;
        double amount; ///< stretch or shear
        double exact; ///< Cauchy stress, MPa
    };

    std::vector<Case> cases()
    {
        std::vector<Case> all;
        for (const double l : { 0.7, 1.3, 1.8 })
            all.push_back({ State::uniaxial, "uniaxial", l, kCubeMu * (l * l - 1 / l) });
        for (const double l : { 1.2, 1.5 })
            all.push_back({ State::equibiaxial, "equibiaxial", l, kCubeMu * (l * l - std::pow(l, -4)) });
        for (const double g : { 0.3, 0.8 })
            all.push_back({ State::shear, "simple shear", g, kCubeMu * g });
        return all;
    }

    /// Uniaxial tension: Cauchy stress lambda dW / dlambda of an incompressible law.
    double stretched_stress(const fem::MooneyRivlin& law, double l)
    {
        return 2.0 * (l * l - 1.0 / l) * (law.c10 + law.c01 / l);
    }
    /// Fibres: both families along the stretch.
    double stretched_stress(const fem::HolzapfelGasserOgden& law, double l)
    {
        const double spread = law.dispersion, along = 1.0 - 3.0 * spread;
        const double e = spread * (l * l + 2.0 / l - 3.0) + along * (l * l - 1.0);
        // derivative of the energy of two families
        const double fibres = e > 0.0 ? 2.0 * law.k1 * e * std::exp(law.k2 * e * e) : 0.0;
        return law.mu * (l * l - 1.0 / l) + fibres * (spread * (2.0 * l * l - 2.0 / l) + 2.0 * along * l * l);
    }
    template <class Law> std::vector<Case> stretches(const Law& law)
    {
        std::vector<Case> all;
        for (const double l : { 0.7, 1.3, 1.8 })
            all.push_back({ State::uniaxial, "uniaxial", l, stretched_stress(law, l) });
        return all;
    }

    Held hold_cube(const mesh::TetMesh& mesh, const Case& c)
    {
        if (c.state == State::shear)
            return hold_boundary(mesh, [&](const Vec3& p) -> Vec3 { return { c.amount * p.z(), 0.0, 0.0 }; });
        Held held = hold_nothing(mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            for (int axis = 0; axis < 3; ++axis) {
                const bool pulled = axis == 0 || (axis == 1 && c.state == State::equibiaxial);
                if (mesh.vertices(v, axis) < kOnFace)
                    hold(held, v, axis);
                else if (pulled && mesh.vertices(v, axis) > 1.0 - kOnFace)
                    hold(held, v, axis, c.amount - 1.0);
            }
        return held;
    }

    /// Cauchy stress from the force on the face x = 1, or z = 1 in shear, and the deformed area of that face.
    double stress(const mesh::TetMesh& mesh, const Case& c, const fem::Equilibrium& result)
    {
        const int face = c.state == State::shear ? 2 : 0;
        double force = 0.0;
        Vec3 stretch = Vec3::Ones();
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            if (mesh.vertices(v, face) > 1.0 - kOnFace)
                force += result.forces[3 * v];
            for (int axis = 0; axis < 3; ++axis)
                if (mesh.vertices(v, axis) > 1.0 - kOnFace)
                    stretch[axis] = 1.0 + result.displacement[3 * v + axis];
        }
        return c.state == State::shear ? force : force / (stretch[1] * stretch[2]);
    }

    VerificationRow cube(
        VerificationElement element, const VerificationLaw& law, const Case& c, int cells, const Job& job)
    {
        const mesh::TetMesh mesh
            = mapped_box(nodes_per_tet(element), cells, cells, cells, [&](const Vec3& p) -> Vec3 { return p / cells; });
        const Held held = hold_cube(mesh, c);
        fem::ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-10 }, job);
        VerificationRow row
            = make_row(c.name + ", " + std::to_string(c.amount).substr(0, 3), element, law, mesh, solve);
        compare(row, "Cauchy stress, MPa", stress(mesh, c, solve.equilibrium), c.exact);
        row.bound = 10.0 * std::max(kCubeMu, std::abs(c.exact)) / kCubeBulk; // effect of the compressibility
        return row;
    }

} // namespace

VerificationProblem homogeneous_problem()
{
    return { "homogeneous",
        "uniaxial, equibiaxial and simple shear of a neo-Hookean cube, uniaxial of Mooney-Rivlin and "
        "Holzapfel-Gasser-Ogden ones, K / mu = 1e4, closed form",
        [](const VerificationOptions& options, const Job& job) {
            const fem::MooneyRivlin mooney { 0.3 * kCubeMu, 0.2 * kCubeMu, kCubeBulk };
            constexpr double kFibres = 0.3, kGrowth = 0.1, kDispersion = 0.1; // k1 / mu, k2, kappa
            const fem::HolzapfelGasserOgden fibres { kCubeMu, kFibres * kCubeMu, kGrowth, kDispersion, kCubeBulk };
            const std::vector<std::pair<VerificationLaw, std::vector<Case>>> laws {
                { hyperelastic_law("neo-Hookean, coupled", fem::NeoHookean { kCubeMu, kCubeBulk }), cases() },
                { hyperelastic_law("neo-Hookean", fem::MooneyRivlin { 0.5 * kCubeMu, 0.0, kCubeBulk }), cases() },
                { hyperelastic_law("Mooney-Rivlin", mooney), stretches(mooney) },
                { hyperelastic_law("Holzapfel-Gasser-Ogden", fibres), stretches(fibres) },
            };
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 })
                for (const auto& [law, states] : laws)
                    for (const Case& c : states)
                        for (const int cells : coarsest(std::vector<int> { 1, 2, 3 }, options))
                            if (!job.cancelled())
                                rows.push_back(cube(element, law, c, cells, job));
            return rows;
        },
        "linear and corotational tissue, which is for small strain; Guccione's, which stretches unlike to its sides "
        "(cardiac benchmark 1)" };
}

} // namespace retractor::verification
