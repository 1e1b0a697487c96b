#pragma once
// An elastic body condensed onto the stations fingers touch: L = K^-1 restricted to them, block by block, without a
// dense inverse. K is factored once; when a finger is about to come near a station it is fetched into a bounded store,
// in two steps: the forward half of the solve, visiting only what the station reaches in the elimination tree, gives
// its blocks with all others (L_ab = y_a^T y_b), exact; the other half gives the columns that move the whole surface,
// and may come later. Units mm, N, MPa.
//
// Two threads: the simulation thread fetches columns and forgets old ones, the servo reads blocks between two ready
// stations. A station's place in the store is published when all its blocks are there, and given to another only after
// the servo has left the tick in which it might still read it (`ServoGate`).

#include "fem/model/elastic_body.h"
#include "haptics/condensed/touch_surface.h"
#include "mesh/base/job.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace retractor::haptics {

/// Which elements carry the body.
enum class TouchElement {
    p1, ///< four nodes: the source's. Stiff: a thin wall of one layer comes out about twice too stiff
    locking_free, ///< four nodes, strains averaged (fem/locking_free.h)
    p2, ///< ten nodes: the same time per tick, longer to factorise
};

/// Told by the servo, asked by the simulation thread: is a tick going on that began before now?
class ServoGate {
public:
    void enter() noexcept { count_.fetch_add(1, std::memory_order_seq_cst); }
    void leave() noexcept { count_.fetch_add(1, std::memory_order_seq_cst); }
    /// Simulation thread: returns when no tick that was going on at the call still is.
    void wait_for_tick_end() const noexcept;

private:
    std::atomic<std::uint64_t> count_ { 0 }; ///< odd within a tick
};

/// The body and its boundary conditions, as the compliance needs them.
struct TouchedBody {
    const mesh::TetMesh* mesh = nullptr; ///< of the element's nodes
    std::vector<std::uint8_t> prescribed; ///< one per unknown, three per node; 1 = does not move
    std::vector<mesh::TetFace> inner_faces; ///< where blood presses
    std::vector<VertexId> shown; ///< nodes whose displacement is drawn
};

class ContactNodeCompliance {
public:
    /// Factors, solves for the unit pressure, and measures what stands in for stations that are not ready.
    /// @param lame one per element. @param budget bytes for columns and blocks.
    /// @throws SolverError naming the node when the body is not held.
    ContactNodeCompliance(const TouchedBody& body, const TouchSurface& surface, const std::vector<fem::Lame>& lame,
        TouchElement element, std::size_t budget, const Job& job);
    ~ContactNodeCompliance();
    ContactNodeCompliance(const ContactNodeCompliance&) = delete;
    ContactNodeCompliance& operator=(const ContactNodeCompliance&) = delete;

    // Simulation thread.
    std::size_t capacity() const { return capacity_; } ///< stations that can be ready at once
    std::size_t ready_count() const { return ready_count_; }
    bool holds_all() const { return capacity_ == surface_->contact_nodes().size(); }
    /// Fetches those of `wanted` (most wanted first) that are not ready, `most` at most; forgets the ones not wanted
    /// for longest when the store is full. @return how many were fetched: their blocks are exact.
    std::size_t fetch(std::span<const std::int32_t> wanted, std::size_t most, const ServoGate& gate);
    /// Solves for columns of the shown nodes where they are still missing, those wanted last first, for so many batches
    /// of stations fetched together.
    void finish_columns(std::size_t batches);
    static constexpr std::size_t kBatch
        = 8; ///< stations solved together: 24 right sides share each pass over the factor
    std::size_t columns_missing() const; ///< of batches
    /// More are not to wait for long: each is held beside the store, and multiplied with every station fetched. As many
    /// as the stations within two fingers' reach.
    static constexpr std::size_t kMostWaiting = 12;
    /// Fetches all, columns too. @pre holds_all()
    void fetch_all(const ServoGate& gate, const Job& job);

