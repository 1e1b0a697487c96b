#include "fem/material/hyperelasticity.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>

namespace retractor::fem {

namespace {

    double contract(const Mat3& a, const Mat3& b) { return a.cwiseProduct(b).sum(); }

    // Each distortional energy W(A) returns its value and stress, and dP[D], the derivative of the stress in the
    // direction D.

    struct MooneyRivlinShape {
        const MooneyRivlin& law;
        Mat3 A, C;
        double I1;

        MooneyRivlinShape(const MooneyRivlin& of, const FibreDirections&, const Mat3& a)
            : law(of)
            , A(a)
            , C(a.transpose() * a)
            , I1(C.trace())
        {
        }
        double energy() const
        {
            const double I2 = 0.5 * (I1 * I1 - C.squaredNorm());
            return law.c10 * (I1 - 3.0) + law.c01 * (I2 - 3.0);
        }
        Mat3 stress() const { return 2.0 * law.c10 * A + 2.0 * law.c01 * (I1 * A - A * C); }
        Mat3 along(const Mat3& D) const
        {
            return 2.0 * law.c10 * D
                + 2.0 * law.c01
                * (2.0 * contract(A, D) * A + I1 * D - D * C - A * (D.transpose() * A + A.transpose() * D));
        }
    };

    struct FibreShape {
        struct Family {
            Mat3 M; ///< e = C : M - 1
            Mat3 gradient; ///< derivative of e by A
            double slope = 0.0, curvature = 0.0; ///< derivatives of the energy by e; 0 where the fibres are slack
            double energy = 0.0;
        };
        const HolzapfelGasserOgden& law;
        Mat3 A;
        std::array<Family, 2> families;

        FibreShape(const HolzapfelGasserOgden& of, const FibreDirections& fibres, const Mat3& a)
            : law(of)
            , A(a)
        {
            const Mat3 C = a.transpose() * a;
            const std::array<Vec3, 2> directions { fibres.first, fibres.second };
            for (std::size_t i = 0; i < 2; ++i) {
                Family& f = families[i];
                f.M = law.dispersion * Mat3::Identity()
                    + (1.0 - 3.0 * law.dispersion) * directions[i] * directions[i].transpose();
                const double e = contract(C, f.M) - 1.0;
                if (e <= 0.0)
                    continue;
                const double growth = std::exp(law.k2 * e * e);
                f.energy = 0.5 * law.k1 / law.k2 * (growth - 1.0);
                f.slope = law.k1 * e * growth;
                f.curvature = law.k1 * (1.0 + 2.0 * law.k2 * e * e) * growth;
                f.gradient = 2.0 * A * f.M;
            }
        }
        double energy() const
        {
            return 0.5 * law.mu * (A.squaredNorm() - 3.0) + families[0].energy + families[1].energy;
        }
        Mat3 stress() const
        {
            Mat3 P = law.mu * A;
            for (const Family& f : families)
                if (f.curvature > 0.0)
                    P += f.slope * f.gradient;
            return P;
        }
        Mat3 along(const Mat3& D) const
        {
            Mat3 dP = law.mu * D;
            for (const Family& f : families)
                if (f.curvature > 0.0)
                    dP += f.curvature * contract(f.gradient, D) * f.gradient + 2.0 * f.slope * D * f.M;
            return dP;
        }
    };

    struct GuccioneShape {
        const Guccione& law;
        Mat3 A;
        Mat3 frame; ///< columns: the fibre direction and two directions across it
        Mat3 weighted; ///< dQ/dE = 2 weighted
        double Q, growth;
        Mat3 second_piola;

