#include "fem/element/locking_free.h"

#include "fem/element/tet_element.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace retractor::fem {

namespace {

    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

    struct Volumetric {
        double energy, slope, curvature;
    };

    Volumetric volumetric(Elasticity model, double k, double J)
    {
        if (model != Elasticity::hyperelastic)
            return { 0.5 * k * (J - 1.0) * (J - 1.0), k * (J - 1.0), k };
        if (!(J > 0.0))
            return { std::numeric_limits<double>::infinity(), 0.0, 0.0 };
        const double ln = std::log(J);
        return { 0.5 * k * ln * ln, k * ln / J, k * (1.0 - ln) / (J * J) };
    }

    double take_volumetric_part(PointLaw& law)
    {
        if (law.model != Elasticity::hyperelastic)
            return std::exchange(law.lame.lambda, 0.0);
        return std::visit(
            [](auto& l) {
                if constexpr (requires { l.bulk; })
                    return std::exchange(l.bulk, 0.0);
                else
                    return std::exchange(l.lambda, 0.0);
            },
            law.hyperelastic);
    }

    double volume_ratio(Elasticity model, const Mat3& F)
    {
        return model == Elasticity::linear ? F.trace() - 2.0 : F.determinant();
    }

    /// Derivative of the volume ratio det F by F.
    Mat3 cofactor(Elasticity model, const Mat3& F)
    {
        if (model == Elasticity::linear)
            return Mat3::Identity();
        Mat3 c;
        c << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
        return c;
    }

    /// Adds p times the second derivative of det F.
    void add_cofactor_derivative(double p, const Mat3& F, TangentMatrix& tangent)
    {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
                tangent(3 * i + j, 3 * i1 + j1) += p * F(i2, j2);
                tangent(3 * i + j, 3 * i2 + j2) += p * F(i1, j1);
                tangent(3 * i + j, 3 * i1 + j2) -= p * F(i2, j1);
                tangent(3 * i + j, 3 * i2 + j1) -= p * F(i1, j2);
            }
    }

    struct Shape {
        double energy;
        Mat3 stress;
    };

    Shape shape_response(const PointLaw& law, const FibreDirections& fibres, const Mat3& F)
    {
        if (law.model == Elasticity::hyperelastic) {
            const HyperelasticPoint point = evaluate_point(law.hyperelastic, fibres, F, false);
            return { point.energy, point.stress };
        }
        const PointResponse point = evaluate_point(law.model, law.lame, F, false);
        return { point.energy, point.stress };
    }

    TangentMatrix shape_tangent(
        const PointLaw& law, const FibreDirections& fibres, const Mat3& F, double pressure, double projected)
    {
        if (law.model == Elasticity::linear)
            return tangent_matrix(tangent(law.model, law.lame, F, 0.0));
        TangentMatrix matrix = law.model == Elasticity::hyperelastic
            ? evaluate_point(law.hyperelastic, fibres, F, true).tangent
            : tangent_matrix(tangent(law.model, law.lame, F, 0.0));
        add_cofactor_derivative(pressure, F, matrix);
        lift_negative(matrix, projected);
        return matrix;
    }

    void add_block(double* values, std::int32_t target, const RowMat3& block)
    {
        if (target >= 0)
            Eigen::Map<RowMat3>(values + 9 * static_cast<std::size_t>(target)) += block;
        else
            Eigen::Map<RowMat3>(values + 9 * static_cast<std::size_t>(~target)) += block.transpose();
    }

    std::size_t pairs(std::size_t nodes) { return nodes * (nodes + 1) / 2; }

    template <class T> void sort_unique(std::vector<T>& v)
    {
        std::sort(v.begin(), v.end());
        v.erase(std::unique(v.begin(), v.end()), v.end());
    }

} // namespace

struct LockingFree::Elements {
    std::vector<Eigen::Matrix<double, 4, 3>> gradients;
    std::vector<double> volume; ///< mm^3
};

namespace {

    // share of the distortional energy; also FEBio's default for its stabilisation
    constexpr double kElementShare = 0.05;

