#include "fem/linear_algebra/partial_factor.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"

#include <cblas.h>

#include <exception>
#include <utility>

namespace retractor::fem {

namespace {

    /// The columns of the lower triangle before `end`, with rows and columns in the order of elimination.
    struct Columns {
        struct Entry {
            std::int32_t row;
            double value;
        };
        std::vector<std::size_t> start;
        std::vector<Entry> entries;
    };

    Columns columns_before(Eigen::Index end, const SymmetricPattern& pattern, const std::vector<std::int32_t>& place,
        const std::vector<double>& values)
    {
        Columns columns { std::vector<std::size_t>(static_cast<std::size_t>(end) + 1, 0), {} };
        const auto for_entries = [&](const auto& work) {
            for (std::size_t j = 0; j < place.size(); ++j)
                for (auto k = static_cast<std::size_t>(pattern.column_start[j]);
                     k < static_cast<std::size_t>(pattern.column_start[j + 1]); ++k) {
                    const auto [column, row] = std::minmax(place[j], place[static_cast<std::size_t>(pattern.row[k])]);
                    if (column < end)
                        work(static_cast<std::size_t>(column), row, values[k]);
                }
        };
        for_entries([&](std::size_t column, std::int32_t, double) { ++columns.start[column + 1]; });
        for (std::size_t c = 0; c + 1 < columns.start.size(); ++c)
            columns.start[c + 1] += columns.start[c];
        columns.entries.resize(columns.start.back());
        std::vector<std::size_t> next = columns.start;
        for_entries([&](std::size_t column, std::int32_t row, double value) {
            columns.entries[next[column]++] = { row, value };
        });
        return columns;
    }

    /// The dense fronts of all supernodes. A front has the supernode's own columns and the rows below that these
    /// columns reach.
    class Fronts {
    public:
        Fronts(const Supernodes& f, double* x, Eigen::Index end, Columns matrix)
            : f_(f)
            , x_(x)
            , end_(end)
            , matrix_(std::move(matrix))
            , children_(f.count)
            , updates_(f.count)
        {
            for (std::size_t s = 0; s < f.count && f.first[s] < end_; ++s)
                if (const std::int32_t p = parent(s); p >= 0)
                    children_[static_cast<std::size_t>(p)].push_back(s);
        }

        /// Factors all fronts. @return as PartialFactor::stopped_at
        Eigen::Index factor_all()
        {
            const TwoParts parts = two_parts(f_, end_);
            const auto all_of = [&](const std::vector<std::size_t>& falling, std::vector<std::int32_t>& at) {
                for (auto s = falling.rbegin(); s != falling.rend(); ++s)
                    if (const Eigen::Index stop = factor(*s, at); stop >= 0)
                        return stop;
                return Eigen::Index { -1 };
            };
            std::vector<std::int32_t> at(static_cast<std::size_t>(f_.size), -1), other_at = at;
            Eigen::Index stop = -1, other_stop = -1;
            std::exception_ptr failed; // exception of the other thread, e.g. out of memory; rethrown in this thread
            {
                const ScopedThread other([&] {
                    try {
                        other_stop = all_of(parts.below[1], other_at);
                    } catch (...) {
                        failed = std::current_exception();
                    }
                });
                stop = all_of(parts.below[0], at);
            }
            if (failed)
                std::rethrow_exception(failed);
            stop = std::max(stop, other_stop);
            return stop >= 0 ? stop : all_of(parts.above, at);
        }

        /// Sum of the updates of all fronts without a parent. @pre factor_all() succeeded
        Eigen::MatrixXd trailing()
        {
            Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(f_.size - end_, f_.size - end_);
            std::vector<std::int32_t> at(static_cast<std::size_t>(f_.size), -1);
            for (Eigen::Index row = end_; row < f_.size; ++row)
                at[static_cast<std::size_t>(row)] = static_cast<std::int32_t>(row - end_);
            for (std::size_t s = 0; s < f_.count && f_.first[s] < end_; ++s)
                if (parent(s) < 0)
                    take_update(s, at, nullptr, 0, 0, sum);
            return sum;
        }

    private:
        Eigen::Index columns(std::size_t s) const { return std::min<Eigen::Index>(f_.columns(s), end_ - f_.first[s]); }