        GuccioneShape(const Guccione& of, const FibreDirections& fibres, const Mat3& a)
            : law(of)
            , A(a)
        {
            const Vec3 across = fibres.first.unitOrthogonal();
            frame << fibres.first, across, fibres.first.cross(across);
            const Mat3 E = 0.5 * (a.transpose() * a - Mat3::Identity());
            weighted = weight(E);
            Q = contract(weighted, E);
            growth = law.C * std::exp(Q);
            second_piola = growth * weighted;
        }
        Mat3 weight(const Mat3& E) const
        {
            Mat3 b;
            b << law.bf, law.bfs, law.bfs, law.bfs, law.bt, law.bt, law.bfs, law.bt, law.bt;
            return frame * b.cwiseProduct(frame.transpose() * E * frame) * frame.transpose();
        }
        double energy() const { return 0.5 * (growth - law.C); }
        Mat3 stress() const { return A * second_piola; }
        Mat3 along(const Mat3& D) const
        {
            const Mat3 dE = 0.5 * (A.transpose() * D + D.transpose() * A);
            return D * second_piola + A * (growth * (2.0 * contract(weighted, dE) * weighted + weight(dE)));
        }
    };

    /// Calls f(index of row and column, unit matrix) for each of the nine entries of F.
    template <class F> void for_each_entry(const F& f)
    {
        for (int c = 0; c < 9; ++c) {
            Mat3 D = Mat3::Zero();
            D(c / 3, c % 3) = 1.0;
            f(c, D);
        }
    }

    void set_column(TangentMatrix& tangent, int c, const Mat3& dP)
    {
        for (int r = 0; r < 9; ++r)
            tangent(r, c) = dP(r / 3, r % 3);
    }

    /// W(J^(-1/3) F) + K/2 (ln J)^2 by the chain rule.
    template <class Shape, class Law>
    HyperelasticPoint split_point(
        const Law& law, const FibreDirections& fibres, const Mat3& F, double J, bool with_tangent)
    {
        HyperelasticPoint point;
        const double g = 1.0 / std::cbrt(J), ln = std::log(J);
        const Mat3 G = F.inverse().transpose();
        const Shape shape(law, fibres, g * F);
        const Mat3 Pb = shape.stress();
        const double PbF = contract(Pb, F);
        const Mat3 distortional = g * (Pb - PbF / 3.0 * G);
        point.volume_ratio = J;
        point.energy = shape.energy() + 0.5 * law.bulk * ln * ln;
        point.stress = distortional + law.bulk * ln * G;
        if (with_tangent) {
            for_each_entry([&](int c, const Mat3& D) {
                const double h = contract(G, D);
                const Mat3 dG = -G * D.transpose() * G;
                const Mat3 dPb = shape.along(g * (D - h / 3.0 * F));
                const Mat3 dP = -h / 3.0 * distortional
                    + g * (dPb - (contract(dPb, F) + contract(Pb, D)) / 3.0 * G - PbF / 3.0 * dG)
                    + law.bulk * (h * G + ln * dG);
                set_column(point.tangent, c, dP);
            });
            point.tangent = (0.5 * (point.tangent + point.tangent.transpose())).eval();
        }
        return point;
    }

    HyperelasticPoint point_of(
        const NeoHookean& law, const FibreDirections&, const Mat3& F, double J, bool with_tangent)
    {
        HyperelasticPoint point;
        const double ln = std::log(J);
        const Mat3 G = F.inverse().transpose();
        point.volume_ratio = J;
        point.energy = 0.5 * law.mu * (F.squaredNorm() - 3.0) - law.mu * ln + 0.5 * law.lambda * ln * ln;
        point.stress = law.mu * (F - G) + law.lambda * ln * G;
        if (with_tangent)
            for_each_entry([&](int c, const Mat3& D) {
                set_column(point.tangent, c,
                    law.mu * D + law.lambda * contract(G, D) * G + (law.mu - law.lambda * ln) * G * D.transpose() * G);
            });
        return point;
    }
    HyperelasticPoint point_of(
        const MooneyRivlin& law, const FibreDirections& fibres, const Mat3& F, double J, bool with_tangent)
    {
        return split_point<MooneyRivlinShape>(law, fibres, F, J, with_tangent);
    }
    HyperelasticPoint point_of(
        const HolzapfelGasserOgden& law, const FibreDirections& fibres, const Mat3& F, double J, bool with_tangent)
    {
        return split_point<FibreShape>(law, fibres, F, J, with_tangent);
    }
    HyperelasticPoint point_of(
        const Guccione& law, const FibreDirections& fibres, const Mat3& F, double J, bool with_tangent)
    {
        return split_point<GuccioneShape>(law, fibres, F, J, with_tangent);
    }

