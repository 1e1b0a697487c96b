#include "fem/element/corotational_elements.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace retractor::fem {

namespace {

    constexpr std::size_t kPack = CorotationalElements::kPack;

    // Operations on all lanes. GCC and Clang compile them for the instruction set of the function that inlines them.
    using Wide = double __attribute__((vector_size(kPack * sizeof(double))));
    using WideMat3 = Wide[3][3];
#define RETRACTOR_INLINED __attribute__((always_inline)) inline

    RETRACTOR_INLINED void load(Wide& to, const CorotationalElements::Lanes& lanes)
    {
        std::memcpy(&to, lanes.data(), sizeof(Wide));
    }

    RETRACTOR_INLINED void gather(Wide& to, const double* from, const std::array<std::int32_t, kPack>& place)
    {
        CorotationalElements::Lanes lanes;
        for (std::size_t l = 0; l < kPack; ++l)
            lanes[l] = from[place[l]];
        load(to, lanes);
    }

    RETRACTOR_INLINED void square_root(Wide& x)
    {
        for (std::size_t l = 0; l < kPack; ++l)
            x[l] = std::sqrt(x[l]);
    }

    RETRACTOR_INLINED void cofactors(WideMat3& c, const WideMat3& a)
    {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
                c[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
            }
    }

    RETRACTOR_INLINED void squared_norm(Wide& sum, const WideMat3& a)
    {
        sum = a[0][0] * a[0][0];
        for (int k = 1; k < 9; ++k)
            sum += a[k / 3][k % 3] * a[k / 3][k % 3];
    }

    /// In lanes without an approximate rotation, the singular values give the rotation.
    void by_singular_values(double (&R)[9], const double (&F)[9])
    {
        const SignedSvd svd = signed_svd(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(F));
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(R);
        rotation = svd.U * svd.V.transpose();
    }

    /// The rotations nearest to F, one per lane.
    RETRACTOR_INLINED void rotations(WideMat3& R, const WideMat3& F)
    {
        constexpr int kMostSteps = 12;
        constexpr double kScaled = 1e-2; // squared step below which scaling by the norms has no use
        constexpr double kConverged = 1e-15; // squared step after which the next step would be below round-off
        constexpr double kFlat = 1e-6; // det F relative to the size of F, below which the iteration loses digits
        for (int k = 0; k < 9; ++k)
            R[k / 3][k % 3] = F[k / 3][k % 3];
        bool found[kPack] = {};
        bool scaled = true;
        for (int step = 0; step < kMostSteps; ++step) {
            WideMat3 c;
            cofactors(c, R);
            const Wide det = R[0][0] * c[0][0] + R[0][1] * c[0][1] + R[0][2] * c[0][2];
            Wide mine, others;
            squared_norm(mine, R);
            squared_norm(others, c);
            if (step == 0)
                for (std::size_t l = 0; l < kPack; ++l)
                    found[l] = det[l] > kFlat * mine[l] * std::sqrt(mine[l]);
            Wide a = mine * 0.0 + 0.5, b = 0.5 / det;
            if (scaled) { // g^2 = |X^-1| / |X|
                Wide g = others / (det * det * mine);
                square_root(g);
                square_root(g);
                a *= g;
                b /= g;
            }
            Wide change = a * 0.0;
            for (int k = 0; k < 9; ++k) {
                Wide& x = R[k / 3][k % 3];
                const Wide next = a * x + b * c[k / 3][k % 3];
                change += (next - x) * (next - x);
                x = next;
            }
            double largest = 0.0;
            for (std::size_t l = 0; l < kPack; ++l)
                if (found[l])
                    largest = std::max(largest, change[l]);
            if (largest < kConverged)
                break;
            scaled = largest > kScaled;
            if (step + 1 == kMostSteps)
                for (std::size_t l = 0; l < kPack; ++l)
                    found[l] = found[l] && change[l] < kConverged;
        }
        for (std::size_t l = 0; l < kPack; ++l)
            if (!found[l]) {
                double f[9], r[9];
                for (int k = 0; k < 9; ++k)
                    f[k] = F[k / 3][k % 3][l];
                by_singular_values(r, f);
                for (int k = 0; k < 9; ++k)
                    R[k / 3][k % 3][l] = r[k];
            }
    }

