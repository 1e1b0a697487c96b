#include "fem/error_estimation/gradient_recovery.h"

#include "fem/element/tet_element.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/error.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <map>
#include <set>
#include <vector>

namespace retractor::fem {

namespace {

    // least number of samples, three per term; patches with fewer are extended by the elements round them
    constexpr std::size_t kFewest = 30;
    /// Number of terms of the fitted function: quadratic, linear, or constant.
    constexpr std::array<Eigen::Index, 3> kDegrees { 10, 4, 1 };
    /// Least length of a column, for samples with unit spread along their axes. Shorter columns do not determine
    /// their term.
    constexpr double kRank = 1e-2;
    /// Bound of the sum of the weights' sizes, where a value of a fit is a weighted sum of samples. A recovered
    /// gradient then exceeds the samples by no more than this factor: patches of flat elements, and places far
    /// outside their samples, get a fit of lower degree. At corners of cubes cut into tetrahedra the sum of a
    /// quadratic is 9.
    constexpr double kMostWeight = 12.0;

    Mat3 gradient(const mesh::TetMesh& mesh, TetId t, const ShapeGradients& shape, const Eigen::VectorXd& u)
    {
        const auto nodes = mesh.tet(t);
        Mat3 H = Mat3::Zero();
        for (std::size_t a = 0; a < nodes.size(); ++a)
            H += u.segment<3>(3 * nodes[a]) * shape.gradients.row(static_cast<Eigen::Index>(a));
        return H;
    }

    /// Twice the energy density of a small change of the gradient. In nonlinear tissue the change is taken in axes
    /// that turn with the tissue.
    double twice_density(Elasticity model, const Lame& lame, const Mat3& H, const Mat3& change)
    {
        Mat3 seen = change;
        if (model != Elasticity::linear) {
            const SignedSvd svd = signed_svd(Mat3::Identity() + H);
            seen = svd.V * svd.U.transpose() * change;
        }
        const Mat3 strain = 0.5 * (seen + seen.transpose());
        const double trace = strain.trace();
        return 2.0 * lame.mu * (strain.squaredNorm() - trace * trace / 3.0);
    }

    /// Four points in each of the eight parts into which the midpoints divide an element. At the four points of the
    /// whole element the fitted gradients look better than they are.
    std::vector<QuadraturePoint> fine_rule()
    {
        constexpr std::array<std::array<int, 4>, 8> kParts { { { 0, 4, 6, 7 }, { 1, 4, 5, 8 }, { 2, 5, 6, 9 },
            { 3, 7, 8, 9 }, { 4, 5, 6, 8 }, { 4, 6, 7, 8 }, { 5, 6, 8, 9 }, { 6, 7, 8, 9 } } };
        std::array<Eigen::Vector4d, 10> node;
        for (int a = 0; a < 4; ++a)
            node[static_cast<std::size_t>(a)] = Eigen::Vector4d::Unit(a);
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
            node[4 + e]
                = 0.5 * (Eigen::Vector4d::Unit(mesh::kTetEdges[e][0]) + Eigen::Vector4d::Unit(mesh::kTetEdges[e][1]));
        std::vector<QuadraturePoint> rule;
        for (const auto& part : kParts)
            for (const QuadraturePoint& q : quadrature(10)) {
                Eigen::Vector4d b = Eigen::Vector4d::Zero();
                for (std::size_t a = 0; a < 4; ++a)
                    b += q.barycentric[a] * node[static_cast<std::size_t>(part[a])];
                rule.push_back({ { b[0], b[1], b[2], b[3] }, q.weight / static_cast<double>(kParts.size()) });
            }
        return rule;
    }

    Eigen::Matrix<double, kDegrees[0], 1> terms(const Vec3& p)
    {
        Eigen::Matrix<double, kDegrees[0], 1> all;
        all << 1.0, p.x(), p.y(), p.z(), p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.x() * p.y(), p.y() * p.z(),
            p.z() * p.x();
        return all;
    }

    using Gradient = Eigen::Matrix<double, 9, 1>;

