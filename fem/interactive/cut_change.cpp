#include "fem/interactive/cut_change.h"

#include "fem/interactive/vertex_matrix.h"
#include "mesh/base/assert.h"

#include <algorithm>

namespace retractor::fem {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    RowBlock block(const OnlineStiffness::Row& row, std::size_t k) { return RowBlock(row.value.data() + 9 * k); }

    using Places = std::map<VertexId, std::int32_t>;
    std::int32_t find(const Places& places, VertexId v)
    {
        const auto found = places.find(v);
        return found == places.end() ? -1 : found->second;
    }

    RowOf rows_of(const OnlineStiffness& K)
    {
        return [&K](VertexId v) -> const OnlineStiffness::Row& { return K.row(v); };
    }

    /// Adds the blocks of the change, without the contribution of added vertices. A vertex that is gone, or is fixed
    /// now, is put on a spring of its own: the vertex stays where it is and affects no other vertex.
    void add_change(const OnlineStiffness& K, const CondensedState& state, const std::vector<std::uint8_t>& active,
        const Places& place, CutChange& change)
    {
        const auto is_active = [&](VertexId v) { return active[static_cast<std::size_t>(v)] != 0; };
        const auto add = [&](const OnlineStiffness::Row& row, std::int32_t at, double sign) {
            for (std::size_t k = 0; k < row.column.size(); ++k)
                if (const std::int32_t other = find(place, row.column[k]);
                    other >= 0 && (sign < 0.0 || is_active(row.column[k])))
                    change.blocks.push_back({ at, other, sign * block(row, k) });
        };
        for (const VertexId v : change.changed) {
            const std::int32_t at = place.at(v);
            const OnlineStiffness::Row& before = state.reference.at(v);
            if (is_active(v))
                add(K.row(v), at, 1.0);
            add(before, at, -1.0);
            if (is_active(v))
                continue;
            const auto self = std::lower_bound(before.column.begin(), before.column.end(), v) - before.column.begin();
            if (static_cast<std::size_t>(self) < before.column.size()) {
                const RowBlock own = block(before, static_cast<std::size_t>(self));
                change.blocks.push_back({ at, at, own.trace() * Mat3::Identity() });
            }
        }
    }

    void eliminate_added(const OnlineStiffness& K, const Places& place, CutChange& change)
    {
        if (change.added.empty())
            return;
        std::set<std::int32_t> beside;
        for (const VertexId v : change.added)
            for (const VertexId other : K.row(v).column)
                if (const std::int32_t at = find(place, other); at >= 0)
                    beside.insert(at);
        std::vector<VertexId> vertices = change.added;
        Places number = change.added_place;
        for (const std::int32_t at : beside) {
            const VertexId v = change.changed[static_cast<std::size_t>(at)];
            number.emplace(v, static_cast<std::int32_t>(vertices.size()));
            vertices.push_back(v);
            for (std::int32_t axis = 0; axis < 3; ++axis)
                change.beside.push_back(3 * at + axis);
        }
        const auto number_of = [&](VertexId v) { return find(number, v); };
        SparseMatrix matrix = vertex_matrix(rows_of(K), vertices, number_of);
        change.condensing.analyse_in_order(std::move(matrix.pattern),
            condensing_order(rows_of(K), vertices, number_of, change.added.size(), Ordering::minimum_degree));
        change.taken = change.condensing.condense(matrix.values, static_cast<Eigen::Index>(change.beside.size()));
    }

} // namespace

Eigen::MatrixXd CutChange::added_following(const Eigen::MatrixXd& beside_displacement) const
{
    RETRACTOR_ASSERT(beside_displacement.rows() == static_cast<Eigen::Index>(beside.size()));
    const auto rows = 3 * static_cast<Eigen::Index>(added.size());
    if (rows == 0)
        return Eigen::MatrixXd::Zero(0, beside_displacement.cols());
    Eigen::MatrixXd x(rows + beside_displacement.rows(), beside_displacement.cols());
    x.bottomRows(beside_displacement.rows()) = beside_displacement;
    condensing.fill_from_trailing(beside_displacement.rows(), x);
    return x.topRows(rows);
}

CutChange::Pushed CutChange::added_alone(const Eigen::MatrixXd& load) const
{
    RETRACTOR_ASSERT(load.rows() == 3 * static_cast<Eigen::Index>(added.size()));
    const auto besides = static_cast<Eigen::Index>(beside.size());
    if (added.empty())
        return { load, Eigen::MatrixXd::Zero(besides, load.cols()) };
    Eigen::MatrixXd x(load.rows() + besides, load.cols());
    x.topRows(load.rows()) = load;
    x.bottomRows(besides).setZero();
    condensing.reduce_to_trailing(besides, x);
    Pushed pushed { {}, x.bottomRows(besides) };
    x.bottomRows(besides).setZero();
    condensing.fill_from_trailing_loaded(besides, x);
    pushed.displacement = x.topRows(load.rows());
    return pushed;
}

Eigen::MatrixXd changed_stiffness(const CutChange& change)
{
    const auto size = static_cast<Eigen::Index>(change.kept_rows.size());
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
    for (const CutChange::Block& b : change.blocks)
        stiffness.block<3, 3>(3 * b.row, 3 * b.column) += b.value;
    for (std::size_t b = 0; b < change.beside.size(); ++b)
        for (std::size_t a = b; a < change.beside.size(); ++a) {
            const double value = change.taken(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
            stiffness(change.beside[a], change.beside[b]) += value;
            if (a != b)
                stiffness(change.beside[b], change.beside[a]) += value;
        }
    return stiffness;
}

std::vector<VertexId> changed_vertices(const OnlineStiffness& K, const CondensedState& state)
{
    std::vector<VertexId> changed;
    for (const auto& [v, row] : state.reference)
        if (state.place(v) >= 0 && !(K.row(v) == row))
            changed.push_back(v);
    return changed;
}

CutChange make_cut_change(const OnlineStiffness& K, const CondensedState& state,
    const std::vector<std::uint8_t>& active, const std::set<VertexId>& added, const std::set<VertexId>& held)
{
    CutChange change;
    change.changed = changed_vertices(K, state);
    change.kept_rows = rows_of_vertices(state, change.changed);
    Places place;
    for (std::size_t i = 0; i < change.changed.size(); ++i)
        place.emplace(change.changed[i], static_cast<std::int32_t>(i));
    for (const VertexId v : added)
        if (!held.contains(v)) {
            change.added_place.emplace(v, static_cast<std::int32_t>(change.added.size()));
            change.added.push_back(v);
        }
    add_change(K, state, active, place, change);
    eliminate_added(K, place, change);
    return change;
}

} // namespace retractor::fem
