#include "fem/interactive/condensed_state.h"

#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/assert.h"

#include <utility>

namespace retractor::fem {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    Eigen::MatrixXd unit_columns(Eigen::Index rows, const std::vector<std::int32_t>& of_vertices)
    {
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(rows, 3 * static_cast<Eigen::Index>(of_vertices.size()));
        for (std::size_t i = 0; i < of_vertices.size(); ++i)
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                unit(3 * of_vertices[i] + axis, 3 * static_cast<Eigen::Index>(i) + axis) = 1.0;
        return unit;
    }

    /// Adds vertices with u = follow u_kept + own f to a compliance matrix.
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

void EliminatedAdded::number_and_factor(const RowOf& row)
{
    place.clear();
    for (std::size_t i = 0; i < vertices.size(); ++i)
        place.emplace(vertices[i], static_cast<std::int32_t>(i));
    if (vertices.empty())
        return;
    SparseMatrix matrix = vertex_matrix(row, vertices, [&](VertexId v) {
        const auto found = place.find(v);
        return found == place.end() ? -1 : found->second;
    });
    factor.analyse(std::move(matrix.pattern), Ordering::minimum_degree);
    factor.factorise(matrix.values);
}

void CondensedState::keep(VertexId v)
{
    RETRACTOR_ASSERT(v >= 0 && place(v) < 0);
    if (static_cast<std::size_t>(v) >= places.size())
        places.resize(static_cast<std::size_t>(v) + 1, -1);
    places[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(vertices.size());
    vertices.push_back(v);
}

CondensedState condensed_state_of(const CondensedBody& body)
{
    CondensedState state;
    for (const VertexId v : body.kept())
        state.keep(v);
    state.body = &body;
    return state;
}

std::vector<std::int32_t> rows_of_vertices(const CondensedState& state, const std::vector<VertexId>& vertices)
{
    std::vector<std::int32_t> rows;
    rows.reserve(3 * vertices.size());
    for (const VertexId v : vertices) {
        RETRACTOR_ASSERT(state.place(v) >= 0);
        for (std::int32_t axis = 0; axis < 3; ++axis)
            rows.push_back(3 * state.place(v) + axis);
    }
    return rows;
}

LoadOnDropped CondensedState::load_on_dropped(const CondensedBody& of, const Eigen::MatrixXd& load) const
{
    RETRACTOR_ASSERT(origin != nullptr && load.rows() == origin->rows());
    LoadOnDropped loaded { Eigen::MatrixXd::Zero(load.rows(), load.cols()), {}, {} };
    for (const VertexId v : dropped)
        loaded.load.middleRows(3 * of.place(v), 3) = load.middleRows(3 * of.place(v), 3);
    Eigen::MatrixXd& x = loaded.response = product(*origin, loaded.load);
    for (const auto& step : steps) {
        loaded.of_changed.emplace_back(x(step->changed, Eigen::all));
        if (!step->changed.empty())
            x -= product(step->columns, product(step->taken, loaded.of_changed.back()));
        const Eigen::MatrixXd of_added = product(step->follow, Eigen::MatrixXd(x(step->beside, Eigen::all)));
        Eigen::MatrixXd on(static_cast<Eigen::Index>(step->staying.size()) + of_added.rows(), x.cols());
        on.topRows(on.rows() - of_added.rows()) = x(step->staying, Eigen::all);
        on.bottomRows(of_added.rows()) = of_added;
        x = std::move(on);
    }
    return loaded;
}

Eigen::MatrixXd CondensedState::carried_back(Eigen::MatrixXd forces, const LoadOnDropped* load) const
{
    RETRACTOR_ASSERT(origin != nullptr);
    RETRACTOR_ASSERT(load == nullptr || load->of_changed.size() == steps.size());
    for (std::size_t i = steps.size(); i-- > 0;) {
        const LowRankUpdate& s = *steps[i];
        Eigen::MatrixXd before = Eigen::MatrixXd::Zero(s.columns.rows(), forces.cols());
        for (std::size_t k = 0; k < s.staying.size(); ++k)
            before.row(s.staying[k]) = forces.row(static_cast<Eigen::Index>(k));
        const Eigen::Index added_rows = forces.rows() - static_cast<Eigen::Index>(s.staying.size());
        if (added_rows > 0) {
            const Eigen::MatrixXd handed_on = product_transposed(s.follow, forces.bottomRows(added_rows));
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

std::size_t CondensedState::step_bytes() const
{
    std::size_t entries = 0;
    for (const auto& step : steps)
        entries += static_cast<std::size_t>(step->columns.size() + step->taken.size() + step->follow.size());
    return entries * sizeof(double);
}

void fetch_back(CondensedState& state, const OnlineStiffness& K, const std::vector<VertexId>& vertices)
{
    if (vertices.empty())
        return;
    RETRACTOR_ASSERT(state.dropped.empty());
    const auto row = [&](VertexId v) -> const OnlineStiffness::Row& {
        const auto found = state.reference.find(v);
        return found == state.reference.end() ? K.row(v) : found->second;
    };
    EliminatedAdded& eliminated_added = state.eliminated_added;
    std::vector<std::int32_t> wanted;
    for (const VertexId v : vertices)
        wanted.push_back(eliminated_added.place.at(v));
    const auto size = 3 * static_cast<Eigen::Index>(eliminated_added.vertices.size());
    const Eigen::MatrixXd unit = unit_columns(size, wanted);
    const Eigen::MatrixXd alone = eliminated_added.factor.solve(unit); // K_zz^-1 E_w
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(state.compliance().rows(), alone.cols()); // K_kz K_zz^-1 E_w
    for (std::size_t z = 0; z < eliminated_added.vertices.size(); ++z) {
        const OnlineStiffness::Row& full = row(eliminated_added.vertices[z]);
        for (std::size_t k = 0; k < full.column.size(); ++k)
            if (const std::int32_t at = state.place(full.column[k]); at >= 0)
                pull.middleRows(3 * at, 3) += RowBlock(full.value.data() + 9 * k).transpose()
                    * alone.middleRows(3 * static_cast<Eigen::Index>(z), 3);
    }
    const Eigen::MatrixXd under = product(state.compliance(), pull);
    const Eigen::MatrixXd own = product_transposed(unit, alone) + product_transposed(pull, under);
    state.own = std::make_shared<const Eigen::MatrixXd>(bordered(state.compliance(), -under.transpose(), own));
    state.body = nullptr;
    for (const VertexId v : vertices) {
        state.keep(v);
        state.added.insert(v);
        std::erase(eliminated_added.vertices, v);
    }
    eliminated_added.number_and_factor(row);
}

void keep_also(CondensedState& state, const AddedVertices& added)
{
    RETRACTOR_ASSERT(state.dropped.empty());
    const std::vector<std::int32_t> before = rows_of_vertices(state, added.before);
    const Eigen::MatrixXd of_before = state.compliance()(before, Eigen::all);
    const Eigen::MatrixXd cross = product(added.follow, of_before);
    const Eigen::MatrixXd own
        = added.own + product(Eigen::MatrixXd(cross(Eigen::all, before)), Eigen::MatrixXd(added.follow.transpose()));
    state.own = std::make_shared<const Eigen::MatrixXd>(bordered(state.compliance(), cross, own));
    state.body = nullptr;
    for (const VertexId v : added.vertices)
        state.keep(v);
}

} // namespace retractor::fem