    struct Sample {
        Vec3 at;
        Gradient value;
        double weight; ///< volume, so that slivers have little influence
    };

    /// Places relative to the samples: from their mean, along their principal axes, in units of their spread. Thin
    /// layers then fit as well as thick ones. A direction without spread of the samples is left out.
    class SampleFrame {
    public:
        explicit SampleFrame(const std::vector<const Sample*>& samples)
        {
            constexpr double kFlat = 1e-3; // relative to the largest spread
            double total = 0.0;
            for (const Sample* sample : samples) {
                centre_ += sample->weight * sample->at;
                total += sample->weight;
            }
            centre_ /= total;
            Mat3 spread = Mat3::Zero();
            for (const Sample* sample : samples)
                spread += sample->weight / total * (sample->at - centre_) * (sample->at - centre_).transpose();
            const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
            const double least = kFlat * kFlat * axes.eigenvalues()[2];
            for (Eigen::Index i = 0; i < 3; ++i)
                if (axes.eigenvalues()[i] > least)
                    to_frame_.row(i) = axes.eigenvectors().col(i).transpose() / std::sqrt(axes.eigenvalues()[i]);
        }
        Vec3 operator()(const Vec3& p) const { return to_frame_ * (p - centre_); }

    private:
        Vec3 centre_ = Vec3::Zero();
        Mat3 to_frame_ = Mat3::Zero();
    };

    /// Values of the fit at the places, one per row.
    Eigen::MatrixXd fitted(const std::vector<const Sample*>& samples, const std::vector<Vec3>& places)
    {
        const SampleFrame frame(samples);
        const auto rows = static_cast<Eigen::Index>(samples.size());
        Eigen::MatrixXd at_samples(rows, kDegrees[0]), values(rows, 9),
            at_places(static_cast<Eigen::Index>(places.size()), kDegrees[0]);
        Eigen::VectorXd root_weight(rows);
        for (Eigen::Index i = 0; i < rows; ++i) {
            const Sample& sample = *samples[static_cast<std::size_t>(i)];
            at_samples.row(i) = terms(frame(sample.at)).transpose();
            values.row(i) = sample.value.transpose();
            root_weight[i] = std::sqrt(sample.weight);
        }
        for (std::size_t i = 0; i < places.size(); ++i)
            at_places.row(static_cast<Eigen::Index>(i)) = terms(frame(places[i])).transpose();
        for (const Eigen::Index degree : kDegrees) {
            Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
            solver.setThreshold(kRank);
            solver.compute(root_weight.asDiagonal() * at_samples.leftCols(degree));
            if (degree == kDegrees[0] && solver.rank() < degree)
                continue;
            const Eigen::MatrixXd weights
                = at_places.leftCols(degree) * solver.pseudoInverse() * root_weight.asDiagonal();
            if (degree == 1 || weights.cwiseAbs().rowwise().sum().maxCoeff() <= kMostWeight)
                return weights * values;
        }
        return {}; // unreachable: the mean is always accepted
    }

    /// The elements of one tissue, with the gradients fitted to the answer there.
    class Tissue {
    public:
        Tissue(const mesh::TetMesh& mesh, std::vector<TetId> tets, const Eigen::VectorXd& u)
            : mesh_(mesh)
            , tets_(std::move(tets))
        {
            for (std::size_t i = 0; i < tets_.size(); ++i) {
                const NodeGradients x = rest_positions(mesh_, tets_[i]);
                for (const QuadraturePoint& q : quadrature(10)) {
                    const ShapeGradients shape = shape_gradients(mesh_, tets_[i], q);
                    const Mat3 H = gradient(mesh_, tets_[i], shape, u);
                    samples_.push_back({ x.transpose() * shape_values(10, q.barycentric),
                        Eigen::Map<const Gradient>(H.data()), shape.volume });
                }
                const auto nodes = mesh_.tet(tets_[i]);
                for (const VertexId v : nodes.first(4))
                    round_[v].push_back(i);
                for (const VertexId v : nodes.first(4))
                    midpoints_.try_emplace(v);
                for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                    for (const int end : mesh::kTetEdges[e])
                        if (!mesh::is_straight(nodes, e))
                            midpoints_[nodes[static_cast<std::size_t>(end)]].insert(nodes[4 + e]);
            }
            std::vector<VertexId> vertices;
            for (const auto& [vertex, near] : round_)
                vertices.push_back(vertex);
            std::vector<Eigen::MatrixXd> values(vertices.size());
            std::array<std::exception_ptr, 2> failed;
            parallel_halves(vertices.size(), [&](std::size_t half, std::size_t begin, std::size_t end) {
                try {
                    for (std::size_t i = begin; i < end; ++i)
                        values[i] = fit(vertices[i]);
                } catch (...) { // no memory
                    failed[half] = std::current_exception();
                }
            });
            for (const std::exception_ptr& failure : failed)
                if (failure)
                    std::rethrow_exception(failure);
            for (std::size_t i = 0; i < vertices.size(); ++i)
                keep(vertices[i], values[i]);
        }

