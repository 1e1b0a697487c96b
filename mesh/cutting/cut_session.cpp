#include "mesh/cutting/cut_session.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "mesh/cutting/cut_ablation.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/stroke/cut_moves.h"
#include "mesh/cutting/stroke/cut_retry.h"
#include "mesh/cutting/stroke/cut_stroke.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>
#include <unordered_map>
#include <utility>

namespace retractor::mesh {

namespace {

    TetMesh checked(TetMesh mesh)
    {
        check_mesh(mesh);
        if (mesh.nodes_per_tet != 4)
            throw InputError("only four-node elements can be cut; add midpoints after cutting", "nodes_per_tet");
        return mesh;
    }

    /// Refuses added elements that no later stage could use.
    void check_born(const CutStore& store, const MeshDelta& delta)
    {
        for (const MeshDelta::Tet& tet : delta.tets_born)
            if (!(store.volume(tet.id) > 0.0))
                throw CutQualityError(CutQualityError::Kind::shape, "the cut would leave an element without volume",
                    "element " + std::to_string(tet.id));
    }

    double as_angle(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi; }

    /// Fills in the counts and the quality of added elements. The function works with cosines and turns only the worst
    /// cosines into angles.
    /// @return per added element the cosine of its smallest angle
    std::vector<double> measure_born(const CutStore& store, const MeshDelta& delta, CutReport& report)
    {
        std::vector<double> cosines, largest;
        cosines.reserve(6 * delta.tets_born.size());
        largest.reserve(delta.tets_born.size());
        double total = 0.0, smallest = std::numeric_limits<double>::infinity();
        for (const MeshDelta::Tet& tet : delta.tets_born) {
            const auto p = corners_of(store, tet.nodes);
            const double volume = tet_volume(p[0], p[1], p[2], p[3]);
            total += volume;
            smallest = std::min(smallest, volume);
            const std::array<double, 6> own = dihedral_cosines(p);
            cosines.insert(cosines.end(), own.begin(), own.end());
            largest.push_back(*std::max_element(own.begin(), own.end()));
        }
        report.tets_created = delta.tets_born.size();
        report.tets_removed = delta.tets_gone.size();
        if (cosines.empty())
            return largest;
        report.p01_dihedral_deg = as_angle(value_of_rank(cosines, cosines.size() / 100, std::greater<> {}));
        report.worst_dihedral_deg = as_angle(*std::max_element(largest.begin(), largest.end()));
        if (report.tets_removed > 0
            && report.removed_volume_mm3
                == 0.0) // elements born and gone fill the same tissue, except for moved surfaces
            report.smallest_volume_ratio = smallest / (total / static_cast<double>(report.tets_removed));
        return largest;
    }

    /// Fills in the quality of the replaced elements, and the number of added elements that are much worse.
    /// @param born per added element the cosine of its smallest angle
    void compare_with_gone(
        const CutStore& store, const CutRecord& record, const std::vector<double>& born, CutReport& report)
    {
        RETRACTOR_ASSERT(born.size() == record.delta.tets_born.size());
        std::unordered_map<VertexId, Vec3> moved; // first position of each moved vertex; never iterated
        for (const auto& change : record.delta.vertices_moved)
            moved.try_emplace(change.id, change.from);
        std::unordered_map<TetId, double>
            parent; // cosine of the smallest angle per element of the first mesh; never iterated
        double worst = -1.0;
        for (const MeshDelta::Tet& tet : record.delta.tets_gone) {
            std::array<Vec3, 4> p;
            for (std::size_t i = 0; i < 4; ++i) {
                const auto it = moved.find(tet.nodes[i]);
                p[i] = it != moved.end() ? it->second : store.position(tet.nodes[i]);
            }
            const double cosine = smallest_dihedral_cosine(p);
            worst = std::max(worst, cosine);
            double& own = parent.try_emplace(tet.origin, cosine).first->second;
            own = std::max(own, cosine);
        }
        report.worst_dihedral_before_deg = record.delta.tets_gone.empty() ? 180.0 : as_angle(worst);
        report.tets_below_half_parent = 0;
        const double flat = std::cos(CutOptions {}.improve_below_deg * std::numbers::pi / 180.0);
        for (std::size_t i = 0; i < born.size(); ++i)
            if (born[i] > flat)
                if (const auto it = parent.find(record.delta.tets_born[i].origin);
                    it != parent.end() && as_angle(born[i]) < 0.5 * as_angle(it->second))
                    ++report.tets_below_half_parent;
    }

