#include "fem/kept_view.h"

#include "fem/cut_change.h"
#include "fem/dense_algebra.h"
#include "fem/vertex_matrix.h"

#include <algorithm>

namespace retractor {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    void factor_behind(LeftBehind& behind, const RowOf& row)
    {
        behind.place.clear();
        for (std::size_t i = 0; i < behind.vertices.size(); ++i)
            behind.place.emplace(behind.vertices[i], static_cast<std::int32_t>(i));
        if (behind.vertices.empty())
            return;
        SparseMatrix matrix = vertex_matrix(row, behind.vertices, [&](VertexId v) {
            const auto found = behind.place.find(v);
            return found == behind.place.end() ? -1 : found->second;
        });
        behind.factor.analyse(std::move(matrix.pattern), Ordering::minimum_degree);
        behind.factor.factorise(matrix.values);
    }

    /// After a change on the rows t the compliance is C - half columns^T: columns C_t, half = C_t G with the symmetric
    /// G = dK (I + C_tt dK)^-1.
    struct Correction {
        Eigen::MatrixXd half, columns;

        Eigen::MatrixXd rows(const Eigen::MatrixXd& C, const std::vector<std::int32_t>& wanted) const
        {
            Eigen::MatrixXd x(static_cast<Eigen::Index>(wanted.size()), C.cols());
            for (std::size_t i = 0; i < wanted.size(); ++i) // C is symmetric
                x.row(static_cast<Eigen::Index>(i)) = C.col(wanted[i]).transpose();
            if (columns.cols() > 0)
                x -= product(Eigen::MatrixXd(half(wanted, Eigen::all)), Eigen::MatrixXd(columns.transpose()));
            return x;
        }
    };

    Correction correction(const Eigen::MatrixXd& C, const CutChange& change)
    {
        const auto& rows = change.kept_rows;
        Correction c { Eigen::MatrixXd(C.rows(), 0),
            Eigen::MatrixXd(C.rows(), static_cast<Eigen::Index>(rows.size())) };
        for (std::size_t j = 0; j < rows.size(); ++j)
            c.columns.col(static_cast<Eigen::Index>(j)) = C.col(rows[j]);
        if (rows.empty())
            return c;
        Eigen::MatrixXd system = product(change.stiffness, Eigen::MatrixXd(c.columns(rows, Eigen::all)));
        system.diagonal().array() += 1.0;
        Eigen::MatrixXd G = change.stiffness;
        DenseLu(std::move(system)).solve(G);
        c.half = product(c.columns, Eigen::MatrixXd(0.5 * (G + G.transpose())));
        return c;
    }

    Eigen::MatrixXd unit_columns(Eigen::Index rows, const std::vector<std::int32_t>& of_vertices)
    {
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rows, 3 * static_cast<Eigen::Index>(of_vertices.size()));
        for (std::size_t i = 0; i < of_vertices.size(); ++i)
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                unit(3 * of_vertices[i] + axis, 3 * static_cast<Eigen::Index>(i) + axis) = 1.0;
        return unit;
    }

    /// Adds vertices with u = follow u_kept + own f to a compliance.
    Eigen::MatrixXd bordered(
        const Eigen::MatrixXd& C, const Eigen::MatrixXd& follow_times_C, const Eigen::MatrixXd& own_corner)
    {
        const Eigen::Index old = C.rows(), added = own_corner.rows();
        Eigen::MatrixXd grown(old + added, old + added);
        grown.topLeftCorner(old, old) = C;
        grown.bottomLeftCorner(added, old) = follow_times_C;
        grown.topRightCorner(old, added) = follow_times_C.transpose();
        grown.bottomRightCorner(added, added) = own_corner;
        return grown;
    }

} // namespace

void KeptView::keep(VertexId v)
{
    if (static_cast<std::size_t>(v) >= places.size())
        places.resize(static_cast<std::size_t>(v) + 1, -1);
    places[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(vertices.size());
    vertices.push_back(v);
}

KeptView view_of(const CondensedBody& body)
{
    KeptView view;
    for (const VertexId v : body.kept())
        view.keep(v);
    view.body = &body;
    return view;
}

std::vector<std::int32_t> rows_of_vertices(const KeptView& view, const std::vector<VertexId>& vertices)
{
    std::vector<std::int32_t> rows;
    rows.reserve(3 * vertices.size());
    for (const VertexId v : vertices)
        for (std::int32_t axis = 0; axis < 3; ++axis)
            rows.push_back(3 * view.place(v) + axis);
    return rows;
}

FoldSource fold_source(const KeptView& view, const CutChange& change, const OnlineStiffness& K, std::set<VertexId> held)
{
    FoldSource source { .compliance = view.shared_compliance(),
        .vertices = view.vertices,
        .newborn = view.newborn,
        .behind = { view.behind.vertices.begin(), view.behind.vertices.end() },
        .rows = {},
        .held = std::move(held),
        .of_view = { view.vertices.begin(), view.vertices.end() } };
    for (const VertexId v : source.newborn)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : source.behind)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : change.newborn)
        source.rows.emplace(v, K.row(v));
    return source;
}