    LockingFree::Elements measure(const mesh::TetMesh& mesh)
    {
        LockingFree::Elements elements;
        NodeGradients rest(4, 3);
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            const auto nodes = mesh.tet(static_cast<TetId>(t));
            for (std::size_t a = 0; a < 4; ++a)
                rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
            const ShapeGradients shape = shape_gradients(rest, quadrature(4)[0]);
            elements.gradients.emplace_back(shape.gradients);
            elements.volume.push_back(shape.volume);
        }
        return elements;
    }

    /// Disjoint patches of at most eight elements of one law round a vertex, chosen greedily.
    /// @return the patch of each element, identified by the number of the patch's first element.
    std::vector<std::int32_t> patches(const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law)
    {
        constexpr std::size_t kMost = 8; // refining one element gives eight
        std::vector<std::vector<std::int32_t>> around(mesh.vertex_count());
        for (std::size_t t = 0; t < mesh.tet_count(); ++t)
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                around[static_cast<std::size_t>(v)].push_back(static_cast<std::int32_t>(t));
        std::vector<std::int32_t> owner(mesh.tet_count(), -1);
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            if (owner[t] >= 0)
                continue;
            std::vector<std::int32_t> best;
            for (const VertexId v : mesh.tet(static_cast<TetId>(t))) {
                std::vector<std::int32_t> open;
                for (const std::int32_t e : around[static_cast<std::size_t>(v)])
                    if (owner[static_cast<std::size_t>(e)] < 0 && law[static_cast<std::size_t>(e)] == law[t])
                        open.push_back(e);
                if (open.size() > best.size())
                    best = std::move(open);
            }
            owner[t] = static_cast<std::int32_t>(t);
            for (std::size_t i = 0; i < best.size() && i < kMost; ++i)
                owner[static_cast<std::size_t>(best[i])] = static_cast<std::int32_t>(t);
        }
        return owner;
    }

    /// The patch that contains most of a domain's volume; the first one among equals.
    std::int32_t patch_of(const std::vector<TetId>& tets, const std::vector<std::int32_t>& patch,
        const std::vector<double>& volume_of_element)
    {
        constexpr double kMore = 1.0 + 1e-9; // volumes that differ by round-off count as equal
        std::map<std::int32_t, double> volume;
        for (const TetId t : tets)
            volume[patch[static_cast<std::size_t>(t)]] += volume_of_element[static_cast<std::size_t>(t)];
        auto best = volume.begin();
        for (auto at = volume.begin(); at != volume.end(); ++at)
            if (at->second > kMore * best->second)
                best = at;
        return best->first;
    }

    Vec3 mean_direction(const AveragingDomain& domain, const std::vector<FibreDirections>& fibres,
        const LockingFree::Elements& elements, Vec3 FibreDirections::*which)
    {
        Vec3 sum = Vec3::Zero();
        const Vec3 first = fibres[static_cast<std::size_t>(domain.tets[0])].*which;
        for (const TetId t : domain.tets) { // a fibre has no sign: both directions are equivalent
            const Vec3& d = fibres[static_cast<std::size_t>(t)].*which;
            sum += elements.volume[static_cast<std::size_t>(t)] * (d.dot(first) < 0.0 ? -d : d);
        }
        return sum.normalized();
    }

} // namespace

std::vector<AveragingDomain> edge_patch_domains(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume)
{
    using EdgeKey = std::array<std::int32_t, 3>; // two vertices of the edge, and the law
    std::vector<std::pair<EdgeKey, TetId>> all;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto nodes = mesh.tet(static_cast<TetId>(t));
        for (const auto& [i, j] : mesh::kTetEdges) {
            const VertexId a = nodes[static_cast<std::size_t>(i)], b = nodes[static_cast<std::size_t>(j)];
            all.push_back({ { std::min(a, b), std::max(a, b), law_of_element[t] }, static_cast<TetId>(t) });
        }
    }
    std::sort(all.begin(), all.end());
    constexpr double kPart = 1.0 / 6.0; // an element has six edges
    std::vector<AveragingDomain> domains;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (i == 0 || all[i].first != all[i - 1].first)
            domains.push_back({ .law = all[i].first[2], .part = kPart });
        domains.back().tets.push_back(all[i].second);
    }
    const std::vector<std::int32_t> patch = patches(mesh, law_of_element);
    for (AveragingDomain& domain : domains)
        domain.patch = patch_of(domain.tets, patch, volume);
    return domains;
}