    /// Quality below which the user gets a remark (degrees): the smallest dihedral angle, and the 1st percentile of the
    /// dihedral angles of added elements.
    constexpr double kLeastDihedralDeg = 5.0, kLeastP01Deg = 8.0;

    /// A remark for the user about a finished cut; empty when the quality is good.
    std::string remark(const CutReport& report)
    {
        const std::string again = report.attempts > 1
            ? "made at attempt " + std::to_string(report.attempts) + " with less snapping, or more bends followed"
            : std::string {};
        const bool flat = report.worst_dihedral_deg < kLeastDihedralDeg || report.p01_dihedral_deg < kLeastP01Deg;
        if (report.tets_below_half_parent == 0 && !flat)
            return again;
        std::ostringstream text;
        text.precision(3);
        text << again << (again.empty() ? "" : "; ");
        if (report.tets_below_half_parent > 0)
            text << report.tets_below_half_parent << " of " << report.tets_created
                 << " new elements are flatter than half the elements they are made of ";
        else
            text << "new elements are flatter than a cut should leave them ";
        text << "(the flattest angle is " << report.worst_dihedral_deg << " degrees, the 1st percentile "
             << report.p01_dihedral_deg << ", asked are " << kLeastDihedralDeg << " and " << kLeastP01Deg
             << "): the blade grazes them, or an earlier wound holds them";
        return text.str();
    }

    /// Adds the report of a step: counts are summed, extremes kept. Values that depend on the finished record are
    /// computed later.
    void add_step(CutReport& sum, const CutReport& step)
    {
        if (sum.tets_crossed == 0 && sum.tets_before == 0)
            sum.tets_before = step.tets_before;
        sum.tets_crossed += step.tets_crossed;
        sum.tets_after = step.tets_after;
        sum.vertices_moved += step.vertices_moved;
        sum.vertices_merged += step.vertices_merged;
        sum.largest_move_mm = std::max(sum.largest_move_mm, step.largest_move_mm);
        sum.surface_deviation = std::max(sum.surface_deviation, step.surface_deviation);
        sum.lip_area_mm2 += step.lip_area_mm2;
        sum.lip_to_blade = std::max(sum.lip_to_blade, step.lip_to_blade);
        sum.attempts = std::max(sum.attempts, step.attempts);
        sum.seconds += step.seconds;
    }

    void must_have_tet(const CutStore& store, TetId tet)
    {
        if (!store.has_tet(tet))
            throw InputError("there is no such element", "element " + std::to_string(tet));
    }

    void must_have_vertex(const CutStore& store, VertexId vertex)
    {
        if (!store.has_vertex(vertex))
            throw InputError("there is no such vertex", "vertex " + std::to_string(vertex));
    }

} // namespace

/// An open freehand stroke.
struct OpenStroke {
    Blade blade;
    CutOptions options;
    StrokeRest rest; ///< state after the last step
    std::vector<CutRecord> steps;
    CutReport report;
};

struct CutSession::State {
    explicit State(const TetMesh& mesh)
        : store(mesh)
    {
    }

    void must_be_closed() const
    {
        if (stroke)
            throw InputError("a freehand stroke is open: finish or abandon it first");
    }

    /// Performs one operation on the store: `work` runs between begin() and finish(), and `record` receives the record.
    /// After any failure, a failure of the witness included, the store is unchanged.
    template <class Work> CutResult step(CutEvent event, CutRecord& record, Work&& work)
    {
        const Stopwatch watch;
        CutResult result = attempt(record, work);
        if (result.status == CutStatus::done) {
            try {
                compare_with_gone(store, record, measure_born(store, record.delta, result.report), result.report);
                result.message = remark(result.report);
                event.delta = &record.delta;
                tell(event);
            } catch (...) {
                store.undo(record);
                throw;
            }
            result.delta = record.delta;
        }
        result.report.seconds = watch.seconds();
        return result;
    }

