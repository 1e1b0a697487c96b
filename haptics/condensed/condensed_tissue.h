#pragma once
// Tissue by condensed finite elements under a pulse (Nakao et al., Transferring bioelasticity knowledge through haptic
// interaction, IEEE MultiMedia 13(3), 2006): u = L f and f_c = L_cc^-1 (u_c - L_ci f_i). The fingertips prescribe the
// displacements u_c of the contact nodes that they press. The fingers feel the forces that these displacements take,
// less the forces of the blood pressure alone. The model is linear and quasi-static: strains are small, inertia and
// flow are neglected, and palpation does not change the pressure. Units mm, N, MPa. Frame: the scene's.
//
// - A fingertip is frictionless (pad or sphere, see FingertipShape). The fingertip presses at most `patch_limit`
//   contact nodes (touch_surface.h), along the surface normal at its place, and never pulls. All fingers are solved
//   together, because one finger moves the surface under the others.
// - The cost of a tick does not depend on the size of the body. follow() prepares contact nodes ahead of the fingers.
//   Until all contact nodes of a contact are ready, the contact rests on the ready ones, or on `fallback_stiffness` of
//   the middle contact node where this gives the larger force. `late_ticks()` counts such ticks. The shown surface lags
//   some frames behind the force there.
// - Edits of the elasticity are built in the background and take effect in one swap. When the force would jump, at a
//   swap or when columns arrive, the difference is blended in by at most `blend` N per tick.
// - The proxy of a contact is the fingertip moved back along the normal until the fingertip just touches the unpressed
//   surface.

#include "datasets/phantoms/elastic_model.h"
#include "haptics/condensed/contact_node_compliance.h"
#include "haptics/condensed/contact_solver.h"
#include "haptics/condensed/elastic_template.h"
#include "haptics/condensed/fingertip_search.h"
#include "haptics/condensed/pulse_pressure.h"
#include "haptics/servo/tissue_response.h"
#include "mesh/base/job.h"
#include "mesh/base/triple_buffer.h"

#include <atomic>
#include <future>
#include <memory>
#include <vector>

namespace retractor::haptics {

struct CondensedOptions {
    TouchElement element = TouchElement::p2;
    FingertipShape fingertip = FingertipShape::pad;
    std::size_t fingers = 1;
    std::size_t patch_limit = 12; ///< largest number of contact nodes that one fingertip presses
    double contact_node_spacing = 2.2; ///< mm; a fingertip of radius 4 mm covers about twelve contact nodes
    double rest_pressure = 80.0 * kMPaPerMmHg; ///< pressure at which the mesh has its shape, MPa
    double force_gain = 1.0; ///< factor on all forces; a view shows the factor when it is not 1
    double blend = 0.02; ///< largest change of force by a swap, N per tick
    std::size_t store_bytes = std::size_t { 256 } << 20U; ///< memory for columns of L
    std::size_t fetch_all_below = 1200; ///< bodies with at most this many contact nodes fetch all columns at the start
    std::size_t fetches_per_follow = 24; ///< contact nodes that one follow() prepares
};

class CondensedTissue : public TissueResponse {
public:
    /// @throws InputError as check_elastic_model(), on options out of range, and when no surface can be touched;
    /// SolverError when the supports do not hold the body.
    CondensedTissue(datasets::ElasticModel model, PulsePressure pulse, CondensedOptions options, const Job& job = {});
    ~CondensedTissue() override;

    std::string_view name() const noexcept override { return "fem"; }
    std::size_t finger_count() const noexcept override { return options_.fingers; }
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    const TriMesh& surface() const noexcept override { return shown_; }
    void follow(Points& deformed) override;

    // Simulation thread:
    /// Edits elasticity or roles. The edit takes effect some follow() calls later; edits that arrive during a build
    /// wait and are built together.
    /// @return the number of elements and vertices that changed
    /// @throws InputError as apply(); the model is unchanged then. follow() throws when an edit leaves the body without
    /// support or without a surface to touch. follow() then takes back this edit and the later edits that depend on it;
    /// the other edits stay.
    std::size_t edit(const ElasticTemplate& edit);
    /// All edits that were not taken back, in order. The last edits may not have taken effect yet.
    std::vector<ElasticTemplate> edits() const;
    /// Any thread: sets the rate of the pulse. @throws InputError outside 20 to 300 per minute.
    void set_heart_rate(double per_min) { beat_.set_rate(pulse_.rate_for(per_min)); }
    bool edit_pending() const { return !waiting_edits_.empty() || building_.valid() || retired_ != nullptr; }
    /// Waits until the next follow() can swap in the edited body. Replays use this function to swap at known ticks.
    void wait_for_edit() const;
    /// Fetches all columns near these fingertips now, before the servo reaches them.
    void prepare(std::span<const Fingertip> fingers);

