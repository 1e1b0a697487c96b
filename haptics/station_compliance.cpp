#include "haptics/station_compliance.h"

#include "fem/constrained_solver.h"
#include "fem/loads.h"
#include "mesh/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace retractor {

namespace {

    constexpr std::size_t kBatch = 8; ///< stations solved together: 24 right sides share each pass over the factor

    /// Stations that fit: n columns and n^2 blocks.
    std::size_t stations_within(std::size_t budget, std::size_t shown_nodes, std::size_t stations)
    {
        const double column = 9.0 * sizeof(double) * static_cast<double>(shown_nodes), block = 9.0 * sizeof(double);
        const double n
            = (-column + std::sqrt(column * column + 4.0 * block * static_cast<double>(budget))) / (2.0 * block);
        constexpr double kFewest = 96.0; // anchors and the reach of two fingers
        return std::min(stations, static_cast<std::size_t>(std::max(kFewest, n)));
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

struct StationCompliance::Solver {
    std::unique_ptr<ConstrainedSolver> solver;
    Eigen::VectorXd pressure_load; ///< of 1 MPa
    Eigen::Index unknowns = 0;
};

StationCompliance::StationCompliance(const TouchedBody& body, const TouchSurface& surface,
    const std::vector<Lame>& lame, TouchElement element, std::size_t budget, const Job& job)
    : surface_(&surface)
    , shown_(body.shown)
    , solver_(std::make_unique<Solver>())
{
    const Stopwatch watch;
    Solver& s = *solver_;
    s.unknowns = 3 * body.mesh->vertices.rows();
    job.report("assemble", 0.0);
    {
        ElasticBody elastic(*body.mesh, Elasticity::linear, lame);
        if (element == TouchElement::locking_free)
            elastic.avoid_locking();
        const BlockMatrix& K = elastic.stiffness(Eigen::VectorXd::Zero(s.unknowns), 0.0);
        job.report("factorise", 0.0);
        s.solver = std::make_unique<ConstrainedSolver>(K.pattern, body.prescribed);
        s.solver->factorise(K);
    }
    s.pressure_load = Eigen::VectorXd::Zero(s.unknowns);
    if (!body.inner_faces.empty())
        s.pressure_load = FollowerPressure(*body.mesh, body.inner_faces, 1.0).force(Eigen::VectorXd::Zero(s.unknowns));

    const std::size_t stations = surface.stations().size();
    capacity_ = stations_within(budget, shown_.size(), stations);
    place_ = std::make_unique<std::atomic<std::int32_t>[]>(stations);
    for (std::size_t i = 0; i < stations; ++i)
        place_[i].store(-1, std::memory_order_relaxed);
    station_at_.assign(capacity_, -1);
    last_wanted_.assign(capacity_, std::numeric_limits<std::int64_t>::min());
    blocks_.assign(9 * capacity_ * capacity_, 0.0);
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
    station_pulse_.resize(static_cast<Eigen::Index>(stations), 3);
    for (std::size_t i = 0; i < stations; ++i)
        station_pulse_.row(static_cast<Eigen::Index>(i)) = mean(pulse, static_cast<std::int32_t>(i)).transpose();

    measure_elasticity(*body.mesh, lame);
    place_anchors();
    record_part(job, "condensed tissue", watch, bytes());
}

StationCompliance::~StationCompliance() = default;

/// Young's modulus about each station: the mean of the elements at its nodes.
void StationCompliance::measure_elasticity(const TetMesh& mesh, const std::vector<Lame>& lame)
{
    std::vector<double> sum(mesh.vertex_count(), 0.0), count(mesh.vertex_count(), 0.0);
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const auto& [mu, lambda] = lame[t];
        for (const VertexId v : mesh.tet(static_cast<TetId>(t))) {
            sum[static_cast<std::size_t>(v)] += mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
            count[static_cast<std::size_t>(v)] += 1.0;
        }
    }
    for (std::size_t s = 0; s < surface_->stations().size(); ++s) {
        double total = 0.0, nodes = 0.0;
        for (const VertexId v : surface_->station_nodes().of(s)) {
            total += sum[static_cast<std::size_t>(v)] / count[static_cast<std::size_t>(v)];
            nodes += 1.0;
        }
        modulus_.push_back(total / nodes);
    }
}

/// Their columns stay for good.
void StationCompliance::place_anchors()
{
    const std::vector<std::int32_t>& anchors = surface_->anchors();
    std::vector<double> stiffness(anchors.size());
    for (std::size_t i = 0; i < anchors.size(); i += kBatch) {
        const std::size_t count = std::min(kBatch, anchors.size() - i);
        const Eigen::MatrixXd fields = solver_->solver->solve_all(unit_loads({ anchors.data() + i, count }));
        for (std::size_t k = 0; k < count; ++k) {
            const auto columns = fields.middleCols(static_cast<Eigen::Index>(3 * k), 3);
            store(anchors[i + k], static_cast<std::int32_t>(i + k), columns);
            last_wanted_[i + k] = std::numeric_limits<std::int64_t>::max();
            stiffness[i + k] = pad_stiffness(anchors[i + k], columns);
        }
    }
    spread_stiffness(stiffness);
}

/// From the anchors to all stations, per elasticity, by the inverse fourth power of the distance: nearest count.
void StationCompliance::spread_stiffness(const std::vector<double>& of_anchors)
{
    const double close = 0.5 * surface_->spacing(); // mm: an anchor's own station
    for (std::size_t s = 0; s < surface_->stations().size(); ++s) {
        double sum = 0.0, weights = 0.0;
        for (std::size_t i = 0; i < of_anchors.size(); ++i) {
            const auto anchor = static_cast<std::size_t>(surface_->anchors()[i]);
            const double squared
                = (surface_->stations()[anchor].point - surface_->stations()[s].point).squaredNorm() + close * close;
            const double weight = 1.0 / (squared * squared);
            sum += weight * of_anchors[i] / modulus_[anchor];
            weights += weight;
        }
        stand_in_.push_back(modulus_[s] * sum / weights);
    }
}

/// The stations within a fingertip about the anchor, pressed in by 1 mm together, as if how one moves another depended
/// on nothing but their distance: that is known from the anchor's own columns.
double StationCompliance::pad_stiffness(std::int32_t anchor, const Eigen::Ref<const Eigen::MatrixXd>& columns) const
{
    const Station& middle = surface_->stations()[static_cast<std::size_t>(anchor)];
    std::vector<std::pair<double, double>> felt; // distance, mm; compliance, mm/N
    std::vector<Vec3> pressed;
    for (std::size_t s = 0; s < surface_->stations().size(); ++s) {
        const Station& station = surface_->stations()[s];
        const double distance = (station.point - middle.point).norm();
        constexpr double kFacing = 0.2; // not the far side of a thin vessel
        if (distance > 2.0 * kStandInRadius + surface_->spacing() || station.normal.dot(middle.normal) < kFacing)
            continue;
        Mat3 L;
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            L.col(axis) = mean(columns.col(axis), static_cast<std::int32_t>(s));
        felt.emplace_back(distance, middle.normal.dot(L * middle.normal));
        if (distance < kStandInRadius)
            pressed.push_back(station.point);
    }
    std::sort(felt.begin(), felt.end());
    const auto at_distance = [&](double r) {
        const auto next = std::lower_bound(felt.begin(), felt.end(), std::pair(r, -1e300));
        if (next == felt.begin() || next == felt.end())
            return next == felt.end() ? felt.back().second : next->second;
        const auto& [r0, c0] = *(next - 1);
        const auto& [r1, c1] = *next;
        return r1 > r0 ? c0 + (c1 - c0) * (r - r0) / (r1 - r0) : c1;
    };
    const auto n = static_cast<Eigen::Index>(pressed.size());
    Eigen::MatrixXd C(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index k = 0; k < n; ++k)
            C(i, k) = at_distance((pressed[static_cast<std::size_t>(i)] - pressed[static_cast<std::size_t>(k)]).norm());
    const double single = 1.0 / felt.front().second, together = C.ldlt().solve(Eigen::VectorXd::Ones(n)).sum();
    // The guess need not be positive definite; pressing more never takes less.
    constexpr double kMost = 4.0; // times a single station's: twice what vessels and blocks show
    return std::isfinite(together) ? std::clamp(together, single, kMost * single) : single;
}

Eigen::MatrixXd StationCompliance::unit_loads(std::span<const std::int32_t> stations) const
{
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(solver_->unknowns, static_cast<Eigen::Index>(3 * stations.size()));
    for (std::size_t i = 0; i < stations.size(); ++i) {
        const auto s = static_cast<std::size_t>(stations[i]);
        const auto first = static_cast<std::size_t>(surface_->station_nodes().start[s]);
        const auto nodes = surface_->station_nodes().of(s);
        for (std::size_t n = 0; n < nodes.size(); ++n)
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                loads(3 * nodes[n] + axis, static_cast<Eigen::Index>(3 * i) + axis) = surface_->weights()[first + n];
    }
    return loads;
}

Vec3 StationCompliance::mean(const Eigen::Ref<const Eigen::VectorXd>& u, std::int32_t station) const
{
    const auto s = static_cast<std::size_t>(station);
    const auto first = static_cast<std::size_t>(surface_->station_nodes().start[s]);
    const auto nodes = surface_->station_nodes().of(s);
    Vec3 sum = Vec3::Zero();
    for (std::size_t n = 0; n < nodes.size(); ++n)
        sum += surface_->weights()[first + n] * u.segment<3>(3 * nodes[n]);
    return sum;
}

std::int32_t StationCompliance::free_place(std::int64_t newer_than)
{
    std::size_t best = capacity_;
    for (std::size_t p = 0; p < capacity_; ++p) {
        if (station_at_[p] < 0 && last_wanted_[p] != newer_than)
            return static_cast<std::int32_t>(p);
        if (station_at_[p] >= 0 && last_wanted_[p] < newer_than
            && (best == capacity_ || last_wanted_[p] < last_wanted_[best]))
            best = p;
    }
    return best == capacity_ ? -1 : static_cast<std::int32_t>(best);
}

std::size_t StationCompliance::fetch(std::span<const std::int32_t> wanted, std::size_t most, const ServoGate& gate)
{
    ++now_;
    std::vector<std::int32_t> missing, places;
    for (const std::int32_t s : wanted)
        if (const std::int32_t p = place(s); p < 0)
            missing.push_back(s);
        else
            last_wanted_[static_cast<std::size_t>(p)] = std::max(last_wanted_[static_cast<std::size_t>(p)], now_);
    missing.resize(std::min(missing.size(), most));
    bool forgotten = false;
    for (std::size_t i = 0; i < missing.size(); ++i) {
        const std::int32_t p = free_place(now_);
        if (p < 0) {
            missing.resize(i); // everything in the store is wanted now
            break;
        }
        const auto at = static_cast<std::size_t>(p);
        if (station_at_[at] >= 0) {
            place_[static_cast<std::size_t>(station_at_[at])].store(-1, std::memory_order_seq_cst);
            station_at_[at] = -1;
            --ready_count_;
            forgotten = true;
        }
        last_wanted_[at] = now_;
        places.push_back(p);
    }
    if (forgotten)
        gate.wait_for_tick_end();
    for (std::size_t i = 0; i < missing.size(); i += kBatch) {
        const std::size_t count = std::min(kBatch, missing.size() - i);
        solve_and_store({ missing.data() + i, count }, { places.data() + i, count });
    }
    return missing.size();
}

void StationCompliance::fetch_all(const ServoGate& gate, const Job& job)
{
    std::vector<std::int32_t> all(surface_->stations().size());
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = static_cast<std::int32_t>(i);
    constexpr std::size_t kStep = 64;
    while (ready_count_ < all.size() && !job.cancelled()) {
        job.report("compliance", static_cast<double>(ready_count_) / static_cast<double>(all.size()));
        if (fetch(all, kStep, gate) == 0)
            return;
    }
}

void StationCompliance::solve_and_store(std::span<const std::int32_t> stations, std::span<const std::int32_t> places)
{
    const Eigen::MatrixXd fields = solver_->solver->solve_all(unit_loads(stations));
    for (std::size_t i = 0; i < stations.size(); ++i)
        store(stations[i], places[i], fields.middleCols(static_cast<Eigen::Index>(3 * i), 3));
}

void StationCompliance::store(
    std::int32_t station, std::int32_t place, const Eigen::Ref<const Eigen::MatrixXd>& columns)
{
    const auto p = static_cast<std::size_t>(place);
    std::vector<double>& kept = columns_[p];
    kept.resize(9 * shown_.size());
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        for (std::size_t v = 0; v < shown_.size(); ++v)
            for (Eigen::Index k = 0; k < 3; ++k)
                kept[3 * (static_cast<std::size_t>(axis) * shown_.size() + v) + static_cast<std::size_t>(k)]
                    = columns(3 * shown_[v] + k, axis);
    station_at_[p] = station;
    for (std::size_t q = 0; q < capacity_; ++q) {
        if (station_at_[q] < 0)
            continue;
        Mat3 L; // displacement of the station at q by a force on this one
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            L.col(axis) = mean(columns.col(axis), station_at_[q]);
        using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        Eigen::Map<RowMajor>(blocks_.data() + 9 * (q * capacity_ + p)) = L;
        Eigen::Map<RowMajor>(blocks_.data() + 9 * (p * capacity_ + q)) = L.transpose();
    }
    ++ready_count_;
    place_[static_cast<std::size_t>(station)].store(place, std::memory_order_release);
}

void StationCompliance::add_displacement(double pressure, std::span<const StationForce> forces, Points& points) const
{
    Eigen::Map<Eigen::VectorXd> sum(points.data(), points.size());
    sum += pressure * Eigen::Map<const Eigen::VectorXd>(shown_pulse_.data(), shown_pulse_.size());
    for (const StationForce& f : forces) {
        const std::int32_t p = place(f.station);
        if (p < 0)
            continue;
        const std::vector<double>& kept = columns_[static_cast<std::size_t>(p)];
        sum += Eigen::Map<const Eigen::MatrixXd>(kept.data(), points.size(), 3) * f.force;
    }
}

Eigen::VectorXd StationCompliance::solve(double pressure, std::span<const StationForce> forces) const
{
    Eigen::VectorXd load = pressure * solver_->pressure_load;
    for (const StationForce& f : forces) {
        const std::array<std::int32_t, 1> one { f.station };
        load += unit_loads(one) * f.force;
    }
    return solver_->solver->solve(load);
}

double StationCompliance::stand_in(std::int32_t station) const noexcept
{
    return stand_in_[static_cast<std::size_t>(station)];
}

std::size_t StationCompliance::unknowns() const { return solver_->solver->free_count(); }

std::size_t StationCompliance::bytes() const
{
    return solver_->solver->bytes() + blocks_.size() * sizeof(double)
        + ready_count_ * 9 * shown_.size() * sizeof(double);
}

} // namespace retractor