LockingFree::LockingFree(const mesh::TetMesh& mesh, const AveragingScheme& scheme, std::vector<PointLaw> laws,
    const std::vector<std::int32_t>& law_of_element, const std::vector<FibreDirections>& fibres)
    : node_count_(mesh.vertex_count())
    , laws_(std::move(laws))
    , share_(1.0 / (1.0 - kElementShare))
{
    if (mesh.nodes_per_tet != 4)
        throw InputError("averaging strain is for four-node elements; ten-node ones do not lock", "mesh");
    for (PointLaw& law : laws_)
        stiffness_.push_back(take_volumetric_part(law));
    const Elements elements = measure(mesh);
    std::vector<std::pair<std::array<std::int32_t, 2>, std::int32_t>> members; // (patch, law), strain point
    for (const AveragingDomain& domain : scheme(mesh, law_of_element, elements.volume)) {
        const std::int32_t point = add_point(mesh, elements, domain, 1.0 - kElementShare, fibres);
        members.push_back({ { domain.patch, domain.law }, point });
    }
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        (void)add_point(mesh, elements,
            { .law = law_of_element[static_cast<std::size_t>(t)], .part = 1.0, .tets = { t } }, kElementShare, fibres);
    gather_volumes(std::move(members));
}

std::int32_t LockingFree::add_point(const mesh::TetMesh& mesh, const Elements& elements, const AveragingDomain& domain,
    double scale, const std::vector<FibreDirections>& fibres)
{
    RETRACTOR_ASSERT(!domain.tets.empty());
    std::vector<VertexId> nodes;
    double weight = 0.0;
    for (const TetId t : domain.tets) {
        const auto own = mesh.tet(t);
        nodes.insert(nodes.end(), own.begin(), own.end());
        weight += domain.part * elements.volume[static_cast<std::size_t>(t)];
    }
    sort_unique(nodes);
    const std::size_t begin = gradients_.size();
    gradients_.resize(begin + 3 * nodes.size(), 0.0);
    for (const TetId t : domain.tets)
        for (std::size_t a = 0; a < 4; ++a) {
            const auto local = static_cast<std::size_t>(
                std::lower_bound(nodes.begin(), nodes.end(), mesh.tet(t)[a]) - nodes.begin());
            const auto i = static_cast<std::size_t>(t);
            Eigen::Map<Vec3>(gradients_.data() + begin + 3 * local) += domain.part * elements.volume[i] / weight
                * elements.gradients[i].row(static_cast<Eigen::Index>(a)).transpose();
        }
    points_.node.insert(points_.node.end(), nodes.begin(), nodes.end());
    points_.start.push_back(static_cast<std::int32_t>(points_.node.size()));
    weights_.push_back(scale * weight);
    law_of_point_.push_back(domain.law);
    fibres_.push_back(fibres.empty()
            ? FibreDirections {}
            : FibreDirections { mean_direction(domain, fibres, elements, &FibreDirections::first),
                mean_direction(domain, fibres, elements, &FibreDirections::second) });
    return static_cast<std::int32_t>(weights_.size()) - 1;
}

void LockingFree::gather_volumes(std::vector<std::pair<std::array<std::int32_t, 2>, std::int32_t>> members)
{
    std::sort(members.begin(), members.end());
    member_start_.push_back(0);
    for (std::size_t i = 0; i < members.size();) {
        std::vector<VertexId> nodes;
        double volume = 0.0;
        law_of_domain_.push_back(members[i].first[1]);
        const std::array<std::int32_t, 2> key = members[i].first;
        for (; i < members.size() && members[i].first == key; ++i) {
            const auto p = static_cast<std::size_t>(members[i].second);
            const auto own = points_.nodes(p);
            nodes.insert(nodes.end(), own.begin(), own.end());
            volume += share_ * weights_[p];
            member_.push_back(members[i].second);
        }
        sort_unique(nodes);
        member_start_.push_back(static_cast<std::int32_t>(member_.size()));
        domains_.node.insert(domains_.node.end(), nodes.begin(), nodes.end());
        domains_.start.push_back(static_cast<std::int32_t>(domains_.node.size()));
        domain_volume_.push_back(volume);
    }
}

