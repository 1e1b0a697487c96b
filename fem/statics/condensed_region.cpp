#include "fem/statics/condensed_region.h"

#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    /// An order of the first `count` free nodes by nested dissection.
    std::vector<std::int32_t> dissection(
        const BlockPattern& blocks, const std::vector<std::int32_t>& number, std::size_t count)
    {
        SymmetricPattern graph;
        graph.column_start.push_back(0);
        for (std::size_t row = 0; row < blocks.row_count(); ++row) {
            if (number[row] < 0 || number[row] >= static_cast<std::int32_t>(count))
                continue;
            for (auto b = blocks.row_start[row]; b < blocks.row_start[row + 1]; ++b)
                if (const std::int32_t other
                    = number[static_cast<std::size_t>(blocks.column[static_cast<std::size_t>(b)])];
                    other >= 0)
                    graph.row.push_back(other);
            graph.column_start.push_back(static_cast<std::int32_t>(graph.row.size()));
        }
        SparseCholesky ordering;
        ordering.analyse(std::move(graph));
        return ordering.elimination_order();
    }

} // namespace

CondensingSystem condensing_system(
    const BlockPattern& blocks, const std::vector<std::uint8_t>& fixed, std::size_t kept, bool dense_kept)
{
    RETRACTOR_ASSERT(fixed.size() == blocks.row_count());
    CondensingSystem system;
    system.number.assign(blocks.row_count(), -1);
    for (std::size_t node = 0; node < blocks.row_count(); ++node)
        if (fixed[node] == 0 && blocks.row_start[node] < blocks.row_start[node + 1]) {
            system.number[node] = static_cast<std::int32_t>(system.free.size());
            system.free.push_back(static_cast<VertexId>(node));
        }
    const auto kept_from = static_cast<std::int32_t>(system.free.size() - kept);
    std::vector<std::int32_t> block_of(system.free.size(), -1); // per free node: its block in the present row, or -1
    std::vector<std::int32_t> columns;
    system.pattern.column_start.push_back(0);
    for (std::size_t j = 0; j < system.free.size(); ++j) {
        const auto self = static_cast<std::int32_t>(j);
        const auto node = static_cast<std::size_t>(system.free[j]);
        columns.clear();
        for (auto b = blocks.row_start[node]; b < blocks.row_start[node + 1]; ++b)
            if (const std::int32_t other
                = system.number[static_cast<std::size_t>(blocks.column[static_cast<std::size_t>(b)])];
                other >= 0) {
                block_of[static_cast<std::size_t>(other)] = b;
                if (!dense_kept || self < kept_from || other < kept_from)
                    columns.push_back(other);
            }
        if (dense_kept && self >= kept_from)
            for (std::int32_t other = kept_from; other <= self; ++other)
                columns.push_back(other);
        for (std::int32_t axis = 0; axis < 3; ++axis) {
            for (const std::int32_t other : columns)
                for (std::int32_t k = 0; k < (other == self ? axis + 1 : 3); ++k) {
                    const std::int32_t block = block_of[static_cast<std::size_t>(other)];
                    system.pattern.row.push_back(3 * other + k);
                    system.source.push_back(block < 0 ? -1 : 9 * block + 3 * axis + k);
                }
            system.pattern.column_start.push_back(static_cast<std::int32_t>(system.pattern.row.size()));
        }
        for (const std::int32_t other : columns)
            block_of[static_cast<std::size_t>(other)] = -1;
    }
    const auto add = [&](std::int32_t block) {
        for (std::int32_t axis = 0; axis < 3; ++axis)
            system.order.push_back(3 * block + axis);
    };
    if (kept_from > 0)
        for (const std::int32_t block : dissection(blocks, system.number, static_cast<std::size_t>(kept_from)))
            add(block);
    for (std::int32_t block = kept_from; block < static_cast<std::int32_t>(system.free.size()); ++block)
        add(block);
    return system;
}