        /// The parent front, or -1 when all rows below belong to unknowns that are not factored.
        std::int32_t parent(std::size_t s) const
        {
            const Eigen::Index own = columns(s);
            return own == f_.rows(s) || f_.row(s, own) >= end_ ? -1 : f_.supernode_of(f_.row(s, own));
        }

        /// Adds the update of supernode s to a front. The first `own` columns of the front lie in `panel`, the others
        /// in `beyond`.
        /// @param at row of each unknown in the front; rises with the unknowns
        void take_update(std::size_t s, const std::vector<std::int32_t>& at, double* panel, Eigen::Index rows,
            Eigen::Index own, Eigen::MatrixXd& beyond)
        {
            const Eigen::MatrixXd update = std::exchange(updates_[s], {});
            const Eigen::Index first = columns(s), n = update.rows();
            std::vector<Eigen::Index> row(static_cast<std::size_t>(n));
            for (Eigen::Index i = 0; i < n; ++i)
                row[static_cast<std::size_t>(i)] = at[static_cast<std::size_t>(f_.row(s, first + i))];
            for (Eigen::Index j = 0; j < n; ++j) {
                const Eigen::Index column = row[static_cast<std::size_t>(j)], skipped = column < own ? 0 : own;
                double* to = column < own ? panel + column * rows : beyond.data() + (column - own) * beyond.rows();
                for (Eigen::Index i = j; i < n; ++i)
                    to[row[static_cast<std::size_t>(i)] - skipped] += update(i, j);
            }
        }

        /// Factors one front.
        /// @param at -1 for all unknowns, before and after the call
        /// @return as factor_all()
        Eigen::Index factor(std::size_t s, std::vector<std::int32_t>& at)
        {
            const Eigen::Index rows = f_.rows(s), own = columns(s), below = rows - own, first = f_.first[s];
            double* panel = x_ + f_.value_start[s];
            std::fill_n(panel, rows * own, 0.0);
            for (Eigen::Index i = 0; i < rows; ++i)
                at[static_cast<std::size_t>(f_.row(s, i))] = static_cast<std::int32_t>(i);
            for (Eigen::Index c = 0; c < own; ++c)
                for (std::size_t k = matrix_.start[static_cast<std::size_t>(first + c)];
                     k < matrix_.start[static_cast<std::size_t>(first + c) + 1]; ++k)
                    panel[c * rows + at[static_cast<std::size_t>(matrix_.entries[k].row)]] += matrix_.entries[k].value;
            Eigen::MatrixXd update = Eigen::MatrixXd::Zero(below, below);
            for (const std::size_t child : children_[s])
                take_update(child, at, panel, rows, own, update);
            for (Eigen::Index i = 0; i < rows; ++i)
                at[static_cast<std::size_t>(f_.row(s, i))] = -1;
            if (const Eigen::Index stop = factor_block(panel, own, rows); stop >= 0)
                return first + stop;
            const auto n = static_cast<int>(own), m = static_cast<int>(below), stride = static_cast<int>(rows);
            if (below > 0) {
                cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, m, n, 1.0, panel, stride,
                    panel + own, stride);
                cblas_dsyrk(
                    CblasColMajor, CblasLower, CblasNoTrans, m, n, -1.0, panel + own, stride, 1.0, update.data(), m);
            }
            updates_[s] = std::move(update);
            return -1;
        }

        const Supernodes& f_;
        double* x_;
        Eigen::Index end_;
        Columns matrix_;
        std::vector<std::vector<std::size_t>> children_;
        /// Updates on the rows below (lower triangles), until the parent adds them.
        std::vector<Eigen::MatrixXd> updates_;
    };

} // namespace

PartialFactor factor_before(const Supernodes& f, double* x, Eigen::Index end, const SymmetricPattern& pattern,
    const std::vector<std::int32_t>& place, const std::vector<double>& values)
{
    RETRACTOR_ASSERT(end >= 0 && end <= f.size);
    RETRACTOR_ASSERT(place.size() == static_cast<std::size_t>(f.size) && values.size() == pattern.row.size());
    Fronts fronts(f, x, end, columns_before(end, pattern, place, values));
    PartialFactor partial;
    partial.stopped_at = fronts.factor_all();
    if (partial.stopped_at < 0)
        partial.trailing = fronts.trailing();
    return partial;
}

} // namespace retractor::fem
