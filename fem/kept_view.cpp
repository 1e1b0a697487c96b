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

    /// After a change on the rows t the compliance is C - columns taken columns^T: columns C_t, taken the symmetric
    /// dK (I + C_tt dK)^-1.
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

FoldSource fold_source(
    const KeptView& view, const CutChange& change, const OnlineStiffness& K, std::set<VertexId> held, bool leaving)
{
    FoldSource source { .compliance = view.shared_compliance(),
        .vertices = view.vertices,
        .newborn = view.newborn,
        .behind = { view.behind.vertices.begin(), view.behind.vertices.end() },
        .rows = {},
        .held = std::move(held),
        .origin = !leaving         ? nullptr
            : view.body != nullptr ? view.shared_compliance()
                                   : view.origin,
        .steps = view.steps,
        .passed = view.passed,
        .left = view.left,
        .of_view = { view.vertices.begin(), view.vertices.end() } };
    for (const VertexId v : source.newborn)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : source.behind)
        source.rows.emplace(v, K.row(v));
    for (const VertexId v : change.newborn)
        source.rows.emplace(v, K.row(v));
    return source;
}

namespace {

    /// Who stays, is left behind, or leaves. @param staying their rows before.
    void sort_out(const FoldSource& source, const CutChange& change, KeptView& next, std::vector<std::int32_t>& staying)
    {
        const std::set<VertexId> changed(change.changed.begin(), change.changed.end());
        next.left = source.left;
        next.behind.vertices.assign(source.behind.begin(), source.behind.end());
        for (std::size_t i = 0; i < source.vertices.size(); ++i) {
            const VertexId v = source.vertices[i];
            const bool newborn = source.newborn.contains(v), is_held = source.held.contains(v);
            if (newborn && !is_held) {
                if (!source.rows.at(v).column.empty())
                    next.behind.vertices.push_back(v);
                continue;
            }
            if (source.origin && !newborn && !is_held && source.passed.contains(v) && !changed.contains(v)) {
                next.left.insert(v);
                continue;
            }
            for (std::int32_t axis = 0; axis < 3; ++axis)
                staying.push_back(3 * static_cast<std::int32_t>(i) + axis);
            next.keep(v);
            if (newborn)
                next.newborn.insert(v);
            else if (changed.contains(v) || source.passed.contains(v))
                next.passed.insert(v);
        }
        for (const VertexId v : change.newborn) {
            next.keep(v);
            next.newborn.insert(v);
        }
        std::sort(next.behind.vertices.begin(), next.behind.vertices.end());
    }

    /// Of those that stay and of the newborn, which follow those beside them; sets what the step has of that.
    Eigen::MatrixXd folded_compliance(
        const FoldSource& source, const CutChange& change, const Correction& corrected, FoldStep& step)
    {
        const Eigen::MatrixXd& C = *source.compliance;
        const auto old = static_cast<Eigen::Index>(step.staying.size());
        const auto fresh = 3 * static_cast<Eigen::Index>(change.newborn.size());
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
            step.follow = change.newborn_following(Eigen::MatrixXd::Identity(besides, besides));
            own.bottomLeftCorner(fresh, old) = product(step.follow, to_staying);
            own.bottomRightCorner(fresh, fresh)
                = change.newborn_alone(Eigen::MatrixXd::Identity(fresh, fresh)).displacement
                + product(step.follow, product(among, Eigen::MatrixXd(step.follow.transpose())));
        }
        mirror_lower(own);
        return own;
    }

} // namespace

KeptView fold(const FoldSource& source, const CutChange& change)
{
    Correction corrected = correction(*source.compliance, change);
    KeptView next;
    auto step = std::make_shared<FoldStep>();
    sort_out(source, change, next, step->staying);
    next.own = std::make_shared<const Eigen::MatrixXd>(folded_compliance(source, change, corrected, *step));
    factor_behind(next.behind, [&](VertexId v) -> const OnlineStiffness::Row& { return source.rows.at(v); });
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

LoadOnLeft KeptView::load_on_left(const CondensedBody& of, const Eigen::MatrixXd& load) const
{
    LoadOnLeft loaded { Eigen::MatrixXd::Zero(load.rows(), load.cols()), {}, {} };
    for (const VertexId v : left)
        loaded.load.middleRows(3 * of.place(v), 3) = load.middleRows(3 * of.place(v), 3);
    Eigen::MatrixXd& x = loaded.response = product(*origin, loaded.load);
    for (const auto& step : steps) {
        loaded.of_changed.emplace_back(x(step->changed, Eigen::all));
        if (!step->changed.empty())
            x -= product(step->columns, product(step->taken, loaded.of_changed.back()));
        const Eigen::MatrixXd added = product(step->follow, Eigen::MatrixXd(x(step->beside, Eigen::all)));
        Eigen::MatrixXd on(static_cast<Eigen::Index>(step->staying.size()) + added.rows(), x.cols());
        on.topRows(on.rows() - added.rows()) = x(step->staying, Eigen::all);
        on.bottomRows(added.rows()) = added;
        x = std::move(on);
    }
    return loaded;
}

Eigen::MatrixXd KeptView::carried_back(Eigen::MatrixXd forces, const LoadOnLeft* load) const
{
    for (std::size_t i = steps.size(); i-- > 0;) {
        const FoldStep& s = *steps[i];
        Eigen::MatrixXd before = Eigen::MatrixXd::Zero(s.columns.rows(), forces.cols());
        for (std::size_t k = 0; k < s.staying.size(); ++k)
            before.row(s.staying[k]) = forces.row(static_cast<Eigen::Index>(k));
        const Eigen::Index added = forces.rows() - static_cast<Eigen::Index>(s.staying.size());
        if (added > 0) {
            const Eigen::MatrixXd handed_on = product_transposed(s.follow, forces.bottomRows(added));
            for (std::size_t k = 0; k < s.beside.size(); ++k)
                before.row(s.beside[k]) += handed_on.row(static_cast<Eigen::Index>(k));
        }
        Eigen::MatrixXd of_changed = product_transposed(s.columns, before);
        if (load != nullptr)
            of_changed += load->of_changed[i];
        const Eigen::MatrixXd held_back = product(s.taken, of_changed);
        for (std::size_t k = 0; k < s.changed.size(); ++k)
            before.row(s.changed[k]) -= held_back.row(static_cast<Eigen::Index>(k));
        forces = std::move(before);
    }
    if (load != nullptr)
        forces += load->load;
    return product(*origin, forces);
}

std::size_t KeptView::step_bytes() const
{
    std::size_t entries = 0;
    for (const auto& step : steps)
        entries += static_cast<std::size_t>(step->columns.size() + step->taken.size() + step->follow.size());
    return entries * sizeof(double);
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