    /// Calls begin(), `work` and finish(). The store is unchanged unless the result is `done`.
    template <class Work> CutResult attempt(CutRecord& record, Work&& work)
    {
        store.begin();
        bool finished = false;
        try {
            CutResult result = work();
            if (result.status == CutStatus::done) {
                record = store.finish();
                finished = true;
                check_born(store, record.delta);
            } else {
                store.rollback();
            }
            return result;
        } catch (...) {
            if (finished)
                store.undo(record);
            else
                store.rollback();
            throw;
        }
    }

    /// step() for a stroke, which is repeated with other settings when an attempt breaks a guarantee.
    CutResult stroke_step(const CutEvent& event, CutRecord& record, const SweptBlade& blade, const CutOptions& options,
        StrokeStep part, const Job& job, StrokeRest* rest = nullptr)
    {
        const Stopwatch watch;
        for (;;)
            try {
                CutResult result = step(event, record, [&] {
                    CutResult cut = cut_stroke(store, blade, options, static_cast<int>(done), job, part, rest);
                    cut.report.attempts = part.settings.attempt;
                    return cut;
                });
                result.report.seconds = watch.seconds();
                return result;
            } catch (const CutQualityError& broken) {
                if (part.settings.attempt == kMostAttempts || broken.kind() == CutQualityError::Kind::growth)
                    throw final_error(broken, part.settings.attempt);
                part.settings = settings_of_retry(part.settings, broken.kind());
            }
    }

    void tell(const CutEvent& event) const
    {
        if (witness)
            witness(event);
    }

    void keep(CutRecord record)
    {
        RETRACTOR_ASSERT(done <= journal.size());
        journal.resize(done);
        journal.push_back(std::move(record));
        ++done;
    }

    CutRecord merged(std::vector<CutRecord> steps) const
    {
        RETRACTOR_ASSERT(!steps.empty());
        while (steps.size() > 1) { // merges pairs, so that a record is copied at most log2(number of records) times
            std::vector<CutRecord> half;
            for (std::size_t i = 0; i < steps.size(); i += 2)
                half.push_back(i + 1 < steps.size() ? store.merged(steps[i], steps[i + 1]) : std::move(steps[i]));
            steps = std::move(half);
        }
        return std::move(steps.front());
    }