    struct ContactNodeForce {
        std::int32_t contact_node = 0;
        Vec3 force = Vec3::Zero(); ///< on the tissue, N
    };
    /// Displacement of the shown nodes under a pressure (MPa) and forces on stations whose columns are there, added to
    /// `points`.
    void add_displacement(double pressure, std::span<const ContactNodeForce> forces, Points& points) const;
    /// Displacement of every node of the mesh, by a solve of its own.
    Eigen::VectorXd solve(double pressure, std::span<const ContactNodeForce> forces) const;
    /// A station's displacement in a field over the mesh's nodes.
    Vec3 mean(const Eigen::Ref<const Eigen::VectorXd>& u, std::int32_t contact_node) const;
    std::size_t unknowns() const;
    std::size_t bytes() const;

    // Servo thread.
    bool ready(std::int32_t contact_node) const noexcept { return place(contact_node) >= 0; }
    /// Displacement of station a by a force on station b: nine numbers, row by row, or null when one is not ready.
    const double* block(std::int32_t a, std::int32_t b) const noexcept
    {
        const std::int32_t i = place(a), j = place(b);
        return i < 0 || j < 0
            ? nullptr
            : blocks_.data() + 9 * (static_cast<std::size_t>(i) * contact_nodes_ + static_cast<std::size_t>(b));
    }
    /// Displacement by a pressure of 1 MPa, mm.
    Vec3 pulse_of_vertex(std::int32_t touch_vertex) const noexcept
    {
        return vertex_pulse_.row(touch_vertex).transpose();
    }
    Vec3 pulse_of_contact_node(std::int32_t contact_node) const noexcept
    {
        return contact_node_pulse_.row(contact_node).transpose();
    }
    /// N/mm: what a pad of kStandInRadius pressed on this station's middle feels, the others ready or not; measured
    /// when the body was factored. It stands in until the stations are ready.
    double fallback_stiffness(std::int32_t contact_node) const noexcept
    {
        return stand_in_[static_cast<std::size_t>(contact_node)];
    }
    static constexpr double kStandInRadius = 4.0; ///< mm

private:
    struct Solver;
    std::int32_t place(std::int32_t contact_node) const noexcept
    {
        return place_[static_cast<std::size_t>(contact_node)].load(std::memory_order_acquire);
    }
    struct Batch;
    std::int32_t free_place(std::int64_t newer_than);
    void forget(std::size_t place);
    void take_in(std::span<const std::int32_t> contact_nodes, std::span<const std::int32_t> places);
    using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    Block block_at(std::int32_t place, std::int32_t contact_node)
    {
        return Block(blocks_.data()
            + 9 * (static_cast<std::size_t>(place) * contact_nodes_ + static_cast<std::size_t>(contact_node)));
    }
    bool awaits_columns(std::int32_t place, std::int32_t contact_node) const;
    void keep_columns(std::int32_t place, const Eigen::Ref<const Eigen::MatrixXd>& columns);
    void measure_pads(const Job& job);

    const TouchSurface* surface_;
    std::vector<VertexId> shown_;
    std::unique_ptr<Solver> solver_;
    std::size_t contact_nodes_ = 0, capacity_ = 0, ready_count_ = 0;
    std::unique_ptr<std::atomic<std::int32_t>[]> place_; ///< per station: its place in the store; -1: not ready
    std::vector<std::int32_t> contact_node_at_; ///< per place; -1: empty
    std::vector<std::int64_t> last_wanted_; ///< per place
    std::int64_t now_ = 0;
    std::vector<double> blocks_; ///< place, station, 3 x 3: with all ready ones; with all, where the columns are there
    std::vector<std::vector<double>> columns_; ///< per place: shown nodes x 3, for each of three unit forces; or empty
    std::vector<Batch> batches_; ///< fetched, their columns not yet
    Points vertex_pulse_, contact_node_pulse_, shown_pulse_;
    std::vector<double> stand_in_; ///< N/mm, per station
};

} // namespace retractor::haptics