CondensedRegion::CondensedRegion(ElasticBody& body, const std::vector<std::uint8_t>& fixed, std::size_t rim)
    : nodes_(body.mesh().vertex_count())
{
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(nodes_));
    const BlockMatrix& K = body.stiffness(rest, 0.0);
    CondensingSystem system = condensing_system(K.pattern, fixed, rim, false);
    free_ = system.free;
    const auto kept = 3 * static_cast<Eigen::Index>(rim);
    const auto unknowns = 3 * static_cast<Eigen::Index>(free_.size());
    std::vector<double> values;
    values.reserve(system.source.size());
    for (const std::int32_t source : system.source)
        values.push_back(K.values[static_cast<std::size_t>(source)]);
    // The body alone may be loose at the rim. Springs as stiff as the rim's own diagonal hold the rim during the
    // factorisation and are subtracted afterwards.
    Eigen::VectorXd springs(kept);
    for (Eigen::Index i = 0; i < kept; ++i) {
        double& diagonal = values[static_cast<std::size_t>(
            system.pattern.column_start[static_cast<std::size_t>(unknowns - kept + i + 1)] - 1)];
        springs[i] = diagonal;
        diagonal *= 2.0;
    }
    factor_.analyse_in_order(std::move(system.pattern), std::move(system.order));
    try {
        factor_.factorise(values);
    } catch (const SolverError& error) {
        const std::int32_t unknown = factor_.failed_unknown();
        if (unknown < 0)
            throw;
        throw SolverError(std::string("stiffness beyond the rim: ") + error.what(),
            "node " + std::to_string(free_[static_cast<std::size_t>(unknown / 3)]) + ", axis " + "xyz"[unknown % 3]);
    }
    factor_.keep_factor_only();
    stiffness_ = times_own_transpose(factor_.trailing_factor(kept));
    stiffness_.diagonal() -= springs;
}

Eigen::VectorXd CondensedRegion::field(const Eigen::VectorXd& rim_displacement) const
{
    RETRACTOR_ASSERT(rim_displacement.size() == stiffness_.rows());
    Eigen::MatrixXd x(3 * static_cast<Eigen::Index>(free_.size()), 1);
    x.bottomRows(rim_displacement.size()) = rim_displacement;
    factor_.fill_from_trailing(rim_displacement.size(), x);
    return spread(x);
}

CondensedRegion::Reduced CondensedRegion::reduce(const Eigen::VectorXd& forces) const
{
    RETRACTOR_ASSERT(forces.size() == 3 * static_cast<Eigen::Index>(nodes_));
    const Eigen::Index rim = stiffness_.rows();
    Reduced reduced { {}, Eigen::MatrixXd(3 * static_cast<Eigen::Index>(free_.size()), 1) };
    for (std::size_t i = 0; i < free_.size(); ++i)
        reduced.half.col(0).segment<3>(3 * static_cast<Eigen::Index>(i))
            = forces.segment<3>(3 * static_cast<Eigen::Index>(free_[i]));
    factor_.reduce_to_trailing(rim, reduced.half);
    reduced.on_rim = reduced.half.col(0).tail(rim);
    return reduced;
}

Eigen::VectorXd CondensedRegion::field(const Eigen::VectorXd& rim_displacement, const Reduced& forces) const
{
    RETRACTOR_ASSERT(rim_displacement.size() == stiffness_.rows());
    Eigen::MatrixXd x = forces.half;
    x.bottomRows(rim_displacement.size()) = rim_displacement;
    factor_.fill_from_trailing_loaded(rim_displacement.size(), x);
    return spread(x);
}

Eigen::VectorXd CondensedRegion::spread(const Eigen::MatrixXd& of_free) const
{
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(nodes_));
    for (std::size_t i = 0; i < free_.size(); ++i)
        whole.segment<3>(3 * static_cast<Eigen::Index>(free_[i]))
            = of_free.col(0).segment<3>(3 * static_cast<Eigen::Index>(i));
    return whole;
}

std::size_t CondensedRegion::bytes() const
{
    return factor_.bytes() + static_cast<std::size_t>(stiffness_.size()) * sizeof(double)
        + free_.size() * sizeof(VertexId);
}

} // namespace retractor::fem
