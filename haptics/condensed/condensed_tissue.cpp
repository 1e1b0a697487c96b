#include "haptics/condensed/condensed_tissue.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace retractor::haptics {

namespace {

    /// Contact nodes kept beside the ones in use, for a finger that moves to and fro.
    constexpr std::size_t kSpareResidents = 8;
    constexpr double kAhead = 0.25; ///< s; columns are fetched for the finger's motion within this time
    constexpr double kMargin = 8.0; ///< mm; columns are fetched within this distance of a finger's reach

    std::vector<fem::Lame> lame_of(const datasets::ElasticModel& model)
    {
        std::vector<fem::Lame> lame(model.mesh.tet_count());
        for (std::size_t t = 0; t < lame.size(); ++t) {
            const double E = model.youngs_modulus[t], nu = model.poissons_ratio[t];
            lame[t] = { E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) };
        }
        return lame;
    }

    std::vector<std::uint8_t> corners_with(const datasets::ElasticModel& model, datasets::VertexRole role)
    {
        std::vector<std::uint8_t> flags(model.roles.size());
        std::transform(model.roles.begin(), model.roles.end(), flags.begin(),
            [&](datasets::VertexRole r) { return static_cast<std::uint8_t>(r == role); });
        return flags;
    }

    /// A midpoint is fixed when both its corners are.
    std::vector<std::uint8_t> with_fixed_midpoints(const mesh::TetMesh& mesh, std::vector<std::uint8_t> fixed)
    {
        fixed.resize(mesh.vertex_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()) && mesh.nodes_per_tet == 10; ++t) {
            const auto tet = mesh.tet(t);
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (fixed[static_cast<std::size_t>(tet[static_cast<std::size_t>(mesh::kTetEdges[e][0])])] != 0
                    && fixed[static_cast<std::size_t>(tet[static_cast<std::size_t>(mesh::kTetEdges[e][1])])] != 0)
                    fixed[static_cast<std::size_t>(tet[4 + e])] = 1;
        }
        return fixed;
    }

    void check(const CondensedOptions& o, const datasets::ElasticModel& model)
    {
        const auto refuse = [](const char* what, const char* where) { throw InputError(what, where); };
        if (o.fingers < 1 || o.fingers > 16)
            refuse("between 1 and 16 fingers", "fingers");
        if (o.patch_limit < 1 || o.patch_limit > 1024)
            refuse("between 1 and 1024 contact nodes", "patch limit");
        if (!(std::isfinite(o.force_gain) && o.force_gain > 0.0))
            refuse("must be positive and finite", "force gain");
        if (!(std::isfinite(o.blend) && o.blend > 0.0))
            refuse("must be positive and finite", "blend");
        if (!std::isfinite(o.rest_pressure))
            refuse("must be finite", "rest pressure");
        if (model.mesh.nodes_per_tet == 10 && o.element != TouchElement::p2)
            refuse("a mesh with midpoints needs ten-node elements", "element");
    }

} // namespace

struct CondensedTissue::Finger {
    TouchedPlace place {};
    std::vector<Candidate> candidates;
    std::size_t count = 0; ///< number of candidates
    int missing = 0, missing_before = 0;
    bool fallback_stiffness = false, fallback_before = false;
    std::vector<std::int32_t> pressing {}; ///< contact nodes that pressed at the last tick
    std::size_t pressing_count = 0;
    std::size_t first_point = 0, last_point = 0;
    Vec3 raw = Vec3::Zero(), raw_before = Vec3::Zero(), offset = Vec3::Zero();
    double stiffness = 0.0;

    explicit Finger(std::size_t limit)
        : candidates(limit)
        , pressing(limit, -1)
    {
    }
    bool pressed(std::int32_t contact_node) const noexcept
    {
        const auto end = pressing.begin() + static_cast<std::ptrdiff_t>(pressing_count);
        return std::find(pressing.begin(), end, contact_node) != end;
    }
};