Mat3 LockingFree::deformation_gradient(const Eigen::VectorXd& u, std::size_t point) const
{
    RETRACTOR_ASSERT(point < points_.count());
    Mat3 F = Mat3::Identity();
    for (auto i = points_.start[point]; i < points_.start[point + 1]; ++i)
        F.noalias() += u.segment<3>(3 * static_cast<Eigen::Index>(points_.node[static_cast<std::size_t>(i)]))
            * Eigen::Map<const Eigen::RowVector3d>(gradients_.data() + 3 * static_cast<std::size_t>(i));
    return F;
}

LockingFree::VolumeState LockingFree::volumes(const Eigen::VectorXd& u) const
{
    std::vector<double> ratio(weights_.size());
    parallel_halves(weights_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p)
            ratio[p]
                = volume_ratio(laws_[static_cast<std::size_t>(law_of_point_[p])].model, deformation_gradient(u, p));
    });
    VolumeState state;
    state.pressure.assign(weights_.size(), 0.0);
    for (std::size_t d = 0; d < domain_volume_.size(); ++d) {
        double volume = 0.0;
        for (auto i = member_start_[d]; i < member_start_[d + 1]; ++i) {
            const auto p = static_cast<std::size_t>(member_[static_cast<std::size_t>(i)]);
            volume += share_ * weights_[p] * ratio[p];
        }
        const auto law = static_cast<std::size_t>(law_of_domain_[d]);
        const Volumetric v = volumetric(laws_[law].model, stiffness_[law], volume / domain_volume_[d]);
        state.energy += domain_volume_[d] * v.energy;
        state.slope.push_back(v.slope);
        state.curvature.push_back(v.curvature);
        for (auto i = member_start_[d]; i < member_start_[d + 1]; ++i)
            state.pressure[static_cast<std::size_t>(member_[static_cast<std::size_t>(i)])] += share_ * v.slope;
    }
    return state;
}

double LockingFree::add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const
{
    RETRACTOR_ASSERT(u.size() == 3 * static_cast<Eigen::Index>(node_count_) && forces.size() == u.size());
    const VolumeState state = volumes(u);
    std::array<double, 2> energy { 0.0, 0.0 };
    std::array<Eigen::VectorXd, 2> half;
    parallel_halves(weights_.size(), [&](std::size_t which, std::size_t begin, std::size_t end) {
        half[which] = Eigen::VectorXd::Zero(u.size());
        for (std::size_t p = begin; p < end; ++p) {
            const PointLaw& law = laws_[static_cast<std::size_t>(law_of_point_[p])];
            const Mat3 F = deformation_gradient(u, p);
            const Shape shape = shape_response(law, fibres_[p], F);
            energy[which] += weights_[p] * shape.energy;
            const Mat3 P = weights_[p] * (shape.stress + state.pressure[p] * cofactor(law.model, F));
            for (auto i = points_.start[p]; i < points_.start[p + 1]; ++i)
                half[which]
                    .segment<3>(3 * static_cast<Eigen::Index>(points_.node[static_cast<std::size_t>(i)]))
                    .noalias()
                    += P * Eigen::Map<const Vec3>(gradients_.data() + 3 * static_cast<std::size_t>(i));
        }
    });
    forces += half[0] + half[1];
    return energy[0] + energy[1] + state.energy;
}

BlockPattern LockingFree::pattern() const
{
    NodeGroups all = domains_;
    for (std::size_t p = 0; p < points_.count(); ++p) {
        const auto own = points_.nodes(p);
        all.node.insert(all.node.end(), own.begin(), own.end());
        all.start.push_back(static_cast<std::int32_t>(all.node.size()));
    }
    return block_pattern(node_count_, all);
}

