#include "fem/interactive/local_system.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>

namespace retractor::fem {

namespace {

    using Rows = std::vector<std::int32_t>;
    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    Eigen::MatrixXd rows_of(const Eigen::MatrixXd& a, const Rows& rows) { return a(rows, Eigen::all); }

    void add_to_rows(const Eigen::MatrixXd& from, const Rows& rows, double factor, Eigen::MatrixXd& to)
    {
        for (Eigen::Index c = 0; c < from.cols(); ++c)
            for (std::size_t i = 0; i < rows.size(); ++i)
                to(rows[i], c) += factor * from(static_cast<Eigen::Index>(i), c);
    }

    Rows kept_rows(const CondensedState& state, const std::vector<HeldVertex>& held)
    {
        Rows rows;
        for (const HeldVertex& h : held)
            if (const std::int32_t place = state.place(h.vertex); place >= 0)
                for (std::int32_t axis = 0; axis < 3; ++axis)
                    rows.push_back(3 * place + axis);
        return rows;
    }

    bool is_zero(const Eigen::MatrixXd& a) { return (a.array() == 0.0).all(); }

} // namespace

HookCompliance make_hook_compliance(const CondensedState& state, const std::vector<HeldVertex>& held)
{
    HookCompliance hooks { kept_rows(state, held), {}, {} };
    const Eigen::MatrixXd& C = state.compliance();
    hooks.factor = C(hooks.rows, hooks.rows);
    if (!cholesky(hooks.factor))
        throw SolverError("the compliance under the hooks is singular", "hooks");
    hooks.columns.resize(C.rows(), static_cast<Eigen::Index>(hooks.rows.size()));
    for (std::size_t j = 0; j < hooks.rows.size(); ++j)
        hooks.columns.col(static_cast<Eigen::Index>(j)) = C.col(hooks.rows[j]);
    divide_by_transpose(hooks.factor, hooks.columns);
    return hooks;
}

double low_rank_work(std::size_t changed_vertices, std::size_t held_vertices)
{
    const double changed = 3.0 * static_cast<double>(changed_vertices), held = 3.0 * static_cast<double>(held_vertices);
    return changed * changed * (5.0 / 3.0 * changed + held);
}

double dense_work(std::size_t kept_vertices, std::size_t held_vertices)
{
    const double free = std::max(3.0 * (static_cast<double>(kept_vertices) - static_cast<double>(held_vertices)), 0.0);
    return free * free * free / 3.0;
}

LocalSystem::LocalSystem(const OnlineStiffness& K, const CondensedState& state, const CutChange& change,
    const HookCompliance& hooks, const std::vector<HeldVertex>& held)
    : K_(&K)
    , state_(&state)
    , stiffness_(nullptr)
    , change_(&change)
    , hooks_(&hooks)
    , hook_rows_(hooks.rows)
    , held_(&held)
    , held_in_factor_(held.size())
{
    prepare_low_rank();
}

LocalSystem::LocalSystem(const OnlineStiffness& K, const CondensedState& state, const CutChange& change,
    const Eigen::MatrixXd& stiffness, const std::vector<HeldVertex>& held)
    : K_(&K)
    , state_(&state)
    , stiffness_(&stiffness)
    , change_(&change)
    , hooks_(nullptr)
    , hook_rows_(kept_rows(state, held))
    , held_(&held)
    , held_in_factor_(held.size())
{
    prepare_dense();
}

void LocalSystem::prepare_low_rank()
{
    const Rows& rows = change_->kept_rows;
    RETRACTOR_ASSERT(change_->stiffness.rows() == static_cast<Eigen::Index>(rows.size()));
    Eigen::MatrixXd C = state_->compliance()(rows, rows);
    const Eigen::MatrixXd held = rows_of(hooks_->columns, rows);
    C -= product(held, Eigen::MatrixXd(held.transpose()));
    Eigen::MatrixXd capacitance = product(C, change_->stiffness);
    capacitance.diagonal().array() += 1.0;
    capacitance_.emplace(std::move(capacitance));
    rcond_ = capacitance_->reciprocal_condition();
}

void LocalSystem::prepare_dense()
{
    std::vector<std::uint8_t> is_held(static_cast<std::size_t>(stiffness_->rows()), 0);
    for (const std::int32_t row : hook_rows_)
        is_held[static_cast<std::size_t>(row)] = 1;
    Rows number(is_held.size(), -1), held_number(is_held.size(), -1);
    for (std::size_t row = 0; row < is_held.size(); ++row)
        if (is_held[row] == 0) {
            number[row] = static_cast<std::int32_t>(free_rows_.size());
            free_rows_.push_back(static_cast<std::int32_t>(row));
        }
    factor_.resize(static_cast<Eigen::Index>(free_rows_.size()), static_cast<Eigen::Index>(free_rows_.size()));
    copy_lower(*stiffness_, free_rows_, factor_);
    held_stiffness_.resize(static_cast<Eigen::Index>(hook_rows_.size()), stiffness_->cols());
    for (std::size_t i = 0; i < hook_rows_.size(); ++i) // the matrix is symmetric
        held_stiffness_.row(static_cast<Eigen::Index>(i)) = stiffness_->col(hook_rows_[i]).transpose();
    for (std::size_t i = 0; i < hook_rows_.size(); ++i)
        held_number[static_cast<std::size_t>(hook_rows_[i])] = static_cast<std::int32_t>(i);
    const Rows& changed = change_->kept_rows;
    const auto add = [&](std::int32_t i, std::int32_t j, double k) { // adds an entry of the change
        const auto row = static_cast<std::size_t>(changed[static_cast<std::size_t>(i)]),
                   column = static_cast<std::size_t>(changed[static_cast<std::size_t>(j)]);
        if (number[column] >= 0 && number[row] >= number[column])
            factor_(number[row], number[column]) += k;
        if (held_number[row] >= 0)
            held_stiffness_(held_number[row], static_cast<Eigen::Index>(column)) += k;
    };
    for (const CutChange::Block& b : change_->blocks)
        for (std::int32_t c = 0; c < 3; ++c)
            for (std::int32_t r = 0; r < 3; ++r)
                add(3 * b.row + r, 3 * b.column + c, b.value(r, c));
    const Rows& beside = change_->beside;
    for (std::size_t j = 0; j < beside.size(); ++j)
        for (std::size_t i = j; i < beside.size(); ++i) {
            const double k = change_->taken(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            add(beside[i], beside[j], k);
            if (i != j)
                add(beside[j], beside[i], k);
        }
    if (!cholesky(factor_)) {
        rcond_ = 0.0;
        return;
    }
    const auto pivots = factor_.diagonal().array();
    if (pivots.size() > 0) {
        const double ratio = pivots.minCoeff() / pivots.maxCoeff();
        rcond_ = ratio * ratio;
    }
}

void LocalSystem::hold_appended()
{
    RETRACTOR_ASSERT(route() == LocalRoute::dense);
    Rows number(static_cast<std::size_t>(stiffness_->rows()), -1);
    for (std::size_t i = 0; i < free_rows_.size(); ++i)
        number[static_cast<std::size_t>(free_rows_[i])] = static_cast<std::int32_t>(i);
    late_.clear();
    for (std::size_t i = held_in_factor_; i < held_->size(); ++i)
        for (std::int32_t axis = 0; axis < 3; ++axis)
            late_.push_back(number[static_cast<std::size_t>(3 * state_->place((*held_)[i].vertex) + axis)]);
    RETRACTOR_ASSERT(std::none_of(late_.begin(), late_.end(), [](std::int32_t row) { return row < 0; }));
    late_columns_ = Eigen::MatrixXd::Zero(factor_.rows(), static_cast<Eigen::Index>(late_.size()));
    for (std::size_t i = 0; i < late_.size(); ++i)
        late_columns_(late_[i], static_cast<Eigen::Index>(i)) = 1.0;
    forward(factor_, late_columns_);
    backward(factor_, late_columns_);
    late_factor_ = rows_of(late_columns_, late_);
    if (!cholesky(late_factor_))
        throw SolverError("the compliance under the hooks is singular", "hooks");
}

Eigen::MatrixXd LocalSystem::low_rank_kept(const Eigen::MatrixXd& load, const Eigen::MatrixXd& given,
    const Eigen::MatrixXd& elsewhere, Eigen::MatrixXd& forces, Eigen::MatrixXd& kept_forces) const
{
    const Rows& rows = change_->kept_rows;
    Eigen::MatrixXd through_hooks = given;
    if (elsewhere.size() != 0)
        through_hooks -= rows_of(elsewhere, hook_rows_);
    forward(hooks_->factor, through_hooks); // L^-1 u_h
    const auto under = [&](const Eigen::MatrixXd& g) { // C g while the hooks do not move
        const Eigen::MatrixXd x = product(state_->compliance(), g);
        return Eigen::MatrixXd(x - product(hooks_->columns, product_transposed(hooks_->columns, g)));
    };
    Eigen::MatrixXd moved = product(hooks_->columns, through_hooks);
    if (elsewhere.size() != 0)
        moved += elsewhere;
    const bool loaded = !is_zero(load);
    Eigen::MatrixXd x = loaded ? Eigen::MatrixXd(moved + under(load)) : moved;
    Eigen::MatrixXd g = load;
    if (!rows.empty()) {
        Eigen::MatrixXd at_changed = rows_of(x, rows);
        capacitance_->solve(at_changed);
        add_to_rows(product(change_->stiffness, at_changed), rows, -1.0, g);
        x = moved + under(g);
    }
    forces = through_hooks - product_transposed(hooks_->columns, g);
    backward(hooks_->factor, forces);
    add_to_rows(forces, hook_rows_, 1.0, g);
    kept_forces = std::move(g);
    return x;
}

Eigen::MatrixXd LocalSystem::dense_kept(
    const Eigen::MatrixXd& load, const Eigen::MatrixXd& given, Eigen::MatrixXd& forces) const
{
    Eigen::MatrixXd x = rows_of(load, free_rows_);
    if (!hook_rows_.empty()) {
        const Eigen::MatrixXd pull = product_transposed(held_stiffness_, given.topRows(held_stiffness_.rows()));
        x -= rows_of(pull, free_rows_);
    }
    forward(factor_, x);
    backward(factor_, x);
    Eigen::MatrixXd late_forces(0, load.cols());
    if (!late_.empty()) {
        late_forces = given.bottomRows(static_cast<Eigen::Index>(late_.size())) - rows_of(x, late_);
        forward(late_factor_, late_forces);
        backward(late_factor_, late_forces);
        x += product(late_columns_, late_forces);
    }
    Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(load.rows(), load.cols());
    add_to_rows(x, free_rows_, 1.0, kept);
    add_to_rows(given.topRows(held_stiffness_.rows()), hook_rows_, 1.0, kept);
    forces.resize(given.rows(), given.cols());
    forces.topRows(held_stiffness_.rows()) = product(held_stiffness_, kept) - rows_of(load, hook_rows_);
    forces.bottomRows(late_forces.rows()) = late_forces;
    return kept;
}

std::size_t LocalSystem::bytes() const
{
    const auto changed = capacitance_ ? change_->stiffness.size() : 0;
    return static_cast<std::size_t>(changed + factor_.size() + held_stiffness_.size() + late_columns_.size())
        * sizeof(double);
}

LocalSystem::Solution LocalSystem::solve(const Eigen::MatrixXd& load_kept, const Eigen::MatrixXd& load_added,
    const Eigen::MatrixXd& hook_displacement, const Eigen::MatrixXd& elsewhere) const
{
    const CutChange& change = *change_;
    const Eigen::Index cases = hook_displacement.cols();
    RETRACTOR_ASSERT(load_kept.rows() == 3 * static_cast<Eigen::Index>(state_->vertices.size()));
    RETRACTOR_ASSERT(load_added.rows() == 3 * static_cast<Eigen::Index>(change.added.size()));
    RETRACTOR_ASSERT(load_kept.cols() == cases && load_added.cols() == cases);
    Eigen::MatrixXd load = load_kept, added_load = load_added;
    // Held vertices that cuts have added pull directly on their neighbours.
    for (const HeldVertex& h : *held_) {
        if (state_->place(h.vertex) >= 0)
            continue;
        const OnlineStiffness::Row& row = K_->row(h.vertex);
        for (std::size_t k = 0; k < row.column.size(); ++k) {
            const RowBlock block(row.value.data() + 9 * k);
            const Eigen::MatrixXd pull = block.transpose() * hook_displacement.middleRows(3 * h.hook, 3);
            if (const std::int32_t place = state_->place(row.column[k]); place >= 0)
                load.middleRows(3 * place, 3) -= pull;
            else if (const auto n = change.added_place.find(row.column[k]); n != change.added_place.end())
                added_load.middleRows(3 * n->second, 3) -= pull;
        }
    }
    const bool pushed = !is_zero(added_load);
    CutChange::Pushed alone;
    if (pushed) {
        alone = change.added_alone(added_load);
        for (Eigen::Index c = 0; c < cases; ++c)
            for (std::size_t b = 0; b < change.beside.size(); ++b)
                load(change.kept_rows[static_cast<std::size_t>(change.beside[b])], c)
                    += alone.handed_on(static_cast<Eigen::Index>(b), c);
    }
    Eigen::MatrixXd given(static_cast<Eigen::Index>(hook_rows_.size() + late_.size()), cases);
    Eigen::Index next = 0;
    for (const HeldVertex& h : *held_)
        if (state_->place(h.vertex) >= 0) {
            given.middleRows(next, 3) = hook_displacement.middleRows(3 * h.hook, 3);
            next += 3;
        }
    Solution s;
    Eigen::MatrixXd forces;
    s.kept = route() == LocalRoute::low_rank ? low_rank_kept(load, given, elsewhere, forces, s.kept_forces)
                                             : dense_kept(load, given, forces);
    s.added = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(change.added.size()), cases);
    if (!change.added.empty()) {
        Eigen::MatrixXd beside(static_cast<Eigen::Index>(change.beside.size()), cases);
        for (std::size_t b = 0; b < change.beside.size(); ++b)
            beside.row(static_cast<Eigen::Index>(b))
                = s.kept.row(change.kept_rows[static_cast<std::size_t>(change.beside[b])]);
        s.added = change.added_following(beside);
        if (pushed)
            s.added += alone.displacement;
    }
    s.held_forces = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(held_->size()), cases);
    next = 0;
    for (std::size_t i = 0; i < held_->size(); ++i)
        if (state_->place((*held_)[i].vertex) >= 0) {
            s.held_forces.middleRows(3 * static_cast<Eigen::Index>(i), 3) = forces.middleRows(next, 3);
            next += 3;
        }
    return s;
}

} // namespace retractor::fem
