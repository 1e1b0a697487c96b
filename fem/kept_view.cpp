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

    /// C - C_t G C_t^T with G = dK (I + C_tt dK)^-1: the compliance after a change on the rows t.
    Eigen::MatrixXd changed_compliance(const Eigen::MatrixXd& C, const CutChange& change)
    {
        const auto& rows = change.kept_rows;
        if (rows.empty())
            return C;
        Eigen::MatrixXd C_t(C.rows(), static_cast<Eigen::Index>(rows.size()));
        for (std::size_t j = 0; j < rows.size(); ++j)
            C_t.col(static_cast<Eigen::Index>(j)) = C.col(rows[j]);
        Eigen::MatrixXd system = product(change.stiffness, Eigen::MatrixXd(C_t(rows, Eigen::all)));
        system.diagonal().array() += 1.0;
        Eigen::MatrixXd G = change.stiffness;
        DenseLu(std::move(system)).solve(G);
        const Eigen::MatrixXd half = product(C_t, Eigen::MatrixXd(0.5 * (G + G.transpose())));
        Eigen::MatrixXd after = C;
        subtract_symmetric_product(after, half, C_t);
        return after;
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
    view.of_body = &body.compliance();
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

KeptView fold(const KeptView& view, const CutChange& change, const OnlineStiffness& K, const std::set<VertexId>& held)
{
    const Eigen::MatrixXd C = changed_compliance(view.compliance(), change);
    // Those that cuts had added before this change leave, unless a hook holds them.
    KeptView next;
    std::vector<VertexId> stay;
    next.behind.vertices = view.behind.vertices;
    for (const VertexId v : view.vertices)
        if (view.newborn.contains(v) && !held.contains(v)) {
            if (K.alive(v))
                next.behind.vertices.push_back(v);
        } else {
            stay.push_back(v);
            next.keep(v);
            if (view.newborn.contains(v))
                next.newborn.insert(v);
        }
    const auto staying = rows_of_vertices(view, stay);
    Eigen::MatrixXd beside_rows(static_cast<Eigen::Index>(change.beside.size()), C.cols());
    for (std::size_t b = 0; b < change.beside.size(); ++b)
        beside_rows.row(static_cast<Eigen::Index>(b))
            = C.row(change.kept_rows[static_cast<std::size_t>(change.beside[b])]);
    std::vector<std::int32_t> beside_in_view;
    for (const std::int32_t b : change.beside)
        beside_in_view.push_back(change.kept_rows[static_cast<std::size_t>(b)]);
    for (const VertexId v : change.newborn) {
        next.keep(v);
        next.newborn.insert(v);
    }
    const Eigen::MatrixXd kept = C(staying, staying);
    if (change.newborn.empty()) {
        next.own = kept;
    } else {
        const Eigen::MatrixXd follow = change.newborn_following(
            Eigen::MatrixXd::Identity(beside_rows.rows(), beside_rows.rows())); // 3 newborn x beside
        const Eigen::MatrixXd cross = product(follow, Eigen::MatrixXd(beside_rows(Eigen::all, staying)));
        const Eigen::MatrixXd beside_beside = beside_rows(Eigen::all, beside_in_view);
        const auto count = 3 * static_cast<Eigen::Index>(change.newborn.size());
        const Eigen::MatrixXd own = change.newborn_alone(Eigen::MatrixXd::Identity(count, count), K)
            + product(follow, product(beside_beside, Eigen::MatrixXd(follow.transpose())));
        next.own = bordered(kept, cross, own);
    }
    std::sort(next.behind.vertices.begin(), next.behind.vertices.end());
    factor_behind(next.behind, [&K](VertexId v) -> const OnlineStiffness::Row& { return K.row(v); });
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
    view.own = bordered(view.compliance(), -under.transpose(), own);
    view.of_body = nullptr;
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
    view.own = bordered(view.compliance(), cross, own);
    view.of_body = nullptr;
    for (const VertexId v : added.vertices)
        view.keep(v);
}

} // namespace retractor
