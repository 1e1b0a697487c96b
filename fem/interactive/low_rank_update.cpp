#include "fem/interactive/low_rank_update.h"

#include "fem/linear_algebra/dense_algebra.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace retractor::fem {

UpdateSource update_source(const CondensedState& state, const CutChange& change, const OnlineStiffness& K,
    std::set<VertexId> held, bool leaving)
{
    UpdateSource source { .compliance = state.shared_compliance(),
        .vertices = state.vertices,
        .added = state.added,
        .eliminated_added = { state.eliminated_added.vertices.begin(), state.eliminated_added.vertices.end() },
        .rows = {},
        .held = std::move(held),
        .origin = !leaving          ? nullptr
            : state.body != nullptr ? state.shared_compliance()
                                    : state.origin,
        .steps = state.steps,
        .stale = state.stale,
        .dropped = state.dropped,
        .vertex_set = { state.vertices.begin(), state.vertices.end() } };
    for (const VertexId v : source.added)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : source.eliminated_added)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : change.added)
        source.rows.emplace(v, K.row(v));
    return source;
}

namespace {

    /// The compliance after a change on the rows t is C - columns taken columns^T, with columns = C_t and the symmetric
    /// taken = dK (I + C_tt dK)^-1 (Woodbury formula).
    struct Correction {
        Eigen::MatrixXd columns, taken;
    };

    Correction correction(const Eigen::MatrixXd& C, const CutChange& change)
    {
        const auto& rows = change.kept_rows;
        Correction c { Eigen::MatrixXd(C.rows(), static_cast<Eigen::Index>(rows.size())), change.stiffness };
        for (std::size_t j = 0; j < rows.size(); ++j)
            c.columns.col(static_cast<Eigen::Index>(j)) = C.col(rows[j]);
        if (rows.empty())
            return c;
        Eigen::MatrixXd system = product(change.stiffness, Eigen::MatrixXd(c.columns(rows, Eigen::all)));
        system.diagonal().array() += 1.0;
        Eigen::MatrixXd G = change.stiffness;
        DenseLu(std::move(system)).solve(G);
        c.taken = 0.5 * (G + G.transpose());
        return c;
    }

    /// Decides which vertices the next state retains, eliminates or drops.
    /// @param staying their rows in the state before
    void sort_out(
        const UpdateSource& source, const CutChange& change, CondensedState& next, std::vector<std::int32_t>& staying)
    {
        const std::set<VertexId> changed(change.changed.begin(), change.changed.end());
        next.dropped = source.dropped;
        next.eliminated_added.vertices.assign(source.eliminated_added.begin(), source.eliminated_added.end());
        for (std::size_t i = 0; i < source.vertices.size(); ++i) {
            const VertexId v = source.vertices[i];
            const bool added = source.added.contains(v), is_held = source.held.contains(v);
            if (added && !is_held) {
                if (!source.rows.at(v).column.empty())
                    next.eliminated_added.vertices.push_back(v);
                continue;
            }
            if (source.origin && !added && !is_held && source.stale.contains(v) && !changed.contains(v)) {
                next.dropped.insert(v);
                continue;
            }
            for (std::int32_t axis = 0; axis < 3; ++axis)
                staying.push_back(3 * static_cast<std::int32_t>(i) + axis);
            next.keep(v);
            if (added)
                next.added.insert(v);
            else if (changed.contains(v) || source.stale.contains(v))
                next.stale.insert(v);
        }
        for (const VertexId v : change.added) {
            next.keep(v);
            next.added.insert(v);
        }
        std::sort(next.eliminated_added.vertices.begin(), next.eliminated_added.vertices.end());
    }

    /// Compliance of the vertices that stay and of the added vertices, which follow `beside`. Sets the members `beside`
    /// and `follow` of the step.
    Eigen::MatrixXd updated_compliance(
        const UpdateSource& source, const CutChange& change, const Correction& corrected, LowRankUpdate& step)
    {
        const Eigen::MatrixXd& C = *source.compliance;
        const auto old = static_cast<Eigen::Index>(step.staying.size());
        const auto fresh = 3 * static_cast<Eigen::Index>(change.added.size());
        Eigen::MatrixXd own(old + fresh, old + fresh);
        copy_lower(C, step.staying, own.topLeftCorner(old, old));
        const Eigen::MatrixXd columns = corrected.columns(step.staying, Eigen::all),
                              half = product(columns, corrected.taken);
        subtract_lower_product(own.topLeftCorner(old, old), half, columns);
        if (fresh > 0) {
            for (const std::int32_t b : change.beside)
                step.beside.push_back(change.kept_rows[static_cast<std::size_t>(b)]);
            const auto besides = static_cast<Eigen::Index>(step.beside.size());
            const Eigen::MatrixXd columns_beside = corrected.columns(step.beside, Eigen::all),
                                  half_beside = product(columns_beside, corrected.taken);
            Eigen::MatrixXd to_staying(besides, old), among(besides, besides); // of the corrected compliance
            for (Eigen::Index b = 0; b < besides; ++b) { // C is symmetric
                const auto column = C.col(step.beside[static_cast<std::size_t>(b)]);
                to_staying.row(b) = column(step.staying).transpose();
                among.row(b) = column(step.beside).transpose();
            }
            to_staying -= product(half_beside, Eigen::MatrixXd(columns.transpose()));
            among -= product(half_beside, Eigen::MatrixXd(columns_beside.transpose()));
            step.follow = change.added_following(Eigen::MatrixXd::Identity(besides, besides));
            own.bottomLeftCorner(fresh, old) = product(step.follow, to_staying);
            own.bottomRightCorner(fresh, fresh)
                = change.added_alone(Eigen::MatrixXd::Identity(fresh, fresh)).displacement
                + product(step.follow, product(among, Eigen::MatrixXd(step.follow.transpose())));
        }
        mirror_lower(own);
        return own;
    }

} // namespace

CondensedState apply_update(const UpdateSource& source, const CutChange& change)
{
    Correction corrected = correction(*source.compliance, change);
    CondensedState next;
    auto step = std::make_shared<LowRankUpdate>();
    sort_out(source, change, next, step->staying);
    next.own = std::make_shared<const Eigen::MatrixXd>(updated_compliance(source, change, corrected, *step));
    next.eliminated_added.number_and_factor(
        [&](VertexId v) -> const OnlineStiffness::Row& { return source.rows.at(v); });
    if (source.origin) {
        step->changed = change.kept_rows;
        step->columns = std::move(corrected.columns);
        step->taken = std::move(corrected.taken);
        next.origin = source.origin;
        next.steps = source.steps;
        next.steps.push_back(std::move(step));
    }
    return next;
}

} // namespace retractor::fem
