#include "fem/material/elasticity.h"

#include "mesh/base/assert.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace retractor::fem {

namespace {

    // Tissue at half its volume is crushed: no measurement supports the model there. Without the penalty, elements at
    // the rim of a hook patch turn over at little cost in energy. A hundred times the P-wave modulus keeps det F
    // above zero where hooks pull fat across a neighbouring rib, and at the tip of a cut that is opened by 50 mm;
    // thirty times left four elements inside out there, with as many Newton steps.
    constexpr double kCrushed = 0.5;
    constexpr double kCrushPenalty = 100.0;

    /// The volumetric energy and its derivatives by J = det F: lambda/2 (J - 1)^2, and below kCrushed a cubic penalty.
    struct Volumetric {
        double energy, slope, curvature;
    };

    Volumetric volumetric(const Lame& l, double J)
    {
        const double d = J - 1.0, c = std::max(kCrushed - J, 0.0), k = kCrushPenalty * (l.lambda + 2.0 * l.mu);
        return { 0.5 * l.lambda * d * d + k * c * c * c / 3.0, l.lambda * d - k * c * c, l.lambda + 2.0 * k * c };
    }

    /// The volumetric energy of the corotational_linear model and its derivatives by the trace of S - I.
    Volumetric corotational_linear_volumetric(const Lame& l, double trace)
    {
        const double largest = kLargestCorotationalLinearPressure * l.mu, pressure = l.lambda * trace;
        if (pressure <= largest)
            return { 0.5 * pressure * trace, pressure, l.lambda };
        return { largest * (trace - 0.5 * largest / l.lambda), largest, 0.0 };
    }

    /// Derivatives of the energy by the signed singular values.
    Vec3 principal_stress(Elasticity model, const Lame& l, const Vec3& s)
    {
        if (model == Elasticity::corotational_linear)
            return (2.0 * l.mu * (s.array() - 1.0) + corotational_linear_volumetric(l, s.sum() - 3.0).slope).matrix();
        const double slope = volumetric(l, s.prod()).slope;
        return { 2.0 * l.mu * (s[0] - 1.0) + slope * s[1] * s[2], 2.0 * l.mu * (s[1] - 1.0) + slope * s[2] * s[0],
            2.0 * l.mu * (s[2] - 1.0) + slope * s[0] * s[1] };
    }

    double principal_energy(Elasticity model, const Lame& l, const Vec3& s)
    {
        const Volumetric volume = model == Elasticity::corotational_linear
            ? corotational_linear_volumetric(l, s.sum() - 3.0)
            : volumetric(l, s.prod());
        return l.mu * (s - Vec3::Ones()).squaredNorm() + volume.energy;
    }

    bool positive_definite(const Mat3& a)
    {
        const double minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
        return a(0, 0) > 0.0 && minor > 0.0 && a.determinant() > 0.0;
    }

    void project(Mat3& a, double share)
    {
        if (share == 0.0 || positive_definite(a))
            return;
        const Eigen::SelfAdjointEigenSolver<Mat3> eigen(a);
        const Vec3 lift = share * (-eigen.eigenvalues()).cwiseMax(0.0);
        a += eigen.eigenvectors() * lift.asDiagonal() * eigen.eigenvectors().transpose();
    }

    constexpr double kKink = 1e-9; // width of the energies' kink at sigma_i + sigma_j = 0

    Tangent corotational_linear_tangent(const Lame& l, const SignedSvd& svd, double projected)
    {
        const Vec3& s = svd.sigma;
        const Volumetric volume = corotational_linear_volumetric(l, s.sum() - 3.0);
        Tangent t { svd.U, svd.V, Mat3::Constant(volume.curvature), Vec3::Zero(), Vec3::Zero() };
        t.scaling.diagonal().array() += 2.0 * l.mu;
        for (int k = 0; k < 3; ++k) {
            const double sum = std::max(s[(k + 1) % 3] + s[(k + 2) % 3], kKink);
            const double flip = 2.0 * l.mu;
            double twist = 2.0 * l.mu + 2.0 * (volume.slope - 2.0 * l.mu) / sum;
            twist += projected * std::max(-twist, 0.0);
            t.same[k] = 0.5 * (flip + twist);
            t.cross[k] = 0.5 * (flip - twist);
        }
        return t;
    }