CondensedTissue::CondensedTissue(
    datasets::ElasticModel model, PulsePressure pulse, CondensedOptions options, const Job& job)
    : model_(std::move(model))
    , pulse_(std::move(pulse))
    , options_(options)
    , solver_(options.patch_limit * options.fingers)
{
    datasets::check_elastic_model(model_);
    check(options_, model_);
    const Stopwatch watch;
    mesh_ = options_.element == TouchElement::p2 && model_.mesh.nodes_per_tet == 4 ? mesh::with_midpoints(model_.mesh)
                                                                                   : model_.mesh;
    show_surface();
    body_ = build(model_, nullptr, {}, job);
    record_part(job, "touch surface", watch, body_->touch->bytes());
    ContactNodeCompliance& compliance = *body_->compliance;
    if (compliance.holds_all() && body_->touch->contact_nodes().size() <= options_.fetch_all_below)
        compliance.fetch_all(gate_, job);
    published_.store(body_.get());
    make_room_for_fingers();
}

void CondensedTissue::show_surface()
{
    std::vector<std::int32_t> number(mesh_.vertex_count(), -1);
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh_)) {
        std::array<VertexId, 3> triangle = mesh::face_vertices(mesh_, face);
        for (VertexId& v : triangle) {
            std::int32_t& n = number[static_cast<std::size_t>(v)];
            if (n < 0) {
                n = static_cast<std::int32_t>(shown_nodes_.size());
                shown_nodes_.push_back(v);
            }
            v = n;
        }
        shown_.triangles.push_back(triangle);
        shown_.labels.push_back(mesh_.labels[static_cast<std::size_t>(face.tet)]);
    }
    shown_.vertices.resize(static_cast<Eigen::Index>(shown_nodes_.size()), 3);
    for (std::size_t i = 0; i < shown_nodes_.size(); ++i)
        shown_.vertices.row(static_cast<Eigen::Index>(i)) = mesh_.vertices.row(shown_nodes_[i]);
}

void CondensedTissue::make_room_for_fingers()
{
    const std::size_t points = options_.patch_limit * options_.fingers;
    Snapshot empty;
    empty.force.resize(points);
    empty.normal.resize(points);
    empty.demand.resize(points);
    empty.fingers.assign(options_.fingers, Fingertip { Vec3::Constant(1e9) });
    for (int i = 0; i < 3; ++i) {
        snapshots_.draft() = empty;
        snapshots_.publish();
        snapshots_.latest();
    }
    fingers_.assign(options_.fingers, Finger(options_.patch_limit));
    residents_per_finger_ = options_.patch_limit + kSpareResidents;
    resident_.assign(residents_per_finger_ * options_.fingers, -1);
    resident_blocks_.assign(9 * resident_.size() * resident_.size(), 0.0);
    point_place_.resize(points);
    point_finger_.resize(points);
}

CondensedTissue::~CondensedTissue() = default;