        const std::vector<TetId>& tets() const { return tets_; }

        /// Recovered gradients, one column per node of the element.
        Eigen::Matrix<double, 9, 10> recovered(TetId t) const
        {
            Eigen::Matrix<double, 9, 10> at_nodes;
            const auto nodes = mesh_.tet(t);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                at_nodes.col(static_cast<Eigen::Index>(a)) = recovered_.at(nodes[a]);
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (mesh::is_straight(nodes, e))
                    at_nodes.col(static_cast<Eigen::Index>(4 + e))
                        = 0.5 * (at_nodes.col(mesh::kTetEdges[e][0]) + at_nodes.col(mesh::kTetEdges[e][1]));
            return at_nodes;
        }

    private:
        static constexpr std::size_t kPerTet = 4; // samples per element

        /// Values of the fit round a vertex, one per row: at the vertex, then at the midpoints of its edges.
        Eigen::MatrixXd fit(VertexId vertex) const
        {
            std::set<std::size_t> near(round_.at(vertex).begin(), round_.at(vertex).end());
            for (std::size_t before = 0; kPerTet * near.size() < kFewest && near.size() > before;) {
                before = near.size();
                const std::vector<std::size_t> so_far(near.begin(), near.end());
                for (const std::size_t i : so_far)
                    for (const VertexId v : mesh_.tet(tets_[i]).first(4))
                        near.insert(round_.at(v).begin(), round_.at(v).end());
            }
            std::vector<const Sample*> samples;
            for (const std::size_t i : near)
                for (std::size_t n = 0; n < kPerTet; ++n)
                    samples.push_back(&samples_[kPerTet * i + n]);
            const auto place = [this](VertexId node) -> Vec3 { return mesh_.vertices.row(node).transpose(); };
            std::vector<Vec3> places { place(vertex) };
            for (const VertexId node : midpoints_.at(vertex))
                places.push_back(place(node));
            return fitted(samples, places);
        }

        void keep(VertexId vertex, const Eigen::MatrixXd& values)
        {
            recovered_[vertex] = values.row(0).transpose();
            Eigen::Index row = 1;
            for (const VertexId node : midpoints_.at(vertex)) // mean of the fits round both ends
                recovered_.try_emplace(node, Gradient::Zero()).first->second += 0.5 * values.row(row++).transpose();
        }

        const mesh::TetMesh& mesh_;
        std::vector<TetId> tets_;
        std::vector<Sample> samples_; ///< samples, kPerTet per element
        /// elements of this tissue round a vertex, as positions in tets_
        std::map<VertexId, std::vector<std::size_t>> round_;
        std::map<VertexId, std::set<VertexId>> midpoints_; ///< midpoints of the edges that end at a vertex
        std::map<VertexId, Gradient> recovered_; ///< recovered gradients at the nodes
    };

    void check(const mesh::TetMesh& mesh, std::span<const Lame> lame, const Eigen::VectorXd& u)
    {
        if (mesh.nodes_per_tet != 10)
            throw InputError("gradients are recovered from ten-node elements", "nodes_per_tet");
        if (lame.size() != mesh.tet_count())
            throw InputError("there must be parameters for each element", "lame");
        if (u.size() != 3 * mesh.vertices.rows() || !u.allFinite())
            throw InputError("there must be three finite displacements per node", "displacement");
    }