    Tangent corotational_tangent(const Lame& l, const SignedSvd& svd, double projected)
    {
        const Vec3& s = svd.sigma;
        const Volumetric volume = volumetric(l, s.prod());
        const Vec3 cofactor(s[1] * s[2], s[2] * s[0], s[0] * s[1]);
        Tangent t { svd.U, svd.V, volume.curvature * cofactor * cofactor.transpose(), Vec3::Zero(), Vec3::Zero() };
        for (int k = 0; k < 3; ++k) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            t.scaling(k, k) += 2.0 * l.mu;
            t.scaling(i, j) += volume.slope * s[k];
            t.scaling(j, i) += volume.slope * s[k];
            double flip = 2.0 * l.mu - volume.slope * s[k];
            double twist = 2.0 * l.mu * (1.0 - 2.0 / std::max(s[i] + s[j], kKink)) + volume.slope * s[k];
            flip += projected * std::max(-flip, 0.0);
            twist += projected * std::max(-twist, 0.0);
            t.same[k] = 0.5 * (flip + twist);
            t.cross[k] = 0.5 * (flip - twist);
        }
        project(t.scaling, projected);
        return t;
    }

    Tangent rotating_tangent(Elasticity model, const Lame& l, const SignedSvd& svd, double projected)
    {
        return model == Elasticity::corotational_linear ? corotational_linear_tangent(l, svd, projected)
                                                        : corotational_tangent(l, svd, projected);
    }

    Tangent linear_tangent(const Lame& l)
    {
        Tangent t { Mat3::Identity(), Mat3::Identity(), Mat3::Constant(l.lambda), Vec3::Constant(l.mu),
            Vec3::Constant(l.mu) };
        t.scaling.diagonal().array() += 2.0 * l.mu;
        return t;
    }

    Mat3 small_strain(const Mat3& F) { return 0.5 * (F + F.transpose()) - Mat3::Identity(); }

    Vec3 any_perpendicular(const Vec3& u)
    {
        Vec3 axis = Vec3::Zero();
        Eigen::Index least = 0;
        u.cwiseAbs().minCoeff(&least);
        axis[least] = 1.0;
        return u.cross(axis).normalized();
    }

    /// Sorts columns by falling length. Each swap reverses one column, so that V stays a rotation.
    void sort_columns(Mat3& B, Mat3& V)
    {
        const auto order = [&](int p, int q) {
            if (B.col(p).squaredNorm() >= B.col(q).squaredNorm())
                return;
            B.col(p).swap(B.col(q));
            V.col(p).swap(V.col(q));
            B.col(q) *= -1.0;
            V.col(q) *= -1.0;
        };
        order(0, 1);
        order(1, 2);
        order(0, 1);
    }

    /// Derivative of det F by F: det F times the inverse transposed.
    Mat3 cofactors(const Mat3& F)
    {
        Mat3 C;
        C << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
        return C;
    }

    /// The rotation of the polar decomposition F = R S by Newton's method (Higham 1986, SIAM J Sci Stat Comput 7:1160),
    /// a fifth of the work of a singular value decomposition. Nothing where F is turned over or nearly singular.
    std::optional<Mat3> polar_rotation(const Mat3& F)
    {
        constexpr double kNearlySingular = 1e-3; // det F, where the first steps are long
        constexpr double kClose = 1e-16; // squared length of a step, after which the error is below round-off
        constexpr int kMostSteps = 12;
        Mat3 R = F;
        for (int step = 0; step < kMostSteps; ++step) {
            const Mat3 C = cofactors(R);
            const double det = R.col(0).dot(C.col(0));
            if (!(det > kNearlySingular))
                return std::nullopt;
            const Mat3 next = 0.5 * (R + C / det);
            const double moved = (next - R).squaredNorm();
            R = next;
            if (moved <= kClose)
                return R;
        }
        return std::nullopt;
    }

    /// Energy and stress of a rotating model without the tangent, from the rotation alone.
    void respond_with_rotation(Elasticity model, const Lame& l, const Mat3& F, const Mat3& R, PointResponse& response)
    {
        const Mat3 stretched = F - R;
        const bool by_trace = model == Elasticity::corotational_linear;
        const Volumetric volume = by_trace ? corotational_linear_volumetric(l, R.cwiseProduct(F).sum() - 3.0)
                                           : volumetric(l, response.volume_ratio);
        response.energy = l.mu * stretched.squaredNorm() + volume.energy;
        response.stress = 2.0 * l.mu * stretched + volume.slope * (by_trace ? R : cofactors(F));
    }

    /// Rotates columns p and q until the columns of B are perpendicular. @return false when the columns are so nearly
    /// perpendicular that a sweep of such rotations leaves only round-off (convergence is quadratic)
    bool jacobi_rotate(Mat3& B, Mat3& V, int p, int q)
    {
        const double alpha = B.col(p).squaredNorm(), beta = B.col(q).squaredNorm(), gamma = B.col(p).dot(B.col(q));
        constexpr double kPerpendicular = std::numeric_limits<double>::epsilon(); // cosine of the angle between columns
        if (gamma == 0.0 || gamma * gamma <= kPerpendicular * kPerpendicular * alpha * beta)
            return false;
        const double zeta = (beta - alpha) / (2.0 * gamma);
        const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = c * t;
        for (Mat3* M : { &B, &V }) {
            const Vec3 old = M->col(p);
            M->col(p) = c * old - s * M->col(q);
            M->col(q) = s * old + c * M->col(q);
        }
        constexpr double kLastSweep = 1e-8; // tangent of the angle of rotation
        return std::abs(t) > kLastSweep;
    }

} // namespace

