#pragma once
// Tissue by condensed finite elements under a pulse [seed: u = L f, f_c = L_cc^-1 (u_c - L_ci f_i)]: the fingertips
// prescribe how far the stations they press give way; the forces that takes, less what the blood pressure does by
// itself, are what the fingers feel. Linear and quasi-static: strains are small, inertia and flow are left out, and the
// pressure is not changed by the palpation. Units mm, N, MPa.
//
// - A fingertip is frictionless (pad or sphere, see FingertipShape); it presses at most `patch_limit` stations
//   (touch_surface.h), along the surface normal where it touches, and never pulls. All fingers are solved together:
//   what one presses in moves the surface under the others.
// - The cost of a tick does not depend on the size of the body. ContactNodes are made ready by follow(), ahead of the
//   fingers. Until all stations of a contact are ready it rests on those that are, or, where that is more, on what a
//   pad feels on the station in its middle (measured when the body was factored). `late_ticks()` counts the ticks in
//   which that was so. The shown surface lags behind the force by some frames there.
// - Edits of the elasticity are built in the background and swapped in whole. What the force would jump by, at a swap
//   or when columns arrive, is handed over by at most `blend` N per tick.
// - A contact's proxy is the fingertip moved back along the normal to where it would just touch the unpressed surface.

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
    std::size_t patch_limit = 12; ///< stations a fingertip presses at once
    double contact_node_spacing = 2.2; ///< mm: a fingertip of 4 mm covers about twelve
    double rest_pressure = 80.0 * kMPaPerMmHg; ///< MPa, at which the mesh has its shape
    double force_gain = 1.0; ///< forces are multiplied by this; say so where they are shown
    double blend = 0.02; ///< N per tick
    std::size_t store_bytes = std::size_t { 256 } << 20U; ///< for columns of L
    std::size_t fetch_all_below = 1200; ///< bodies of at most so many stations have all their columns from the start
    std::size_t fetches_per_follow = 24; ///< stations made ready by one follow()
};

class CondensedTissue : public TissueResponse {
public:
    /// @throws InputError as check_elastic_model, on options out of their range, and when no surface can be touched;
    /// SolverError when the body is not held.
    CondensedTissue(datasets::ElasticModel model, PulsePressure pulse, CondensedOptions options, const Job& job = {});
    ~CondensedTissue() override;

    std::string_view name() const noexcept override { return "fem"; }
    std::size_t finger_count() const noexcept override { return options_.fingers; }
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    const TriMesh& surface() const noexcept override { return shown_; }
    void follow(Points& deformed) override;

    // Simulation thread.
    /// Elasticity or roles; takes effect some follow() calls later; edits made meanwhile wait and are then built
    /// together. @return how many elements and vertices it changed. @throws InputError as apply(): the model is as it
    /// was then. (follow() throws when an edit leaves the body unheld or nothing to touch: that edit is taken back, and
    /// those made later that cannot be without it; the others stay.)
    std::size_t edit(const ElasticTemplate& edit);
    /// What has been edited and not taken back, in order; the last ones may not be felt yet.
    std::vector<ElasticTemplate> edits() const;
    /// Any thread: the pulse goes on at this rate. @throws InputError outside 20 to 300 per minute.
    void set_heart_rate(double per_min) { beat_.set_rate(pulse_.rate_for(per_min)); }
    bool edit_pending() const { return !waiting_edits_.empty() || building_.valid() || retired_ != nullptr; }
    /// Waits until the edit's body can be swapped in by the next follow(). For replays, which swap at known ticks.
    void wait_for_edit() const;
    /// Fetches every column about these places now, before the servo comes there.
    void prepare(std::span<const Fingertip> fingers);

    const datasets::ElasticModel& model() const { return model_; }
    const PulsePressure& pulse() const { return pulse_; }
    const CondensedOptions& options() const { return options_; }
    const TouchSurface& touch_surface() const { return *body_->touch; }
    const ContactNodeCompliance& compliance() const { return *body_->compliance; }
    /// Nodes of the element's mesh that surface() shows, in its order.
    const std::vector<VertexId>& shown_nodes() const { return shown_nodes_; }
    /// Pressure above the rest state at the curve's own rate, MPa.
    double pressure(double time_s) const noexcept { return pulse_.at(time_s) - options_.rest_pressure; }

