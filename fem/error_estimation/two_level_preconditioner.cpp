#include "fem/error_estimation/two_level_preconditioner.h"

#include "mesh/base/assert.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <set>
#include <utility>

namespace retractor::fem {

namespace {

    Mat3 diagonal_block(const BlockMatrix& K, VertexId node)
    {
        const auto last = static_cast<std::size_t>(K.pattern.row_start[static_cast<std::size_t>(node) + 1] - 1);
        return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&K.values[9 * last]);
    }

    /// Where the true stiffness is not positive definite, any positive scale serves.
    Mat3 made_positive(const Mat3& block)
    {
        return block.llt().info() == Eigen::Success ? block
                                                    : Mat3(block.diagonal().cwiseAbs().maxCoeff() * Mat3::Identity());
    }

    /// The block without its negative part, so that its sum with a positive definite matrix is positive definite.
    Mat3 without_negative(const Mat3& block)
    {
        const Eigen::SelfAdjointEigenSolver<Mat3> modes(block);
        return modes.eigenvectors() * modes.eigenvalues().cwiseMax(0.0).asDiagonal() * modes.eigenvectors().transpose();
    }

    /// Calls f(begin, end) for each run of shares with the same end.
    template <class F> void for_each_end(const std::vector<AveragedContact::Share>& shares, const F& f)
    {
        for (std::size_t begin = 0, end = 0; begin < shares.size(); begin = end) {
            while (end < shares.size() && shares[end].end == shares[begin].end)
                ++end;
            f(begin, end);
        }
    }

} // namespace

Nesting::Nesting(const mesh::TetMesh& fine, std::size_t corners)
    : corners_(static_cast<Eigen::Index>(corners))
    , ends_(fine.vertex_count() - corners)
{
    for (std::size_t t = 0; t < fine.tet_count(); ++t) {
        const auto nodes = fine.tet(static_cast<TetId>(t));
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
            ends_[static_cast<std::size_t>(nodes[4 + e]) - corners]
                = { nodes[static_cast<std::size_t>(mesh::kTetEdges[e][0])],
                      nodes[static_cast<std::size_t>(mesh::kTetEdges[e][1])] };
    }
}

Eigen::VectorXd Nesting::prolong(const Eigen::VectorXd& coarse) const
{
    RETRACTOR_ASSERT(coarse.size() == 3 * corners_);
    Eigen::VectorXd fine(3 * (corners_ + static_cast<Eigen::Index>(ends_.size())));
    fine.head(3 * corners_) = coarse;
    for (std::size_t e = 0; e < ends_.size(); ++e)
        fine.segment<3>(3 * (corners_ + static_cast<Eigen::Index>(e)))
            = 0.5 * (coarse.segment<3>(3 * ends_[e][0]) + coarse.segment<3>(3 * ends_[e][1]));
    return fine;
}

Eigen::VectorXd Nesting::restrict_to_corners(const Eigen::VectorXd& fine) const
{
    Eigen::VectorXd coarse = fine.head(3 * corners_);
    for (std::size_t e = 0; e < ends_.size(); ++e) {
        const Vec3 half = 0.5 * fine.segment<3>(3 * (corners_ + static_cast<Eigen::Index>(e)));
        coarse.segment<3>(3 * ends_[e][0]) += half;
        coarse.segment<3>(3 * ends_[e][1]) += half;
    }
    return coarse;
}

TwoLevelPreconditioner::TwoLevelPreconditioner(ConstrainedSolver& coarse, const Nesting& nesting,
    const AveragedContact& contact, const std::vector<std::uint8_t>& held)
    : coarse_(coarse)
    , nesting_(nesting)
    , contact_(contact)
    , held_(held)
{
    number_edges_in_contact();
}

void TwoLevelPreconditioner::number_edges_in_contact()
{
    const auto& shares = contact_.shares();
    for (const auto& share : shares)
        number_.emplace(share.middle, 0);
    if (number_.empty())
        return;
    std::vector<std::uint8_t> held;
    std::size_t next = 0;
    for (auto& [middle, number] : number_) {
        number = next++;
        held.insert(held.end(), held_.begin() + 3 * middle, held_.begin() + 3 * middle + 3);
    }
    std::vector<std::set<std::int32_t>> columns(number_.size());
    for (std::size_t i = 0; i < columns.size(); ++i)
        columns[i].insert(static_cast<std::int32_t>(i));
    for_each_end(shares, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = begin; j < i; ++j) {
                const auto [column, row] = std::minmax({ number_.at(shares[i].middle), number_.at(shares[j].middle) });
                columns[row].insert(static_cast<std::int32_t>(column));
            }
    });
    BlockPattern& pattern = matrix_.pattern;
    pattern.row_start.push_back(0);
    for (const auto& row : columns) {
        pattern.column.insert(pattern.column.end(), row.begin(), row.end());
        pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
    }
    together_.emplace(pattern, std::move(held));
}