SignedSvd signed_svd(const Mat3& F)
{
    Mat3 B = F, V = Mat3::Identity();
    constexpr int kMaxSweeps = 16; // convergence is quadratic: three to five sweeps in practice
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        const bool a = jacobi_rotate(B, V, 0, 1), b = jacobi_rotate(B, V, 0, 2), c = jacobi_rotate(B, V, 1, 2);
        if (!a && !b && !c)
            break;
    }
    sort_columns(B, V);
    SignedSvd svd { Mat3::Identity(), V, Vec3::Zero() };
    const double largest = B.col(0).norm();
    if (!(largest > 0.0))
        return svd;
    // below this ratio the second direction is round-off, and any perpendicular direction serves
    constexpr double kRankOne = 1e-13;
    const Vec3 u0 = B.col(0) / largest;
    const Vec3 rest = B.col(1) - u0 * u0.dot(B.col(1));
    const Vec3 u1 = rest.norm() > kRankOne * largest ? Vec3(rest.normalized()) : any_perpendicular(u0);
    const Vec3 u2 = u0.cross(u1);
    svd.U << u0, u1, u2;
    svd.sigma << largest, u1.dot(B.col(1)), u2.dot(B.col(2));
    return svd;
}

Tangent tangent(Elasticity model, const Lame& l, const Mat3& F, double projected)
{
    RETRACTOR_ASSERT(model != Elasticity::hyperelastic && projected >= 0.0 && projected <= 1.0);
    return model == Elasticity::linear ? linear_tangent(l) : rotating_tangent(model, l, signed_svd(F), projected);
}

Tangent tangent_raised_at_extremes(Elasticity model, const Lame& l, const Mat3& F, double projected)
{
    constexpr double kLongest = 2.0, kShortest = 0.5; // singular values
    RETRACTOR_ASSERT(model != Elasticity::hyperelastic && projected >= 0.0 && projected <= 1.0);
    if (model == Elasticity::linear)
        return linear_tangent(l);
    const SignedSvd svd = signed_svd(F);
    const bool extreme = svd.sigma[0] > kLongest || svd.sigma[2] < kShortest;
    return rotating_tangent(model, l, svd, extreme ? 1.0 : projected);
}

TangentMatrix tangent_matrix(const Tangent& t)
{
    TangentMatrix matrix;
    for (int c = 0; c < 9; ++c) {
        Mat3 dF = Mat3::Zero();
        dF(c / 3, c % 3) = 1.0;
        const Mat3 d = t.U.transpose() * dF * t.V;
        Mat3 dP;
        dP.diagonal() = t.scaling * d.diagonal();
        for (int k = 0; k < 3; ++k) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            dP(i, j) = t.same[k] * d(i, j) + t.cross[k] * d(j, i);
            dP(j, i) = t.same[k] * d(j, i) + t.cross[k] * d(i, j);
        }
        dP = (t.U * dP * t.V.transpose()).eval();
        for (int r = 0; r < 9; ++r)
            matrix(r, c) = dP(r / 3, r % 3);
    }
    return matrix;
}

PointResponse evaluate_point(Elasticity model, const Lame& l, const Mat3& F, bool with_tangent)
{
    RETRACTOR_ASSERT(model != Elasticity::hyperelastic);
    PointResponse response;
    response.volume_ratio = F.determinant();
    if (model == Elasticity::linear) {
        const Mat3 e = small_strain(F);
        response.energy = l.mu * e.squaredNorm() + 0.5 * l.lambda * e.trace() * e.trace();
        response.stress = 2.0 * l.mu * e + l.lambda * e.trace() * Mat3::Identity();
        if (with_tangent)
            response.tangent = linear_tangent(l);
        return response;
    }
    if (!with_tangent)
        if (const std::optional<Mat3> R = polar_rotation(F)) {
            respond_with_rotation(model, l, F, *R, response);
            return response;
        }
    const SignedSvd svd = signed_svd(F);
    response.energy = principal_energy(model, l, svd.sigma);
    response.stress = svd.U * principal_stress(model, l, svd.sigma).asDiagonal() * svd.V.transpose();
    if (with_tangent)
        response.tangent = rotating_tangent(model, l, svd, 1.0);
    return response;
}

} // namespace retractor::fem