std::unique_ptr<CondensedTissue::Body> CondensedTissue::build(datasets::ElasticModel model,
    std::shared_ptr<const TouchSurface> touch, const std::vector<datasets::VertexRole>& touch_roles,
    const Job& job) const
{
    auto body = std::make_unique<Body>();
    std::vector<std::uint8_t> inner = corners_with(model, datasets::VertexRole::inner_wall);
    inner.resize(mesh_.vertex_count(), 0);
    body->fixed = with_fixed_midpoints(mesh_, corners_with(model, datasets::VertexRole::fixed));
    const WallFaces faces = wall_faces(mesh_, inner, body->fixed);
    body->touch = touch != nullptr && touch_roles == model.roles
        ? std::move(touch)
        : std::make_shared<const TouchSurface>(mesh_, faces.outer, body->fixed, options_.contact_node_spacing);
    std::vector<std::uint8_t> prescribed(3 * body->fixed.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        prescribed[i] = body->fixed[i / 3];
    body->compliance = std::make_unique<ContactNodeCompliance>(
        TouchedBody { &mesh_, std::move(prescribed), faces.inner, shown_nodes_ }, *body->touch, lame_of(model),
        options_.element, options_.store_bytes, job);
    body->searches.assign(options_.fingers, FingertipSearch(*body->touch, options_.fingertip));
    body->model = std::move(model);
    return body;
}

// ---- Servo thread ----

void CondensedTissue::forget_residents() noexcept { std::fill(resident_.begin(), resident_.end(), -1); }

std::int32_t CondensedTissue::make_resident(
    std::size_t finger, std::int32_t contact_node, std::size_t points, const ContactNodeCompliance& body) noexcept
{
    const std::size_t first = finger * residents_per_finger_, last = first + residents_per_finger_;
    std::size_t empty = last;
    for (std::size_t p = first; p < last; ++p) {
        if (resident_[p] == contact_node)
            return static_cast<std::int32_t>(p);
        if (resident_[p] < 0)
            empty = p;
    }
    const Finger& owner = fingers_[finger];
    for (std::size_t p = first; p < last && empty == last; ++p) {
        bool used = false;
        for (std::size_t c = 0; c < owner.count; ++c)
            used = used || owner.candidates[c].contact_node == resident_[p];
        if (!used)
            empty = p;
    }
    resident_[empty] = contact_node;
    const std::size_t count = resident_.size();
    for (std::size_t q = 0; q < count; ++q) {
        if (resident_[q] < 0)
            continue;
        const double* block = body.block(contact_node, resident_[q]);
        if (block == nullptr) { // the store has forgotten one of the two since
            const auto placed = point_place_.begin() + static_cast<std::ptrdiff_t>(points);
            const bool in_use = std::find(point_place_.begin(), placed, static_cast<std::int32_t>(q)) != placed;
            if (q == empty || in_use || !body.ready(contact_node)) { // a contact point of this tick keeps its place
                resident_[empty] = -1;
                return -1;
            }
            resident_[q] = -1;
            continue;
        }
        double* here = resident_blocks_.data() + 9 * (empty * count + q);
        double* there = resident_blocks_.data() + 9 * (q * count + empty);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                here[3 * i + k] = there[3 * k + i] = block[3 * i + k];
    }
    return static_cast<std::int32_t>(empty);
}

void CondensedTissue::fill_compliance() noexcept
{
    const std::size_t count = resident_.size(), points = fingers_.back().last_point;
    for (std::size_t a = 0; a < points; ++a) {
        const Vec3& n = fingers_[point_finger_[a]].place.normal;
        const double* row = resident_blocks_.data() + 9 * static_cast<std::size_t>(point_place_[a]) * count;
        for (std::size_t b = 0; b <= a; ++b) {
            const Vec3& m = fingers_[point_finger_[b]].place.normal;
            const double* L = row + 9 * static_cast<std::size_t>(point_place_[b]);
            solver_.compliance(a, b) = n[0] * (L[0] * m[0] + L[1] * m[1] + L[2] * m[2])
                + n[1] * (L[3] * m[0] + L[4] * m[1] + L[5] * m[2]) + n[2] * (L[6] * m[0] + L[7] * m[1] + L[8] * m[2]);
        }
    }
}

bool CondensedTissue::find_forces() noexcept
{
    const std::size_t points = fingers_.back().last_point;
    if (options_.fingertip != FingertipShape::held)
        return solver_.solve(points);
    for (std::size_t a = 0; a < points; ++a)
        solver_.pressing(a) = 1;
    for (bool pulls = true; pulls;) {
        if (!solver_.hold(points))
            return false;
        pulls = false;
        for (const Finger& finger : fingers_) {
            double sum = 0.0;
            for (std::size_t a = finger.first_point; a < finger.last_point; ++a)
                sum += solver_.force(a);
            if (sum >= 0.0)
                continue;
            pulls = true; // the finger pulls as a whole, so the finger loses contact
            for (std::size_t a = finger.first_point; a < finger.last_point; ++a)
                solver_.pressing(a) = 0;
        }
    }
    return true;
}

/// Index of the contact point among the first `points` that presses this contact node; `points` when there is none.
std::size_t CondensedTissue::point_at(std::int32_t contact_node, std::size_t points) const noexcept
{
    for (std::size_t p = 0; p < points; ++p)
        if (resident_[static_cast<std::size_t>(point_place_[p])] == contact_node)
            return p;
    return points;
}

bool CondensedTissue::solve_contact(Body& body, double pressure, std::span<const Fingertip> fingers) noexcept
{
    const ContactNodeCompliance& compliance = *body.compliance;
    std::size_t points = 0;
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        Finger& finger = fingers_[f];
        finger.place = body.searches[f].find(fingers[f], compliance, pressure);
        finger.count = 0;
        finger.missing = 0;
        finger.first_point = points;
        if (finger.place.touching)
            finger.count = body.searches[f].candidates(fingers[f], finger.place, compliance, pressure,
                finger.candidates, options_.patch_limit, finger.missing);
        for (std::size_t c = 0; c < finger.count; ++c) {
            const Candidate& candidate = finger.candidates[c];
            if (const std::size_t taken = point_at(candidate.contact_node, finger.first_point);
                taken < finger.first_point) {
                solver_.demand(taken) = std::max(solver_.demand(taken), candidate.demand);
                continue; // two fingers press one contact node: it belongs to the first finger
            }
            const std::int32_t place = make_resident(f, candidate.contact_node, points, compliance);
            if (place < 0) {
                ++finger.missing;
                continue;
            }
            point_place_[points] = place;
            point_finger_[points] = f;
            solver_.demand(points) = candidate.demand;
            solver_.pressing(points) = finger.pressed(candidate.contact_node);
            ++points;
        }
        finger.last_point = points;
    }
    fill_compliance();
    if (!find_forces())
        return false;
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        Finger& finger = fingers_[f];
        double sum = 0.0;
        finger.pressing_count = 0;
        for (std::size_t a = finger.first_point; a < finger.last_point; ++a) {
            sum += solver_.force(a);
            if (solver_.pressing(a) != 0)
                finger.pressing[finger.pressing_count++] = resident_[static_cast<std::size_t>(point_place_[a])];
        }
        finger.stiffness = solver_.stiffness(finger.first_point, finger.last_point);
        finger.fallback_stiffness = false;
        if (finger.place.touching && finger.missing > 0) {
            const std::int32_t contact_node = body.touch->contact_node_of(finger.place.vertex);
            const double stiffness = compliance.fallback_stiffness(std::max(contact_node, 0)) * fingers[f].radius
                / ContactNodeCompliance::kFallbackRadius;
            if (finger.place.depth * stiffness > sum) {
                finger.fallback_stiffness = true;
                finger.stiffness = stiffness;
                sum = finger.place.depth * stiffness;
            }
        }
        finger.raw = sum * finger.place.normal;
    }
    return true;
}

