#include "fem/linear_algebra/partial_factor.h"

#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"

#include <cblas.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace retractor::fem {

FrontUpdate UpdateMemory::zeros(Eigen::Index n)
{
    const auto size = static_cast<std::size_t>(n * n);
    FrontUpdate update;
    {
        const std::scoped_lock lock(mutex_);
        const auto at = std::lower_bound(free_.begin(), free_.end(), size,
            [](const FrontUpdate& one, std::size_t wanted) { return one.capacity < wanted; });
        if (at != free_.end()) {
            update = std::move(*at);
            free_.erase(at);
        } else if (!free_.empty()) {
            free_.pop_back();
        }
    }
    if (update.capacity < size) {
        update.values.reset(new double[size]);
        update.capacity = size;
    }
    update.n = n;
    for (Eigen::Index j = 0; j < n; ++j)
        std::fill_n(update.values.get() + j * n + j, n - j, 0.0);
    return update;
}

void UpdateMemory::give_back(FrontUpdate update)
{
    if (update.capacity == 0)
        return;
    const std::scoped_lock lock(mutex_);
    free_.insert(std::upper_bound(free_.begin(), free_.end(), update,
                     [](const FrontUpdate& a, const FrontUpdate& b) { return a.capacity < b.capacity; }),
        std::move(update));
}

std::size_t UpdateMemory::bytes() const
{
    const std::scoped_lock lock(mutex_);
    std::size_t sum = 0;
    for (const FrontUpdate& update : free_)
        sum += update.capacity * sizeof(double);
    return sum;
}

void UpdateMemory::release()
{
    const std::scoped_lock lock(mutex_);
    free_ = std::vector<FrontUpdate>();
}

namespace {

    /// The columns of the lower triangle before `end`, with rows and columns in the order of elimination.
    struct Columns {
        struct Entry {
            std::int32_t row, source; ///< `source`: place among the values of the matrix
        };
        std::vector<std::size_t> start;
        std::vector<Entry> entries;
    };

    Columns columns_before(Eigen::Index end, const SymmetricPattern& pattern, const std::vector<std::int32_t>& place)
    {
        Columns columns { std::vector<std::size_t>(static_cast<std::size_t>(end) + 1, 0), {} };
        const auto for_entries = [&](const auto& work) {
            for (std::size_t j = 0; j < place.size(); ++j)
                for (auto k = static_cast<std::size_t>(pattern.column_start[j]);
                     k < static_cast<std::size_t>(pattern.column_start[j + 1]); ++k) {
                    const auto [column, row] = std::minmax(place[j], place[static_cast<std::size_t>(pattern.row[k])]);
                    if (column < end)
                        work(static_cast<std::size_t>(column), row, static_cast<std::int32_t>(k));
                }
        };
        for_entries([&](std::size_t column, std::int32_t, std::int32_t) { ++columns.start[column + 1]; });
        for (std::size_t c = 0; c + 1 < columns.start.size(); ++c)
            columns.start[c + 1] += columns.start[c];
        columns.entries.resize(columns.start.back());
        std::vector<std::size_t> next = columns.start;
        for_entries([&](std::size_t column, std::int32_t row, std::int32_t source) {
            columns.entries[next[column]++] = { row, source };
        });
        return columns;
    }

    constexpr Eigen::Index kWorthTwoCores = 400; ///< rows of an update

    /// The dense fronts of all supernodes. A front has the supernode's own columns and the rows below that these
    /// columns reach.
    class Fronts {
    public:
        Fronts(const Supernodes& f, double* x, Eigen::Index end, Columns matrix, const std::vector<double>& values,
            UpdateMemory& memory)
            : f_(f)
            , x_(x)
            , end_(end)
            , matrix_(std::move(matrix))
            , values_(values)
            , memory_(memory)
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
            const auto all_of = [&](const std::vector<std::size_t>& falling, RowOf& at, Cores cores) {
                for (auto s = falling.rbegin(); s != falling.rend(); ++s)
                    if (const Eigen::Index stop = factor(*s, at, cores); stop >= 0)
                        return stop;
                return Eigen::Index { -1 };
            };
            RowOf at(static_cast<std::size_t>(f_.size), -1), other_at = at;
            Eigen::Index stop = -1, other_stop = -1;
            std::exception_ptr failed; // exception of the other thread, e.g. out of memory; rethrown in this thread
            {
                const ScopedThread other([&] {
                    try {
                        other_stop = all_of(parts.below[1], other_at, Cores::one);
                    } catch (...) {
                        failed = std::current_exception();
                    }
                });
                stop = all_of(parts.below[0], at, Cores::one);
            }
            if (failed)
                std::rethrow_exception(failed);
            stop = std::max(stop, other_stop);
            return stop >= 0 ? stop : all_of(parts.above, at, Cores::two);
        }

        /// Gives back the memory of the updates that no parent has added. Call where the factorisation stopped.
        void give_back_updates()
        {
            for (FrontUpdate& update : updates_)
                memory_.give_back(std::move(update));
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
                    take_update(updates_[s], s, at, nullptr, 0, 0, sum.data(), sum.rows(), Cores::one);
            return sum;
        }