    void must(bool good, const char* law, const std::string& parameter, double value)
    {
        if (!(good && std::isfinite(value)))
            throw InputError("the parameter " + parameter + " = " + std::to_string(value) + " is out of range", law);
    }

    void check(const NeoHookean& l)
    {
        must(l.mu > 0.0, "neo-Hookean", "mu", l.mu);
        must(l.lambda > -2.0 / 3.0 * l.mu, "neo-Hookean", "lambda", l.lambda);
    }
    void check(const MooneyRivlin& l)
    {
        must(l.c10 + l.c01 > 0.0, "Mooney-Rivlin", "c10", l.c10);
        must(l.c01 >= 0.0, "Mooney-Rivlin", "c01", l.c01);
        must(l.bulk > 0.0, "Mooney-Rivlin", "bulk", l.bulk);
    }
    void check(const HolzapfelGasserOgden& l)
    {
        constexpr const char* kName = "Holzapfel-Gasser-Ogden";
        must(l.mu > 0.0, kName, "mu", l.mu);
        must(l.k1 >= 0.0, kName, "k1", l.k1);
        must(l.k2 > 0.0, kName, "k2", l.k2);
        must(l.dispersion >= 0.0 && l.dispersion <= 1.0 / 3.0, kName, "dispersion", l.dispersion);
        must(l.bulk > 0.0, kName, "bulk", l.bulk);
    }
    void check(const Guccione& l)
    {
        must(l.C > 0.0, "Guccione", "C", l.C);
        must(l.bf > 0.0, "Guccione", "bf", l.bf);
        must(l.bt > 0.0, "Guccione", "bt", l.bt);
        must(l.bfs > 0.0, "Guccione", "bfs", l.bfs);
        must(l.bulk > 0.0, "Guccione", "bulk", l.bulk);
    }

    Lame from_bulk(double mu, double bulk) { return { mu, bulk - 2.0 / 3.0 * mu }; }
    Lame moduli(const NeoHookean& l) { return { l.mu, l.lambda }; }
    Lame moduli(const MooneyRivlin& l) { return from_bulk(2.0 * (l.c10 + l.c01), l.bulk); }
    Lame moduli(const HolzapfelGasserOgden& l) { return from_bulk(l.mu, l.bulk); }
    Lame moduli(const Guccione& l) { return from_bulk(0.5 * l.C * l.bt, l.bulk); }

} // namespace

void check_hyperelastic(const Hyperelastic& law)
{
    std::visit([](const auto& l) { check(l); }, law);
}

Hyperelastic with_bulk(Hyperelastic law, double poissons_ratio)
{
    const double mu = small_strain_moduli(law).mu;
    std::visit(
        [&](auto& l) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(l)>, NeoHookean>)
                l.bulk = 2.0 * mu * (1.0 + poissons_ratio) / (3.0 * (1.0 - 2.0 * poissons_ratio));
        },
        law);
    return law;
}

Lame small_strain_moduli(const Hyperelastic& law)
{
    return std::visit([](const auto& l) { return moduli(l); }, law);
}

HyperelasticPoint evaluate_point(
    const Hyperelastic& law, const FibreDirections& fibres, const Mat3& F, bool with_tangent)
{
    const double J = F.determinant();
    if (!(J > 0.0)) {
        HyperelasticPoint point;
        point.energy = std::numeric_limits<double>::infinity();
        point.volume_ratio = J;
        return point;
    }
    return std::visit([&](const auto& l) { return point_of(l, fibres, F, J, with_tangent); }, law);
}

void lift_negative(TangentMatrix& tangent, double projected)
{
    RETRACTOR_ASSERT(projected >= 0.0 && projected <= 1.0);
    if (projected == 0.0 || tangent.llt().info() == Eigen::Success)
        return;
    const Eigen::SelfAdjointEigenSolver<TangentMatrix> eigen(tangent);
    const Eigen::Matrix<double, 9, 1> lift = projected * (-eigen.eigenvalues()).cwiseMax(0.0);
    tangent += eigen.eigenvectors() * lift.asDiagonal() * eigen.eigenvectors().transpose();
}

} // namespace retractor::fem
