#include "haptics/condensed/contact_node_compliance.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/linear_algebra/parallel.h"
#include "fem/model/loads.h"
#include "haptics/condensed/pad_stiffness.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <thread>

namespace retractor::haptics {

namespace {

    /// Number of contact nodes within the budget. Each contact node has its columns and a row of blocks.
    std::size_t contact_nodes_within(std::size_t budget, std::size_t shown_nodes, std::size_t contact_nodes)
    {
        const std::size_t each = 9 * sizeof(double) * (shown_nodes + contact_nodes);
        constexpr std::size_t kFewestColumns = 96; // reach of two fingers
        return std::min(contact_nodes, std::max(kFewestColumns, budget / each));
    }

} // namespace

void ServoGate::wait_for_tick_end() const noexcept
{
    const std::uint64_t seen = count_.load(std::memory_order_seq_cst);
    if (seen % 2 == 0)
        return;
    while (count_.load(std::memory_order_seq_cst) == seen)
        std::this_thread::yield();
}

/// Contact nodes whose columns are not solved yet.
struct ContactNodeCompliance::Batch {
    std::vector<std::int32_t> contact_nodes, places;
    fem::SparseCholesky::HalfSolution half; ///< three columns per contact node
};

struct ContactNodeCompliance::Solver {
    std::unique_ptr<fem::ConstrainedSolver> solver;
    Eigen::VectorXd pressure_load; ///< load of a pressure of 1 MPa
    Eigen::Index unknowns = 0;