    CutStore store;
    std::vector<CutRecord> journal;
    std::size_t done = 0; ///< records of the journal that are not undone; the rest can be redone
    std::optional<OpenStroke> stroke;
    CutWitness witness;
};

CutSession::CutSession(TetMesh mesh)
    : state_(std::make_unique<State>(checked(std::move(mesh))))
{
}
CutSession::~CutSession() = default;
CutSession::CutSession(CutSession&&) noexcept = default;
CutSession& CutSession::operator=(CutSession&&) noexcept = default;

CutResult CutSession::cut(const Blade& blade, const CutOptions& options, const Job& job)
{
    State& s = *state_;
    s.must_be_closed();
    const SweptBlade swept(blade);
    CutRecord record;
    CutResult result = s.stroke_step(
        { .kind = CutEvent::Kind::cut, .blade = &blade, .options = &options }, record, swept, options, {}, job);
    if (result.status == CutStatus::done)
        s.keep(std::move(record));
    return result;
}

CutResult CutSession::extend_stroke(const Blade& so_far, const CutOptions& options, const Job& job)
{
    State& s = *state_;
    const SweptBlade swept(so_far);
    const StrokeRest former = s.stroke ? s.stroke->rest : StrokeRest {};
    const StrokeStep part {
        .from_along = former.resume_along, .resolve_end = false, .goes_on = true, .drift = &former.drift
    };
    StrokeRest rest;
    CutRecord record;
    const CutEvent event { .kind = CutEvent::Kind::stroke_step, .blade = &so_far, .options = &options };
    CutResult result = s.stroke_step(event, record, swept, options, part, job, &rest);
    if (result.status == CutStatus::cancelled)
        return result;
    const bool nothing_yet = result.status == CutStatus::missed_body; // no element is crossed completely
    if (nothing_yet) {
        CutEvent told = event;
        told.delta = &result.delta;
        s.tell(told);
        result.status = CutStatus::done;
    }
    if (!s.stroke)
        s.stroke.emplace();
    s.stroke->blade = so_far;
    s.stroke->options = options;
    if (!nothing_yet) {
        s.stroke->rest = std::move(rest);
        s.stroke->steps.push_back(std::move(record));
        add_step(s.stroke->report, result.report);
    }
    return result;
}

CutResult CutSession::finish_stroke(const Job& job)
{
    State& s = *state_;
    if (!s.stroke)
        throw InputError("there is no stroke to finish");
    OpenStroke& stroke = *s.stroke;
    const SweptBlade swept(stroke.blade);
    const StrokeStep part {
        .from_along = stroke.rest.resume_along, .resolve_end = true, .goes_on = true, .drift = &stroke.rest.drift
    };
    CutRecord record;
    const CutEvent event { .kind = CutEvent::Kind::stroke_end };
    CutResult result = s.stroke_step(event, record, swept, stroke.options, part, job);
    if (result.status == CutStatus::cancelled)
        return result;
    if (result.status == CutStatus::done) {
        stroke.steps.push_back(std::move(record));
        add_step(stroke.report, result.report);
    } else {
        CutEvent told = event;
        told.delta = &result.delta;
        s.tell(told);
    }
    if (!stroke.steps.empty()) {
        result.status = CutStatus::done;
        CutRecord whole = s.merged(std::move(stroke.steps));
        compare_with_gone(s.store, whole, measure_born(s.store, whole.delta, stroke.report), stroke.report);
        result.report = stroke.report;
        result.message = remark(result.report);
        s.keep(std::move(whole));
    }
    s.stroke.reset();
    return result;
}

MeshDelta CutSession::abandon_stroke()
{
    State& s = *state_;
    if (!s.stroke)
        throw InputError("there is no stroke to abandon");
    std::vector<CutRecord>& steps = s.stroke->steps;
    std::optional<CutRecord> whole;
    MeshDelta back;
    if (!steps.empty()) {
        whole = s.merged(steps);
        back = inverse(whole->delta);
    }
    s.tell({ .kind = CutEvent::Kind::stroke_abandoned, .delta = &back });
    if (whole)
        s.store.undo(*whole);
    s.stroke.reset();
    return back;
}

CutResult CutSession::ablate(std::span<const TetId> tets, const Job& job)
{
    State& s = *state_;
    s.must_be_closed();
    const std::vector<TetId> marked = checked_marks(s.store, tets);
    CutRecord record;
    CutResult result = s.step({ .kind = CutEvent::Kind::ablation, .tets = marked }, record,
        [&] { return ablate_elements(s.store, marked, static_cast<int>(s.done), job); });
    if (result.status == CutStatus::done)
        s.keep(std::move(record));
    return result;
}

bool CutSession::stroke_open() const { return state_->stroke.has_value(); }

bool CutSession::can_undo() const { return state_->done > 0; }
bool CutSession::can_redo() const { return state_->done < state_->journal.size(); }

MeshDelta CutSession::undo()
{
    state_->must_be_closed();
    if (!can_undo())
        throw InputError("there is no cut to undo");
    const CutRecord& record = state_->journal[state_->done - 1];
    MeshDelta back = inverse(record.delta);
    state_->tell({ .kind = CutEvent::Kind::undo, .delta = &back });
    state_->store.undo(record);
    --state_->done;
    return back;
}

MeshDelta CutSession::redo()
{
    state_->must_be_closed();
    if (!can_redo())
        throw InputError("there is no cut to redo");
    const CutRecord& record = state_->journal[state_->done];
    state_->tell({ .kind = CutEvent::Kind::redo, .delta = &record.delta });
    state_->store.redo(record);
    ++state_->done;
    return record.delta;
}

std::size_t CutSession::tet_count() const { return state_->store.counts().tets; }
std::size_t CutSession::vertex_count() const { return state_->store.counts().vertices; }
std::size_t CutSession::cut_count() const { return state_->done; }

bool CutSession::has_tet(TetId tet) const { return state_->store.has_tet(tet); }
bool CutSession::has_vertex(VertexId vertex) const { return state_->store.has_vertex(vertex); }
std::size_t CutSession::tet_slots() const { return state_->store.counts().tet_slots; }
std::size_t CutSession::vertex_slots() const { return state_->store.counts().vertex_slots; }

MeshDelta::Tet CutSession::tet(TetId tet) const
{
    must_have_tet(state_->store, tet);
    const TetSlot& slot = state_->store.tet(tet);
    return { tet, slot.nodes, slot.label, slot.origin };
}

Vec3 CutSession::position(VertexId vertex) const
{
    must_have_vertex(state_->store, vertex);
    return state_->store.position(vertex);
}

std::vector<TetId> CutSession::tets_at(VertexId vertex) const
{
    must_have_vertex(state_->store, vertex);
    return state_->store.star(vertex);
}

void CutSession::set_witness(CutWitness witness) { state_->witness = std::move(witness); }

SessionBytes CutSession::bytes() const
{
    SessionBytes sum { state_->store.bytes(), state_->journal.capacity() * sizeof(CutRecord) };
    const auto add = [&](const CutRecord& record) { sum.journal += record.bytes() - sizeof(record); };
    for (const CutRecord& record : state_->journal)
        add(record);
    if (state_->stroke)
        for (const CutRecord& record : state_->stroke->steps)
            add(record);
    return sum;
}

std::vector<LipFace> CutSession::lips() const
{
    std::vector<LipFace> faces;
    for (TetId t = 0; t < static_cast<TetId>(state_->store.counts().tet_slots); ++t) {
        const TetSlot& tet = state_->store.tet(t);
        if (!tet.alive)
            continue;
        for (int corner = 0; corner < 4; ++corner)
            if (const LipTag tag = tet.lips[static_cast<std::size_t>(corner)]; tag.cut >= 0)
                faces.push_back({ { t, corner }, tag.side, tag.cut });
    }
    return faces;
}

TetId CutSession::origin(TetId tet) const
{
    must_have_tet(state_->store, tet);
    return state_->store.tet(tet).origin;
}

TetMesh CutSession::compact_mesh(SlotMap* map) const
{
    const CutStore& store = state_->store;
    SlotMap slots;
    slots.compact_vertex.assign(store.counts().vertex_slots, -1);
    slots.compact_tet.assign(store.counts().tet_slots, -1);
    TetMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(vertex_count()), 3);
    for (VertexId v = 0; v < static_cast<VertexId>(store.counts().vertex_slots); ++v) {
        if (!store.vertex(v).alive)
            continue;
        const auto compact = static_cast<VertexId>(slots.vertex_slot.size());
        slots.compact_vertex[static_cast<std::size_t>(v)] = compact;
        slots.vertex_slot.push_back(v);
        mesh.vertices.row(compact) = store.position(v).transpose();
    }
    for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t) {
        const TetSlot& tet = store.tet(t);
        if (!tet.alive)
            continue;
        slots.compact_tet[static_cast<std::size_t>(t)] = static_cast<TetId>(slots.tet_slot.size());
        slots.tet_slot.push_back(t);
        for (const VertexId v : tet.nodes)
            mesh.nodes.push_back(slots.compact_vertex[static_cast<std::size_t>(v)]);
        mesh.labels.push_back(tet.label);
    }
    RETRACTOR_ASSERT(slots.vertex_slot.size() == vertex_count() && mesh.labels.size() == tet_count());
    RETRACTOR_ASSERT(std::none_of(mesh.nodes.begin(), mesh.nodes.end(), [](VertexId v) { return v < 0; }));
    if (map != nullptr)
        *map = std::move(slots);
    return mesh;
}

} // namespace retractor::mesh