void CondensedTissue::tick(
    double time_s, double, std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept
{
    gate_.enter();
    const double p = pressure(beat_.at(time_s));
    Body* const newest = published_.load(std::memory_order_acquire);
    const bool swapped = current_ != nullptr && newest != current_;
    bool solved = true;
    if (swapped) {
        solved = solve_contact(*current_, p, fingers);
        for (Finger& finger : fingers_)
            finger.raw_before = finger.raw;
        forget_residents();
        for (std::size_t f = 0; f < fingers_.size(); ++f) {
            newest->searches[f].go_on_from(current_->searches[f]);
            fingers_[f].pressing_count = newest->touch == current_->touch ? fingers_[f].pressing_count : 0;
        }
    }
    current_ = newest;
    solved = solve_contact(*current_, p, fingers) && solved;
    bool late = false;
    for (Finger& finger : fingers_) {
        const bool columns_came
            = finger.missing < finger.missing_before || finger.fallback_stiffness != finger.fallback_before;
        if (!finger.place.touching)
            finger.offset.setZero();
        else if (swapped || (columns_came && !finger.raw_before.isZero(0.0)))
            finger.offset += finger.raw_before - finger.raw;
        const double left = finger.offset.norm();
        finger.offset *= left > options_.blend ? (left - options_.blend) / left : 0.0;
        finger.raw_before = finger.raw;
        finger.missing_before = finger.missing;
        finger.fallback_before = finger.fallback_stiffness;
        late = late || finger.missing > 0;
    }
    ++ticks_;
    late_ticks_ += late ? 1 : 0;
    if (solved)
        report(fingers, contacts);
    else
        for (FingerContact& contact : contacts) {
            contact = {};
            contact.force.setConstant(std::numeric_limits<double>::quiet_NaN());
        }
    publish(time_s, p, fingers);
    in_use_.store(current_, std::memory_order_release);
    gate_.leave();
}

void CondensedTissue::report(std::span<const Fingertip> fingers, std::span<FingerContact> contacts) noexcept
{
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        const Finger& finger = fingers_[f];
        FingerContact& contact = contacts[f];
        contact = {};
        contact.proxy = fingers[f].position;
        contact.touching = finger.place.touching;
        if (!contact.touching)
            continue;
        Vec3 force = finger.raw + finger.offset;
        // The blended offset might make the force pull.
        force -= std::min(0.0, force.dot(finger.place.normal)) * finger.place.normal;
        contact.force = options_.force_gain * force;
        contact.normal = finger.place.normal;
        contact.depth = finger.place.depth;
        contact.proxy += finger.place.depth * finger.place.normal;
        contact.stiffness = options_.force_gain * finger.stiffness;
    }
}