    /// Solves the forward half for unit forces on contact nodes; one column per axis of a contact node.
    fem::SparseCholesky::HalfSolution half_solve(
        const TouchSurface& surface, std::span<const std::int32_t> contact_nodes) const
    {
        std::vector<fem::SparseCholesky::Load> loads;
        for (std::size_t i = 0; i < contact_nodes.size(); ++i)
            for (std::int32_t axis = 0; axis < 3; ++axis)
                add(surface, contact_nodes[i], static_cast<std::int32_t>(3 * i) + axis, Vec3::Unit(axis), loads);
        return solver->half_solve(loads, static_cast<Eigen::Index>(3 * contact_nodes.size()));
    }
    static void add(const TouchSurface& surface, std::int32_t contact_node, std::int32_t column, const Vec3& force,
        std::vector<fem::SparseCholesky::Load>& loads)
    {
        const auto s = static_cast<std::size_t>(contact_node);
        const auto first = static_cast<std::size_t>(surface.contact_node_vertices().start[s]);
        const auto nodes = surface.contact_node_vertices().of(s);
        for (std::size_t n = 0; n < nodes.size(); ++n)
            for (std::int32_t axis = 0; axis < 3; ++axis)
                if (force[axis] != 0.0)
                    loads.push_back({ 3 * nodes[n] + axis, column, force[axis] * surface.weights()[first + n] });
    }
};

ContactNodeCompliance::ContactNodeCompliance(const TouchedBody& body, const TouchSurface& surface,
    const std::vector<fem::Lame>& lame, TouchElement element, std::size_t budget, const Job& job)
    : surface_(&surface)
    , shown_(body.shown)
    , solver_(std::make_unique<Solver>())
{
    RETRACTOR_ASSERT(body.mesh != nullptr && lame.size() == body.mesh->tet_count());
    RETRACTOR_ASSERT(body.prescribed.size() == 3 * body.mesh->vertex_count());
    const Stopwatch watch;
    Solver& s = *solver_;
    s.unknowns = 3 * body.mesh->vertices.rows();
    job.report("assemble", 0.0);
    {
        fem::ElasticBody elastic(*body.mesh, fem::Elasticity::linear, lame);
        if (element == TouchElement::locking_free)
            elastic.avoid_locking();
        const fem::BlockMatrix& K = elastic.stiffness(Eigen::VectorXd::Zero(s.unknowns), 0.0);
        job.report("factorise", 0.0);
        s.solver = std::make_unique<fem::ConstrainedSolver>(K.pattern, body.prescribed);
        s.solver->factorise(K);
    }
    s.pressure_load = Eigen::VectorXd::Zero(s.unknowns);
    if (!body.inner_faces.empty())
        s.pressure_load
            = fem::FollowerPressure(*body.mesh, body.inner_faces, 1.0).force(Eigen::VectorXd::Zero(s.unknowns));

    const std::size_t contact_nodes = contact_nodes_ = surface.contact_nodes().size();
    capacity_ = contact_nodes_within(budget, shown_.size(), contact_nodes);
    place_ = std::make_unique<std::atomic<std::int32_t>[]>(contact_nodes);
    for (std::size_t i = 0; i < contact_nodes; ++i)
        place_[i].store(-1, std::memory_order_relaxed);
    contact_node_at_.assign(capacity_, -1);
    last_wanted_.assign(capacity_, std::numeric_limits<std::int64_t>::min());
    blocks_.assign(9 * capacity_ * contact_nodes, 0.0);
    columns_.resize(capacity_);

    const Eigen::VectorXd pulse = s.solver->solve(s.pressure_load);
    const auto pick = [&](const std::vector<VertexId>& nodes) {
        Points picked(static_cast<Eigen::Index>(nodes.size()), 3);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            picked.row(static_cast<Eigen::Index>(i)) = pulse.segment<3>(3 * nodes[i]).transpose();
        return picked;
    };
    vertex_pulse_ = pick(surface.nodes());
    shown_pulse_ = pick(shown_);
    contact_node_pulse_.resize(static_cast<Eigen::Index>(contact_nodes), 3);
    for (std::size_t i = 0; i < contact_nodes; ++i)
        contact_node_pulse_.row(static_cast<Eigen::Index>(i)) = mean(pulse, static_cast<std::int32_t>(i)).transpose();

    measure_pads(job);
    record_part(job, "condensed tissue", watch, bytes());
}

ContactNodeCompliance::~ContactNodeCompliance() = default;

/// Contact nodes near each other reach nearly the same unknowns. A group of middles and all contact nodes that their
/// pads press are therefore solved together.
void ContactNodeCompliance::measure_pads(const Job& job)
{
    const std::vector<PadGroup> groups = pad_groups(*surface_, kFallbackRadius);
    fallback_stiffness_.assign(surface_->contact_nodes().size(), 0.0);
    std::atomic<std::size_t> next { 0 };
    const auto measure = [&](const PadGroup& group) {
        std::vector<fem::SparseCholesky::Load> loads;
        for (std::size_t i = 0; i < group.pressed.size(); ++i)
            Solver::add(*surface_, group.pressed[i], static_cast<std::int32_t>(i),
                surface_->contact_nodes()[static_cast<std::size_t>(group.pressed[i])].normal, loads);
        const fem::SparseCholesky::HalfSolution half
            = solver_->solver->half_solve(loads, static_cast<Eigen::Index>(group.pressed.size()));
        const Eigen::MatrixXd C = fem::SparseCholesky::product(half, half);
        for (const std::int32_t s : group.middles)
            fallback_stiffness_[static_cast<std::size_t>(s)]
                = pad_stiffness(*surface_, s, kFallbackRadius, group.pressed, C);
    };
    std::array<std::exception_ptr, 2> failures;
    const auto work = [&](std::exception_ptr& failure) noexcept {
        try {
            for (std::size_t g = next.fetch_add(1); g < groups.size() && !job.cancelled(); g = next.fetch_add(1))
                measure(groups[g]);
        } catch (...) {
            failure = std::current_exception();
        }
    };
    job.report("stiffness under fingertips", 0.0);
    constexpr std::size_t kWorthAThread = 32;
    if (groups.size() >= kWorthAThread) {
        const fem::ScopedThread other([&] { work(failures[1]); });
        work(failures[0]);
    } else
        work(failures[0]);
    for (const std::exception_ptr& failure : failures)
        if (failure)
            std::rethrow_exception(failure);
}

Vec3 ContactNodeCompliance::mean(const Eigen::Ref<const Eigen::VectorXd>& u, std::int32_t contact_node) const
{
    const auto s = static_cast<std::size_t>(contact_node);
    const auto first = static_cast<std::size_t>(surface_->contact_node_vertices().start[s]);
    const auto nodes = surface_->contact_node_vertices().of(s);
    Vec3 sum = Vec3::Zero();
    for (std::size_t n = 0; n < nodes.size(); ++n)
        sum += surface_->weights()[first + n] * u.segment<3>(3 * nodes[n]);
    return sum;
}

std::int32_t ContactNodeCompliance::free_place(std::int64_t newer_than)
{
    std::size_t best = capacity_;
    for (std::size_t p = 0; p < capacity_; ++p) {
        if (contact_node_at_[p] < 0 && last_wanted_[p] != newer_than)
            return static_cast<std::int32_t>(p);
        if (contact_node_at_[p] >= 0 && last_wanted_[p] < newer_than
            && (best == capacity_ || last_wanted_[p] < last_wanted_[best]))
            best = p;
    }
    return best == capacity_ ? -1 : static_cast<std::int32_t>(best);
}

void ContactNodeCompliance::forget(std::size_t place)
{
    RETRACTOR_ASSERT(contact_node_at_[place] >= 0 && ready_count_ > 0);
    place_[static_cast<std::size_t>(contact_node_at_[place])].store(-1, std::memory_order_seq_cst);
    contact_node_at_[place] = -1;
    columns_[place].clear();
    --ready_count_;
}

std::size_t ContactNodeCompliance::fetch(std::span<const std::int32_t> wanted, std::size_t most, const ServoGate& gate)
{
    ++now_;
    std::vector<std::int32_t> missing, places;
    for (const std::int32_t s : wanted)
        if (const std::int32_t p = place(s); p < 0)
            missing.push_back(s);
        else
            last_wanted_[static_cast<std::size_t>(p)] = now_;
    missing.resize(std::min(missing.size(), most));
    bool forgotten = false;
    for (std::size_t i = 0; i < missing.size(); ++i) {
        const std::int32_t p = free_place(now_);
        if (p < 0) {
            missing.resize(i); // all contact nodes in the store are wanted now
            break;
        }
        const auto at = static_cast<std::size_t>(p);
        if (contact_node_at_[at] >= 0) {
            forget(at);
            forgotten = true;
        }
        last_wanted_[at] = now_;
        places.push_back(p);
    }
    if (forgotten)
        gate.wait_for_tick_end();
    for (std::size_t i = 0; i < missing.size(); i += kBatch) {
        const std::size_t count = std::min(kBatch, missing.size() - i);
        take_in({ missing.data() + i, count }, { places.data() + i, count });
    }
    return missing.size();
}

void ContactNodeCompliance::fetch_all(const ServoGate& gate, const Job& job)
{
    std::vector<std::int32_t> all(surface_->contact_nodes().size());
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = static_cast<std::int32_t>(i);
    constexpr std::size_t kStep = 8 * kBatch;
    while (ready_count_ < all.size() && !job.cancelled()) {
        job.report("compliance", static_cast<double>(ready_count_) / static_cast<double>(all.size()));
        if (fetch(all, kStep, gate) == 0)
            return;
        finish_columns(kStep / kBatch);
    }
}

/// Whether this contact node is still in this place and has no columns.
bool ContactNodeCompliance::awaits_columns(std::int32_t place, std::int32_t contact_node) const
{
    const auto p = static_cast<std::size_t>(place);
    return contact_node_at_[p] == contact_node && columns_[p].empty();
}

/// Computes the blocks of these contact nodes with each other and with all ready ones; then the servo may use them.
void ContactNodeCompliance::take_in(std::span<const std::int32_t> contact_nodes, std::span<const std::int32_t> places)
{
    RETRACTOR_ASSERT(contact_nodes.size() == places.size());
    Batch fresh { { contact_nodes.begin(), contact_nodes.end() }, { places.begin(), places.end() },
        solver_->half_solve(*surface_, contact_nodes) };
    const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(3 * i); };
    const auto set_blocks_with = [&](const Batch& other) {
        const Eigen::MatrixXd L = fem::SparseCholesky::product(fresh.half, other.half);
        for (std::size_t i = 0; i < fresh.places.size(); ++i)
            for (std::size_t k = 0; k < other.places.size(); ++k)
                if (const std::int32_t q = other.places[k];
                    &other == &fresh || awaits_columns(q, other.contact_nodes[k])) {
                    const Mat3 by_other = L.block<3, 3>(at(i), at(k));
                    block_at(fresh.places[i], other.contact_nodes[k]) = by_other;
                    block_at(q, fresh.contact_nodes[i]) = by_other.transpose();
                }
    };
    for (const Batch& other : batches_)
        set_blocks_with(other);
    set_blocks_with(fresh);
    for (std::size_t q = 0; q < capacity_; ++q)
        if (contact_node_at_[q] >= 0 && !columns_[q].empty())
            for (std::size_t i = 0; i < contact_nodes.size(); ++i)
                block_at(places[i], contact_node_at_[q])
                    = block_at(static_cast<std::int32_t>(q), contact_nodes[i]).transpose();
    for (std::size_t i = 0; i < contact_nodes.size(); ++i) {
        contact_node_at_[static_cast<std::size_t>(places[i])] = contact_nodes[i];
        ++ready_count_;
        place_[static_cast<std::size_t>(contact_nodes[i])].store(places[i], std::memory_order_release);
    }
    batches_.push_back(std::move(fresh));
}