void TwoLevelPreconditioner::add_block(std::size_t row, std::size_t column, const Mat3& block)
{
    const auto& columns = matrix_.pattern.column;
    const auto place = std::lower_bound(columns.begin() + matrix_.pattern.row_start[row],
                           columns.begin() + matrix_.pattern.row_start[row + 1], static_cast<std::int32_t>(column))
        - columns.begin();
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&matrix_.values[9 * static_cast<std::size_t>(place)])
        += block;
}

/// Stiffness of the functions that are subtracted at a corner. Along held axes nothing can be subtracted, and the
/// contact stiffness remains.
Mat3 TwoLevelPreconditioner::felt_at(VertexId corner, const BlockMatrix& coarse_K) const
{
    const Mat3 contact = diagonal_block(contact_.linear_stiffness(), corner);
    Mat3 felt = made_positive(diagonal_block(coarse_K, corner) - contact);
    const std::uint8_t* held = &coarse_.prescribed()[3 * static_cast<std::size_t>(corner)];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (held[i] != 0 || held[j] != 0)
                felt(i, j) = held[i] != 0 && held[j] != 0 ? contact(i, j) : 0.0;
    return without_negative(felt);
}

void TwoLevelPreconditioner::take_blocks(const BlockMatrix& coarse_K, const BlockMatrix& K)
{
    const auto block_of = [&](VertexId middle) { return made_positive(diagonal_block(K, middle)); };
    inverse_.resize(nesting_.midpoints());
    for (std::size_t e = 0; e < inverse_.size(); ++e)
        inverse_[e] = block_of(static_cast<VertexId>(nesting_.corners()) + static_cast<VertexId>(e)).inverse();
    if (!together_)
        return;
    matrix_.values.assign(9 * matrix_.pattern.block_count(), 0.0);
    for (const auto& [middle, number] : number_)
        add_block(number, number, block_of(middle));
    const auto& shares = contact_.shares();
    for_each_end(shares, [&](std::size_t begin, std::size_t end) {
        const Mat3 felt = felt_at(shares[begin].end, coarse_K);
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = begin; j < end; ++j)
                if (const std::size_t row = number_.at(shares[i].middle), column = number_.at(shares[j].middle);
                    row >= column)
                    add_block(row, column, shares[i].weight * shares[j].weight * felt);
    });
    together_->factorise(matrix_);
}

void TwoLevelPreconditioner::solve_edges(Eigen::VectorXd& edges)
{
    Eigen::VectorXd in_contact(3 * static_cast<Eigen::Index>(number_.size()));
    for (const auto& [middle, number] : number_)
        in_contact.segment<3>(3 * static_cast<Eigen::Index>(number)) = edges.segment<3>(at(middle));
    for (std::size_t e = 0; e < inverse_.size(); ++e) {
        auto edge = edges.segment<3>(3 * static_cast<Eigen::Index>(e));
        edge = (inverse_[e] * edge).eval();
    }
    if (!together_)
        return;
    in_contact = together_->solve(in_contact);
    for (const auto& [middle, number] : number_)
        edges.segment<3>(at(middle)) = in_contact.segment<3>(3 * static_cast<Eigen::Index>(number));
}

Eigen::VectorXd TwoLevelPreconditioner::apply(const Eigen::VectorXd& r)
{
    RETRACTOR_ASSERT(static_cast<std::size_t>(r.size()) == held_.size());
    Eigen::VectorXd corners = nesting_.restrict_to_corners(r), edges = r.tail(r.size() - corners.size());
    coarse_.mask(corners);
    for (const auto& share : contact_.shares())
        edges.segment<3>(at(share.middle)) -= share.weight * corners.segment<3>(3 * share.end);
    solve_edges(edges);
    Eigen::VectorXd taken = Eigen::VectorXd::Zero(corners.size());
    for (const auto& share : contact_.shares())
        taken.segment<3>(3 * share.end) += share.weight * edges.segment<3>(at(share.middle));
    coarse_.mask(taken);
    Eigen::VectorXd z = nesting_.prolong(coarse_.solve(corners) - taken);
    z.tail(edges.size()) += edges;
    mask(z);
    return z;
}

void TwoLevelPreconditioner::mask(Eigen::VectorXd& vector) const
{
    for (std::size_t i = 0; i < held_.size(); ++i)
        if (held_[i] != 0)
            vector[static_cast<Eigen::Index>(i)] = 0.0;
}

std::size_t TwoLevelPreconditioner::bytes() const
{
    return inverse_.size() * sizeof(Mat3) + matrix_.values.size() * sizeof(double)
        + (together_ ? together_->bytes() : 0);
}

} // namespace retractor::fem