    private:
        /// The row of each unknown in the front at hand; -1 between two fronts. Each thread has its own.
        using RowOf = std::vector<std::int32_t>;

        Eigen::Index columns(std::size_t s) const { return std::min<Eigen::Index>(f_.columns(s), end_ - f_.first[s]); }

        /// The parent front, or -1 when all rows below belong to unknowns that are not factored.
        std::int32_t parent(std::size_t s) const
        {
            const Eigen::Index own = columns(s);
            return own == f_.rows(s) || f_.row(s, own) >= end_ ? -1 : f_.supernode_of(f_.row(s, own));
        }

        /// Adds the update of supernode s to a front. The first `own` columns of the front lie in `panel` (`rows`
        /// rows), the others in `beyond` (`beyond_rows` rows).
        /// @param at row of each unknown in the front; rises with the unknowns
        void take_update(const FrontUpdate& update, std::size_t s, const RowOf& at, double* panel, Eigen::Index rows,
            Eigen::Index own, double* beyond, Eigen::Index beyond_rows, Cores cores) const
        {
            const Eigen::Index first = columns(s), n = update.n;
            std::vector<Eigen::Index> row(static_cast<std::size_t>(n));
            for (Eigen::Index i = 0; i < n; ++i)
                row[static_cast<std::size_t>(i)] = at[static_cast<std::size_t>(f_.row(s, first + i))];
            const auto add_columns = [&](Eigen::Index from, Eigen::Index to) {
                for (Eigen::Index j = from; j < to; ++j) {
                    const Eigen::Index column = row[static_cast<std::size_t>(j)], skipped = column < own ? 0 : own;
                    double* sum = column < own ? panel + column * rows : beyond + (column - own) * beyond_rows;
                    const double* added = update.column(j);
                    for (Eigen::Index i = j; i < n; ++i)
                        sum[row[static_cast<std::size_t>(i)] - skipped] += added[i];
                }
            };
            if (cores == Cores::one || n < kWorthTwoCores)
                return add_columns(0, n);
            const ScopedThread other([&] { add_columns(half_of_lower(n), n); });
            add_columns(0, half_of_lower(n));
        }

        /// Factors one front.
        /// @return as factor_all()
        Eigen::Index factor(std::size_t s, RowOf& at, Cores cores)
        {
            const Eigen::Index rows = f_.rows(s), own = columns(s), below = rows - own, first = f_.first[s];
            double* panel = x_ + f_.value_start[s];
            std::fill_n(panel, rows * own, 0.0);
            for (Eigen::Index i = 0; i < rows; ++i)
                at[static_cast<std::size_t>(f_.row(s, i))] = static_cast<std::int32_t>(i);
            for (Eigen::Index c = 0; c < own; ++c)
                for (std::size_t k = matrix_.start[static_cast<std::size_t>(first + c)];
                     k < matrix_.start[static_cast<std::size_t>(first + c) + 1]; ++k)
                    panel[c * rows + at[static_cast<std::size_t>(matrix_.entries[k].row)]]
                        += values_[static_cast<std::size_t>(matrix_.entries[k].source)];
            FrontUpdate update = memory_.zeros(below);
            for (const std::size_t child : children_[s]) {
                FrontUpdate taken = std::exchange(updates_[child], {});
                take_update(taken, child, at, panel, rows, own, update.values.get(), below, cores);
                memory_.give_back(std::move(taken));
            }
            for (Eigen::Index i = 0; i < rows; ++i)
                at[static_cast<std::size_t>(f_.row(s, i))] = -1;
            if (const Eigen::Index stop = factor_block(panel, own, rows); stop >= 0)
                return first + stop;
            if (below > 0) {
                Eigen::Map<Eigen::MatrixXd> front(panel, rows, own);
                const Cores worth = below < kWorthTwoCores ? Cores::one : cores;
                divide_by_transpose(front.topRows(own), front.bottomRows(below), worth);
                subtract_lower_product(update.matrix(), front.bottomRows(below), front.bottomRows(below), worth);
            }
            updates_[s] = std::move(update);
            return -1;
        }

        const Supernodes& f_;
        double* x_;
        Eigen::Index end_;
        Columns matrix_;
        const std::vector<double>& values_;
        UpdateMemory& memory_;
        std::vector<std::vector<std::size_t>> children_;
        /// Updates on the rows below (lower triangles), until the parent adds them.
        std::vector<FrontUpdate> updates_;
    };

} // namespace

PartialFactor factor_before(const Supernodes& f, double* x, Eigen::Index end, const SymmetricPattern& pattern,
    const std::vector<std::int32_t>& place, const std::vector<double>& values, UpdateMemory& memory)
{
    RETRACTOR_ASSERT(end >= 0 && end <= f.size);
    RETRACTOR_ASSERT(place.size() == static_cast<std::size_t>(f.size) && values.size() == pattern.row.size());
    Fronts fronts(f, x, end, columns_before(end, pattern, place), values, memory);
    PartialFactor partial;
    partial.stopped_at = fronts.factor_all();
    if (partial.stopped_at < 0)
        partial.trailing = fronts.trailing();
    else
        fronts.give_back_updates();
    return partial;
}

} // namespace retractor::fem