void CondensedTissue::publish(double time, double pressure, std::span<const Fingertip> fingers) noexcept
{
    Snapshot& s = snapshots_.draft();
    s.body = current_;
    s.time = time;
    s.pressure = pressure;
    s.forces = 0;
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        s.fingers[f] = fingers[f];
        const Finger& finger = fingers_[f];
        for (std::size_t a = finger.first_point; a < finger.last_point; ++a)
            if (const std::int32_t contact_node = resident_[static_cast<std::size_t>(point_place_[a])];
                contact_node >= 0 && solver_.force(a) != 0.0) {
                s.force[s.forces] = { contact_node, -solver_.force(a) * finger.place.normal };
                s.normal[s.forces] = finger.place.normal;
                s.demand[s.forces++] = solver_.demand(a);
            }
    }
    snapshots_.publish();
}

// ---- Simulation thread ----

/// Contact nodes under the fingers, or under their positions within `ahead_s`, nearest first.
static std::vector<std::int32_t> wanted_by(
    std::span<const Fingertip> fingers, double ahead_s, double margin, const TouchSurface& touch)
{
    std::vector<std::pair<double, std::int32_t>> order;
    for (const Fingertip& finger : fingers) {
        const Vec3 way = ahead_s * finger.velocity;
        const double length2 = way.squaredNorm();
        for (std::size_t s = 0; s < touch.contact_nodes().size(); ++s) {
            const Vec3 from = touch.contact_nodes()[s].point - finger.position;
            const double along = length2 > 0.0 ? std::clamp(from.dot(way) / length2, 0.0, 1.0) : 0.0;
            const double d = (from - along * way).norm() + 0.1 * along * std::sqrt(length2);
            if (d < 2.0 * finger.radius + margin)
                order.emplace_back(d, static_cast<std::int32_t>(s));
        }
    }
    std::sort(order.begin(), order.end());
    std::vector<std::int32_t> wanted;
    for (const auto& [d, s] : order)
        if (std::find(wanted.begin(), wanted.end(), s) == wanted.end())
            wanted.push_back(s);
    return wanted;
}

void CondensedTissue::prepare(std::span<const Fingertip> fingers)
{
    ContactNodeCompliance& compliance = *body_->compliance;
    compliance.fetch(wanted_by(fingers, 0.0, 0.0, *body_->touch), std::numeric_limits<std::size_t>::max(), gate_);
    compliance.finish_columns(compliance.columns_missing());
}

std::size_t CondensedTissue::edit(const ElasticTemplate& edit)
{
    const std::size_t changed = apply(edit, model_);
    if (changed > 0)
        waiting_edits_.push_back(edit);
    return changed;
}

std::vector<ElasticTemplate> CondensedTissue::edits() const
{
    std::vector<ElasticTemplate> all = felt_edits_;
    all.insert(all.end(), building_edits_.begin(), building_edits_.end());
    all.insert(all.end(), waiting_edits_.begin(), waiting_edits_.end());
    return all;
}

void CondensedTissue::wait_for_edit() const
{
    if (building_.valid())
        building_.wait();
}