    /// What the last tick pressed: forces on the tissue, without gain and blend; how far those stations give way beyond
    /// the pulse, and the pressure. Simulation thread.
    struct Pressed {
        double time = 0.0, pressure = 0.0;
        std::vector<ContactNodeCompliance::ContactNodeForce> forces;
        std::vector<Vec3> normals; ///< per force
        std::vector<double> demands; ///< mm, per force
        std::vector<Fingertip> fingers;
    };
    Pressed last_pressed();
    /// Of the last tick, above the rest state, MPa. Simulation thread.
    double last_pressure() { return snapshots_.latest().pressure; }

    // Servo thread, or when it has stopped.
    long ticks() const { return ticks_; }
    long late_ticks() const { return late_ticks_; }

private:
    /// What an edit swaps in whole.
    struct Body {
        datasets::ElasticModel model;
        std::vector<std::uint8_t> fixed; ///< per node
        std::shared_ptr<const TouchSurface> touch; ///< shared while only the elasticity changes
        std::unique_ptr<ContactNodeCompliance> compliance;
        std::vector<FingertipSearch> searches; ///< servo thread; per finger
    };
    struct Snapshot {
        const Body* body = nullptr; ///< whose stations the forces name
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
    /// @param like a body whose touch surface is taken when the roles are the same; or nullptr
    std::unique_ptr<Body> build(datasets::ElasticModel model, std::shared_ptr<const TouchSurface> touch,
        const std::vector<datasets::VertexRole>& touch_roles, const Job& job) const;
    void swap_in();
    void start_build();
    std::unique_ptr<Body> built_body();
    void take_back_build();
    void publish_body(std::unique_ptr<Body> fresh, std::span<const Fingertip> fingers);

    bool solve_contact(Body& body, double pressure, std::span<const Fingertip> fingers) noexcept;
    /// @param points contact points that this tick already has: their places are kept
    std::int32_t make_resident(
        std::size_t finger, std::int32_t contact_node, std::size_t points, const ContactNodeCompliance& body) noexcept;
    std::size_t point_at(std::int32_t contact_node, std::size_t points) const noexcept;
    void forget_residents() noexcept;
    void fill_compliance() noexcept;
    bool find_forces() noexcept;
    void report(std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept;
    void publish(double time, double pressure, std::span<const Fingertip> fingers) noexcept;

    datasets::ElasticModel model_;
    mesh::TetMesh mesh_; ///< of the element's nodes
    PulsePressure pulse_;
    CondensedOptions options_;
    TriMesh shown_;
    std::vector<VertexId> shown_nodes_;

    // Simulation thread.
    std::unique_ptr<Body> body_, retired_;
    std::future<std::unique_ptr<Body>> building_;
    /// In body_, in the one that is being built, and those after it. model_ has them all.
    std::vector<ElasticTemplate> felt_edits_, building_edits_, waiting_edits_;
    std::size_t built_alone_ = 0; ///< so many of the waiting ones: together they made no body
    TripleBuffer<Snapshot> snapshots_;

    // Shared.
    ServoGate gate_;
    std::atomic<Body*> published_ { nullptr };
    std::atomic<const Body*> in_use_ { nullptr };

    // Servo thread.
    Body* current_ = nullptr;
    std::vector<Finger> fingers_;
    std::size_t residents_per_finger_ = 0;
    std::vector<std::int32_t> resident_; ///< station per place; -1: empty
    std::vector<double> resident_blocks_; ///< place, place, 3 x 3
    ContactSolver solver_;
    std::vector<std::int32_t> point_place_; ///< per contact point: its resident place
    std::vector<std::size_t> point_finger_;
    BeatClock beat_;
    long ticks_ = 0, late_ticks_ = 0;
};

/// The forces of the last tick put on the whole body, and solved for at once.
struct PressedCheck {
    Eigen::VectorXd displacement; ///< of every node, mm
    double off_mm = 0.0; ///< the farthest that a pressed station stands from where the tick held it
    double deepest_mm = 0.0; ///< that a station gives way beyond the pulse
};
/// Simulation thread.
PressedCheck check_pressed(CondensedTissue& tissue);

} // namespace retractor::haptics
