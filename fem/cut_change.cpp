#include "fem/cut_change.h"

#include "fem/dense_algebra.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <string>

namespace retractor {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    RowBlock block(const OnlineStiffness::Row& row, std::size_t k) { return RowBlock(row.value.data() + 9 * k); }

    bool differs(const OnlineStiffness& K, VertexId v, const OnlineStiffness::Row& reference)
    {
        return !(K.row(v) == reference);
    }

    /// Rows of the change, before the newborn are eliminated. A vertex that is gone, or fixed now, is put on a spring
    /// of its own: it stays where it is and nothing feels it.
    void add_change(const OnlineStiffness& K, const CondensedBody& body, const ReferenceRows& reference,
        const std::vector<std::uint8_t>& active, const std::map<VertexId, std::int32_t>& place, CutChange& change)
    {
        const auto is_active = [&](VertexId v) { return active[static_cast<std::size_t>(v)] != 0; };
        const auto add = [&](const OnlineStiffness::Row& row, Eigen::Index at, double sign) {
            for (std::size_t k = 0; k < row.column.size(); ++k)
                if (body.has(row.column[k]) && (sign < 0.0 || is_active(row.column[k])))
                    if (const auto other = place.find(row.column[k]); other != place.end())
                        change.stiffness.block<3, 3>(at, 3 * other->second) += sign * block(row, k);
        };
        for (const VertexId v : change.changed) {
            const Eigen::Index at = 3 * place.at(v);
            const OnlineStiffness::Row& before = reference.at(v);
            if (is_active(v))
                add(K.row(v), at, 1.0);
            add(before, at, -1.0);
            if (is_active(v))
                continue;
            const auto self = std::lower_bound(before.column.begin(), before.column.end(), v) - before.column.begin();
            const RowBlock own = block(before, static_cast<std::size_t>(self));
            change.stiffness.block<3, 3>(at, at) += own.trace() * Mat3::Identity();
        }
    }

    void factor_newborn(const OnlineStiffness& K, CutChange& change)
    {
        SymmetricPattern pattern;
        std::vector<double> values;
        pattern.column_start.push_back(0);
        for (std::size_t j = 0; j < change.newborn.size(); ++j) {
            const OnlineStiffness::Row& row = K.row(change.newborn[j]);
            for (std::int32_t axis = 0; axis < 3; ++axis) {
                for (std::size_t k = 0; k < row.column.size(); ++k) {
                    const auto other = change.newborn_place.find(row.column[k]);
                    if (other == change.newborn_place.end() || other->second > static_cast<std::int32_t>(j))
                        continue;
                    const std::int32_t entries = other->second == static_cast<std::int32_t>(j) ? axis + 1 : 3;
                    for (std::int32_t a = 0; a < entries; ++a) {
                        pattern.row.push_back(3 * other->second + a);
                        values.push_back(block(row, k)(axis, a));
                    }
                }
                pattern.column_start.push_back(static_cast<std::int32_t>(pattern.row.size()));
            }
        }
        change.newborn_factor.analyse(std::move(pattern), Ordering::minimum_degree);
        change.newborn_factor.factorise(values);
    }

    void eliminate_newborn(const OnlineStiffness& K, const std::map<VertexId, std::int32_t>& place, CutChange& change)
    {
        if (change.newborn.empty())
            return;
        std::map<std::int32_t, std::int32_t> beside_place; // of changed vertices
        for (const VertexId v : change.newborn)
            for (const VertexId other : K.row(v).column)
                if (const auto found = place.find(other); found != place.end())
                    beside_place.emplace(found->second, 0);
        std::int32_t next = 0;
        for (auto& [changed, at] : beside_place) {
            at = next++;
            for (std::int32_t axis = 0; axis < 3; ++axis)
                change.beside.push_back(3 * changed + axis);
        }
        change.coupling = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(change.newborn.size()), 3 * next);
        for (std::size_t n = 0; n < change.newborn.size(); ++n) {
            const OnlineStiffness::Row& row = K.row(change.newborn[n]);
            for (std::size_t k = 0; k < row.column.size(); ++k)
                if (const auto found = place.find(row.column[k]); found != place.end())
                    change.coupling.block<3, 3>(3 * static_cast<Eigen::Index>(n), 3 * beside_place.at(found->second))
                        = block(row, k);
        }
        factor_newborn(K, change);
        change.newborn_by_beside = change.newborn_factor.solve(change.coupling);
        // K_bn (K_nn^-1 K_nb): a row of K_bn has few entries.
        const Eigen::Index count = change.coupling.cols();
        Eigen::MatrixXd condensed = Eigen::MatrixXd::Zero(count, count);
        std::vector<std::pair<Eigen::Index, double>> entries;
        const Eigen::MatrixXd by_row = change.newborn_by_beside.transpose();
        for (Eigen::Index b = 0; b < count; ++b)
            for (Eigen::Index n = 0; n < change.coupling.rows(); ++n)
                if (const double k = change.coupling(n, b); k != 0.0)
                    condensed.col(b) += k * by_row.col(n);
        for (Eigen::Index b = 0; b < count; ++b)
            for (Eigen::Index a = 0; a < count; ++a)
                change.stiffness(change.beside[static_cast<std::size_t>(a)], change.beside[static_cast<std::size_t>(b)])
                    -= 0.5 * (condensed(a, b) + condensed(b, a));
    }

} // namespace

Eigen::MatrixXd CutChange::newborn_alone(const Eigen::MatrixXd& load) const
{
    if (newborn.empty())
        return load;
    return const_cast<SparseCholesky&>(newborn_factor).solve(load);
}

std::vector<VertexId> changed_but_not_kept(
    const OnlineStiffness& K, const CondensedBody& body, const ReferenceRows& reference)
{
    std::vector<VertexId> missing;
    for (const auto& [v, row] : reference)
        if (body.has(v) && body.place(v) < 0 && differs(K, v, row))
            missing.push_back(v);
    return missing;
}

CutChange make_cut_change(const OnlineStiffness& K, const CondensedBody& body, const ReferenceRows& reference,
    const std::vector<std::uint8_t>& active, const std::set<VertexId>& newborn, const std::set<VertexId>& held)
{
    CutChange change;
    std::map<VertexId, std::int32_t> place;
    for (const auto& [v, row] : reference)
        if (body.place(v) >= 0 && differs(K, v, row)) {
            place.emplace(v, static_cast<std::int32_t>(change.changed.size()));
            change.changed.push_back(v);
            for (std::int32_t axis = 0; axis < 3; ++axis)
                change.kept_rows.push_back(3 * body.place(v) + axis);
        }
    for (const VertexId v : newborn)
        if (!held.contains(v)) {
            change.newborn_place.emplace(v, static_cast<std::int32_t>(change.newborn.size()));
            change.newborn.push_back(v);
        }
    const auto size = static_cast<Eigen::Index>(change.kept_rows.size());
    change.stiffness = Eigen::MatrixXd::Zero(size, size);
    add_change(K, body, reference, active, place, change);
    eliminate_newborn(K, place, change);
    return change;
}

} // namespace retractor