void CondensedTissue::swap_in()
{
    if (retired_ != nullptr && in_use_.load(std::memory_order_acquire) != retired_.get())
        retired_.reset();
    const Snapshot& s = snapshots_.latest();
    if (building_.valid() && building_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
        if (std::unique_ptr<Body> fresh = built_body())
            publish_body(std::move(fresh), s.fingers);
    if (!waiting_edits_.empty() && !building_.valid() && retired_ == nullptr)
        start_build();
}

void CondensedTissue::start_build()
{
    datasets::ElasticModel model = model_;
    const auto first = waiting_edits_.begin();
    auto last = waiting_edits_.end();
    if (built_alone_ > 0) {
        --built_alone_;
        last = first + 1;
        model = body_->model;
        apply(*first, model);
    }
    building_edits_.assign(first, last);
    waiting_edits_.erase(first, last);
    building_ = std::async(std::launch::async,
        [this, model = std::move(model), touch = body_->touch, roles = body_->model.roles]() mutable {
            return build(std::move(model), touch, roles, {});
        });
}

/// @return null when the edits gave no valid body together, and the next builds try them one at a time
std::unique_ptr<CondensedTissue::Body> CondensedTissue::built_body()
{
    try {
        std::unique_ptr<Body> fresh = building_.get();
        felt_edits_.insert(felt_edits_.end(), building_edits_.begin(), building_edits_.end());
        building_edits_.clear();
        return fresh;
    } catch (...) {
        if (building_edits_.size() == 1) {
            take_back_build();
            throw;
        }
        built_alone_ += building_edits_.size();
        waiting_edits_.insert(waiting_edits_.begin(), building_edits_.begin(), building_edits_.end());
        building_edits_.clear();
        return nullptr;
    }
}

/// Sets the model to the last valid body with the later edits that still apply.
void CondensedTissue::take_back_build()
{
    building_edits_.clear();
    model_ = body_->model;
    const auto cannot_be = [this](const ElasticTemplate& edit) {
        try {
            return apply(edit, model_) == 0;
        } catch (const InputError&) { // the edit depends on the edit that was taken back
            return true;
        }
    };
    std::vector<ElasticTemplate> stay;
    std::size_t alone = 0;
    for (std::size_t i = 0; i < waiting_edits_.size(); ++i)
        if (!cannot_be(waiting_edits_[i])) {
            stay.push_back(waiting_edits_[i]);
            alone += i < built_alone_ ? 1 : 0;
        }
    waiting_edits_ = std::move(stay);
    built_alone_ = alone;
}

void CondensedTissue::publish_body(std::unique_ptr<Body> fresh, std::span<const Fingertip> fingers)
{
    const ServoGate nobody; // no servo knows the new body yet
    fresh->compliance->fetch(
        wanted_by(fingers, 0.0, 0.0, *fresh->touch), 4 * options_.patch_limit * options_.fingers, nobody);
    published_.store(fresh.get(), std::memory_order_seq_cst);
    gate_.wait_for_tick_end();
    retired_ = std::move(body_);
    body_ = std::move(fresh);
}

void CondensedTissue::follow(Points& deformed)
{
    swap_in();
    const Snapshot& s = snapshots_.latest();
    const std::size_t contact_nodes = body_->touch->contact_nodes().size();
    ContactNodeCompliance& compliance = *body_->compliance;
    std::size_t fetched = 0;
    if (compliance.ready_count() < contact_nodes) {
        fetched = compliance.fetch(
            wanted_by(s.fingers, kAhead, kMargin, *body_->touch), options_.fetches_per_follow, gate_);
        if (compliance.holds_all() && fetched == 0 && compliance.columns_missing() == 0) {
            std::vector<std::int32_t> all(contact_nodes);
            std::iota(all.begin(), all.end(), 0);
            fetched = compliance.fetch(all, ContactNodeCompliance::kBatch, gate_);
        }
    }
    // When more batches wait than allowed, as many are finished as arrived, and one more.
    const std::size_t came = (fetched + ContactNodeCompliance::kBatch - 1) / ContactNodeCompliance::kBatch;
    compliance.finish_columns(compliance.columns_missing() > ContactNodeCompliance::kMostWaiting ? came + 1 : 1);
    deformed = shown_.vertices;
    // Until the servo has used a new body, the forces refer to contact nodes of the old body.
    const Body& pressed = retired_ != nullptr && s.body == retired_.get() ? *retired_ : *body_;
    pressed.compliance->add_displacement(s.pressure, { s.force.data(), s.forces }, deformed);
}

CondensedTissue::Pressed CondensedTissue::last_pressed()
{
    const Snapshot& s = snapshots_.latest();
    const auto count = static_cast<std::ptrdiff_t>(s.forces);
    return { s.time, s.pressure, { s.force.begin(), s.force.begin() + count },
        { s.normal.begin(), s.normal.begin() + count }, { s.demand.begin(), s.demand.begin() + count }, s.fingers };
}

} // namespace retractor::haptics
