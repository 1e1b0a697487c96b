#pragma once
// An elastic body condensed onto the contact nodes that fingers touch: L = K^-1 restricted to the contact nodes, block
// by block, without a dense inverse. K is factored once. When a finger approaches a contact node, the node is fetched
// into a bounded store in two steps. The forward half of the solve visits only the unknowns that the node reaches in
// the elimination tree and gives the exact blocks with all other contact nodes in the store, L_ab = y_a^T y_b. The
// backward half gives the columns that move the whole surface, and may come later. Units mm, N, MPa.
//
// Two threads use the store. The simulation thread fetches columns and forgets old ones; the servo reads blocks between
// two ready contact nodes. The place of a contact node in the store is published when all its blocks are present. A
// place is given to another contact node only after the servo has left the tick in which it might still read the place
// (`ServoGate`).

#include "fem/model/elastic_body.h"
#include "haptics/condensed/touch_surface.h"
#include "mesh/base/job.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace retractor::haptics {

/// The elements of the body.
enum class TouchElement {
    p1, ///< four nodes, as in Nakao et al. 2006; too stiff: a thin wall of one layer comes out about twice too stiff
    locking_free, ///< four nodes with averaged strains (fem/element/locking_free.h)
    p2, ///< ten nodes: the same time per tick, a longer factorisation
};

/// Tells the simulation thread whether a tick that began earlier still runs. The servo calls enter() and leave().
class ServoGate {
public:
    void enter() noexcept { count_.fetch_add(1, std::memory_order_seq_cst); }
    void leave() noexcept { count_.fetch_add(1, std::memory_order_seq_cst); }
    /// Simulation thread: returns when every tick that ran at the call has ended.
    void wait_for_tick_end() const noexcept;

private:
    std::atomic<std::uint64_t> count_ { 0 }; ///< odd within a tick
};

/// The body and its boundary conditions.
struct TouchedBody {
    const mesh::TetMesh* mesh = nullptr; ///< mesh of the element's nodes
    std::vector<std::uint8_t> prescribed; ///< one per unknown, three per node; 1 = does not move
    std::vector<mesh::TetFace> inner_faces; ///< faces under blood pressure
    std::vector<VertexId> shown; ///< nodes whose displacement is drawn
};

class ContactNodeCompliance {
public:
    /// Factors K, solves for the unit pressure, and computes the fallback stiffness of every contact node.
    /// @param lame one per element
    /// @param budget bytes for columns and blocks
    /// @throws SolverError naming the node when the supports do not hold the body
    ContactNodeCompliance(const TouchedBody& body, const TouchSurface& surface, const std::vector<fem::Lame>& lame,
        TouchElement element, std::size_t budget, const Job& job);
    ~ContactNodeCompliance();
    ContactNodeCompliance(const ContactNodeCompliance&) = delete;
    ContactNodeCompliance& operator=(const ContactNodeCompliance&) = delete;

    // Simulation thread:
    std::size_t capacity() const { return capacity_; } ///< contact nodes that can be ready at once
    std::size_t ready_count() const { return ready_count_; }
    bool holds_all() const { return capacity_ == surface_->contact_nodes().size(); }
    /// Fetches contact nodes of `wanted` (most wanted first) that are not ready, at most `most`. Forgets the contact
    /// nodes that were not wanted for the longest time when the store is full.
    /// @return the number of fetched contact nodes; their blocks are exact
    std::size_t fetch(std::span<const std::int32_t> wanted, std::size_t most, const ServoGate& gate);
    /// Solves for missing columns of the shown nodes, most recently wanted first, for this many batches. A batch is the
    /// contact nodes that were fetched together.
    void finish_columns(std::size_t batches);
    /// Number of contact nodes that are solved together; 24 right sides share each pass over the factor.
    static constexpr std::size_t kBatch = 8;
    std::size_t columns_missing() const; ///< number of batches without columns
    /// Largest number of batches that wait for columns. Each waiting batch is held beside the store and multiplied with
    /// every fetched contact node. The limit covers the contact nodes within reach of two fingers.
    static constexpr std::size_t kMostWaiting = 12;
    /// Fetches all contact nodes with their columns. @pre holds_all()
    void fetch_all(const ServoGate& gate, const Job& job);

    struct ContactNodeForce {
        std::int32_t contact_node = 0;
        Vec3 force = Vec3::Zero(); ///< on the tissue, N
    };
    /// Adds to `points` the displacement of the shown nodes under a pressure (MPa) and forces on contact nodes.
    /// @pre the columns of these contact nodes are present
    void add_displacement(double pressure, std::span<const ContactNodeForce> forces, Points& points) const;
    /// Displacement of every node of the mesh (mm, three numbers a node), by a separate solve.
    Eigen::VectorXd solve(double pressure, std::span<const ContactNodeForce> forces) const;
    /// Displacement of a contact node in a field over the mesh's nodes, mm.
    Vec3 mean(const Eigen::Ref<const Eigen::VectorXd>& u, std::int32_t contact_node) const;
    std::size_t unknowns() const;
    std::size_t bytes() const;

    // Servo thread:
    bool ready(std::int32_t contact_node) const noexcept { return place(contact_node) >= 0; }
    /// Displacement of contact node a by a unit force on contact node b, mm/N: nine numbers, row by row. Null when a or
    /// b is not ready.
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
    /// Stiffness that a pad of radius kFallbackRadius feels on this contact node, N/mm, whether or not the other
    /// contact nodes are ready. The constructor computes the values. The servo uses this stiffness until the contact
    /// nodes are ready.
    double fallback_stiffness(std::int32_t contact_node) const noexcept
    {
        return fallback_stiffness_[static_cast<std::size_t>(contact_node)];
    }
    static constexpr double kFallbackRadius = 4.0; ///< mm

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
    std::unique_ptr<std::atomic<std::int32_t>[]> place_; ///< per contact node: place in the store; -1: not ready
    std::vector<std::int32_t> contact_node_at_; ///< contact node at each place; -1: empty
    std::vector<std::int64_t> last_wanted_; ///< per place
    std::int64_t now_ = 0;
    /// Place, contact node, 3 x 3: valid for all ready contact nodes, and for all contact nodes once the columns exist.
    std::vector<double> blocks_;
    /// Per place: shown nodes x 3 for each of three unit forces; empty when missing.
    std::vector<std::vector<double>> columns_;
    std::vector<Batch> batches_; ///< fetched batches without columns
    Points vertex_pulse_, contact_node_pulse_, shown_pulse_;
    std::vector<double> fallback_stiffness_; ///< fallback stiffness of each contact node, N/mm
};

} // namespace retractor::haptics