void LockingFree::add_points(const Eigen::VectorXd& u, const VolumeState& state, double projected, std::size_t begin,
    std::size_t end, double* values) const
{
    std::size_t at = 0;
    for (std::size_t p = 0; p < begin; ++p)
        at += pairs(points_.nodes(p).size());
    for (std::size_t p = begin; p < end; ++p) {
        const PointLaw& law = laws_[static_cast<std::size_t>(law_of_point_[p])];
        const TangentMatrix tangent
            = weights_[p] * shape_tangent(law, fibres_[p], deformation_gradient(u, p), state.pressure[p], projected);
        const auto n = points_.nodes(p).size();
        const double* g = gradients_.data() + 3 * static_cast<std::size_t>(points_.start[p]);
        for (std::size_t a = 0; a < n; ++a) {
            Eigen::Matrix<double, 3, 9> rows;
            for (int i = 0; i < 3; ++i)
                rows.row(i) = Eigen::Map<const Eigen::RowVector3d>(g + 3 * a) * tangent.middleRows<3>(3 * i);
            for (std::size_t b = 0; b <= a; ++b) {
                RowMat3 block;
                for (int k = 0; k < 3; ++k)
                    block.col(k) = rows.middleCols<3>(3 * k) * Eigen::Map<const Vec3>(g + 3 * b);
                add_block(values, point_map_[at++], block);
            }
        }
    }
}

void LockingFree::add_volumes(
    const Eigen::VectorXd& u, const VolumeState& state, std::size_t begin, std::size_t end, double* values) const
{
    std::size_t at = 0;
    for (std::size_t d = 0; d < begin; ++d)
        at += pairs(domains_.nodes(d).size());
    std::vector<Vec3> c;
    for (std::size_t d = begin; d < end; ++d) {
        const auto nodes = domains_.nodes(d);
        c.assign(nodes.size(), Vec3::Zero());
        for (auto i = member_start_[d]; i < member_start_[d + 1]; ++i) {
            const auto p = static_cast<std::size_t>(member_[static_cast<std::size_t>(i)]);
            const Mat3 G = share_ * weights_[p]
                * cofactor(laws_[static_cast<std::size_t>(law_of_point_[p])].model, deformation_gradient(u, p));
            std::size_t local = 0;
            for (auto k = points_.start[p]; k < points_.start[p + 1]; ++k) {
                while (nodes[local] != points_.node[static_cast<std::size_t>(k)]) // both lists are sorted
                    ++local;
                c[local].noalias() += G * Eigen::Map<const Vec3>(gradients_.data() + 3 * static_cast<std::size_t>(k));
            }
        }
        const double factor = state.curvature[d] / domain_volume_[d];
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b <= a; ++b)
                add_block(values, domain_map_[at++], factor * c[a] * c[b].transpose());
    }
}

void LockingFree::add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix)
{
    RETRACTOR_ASSERT(matrix.values.size() == 9 * matrix.pattern.block_count());
    if (point_map_.empty()) {
        point_map_ = group_block_map(points_, matrix.pattern);
        domain_map_ = group_block_map(domains_, matrix.pattern);
    }
    second_half_.assign(matrix.values.size(), 0.0);
    VolumeState state = volumes(u);
    for (double& curvature : state.curvature)
        curvature += projected * std::max(-curvature, 0.0);
    const auto target = [&](std::size_t which) { return which == 0 ? matrix.values.data() : second_half_.data(); };
    parallel_halves(weights_.size(), [&](std::size_t which, std::size_t begin, std::size_t end) {
        add_points(u, state, projected, begin, end, target(which));
    });
    parallel_halves(domain_volume_.size(), [&](std::size_t which, std::size_t begin, std::size_t end) {
        add_volumes(u, state, begin, end, target(which));
    });
    for (std::size_t i = 0; i < second_half_.size(); ++i)
        matrix.values[i] += second_half_[i];
}

std::size_t LockingFree::bytes() const
{
    return (gradients_.size() + weights_.size() + second_half_.size()) * sizeof(double)
        + (points_.node.size() + domains_.node.size() + member_.size() + point_map_.size() + domain_map_.size())
        * sizeof(std::int32_t)
        + fibres_.size() * sizeof(FibreDirections);
}

} // namespace retractor::fem