    RETRACTOR_INLINED double add_packs(
        const CorotationalElements::Pack* packs, std::size_t count, const double* u, double* forces)
    {
        Wide energies = {};
        for (std::size_t p = 0; p < count; ++p) {
            const CorotationalElements::Pack& pack = packs[p];
            WideMat3 g; // node, axis
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t j = 0; j < 3; ++j)
                    load(g[a][j], pack.gradient[a][j]);
            WideMat3 F;
            for (int i = 0; i < 3; ++i) {
                Wide from, moved[3];
                gather(from, u + i, pack.unknown[0]);
                for (std::size_t a = 0; a < 3; ++a) {
                    gather(moved[a], u + i, pack.unknown[a + 1]);
                    moved[a] -= from;
                }
                for (int j = 0; j < 3; ++j)
                    F[i][j] = moved[0] * g[0][j] + moved[1] * g[1][j] + moved[2] * g[2][j] + (i == j ? 1.0 : 0.0);
            }
            WideMat3 R;
            rotations(R, F);
            Wide volume, mu, lambda;
            load(volume, pack.volume);
            load(mu, pack.mu);
            load(lambda, pack.lambda);
            Wide square = mu * 0.0, trace = square; // |F - R|^2 and tr(R^T F - I)
            for (int k = 0; k < 9; ++k) {
                const Wide d = F[k / 3][k % 3] - R[k / 3][k % 3];
                square += d * d;
                trace += d * R[k / 3][k % 3];
            }
            // As corotational_linear_volumetric(): the pressure stays below its bound.
            const Wide largest = kLargestCorotationalLinearPressure * mu, free = lambda * trace;
            Wide slope = free, volumetric = 0.5 * free * trace;
            for (std::size_t l = 0; l < kPack; ++l)
                if (free[l] > largest[l]) {
                    slope[l] = largest[l];
                    volumetric[l] = largest[l] * (trace[l] - 0.5 * largest[l] / lambda[l]);
                }
            energies += volume * (mu * square + volumetric);
            const Wide twice = 2.0 * mu * volume, turned = (slope - 2.0 * mu) * volume;
            for (int i = 0; i < 3; ++i) {
                Wide P[3];
                for (int j = 0; j < 3; ++j)
                    P[j] = twice * F[i][j] + turned * R[i][j];
                Wide sum = mu * 0.0;
                for (std::size_t a = 0; a < 3; ++a) {
                    const Wide f = P[0] * g[a][0] + P[1] * g[a][1] + P[2] * g[a][2];
                    sum += f;
                    for (std::size_t l = 0; l < kPack; ++l)
                        forces[pack.unknown[a + 1][l] + i] += f[l];
                }
                for (std::size_t l = 0; l < kPack; ++l)
                    forces[pack.unknown[0][l] + i] -= sum[l];
            }
        }
        double energy = 0.0;
        for (std::size_t l = 0; l < kPack; ++l)
            energy += energies[l];
        return energy;
    }

    double add_packs_plainly(
        const CorotationalElements::Pack* packs, std::size_t count, const double* u, double* forces)
    {
        return add_packs(packs, count, u, forces);
    }

#if defined(__x86_64__)
    __attribute__((target("avx2,fma"))) double add_packs_by_avx2(
        const CorotationalElements::Pack* packs, std::size_t count, const double* u, double* forces)
    {
        return add_packs(packs, count, u, forces);
    }
    bool has_avx2() { return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0; }
#endif

#undef RETRACTOR_INLINED

} // namespace

CorotationalElements::CorotationalElements(const mesh::TetMesh& mesh, const std::vector<double>& gradients,
    const std::vector<double>& volumes, const std::vector<Lame>& lame)
{
    packs_.resize((mesh.tet_count() + kPack - 1) / kPack, Pack {});
    for (std::size_t e = 0; e < packs_.size() * kPack; ++e) {
        const std::size_t t = std::min(e, mesh.tet_count() - 1), lane = e % kPack;
        Pack& pack = packs_[e / kPack];
        const auto nodes = mesh.tet(static_cast<TetId>(t));
        for (std::size_t a = 0; a < 4; ++a)
            pack.unknown[a][lane] = 3 * nodes[a];
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t j = 0; j < 3; ++j)
                pack.gradient[a][j][lane] = gradients[12 * t + 3 * (a + 1) + j];
        pack.volume[lane] = e == t ? volumes[t] : 0.0;
        pack.mu[lane] = lame[t].mu;
        pack.lambda[lane] = lame[t].lambda;
    }
}

double CorotationalElements::add_response(
    const Eigen::VectorXd& displacement, std::size_t first, std::size_t end, Eigen::VectorXd& forces) const
{
    const auto count = end - first;
#if defined(__x86_64__)
    static const bool wide = has_avx2();
    if (wide)
        return add_packs_by_avx2(packs_.data() + first, count, displacement.data(), forces.data());
#endif
    return add_packs_plainly(packs_.data() + first, count, displacement.data(), forces.data());
}

} // namespace retractor::fem