KeptView fold(const FoldSource& source, const CutChange& change)
{
    const Eigen::MatrixXd& C = *source.compliance;
    const RowOf row = [&](VertexId v) -> const OnlineStiffness::Row& { return source.rows.at(v); };
    const Correction corrected = correction(C, change);
    // Those that cuts had added before this change leave, unless a hook holds them.
    KeptView next;
    std::vector<std::int32_t> staying;
    next.behind.vertices.assign(source.behind.begin(), source.behind.end());
    for (std::size_t i = 0; i < source.vertices.size(); ++i) {
        const VertexId v = source.vertices[i];
        if (source.newborn.contains(v) && !source.held.contains(v)) {
            if (!row(v).column.empty())
                next.behind.vertices.push_back(v);
            continue;
        }
        for (std::int32_t axis = 0; axis < 3; ++axis)
            staying.push_back(3 * static_cast<std::int32_t>(i) + axis);
        next.keep(v);
        if (source.newborn.contains(v))
            next.newborn.insert(v);
    }
    for (const VertexId v : change.newborn) {
        next.keep(v);
        next.newborn.insert(v);
    }
    const auto old = static_cast<Eigen::Index>(staying.size());
    const auto fresh = 3 * static_cast<Eigen::Index>(change.newborn.size());
    Eigen::MatrixXd own(old + fresh, old + fresh);
    copy_lower(C, staying, own.topLeftCorner(old, old));
    subtract_lower_product(
        own.topLeftCorner(old, old), corrected.half(staying, Eigen::all), corrected.columns(staying, Eigen::all));
    if (fresh > 0) {
        std::vector<std::int32_t> beside;
        for (const std::int32_t b : change.beside)
            beside.push_back(change.kept_rows[static_cast<std::size_t>(b)]);
        const auto besides = static_cast<Eigen::Index>(beside.size());
        const Eigen::MatrixXd rows = corrected.rows(C, beside);
        const Eigen::MatrixXd follow = change.newborn_following(Eigen::MatrixXd::Identity(besides, besides));
        own.bottomLeftCorner(fresh, old) = product(follow, Eigen::MatrixXd(rows(Eigen::all, staying)));
        own.bottomRightCorner(fresh, fresh) = change.newborn_alone(Eigen::MatrixXd::Identity(fresh, fresh), row)
            + product(follow, product(Eigen::MatrixXd(rows(Eigen::all, beside)), Eigen::MatrixXd(follow.transpose())));
    }
    mirror_lower(own);
    next.own = std::make_shared<const Eigen::MatrixXd>(std::move(own));
    std::sort(next.behind.vertices.begin(), next.behind.vertices.end());
    factor_behind(next.behind, row);
    return next;
}

void fetch_back(KeptView& view, const OnlineStiffness& K, const std::vector<VertexId>& vertices)
{
    if (vertices.empty())
        return;
    const auto row = [&](VertexId v) -> const OnlineStiffness::Row& {
        const auto found = view.reference.find(v);
        return found == view.reference.end() ? K.row(v) : found->second;
    };
    LeftBehind& behind = view.behind;
    std::vector<std::int32_t> wanted;
    for (const VertexId v : vertices)
        wanted.push_back(behind.place.at(v));
    const auto size = 3 * static_cast<Eigen::Index>(behind.vertices.size());
    const Eigen::MatrixXd unit = unit_columns(size, wanted);
    const Eigen::MatrixXd alone = behind.factor.solve(unit); // K_zz^-1 E_w
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(view.compliance().rows(), alone.cols()); // K_kz K_zz^-1 E_w
    for (std::size_t z = 0; z < behind.vertices.size(); ++z) {
        const OnlineStiffness::Row& full = row(behind.vertices[z]);
        for (std::size_t k = 0; k < full.column.size(); ++k)
            if (const std::int32_t at = view.place(full.column[k]); at >= 0)
                pull.middleRows(3 * at, 3) += RowBlock(full.value.data() + 9 * k).transpose()
                    * alone.middleRows(3 * static_cast<Eigen::Index>(z), 3);
    }
    const Eigen::MatrixXd under = product(view.compliance(), pull);
    const Eigen::MatrixXd own = product_transposed(unit, alone) + product_transposed(pull, under);
    view.own = std::make_shared<const Eigen::MatrixXd>(bordered(view.compliance(), -under.transpose(), own));
    view.body = nullptr;
    for (const VertexId v : vertices) {
        view.keep(v);
        view.newborn.insert(v);
        std::erase(behind.vertices, v);
    }
    factor_behind(behind, row);
}

void keep_also(KeptView& view, const AddedVertices& added)
{
    const std::vector<std::int32_t> before = rows_of_vertices(view, added.before);
    const Eigen::MatrixXd of_before = view.compliance()(before, Eigen::all);
    const Eigen::MatrixXd cross = product(added.follow, of_before);
    const Eigen::MatrixXd own
        = added.own + product(Eigen::MatrixXd(cross(Eigen::all, before)), Eigen::MatrixXd(added.follow.transpose()));
    view.own = std::make_shared<const Eigen::MatrixXd>(bordered(view.compliance(), cross, own));
    view.body = nullptr;
    for (const VertexId v : added.vertices)
        view.keep(v);
}

} // namespace retractor