    const datasets::ElasticModel& model() const { return model_; }
    const PulsePressure& pulse() const { return pulse_; }
    const CondensedOptions& options() const { return options_; }
    const TouchSurface& touch_surface() const { return *body_->touch; }
    const ContactNodeCompliance& compliance() const { return *body_->compliance; }
    /// Nodes of the element mesh that surface() shows, in the order of its vertices.
    const std::vector<VertexId>& shown_nodes() const { return shown_nodes_; }
    /// Pressure above the rest pressure at the curve's own rate, MPa.
    double pressure(double time_s) const noexcept { return pulse_.at(time_s) - options_.rest_pressure; }

    /// The contact of the last tick, without gain and blend. Simulation thread.
    struct Pressed {
        double time = 0.0, pressure = 0.0; ///< s; MPa above the rest pressure
        std::vector<ContactNodeCompliance::ContactNodeForce> forces; ///< on the tissue, N
        std::vector<Vec3> normals; ///< outward unit normal of each force
        std::vector<double> demands; ///< displacement of each pressed contact node beyond the pulse, mm
        std::vector<Fingertip> fingers;
    };
    Pressed last_pressed();
    /// Pressure of the last tick above the rest pressure, MPa. Simulation thread.
    double last_pressure() { return snapshots_.latest().pressure; }

    // Servo thread, or any thread after the servo has stopped:
    long ticks() const { return ticks_; }
    long late_ticks() const { return late_ticks_; }

private:
    /// Everything that an edit replaces.
    struct Body {
        datasets::ElasticModel model;
        std::vector<std::uint8_t> fixed; ///< per node: 1 = does not move
        std::shared_ptr<const TouchSurface> touch; ///< shared with the body before while only the elasticity changes
        std::unique_ptr<ContactNodeCompliance> compliance;
        std::vector<FingertipSearch> searches; ///< one per finger; servo thread
    };
    struct Snapshot {
        const Body* body = nullptr; ///< body whose contact nodes the forces refer to
        double time = 0.0, pressure = 0.0;
        std::size_t forces = 0;
        std::vector<ContactNodeCompliance::ContactNodeForce> force;
        std::vector<Vec3> normal;
        std::vector<double> demand;
        std::vector<Fingertip> fingers;
    };
    struct Finger;

    void show_surface();
    void make_room_for_fingers();
    /// @param touch touch surface of another body; reused when `touch_roles` equal the model's roles; may be nullptr
    std::unique_ptr<Body> build(datasets::ElasticModel model, std::shared_ptr<const TouchSurface> touch,
        const std::vector<datasets::VertexRole>& touch_roles, const Job& job) const;
    void swap_in();
    void start_build();
    std::unique_ptr<Body> built_body();
    void take_back_build();
    void publish_body(std::unique_ptr<Body> fresh, std::span<const Fingertip> fingers);

    bool solve_contact(Body& body, double pressure, std::span<const Fingertip> fingers) noexcept;
    /// @param points contact points that this tick already has; their places are kept
    std::int32_t make_resident(
        std::size_t finger, std::int32_t contact_node, std::size_t points, const ContactNodeCompliance& body) noexcept;
    std::size_t point_at(std::int32_t contact_node, std::size_t points) const noexcept;
    void forget_residents() noexcept;
    void fill_compliance() noexcept;
    bool find_forces() noexcept;
    void report(std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept;
    void publish(double time, double pressure, std::span<const Fingertip> fingers) noexcept;

    datasets::ElasticModel model_;
    mesh::TetMesh mesh_; ///< mesh of the element's nodes
    PulsePressure pulse_;
    CondensedOptions options_;
    TriMesh shown_;
    std::vector<VertexId> shown_nodes_;

    // Simulation thread.
    std::unique_ptr<Body> body_, retired_;
    std::future<std::unique_ptr<Body>> building_;
    /// Edits in body_, edits in the body that is being built, and later edits. model_ contains all of them.
    std::vector<ElasticTemplate> felt_edits_, building_edits_, waiting_edits_;
    /// Number of waiting edits to build one at a time, because the edits together gave no valid body.
    std::size_t built_alone_ = 0;
    TripleBuffer<Snapshot> snapshots_;

    // Shared.
    ServoGate gate_;
    std::atomic<Body*> published_ { nullptr };
    std::atomic<const Body*> in_use_ { nullptr };

    // Servo thread.
    Body* current_ = nullptr;
    std::vector<Finger> fingers_;
    std::size_t residents_per_finger_ = 0;
    std::vector<std::int32_t> resident_; ///< contact node at each place; -1: empty
    std::vector<double> resident_blocks_; ///< 3 x 3 block for each pair of places
    ContactSolver solver_;
    std::vector<std::int32_t> point_place_; ///< resident place of each contact point
    std::vector<std::size_t> point_finger_;
    BeatClock beat_;
    long ticks_ = 0, late_ticks_ = 0;
};

} // namespace retractor::haptics