void ContactNodeCompliance::finish_columns(std::size_t batches)
{
    const auto last_wanted = [&](const Batch& batch) {
        std::int64_t last = std::numeric_limits<std::int64_t>::min();
        for (std::size_t i = 0; i < batch.places.size(); ++i)
            if (const auto p = static_cast<std::size_t>(batch.places[i]); contact_node_at_[p] == batch.contact_nodes[i])
                last = std::max(last, last_wanted_[p]);
        return last;
    };
    std::erase_if(batches_, [&](const Batch& batch) { // forgotten since
        for (std::size_t i = 0; i < batch.places.size(); ++i)
            if (awaits_columns(batch.places[i], batch.contact_nodes[i]))
                return false;
        return true;
    });
    for (std::size_t done = 0; done < batches && !batches_.empty() && !shown_.empty(); ++done) {
        const auto next = std::max_element(batches_.begin(), batches_.end(),
            // The first of several equals.
            [&](const Batch& a, const Batch& b) { return last_wanted(a) < last_wanted(b); });
        const Eigen::MatrixXd fields = solver_->solver->finish(next->half);
        for (std::size_t i = 0; i < next->places.size(); ++i)
            if (awaits_columns(next->places[i], next->contact_nodes[i]))
                keep_columns(next->places[i], fields.middleCols(static_cast<Eigen::Index>(3 * i), 3));
        batches_.erase(next);
    }
}

