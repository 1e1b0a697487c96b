#include "fem/gradient_recovery.h"

#include "fem/tet_element.h"
#include "mesh/base/error.h"

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <vector>

namespace retractor {

namespace {

    constexpr Eigen::Index kTerms = 10; // of a quadratic in space
    constexpr std::size_t kFewest = 3 * kTerms; // samples: fewer are added to by the elements round them

    NodeGradients rest_positions(const TetMesh& mesh, TetId t)
    {
        const auto nodes = mesh.tet(t);
        NodeGradients x(static_cast<Eigen::Index>(nodes.size()), 3);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            x.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
        return x;
    }

    Mat3 gradient(const TetMesh& mesh, TetId t, const ShapeGradients& shape, const Eigen::VectorXd& u)
    {
        const auto nodes = mesh.tet(t);
        Mat3 H = Mat3::Zero();
        for (std::size_t a = 0; a < nodes.size(); ++a)
            H += u.segment<3>(3 * nodes[a]) * shape.gradients.row(static_cast<Eigen::Index>(a));
        return H;
    }

    /// Twice the density of the energy of a small change of the gradient; nonlinear tissue has it in axes that turn
    /// with the tissue.
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

    /// Four points in each of the eight parts that the midpoints divide an element into: gradients that are fitted to
    /// at the four points of the whole look better there than they are.
    std::vector<QuadraturePoint> fine_rule()
    {
        constexpr std::array<std::array<int, 4>, 8> kParts { { { 0, 4, 6, 7 }, { 1, 4, 5, 8 }, { 2, 5, 6, 9 },
            { 3, 7, 8, 9 }, { 4, 5, 6, 8 }, { 4, 6, 7, 8 }, { 5, 6, 8, 9 }, { 6, 7, 8, 9 } } };
        std::array<Eigen::Vector4d, 10> node;
        for (int a = 0; a < 4; ++a)
            node[static_cast<std::size_t>(a)] = Eigen::Vector4d::Unit(a);
        for (std::size_t e = 0; e < kTetEdges.size(); ++e)
            node[4 + e] = 0.5 * (Eigen::Vector4d::Unit(kTetEdges[e][0]) + Eigen::Vector4d::Unit(kTetEdges[e][1]));
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

    Eigen::Matrix<double, kTerms, 1> terms(const Vec3& p)
    {
        Eigen::Matrix<double, kTerms, 1> all;
        all << 1.0, p.x(), p.y(), p.z(), p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.x() * p.y(), p.y() * p.z(),
            p.z() * p.x();
        return all;
    }

    using Gradient = Eigen::Matrix<double, 9, 1>;

    struct Sample {
        Vec3 at;
        Gradient value;
    };

    /// A quadratic round a vertex.
    struct Patch {
        Vec3 centre = Vec3::Zero();
        double size = 1.0;
        Eigen::Matrix<double, kTerms, 9> coefficients = Eigen::Matrix<double, kTerms, 9>::Zero();
        Gradient at(const Vec3& p) const { return coefficients.transpose() * terms((p - centre) / size); }
    };

    /// The elements of one tissue, and what is fitted to the answer there.
    class Tissue {
    public:
        Tissue(const TetMesh& mesh, std::vector<TetId> tets, const Eigen::VectorXd& u)
            : mesh_(mesh)
            , tets_(std::move(tets))
        {
            for (std::size_t i = 0; i < tets_.size(); ++i) {
                const NodeGradients x = rest_positions(mesh_, tets_[i]);
                for (const QuadraturePoint& q : quadrature(10)) {
                    const Mat3 H = gradient(mesh_, tets_[i], shape_gradients(x, q), u);
                    samples_.push_back(
                        { x.transpose() * shape_values(10, q.barycentric), Eigen::Map<const Gradient>(H.data()) });
                }
                for (const VertexId v : mesh_.tet(tets_[i]).first(4))
                    round_[v].push_back(i);
            }
            for (const auto& [vertex, near] : round_)
                fit(vertex);
            for (const TetId t : tets_) {
                const auto nodes = mesh_.tet(t);
                for (std::size_t a = 0; a < 4; ++a)
                    recovered_[nodes[a]] = patches_.at(nodes[a]).at(mesh_.vertices.row(nodes[a]).transpose());
                for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
                    const Vec3 p = mesh_.vertices.row(nodes[4 + e]).transpose();
                    const auto end = [&](std::size_t i) {
                        return patches_.at(nodes[static_cast<std::size_t>(kTetEdges[e][i])]).at(p);
                    };
                    recovered_[nodes[4 + e]] = 0.5 * (end(0) + end(1));
                }
            }
        }

        const std::vector<TetId>& tets() const { return tets_; }

        /// One column per node of the element.
        Eigen::Matrix<double, 9, kTerms> recovered(TetId t) const
        {
            Eigen::Matrix<double, 9, kTerms> at_nodes;
            const auto nodes = mesh_.tet(t);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                at_nodes.col(static_cast<Eigen::Index>(a)) = recovered_.at(nodes[a]);
            return at_nodes;
        }

    private:
        static constexpr std::size_t kPerTet = 4; // samples

        void fit(VertexId vertex)
        {
            std::set<std::size_t> near(round_.at(vertex).begin(), round_.at(vertex).end());
            for (std::size_t before = 0; kPerTet * near.size() < kFewest && near.size() > before;) {
                before = near.size();
                const std::vector<std::size_t> so_far(near.begin(), near.end());
                for (const std::size_t i : so_far)
                    for (const VertexId v : mesh_.tet(tets_[i]).first(4))
                        near.insert(round_.at(v).begin(), round_.at(v).end());
            }
            Patch patch;
            patch.centre = mesh_.vertices.row(vertex).transpose();
            patch.size = 0.0;
            for (const std::size_t i : near)
                for (std::size_t s = 0; s < kPerTet; ++s)
                    patch.size = std::max(patch.size, (samples_[kPerTet * i + s].at - patch.centre).norm());
            const auto rows = static_cast<Eigen::Index>(kPerTet * near.size());
            Eigen::MatrixXd A(rows, kTerms), b(rows, 9);
            Eigen::Index row = 0;
            for (const std::size_t i : near)
                for (std::size_t s = 0; s < kPerTet; ++s, ++row) {
                    const Sample& sample = samples_[kPerTet * i + s];
                    A.row(row) = terms((sample.at - patch.centre) / patch.size).transpose();
                    b.row(row) = sample.value.transpose();
                }
            // A thin layer says nothing of the third direction: the least coefficients then.
            Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> fitted(A);
            patch.coefficients = fitted.solve(b);
            patches_.emplace(vertex, patch);
        }

        const TetMesh& mesh_;
        std::vector<TetId> tets_;
        std::vector<Sample> samples_; ///< kPerTet per element
        std::map<VertexId, std::vector<std::size_t>> round_; ///< elements of this tissue, by their place in tets_
        std::map<VertexId, Patch> patches_;
        std::map<VertexId, Gradient> recovered_; ///< at nodes
    };