    void check_corners(const mesh::TetMesh& mesh, const Eigen::VectorXd& four_node)
    {
        VertexId corners = 0;
        std::vector<std::uint8_t> used(mesh.vertex_count(), 0);
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            const auto nodes = mesh.tet(static_cast<TetId>(t));
            for (const VertexId v : nodes)
                used[static_cast<std::size_t>(v)] = 1;
            for (const VertexId v : nodes.first(4))
                corners = std::max(corners, v + 1);
        }
        // The nodes of blades, which no element has, follow the corners.
        const auto of_blades = static_cast<Eigen::Index>(std::ranges::count(used, std::uint8_t { 0 }));
        const bool fits = four_node.size() == 3 * static_cast<Eigen::Index>(corners)
            || four_node.size() == 3 * (static_cast<Eigen::Index>(corners) + of_blades);
        if (!fits || !four_node.allFinite())
            throw InputError("plain elements have three finite displacements per corner", "four_node");
    }

} // namespace

double recovered_energy(
    const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u)
{
    check(mesh, lame, u);
    const std::vector<QuadraturePoint> rule = fine_rule();
    std::map<Label, std::vector<TetId>> of_label;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        of_label[mesh.labels[t]].push_back(static_cast<TetId>(t));
    double sum = 0.0;
    for (auto& [label, tets] : of_label) {
        const Tissue tissue(mesh, std::move(tets), u);
        for (const TetId t : tissue.tets()) {
            const auto at_nodes = tissue.recovered(t);
            for (const QuadraturePoint& q : rule) {
                const ShapeGradients shape = shape_gradients(mesh, t, q);
                const Mat3 H = gradient(mesh, t, shape, u);
                const Gradient there = at_nodes * shape_values(10, q.barycentric);
                sum += shape.volume
                    * twice_density(
                        model, lame[static_cast<std::size_t>(t)], H, Eigen::Map<const Mat3>(there.data()) - H);
            }
        }
    }
    return sum;
}

double energy_between(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u,
    const Eigen::VectorXd& other)
{
    check(mesh, lame, u);
    check(mesh, lame, other);
    double sum = 0.0;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto id = static_cast<TetId>(t);
        for (const QuadraturePoint& q : quadrature(10)) {
            const ShapeGradients shape = shape_gradients(mesh, id, q);
            const Mat3 H = gradient(mesh, id, shape, u);
            sum += shape.volume * twice_density(model, lame[t], H, gradient(mesh, id, shape, other) - H);
        }
    }
    return sum;
}

double share_left(const mesh::TetMesh& mesh, Elasticity model, std::span<const Lame> lame,
    const Eigen::VectorXd& ten_node, const Eigen::VectorXd& four_node)
{
    constexpr double kRoundOff = 1e-20; // relative to squared quantities
    check(mesh, lame, ten_node);
    check_corners(mesh, four_node);
    Eigen::VectorXd straight = ten_node;
    straight.head(four_node.size()) = four_node;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto nodes = mesh.tet(static_cast<TetId>(t));
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
            if (!mesh::is_straight(nodes, e))
                straight.segment<3>(3 * nodes[4 + e]) = 0.5
                    * (straight.segment<3>(3 * nodes[static_cast<std::size_t>(mesh::kTetEdges[e][0])])
                        + straight.segment<3>(3 * nodes[static_cast<std::size_t>(mesh::kTetEdges[e][1])]));
    }
    const double gained = energy_between(mesh, model, lame, ten_node, straight);
    const double lacking = recovered_energy(mesh, model, lame, ten_node);
    const double none = kRoundOff * energy_between(mesh, model, lame, ten_node, Eigen::VectorXd::Zero(ten_node.size()));
    if (gained > none)
        return lacking / gained;
    return lacking > none ? std::numeric_limits<double>::infinity() : 0.0;
}

} // namespace retractor::fem
