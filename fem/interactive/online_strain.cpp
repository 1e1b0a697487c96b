#include "fem/interactive/online_strain.h"

#include "fem/element/corner_gradients.h"
#include "fem/element/strain_percentile.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace retractor::fem {

namespace {

    struct Stretched {
        double strain = 0.0, volume = 0.0;
        TetId tet = 0;
    };

    Stretched stretch(const OnlineStiffness& K, const Eigen::VectorXd& u, TetId t)
    {
        const auto& v = K.tet(t);
        const CornerGradients g
            = corner_gradients(K.position(v[0]), K.position(v[1]), K.position(v[2]), K.position(v[3]));
        Mat3 F = Mat3::Identity();
        for (std::size_t a = 0; a < 4; ++a)
            F += u.segment<3>(3 * v[a]) * g.of[a].transpose();
        Eigen::SelfAdjointEigenSolver<Mat3> modes;
        modes.computeDirect(0.5 * (F.transpose() * F - Mat3::Identity()), Eigen::EigenvaluesOnly);
        return { modes.eigenvalues()[2], g.volume, t };
    }

} // namespace

StrainPeak strain_peak(const OnlineStiffness& K, const Eigen::VectorXd& displacement, std::span<const VertexId> held)
{
    if (displacement.size() != 3 * static_cast<Eigen::Index>(K.slot_count()))
        throw InputError("there must be three displacements per vertex id", "displacement");
    std::vector<std::uint8_t> hooked(K.slot_count(), 0);
    for (const VertexId v : held)
        hooked.at(static_cast<std::size_t>(v)) = 1;
    std::vector<Stretched> all;
    all.reserve(K.tet_count());
    double total = 0.0;
    for (TetId t = 0; t < static_cast<TetId>(K.tet_slots()); ++t) {
        if (!K.tet_alive(t))
            continue;
        const auto& nodes = K.tet(t);
        if (std::any_of(
                nodes.begin(), nodes.end(), [&](VertexId v) { return hooked[static_cast<std::size_t>(v)] != 0; }))
            continue;
        all.push_back(stretch(K, displacement, t));
        total += all.back().volume;
    }
    std::sort(all.begin(), all.end(), [](const Stretched& a, const Stretched& b) { return a.strain < b.strain; });
    const auto at = weighted_percentile(all, kStrainPercentile, total, [](const Stretched& s) { return s.volume; });
    if (at == all.end())
        return {};
    Vec3 middle = Vec3::Zero();
    for (const VertexId v : K.tet(at->tet))
        middle += 0.25 * K.position(v);
    return { at->strain, middle };
}

} // namespace retractor::fem