    void check(const TetMesh& mesh, std::span<const Lame> lame, const Eigen::VectorXd& u)
    {
        if (mesh.nodes_per_tet != 10)
            throw InputError("gradients are recovered from ten-node elements", "nodes_per_tet");
        if (lame.size() != mesh.tet_count())
            throw InputError("there must be parameters for each element", "lame");
        if (u.size() != 3 * mesh.vertices.rows() || !u.allFinite())
            throw InputError("there must be three finite displacements per node", "displacement");
    }

} // namespace

double recovered_energy(const TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u)
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
            const NodeGradients x = rest_positions(mesh, t);
            const auto at_nodes = tissue.recovered(t);
            for (const QuadraturePoint& q : rule) {
                const ShapeGradients shape = shape_gradients(x, q);
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

double energy_between(const TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& u,
    const Eigen::VectorXd& other)
{
    check(mesh, lame, u);
    check(mesh, lame, other);
    double sum = 0.0;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto id = static_cast<TetId>(t);
        const NodeGradients x = rest_positions(mesh, id);
        for (const QuadraturePoint& q : quadrature(10)) {
            const ShapeGradients shape = shape_gradients(x, q);
            const Mat3 H = gradient(mesh, id, shape, u);
            sum += shape.volume * twice_density(model, lame[t], H, gradient(mesh, id, shape, other) - H);
        }
    }
    return sum;
}

double share_left(const TetMesh& mesh, Elasticity model, std::span<const Lame> lame, const Eigen::VectorXd& ten_node,
    const Eigen::VectorXd& four_node)
{
    check(mesh, lame, ten_node);
    Eigen::VectorXd straight = ten_node;
    straight.head(four_node.size()) = four_node;
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto nodes = mesh.tet(static_cast<TetId>(t));
        for (std::size_t e = 0; e < kTetEdges.size(); ++e)
            straight.segment<3>(3 * nodes[4 + e]) = 0.5
                * (straight.segment<3>(3 * nodes[static_cast<std::size_t>(kTetEdges[e][0])])
                    + straight.segment<3>(3 * nodes[static_cast<std::size_t>(kTetEdges[e][1])]));
    }
    const double gained = energy_between(mesh, model, lame, ten_node, straight);
    return gained > 0.0 ? recovered_energy(mesh, model, lame, ten_node) / gained : 0.0;
}

} // namespace retractor