std::size_t ContactNodeCompliance::columns_missing() const { return shown_.empty() ? 0 : batches_.size(); }

void ContactNodeCompliance::keep_columns(std::int32_t place, const Eigen::Ref<const Eigen::MatrixXd>& columns)
{
    RETRACTOR_ASSERT(columns.cols() == 3);
    std::vector<double>& kept = columns_[static_cast<std::size_t>(place)];
    kept.resize(9 * shown_.size());
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        for (std::size_t v = 0; v < shown_.size(); ++v)
            for (Eigen::Index k = 0; k < 3; ++k)
                kept[3 * (static_cast<std::size_t>(axis) * shown_.size() + v) + static_cast<std::size_t>(k)]
                    = columns(3 * shown_[v] + k, axis);
    for (std::int32_t s = 0; s < static_cast<std::int32_t>(contact_nodes_); ++s)
        if (!ready(s)) // the servo may read the blocks of ready contact nodes
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                block_at(place, s).row(axis) = mean(columns.col(axis), s).transpose();
}

void ContactNodeCompliance::add_displacement(
    double pressure, std::span<const ContactNodeForce> forces, Points& points) const
{
    RETRACTOR_ASSERT(points.size() == shown_pulse_.size());
    Eigen::Map<Eigen::VectorXd> sum(points.data(), points.size());
    sum += pressure * Eigen::Map<const Eigen::VectorXd>(shown_pulse_.data(), shown_pulse_.size());
    for (const ContactNodeForce& f : forces) {
        const std::int32_t p = place(f.contact_node);
        if (p < 0 || columns_[static_cast<std::size_t>(p)].empty())
            continue;
        const std::vector<double>& kept = columns_[static_cast<std::size_t>(p)];
        sum += Eigen::Map<const Eigen::MatrixXd>(kept.data(), points.size(), 3) * f.force;
    }
}

Eigen::VectorXd ContactNodeCompliance::solve(double pressure, std::span<const ContactNodeForce> forces) const
{
    Eigen::VectorXd load = pressure * solver_->pressure_load;
    std::vector<fem::SparseCholesky::Load> loads;
    for (const ContactNodeForce& f : forces)
        Solver::add(*surface_, f.contact_node, 0, f.force, loads);
    for (const fem::SparseCholesky::Load& l : loads)
        load[l.unknown] += l.value;
    return solver_->solver->solve(load);
}

std::size_t ContactNodeCompliance::unknowns() const { return solver_->solver->free_count(); }

std::size_t ContactNodeCompliance::bytes() const
{
    std::size_t sum = solver_->solver->bytes() + blocks_.size() * sizeof(double);
    for (const std::vector<double>& kept : columns_)
        sum += kept.size() * sizeof(double);
    for (const Batch& batch : batches_)
        sum += static_cast<std::size_t>(batch.half.values.size()) * sizeof(double);
    return sum;
}

} // namespace retractor::haptics
