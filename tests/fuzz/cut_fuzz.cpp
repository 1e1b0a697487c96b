#include "tests/fuzz/cut_fuzz.h"

#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "tests/fuzz/cut_strokes.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

namespace retractor::fuzz {

namespace {

    constexpr double kFlat = 5.0; // degrees
    constexpr double kSlow = 1.0; // seconds
    constexpr int kLate = 4; // attempts

    class Runner {
    public:
        Runner(const Body& body, std::uint64_t seed)
            : body_(body)
            , random_(seed * 0x9e3779b97f4a7c15ULL + 1)
            , session_(body.mesh)
            , now_(std::make_unique<State>(session_))
            , mirror_(*now_)
        {
            options_.snap = kSnaps[seed % kSnaps.size()];
            if (random_() % 12 == 0)
                options_.uncut_labels = { 2 };
            ablates_ = seed / kSnaps.size() % 6 == 5;
        }

        SeedResult run()
        {
            const State first = *now_;
            Findings findings;
            topology_ = check_sound(first, findings);
            report(findings);
            for (int i = 0; i < kStrokesPerSeed; ++i) {
                const RandomStroke stroke = random_stroke(body_, session_, *now_, last_, random_);
                name_ = "stroke " + std::to_string(i) + " (" + stroke.kind + ")";
                ++result_.tally.strokes;
                last_blade_ = {};
                const State before = *now_;
                topology_before_ = topology_;
                copies_.clear();
                try {
                    if (stroke.freehand)
                        freehand(stroke.blade, before);
                    else
                        single(stroke.blade, before);
                } catch (const Error& error) {
                    if (!is_named_refusal(error))
                        report({ { "only named refusals", error.what() } });
                    refuse(error, before);
                } catch (const std::exception& error) {
                    report({ { "exception", error.what() } });
                    refuse(SolverError(error.what()), before);
                }
                last_ = stroke;
                if (ablates_ && random_() % 2 == 0)
                    ablate();
                if (random_() % 4 == 0)
                    back_and_forth();
            }
            all_back(first);
            return std::move(result_);
        }

        const State& state() const { return *now_; }

    private:
        void report(const Findings& findings)
        {
            std::set<std::string> counted;
            for (const Finding& finding : findings) {
                if (counted.insert(finding.invariant).second)
                    ++result_.tally.broken[finding.invariant];
                std::ostringstream text;
                text << name_ << ", snap " << options_.snap << ": " << finding.invariant << ": " << finding.detail;
                if (!last_blade_.line.empty()) {
                    const mesh::SweptBlade swept(last_blade_);
                    text << " (blade " << swept.length() / body_.edge << " long, " << swept.depth() / body_.edge
                         << " deep, in edges, from " << last_blade_.line.front().transpose() << " to "
                         << last_blade_.line.back().transpose() << ", above " << last_blade_.above_mm << ")";
                }
                result_.failures.push_back(text.str());
            }
        }

        /// A cut, or a step of one, refused or not, with the clock running.
        template <class Cut> mesh::CutResult timed(Cut&& cut)
        {
            const std::clock_t start = std::clock(); // whatever else the machine does
            const auto note = [&](const std::string& how, bool late) {
                const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
                result_.tally.slowest = std::max(result_.tally.slowest, seconds);
                if (seconds < kSlow && !late)
                    return;
                std::ostringstream text;
                text.precision(3);
                text << name_ << ", snap " << options_.snap << ": " << seconds << " s, " << how;
                result_.slow.push_back(text.str());
            };
            try {
                mesh::CutResult result = cut();
                const mesh::CutReport& r = result.report;
                note(std::to_string(r.attempts) + " attempts, " + std::to_string(r.tets_crossed) + " crossed, "
                        + std::to_string(r.tets_created) + " made",
                    r.attempts >= kLate);
                return result;
            } catch (const std::exception& error) {
                note(error.what(), true);
                throw;
            }
        }

        void refuse(const Error& error, const State& before)
        {
            // What differs from stroke to stroke is no reason of its own.
            std::string reason = error.what();
            std::erase_if(reason, [](char c) { return std::string_view("0123456789.").find(c) != std::string::npos; });
            ++result_.tally.refused[reason];
            result_.refusals.push_back(name_ + ": " + error.what() + " (" + error.where() + ")");
            if (session_.stroke_open()) { // a stroke that cannot be finished
                const mesh::MeshDelta back = session_.abandon_stroke();
                Findings findings;
                follow_back_to(before, back, "abandoned stroke", findings);
                report(findings);
            }
            now_ = std::make_unique<State>(session_);
            topology_ = topology_before_; // steps of a freehand stroke that was given up later have been looked at
            if (!same_bits(*now_, before))
                report({ { "refusal leaves no trace", error.what() } });
        }

        /// The state after a change that came with this delta; the delta and the state are checked.
        void follow(const mesh::MeshDelta& delta, Findings& findings)
        {
            now_ = std::make_unique<State>(session_);
            mirror_.follow(delta, findings);
            mirror_.compare(*now_, findings);
            topology_ = check_sound(*now_, findings);
            for (const auto& born : delta.vertices_born)
                if (born.origin == mesh::MeshDelta::Origin::copy)
                    copies_[born.id] = born.a;
        }

        /// Of a vertex by its session id; NaN when it is gone.
        Vec3 position(VertexId v) const
        {
            const VertexId own = now_->map.compact_vertex[static_cast<std::size_t>(v)];
            return own < 0 ? Vec3(Vec3::Constant(std::nan(""))) : Vec3(now_->mesh.vertices.row(own));
        }

        /// The same where the state must be one that has been checked.
        void follow_back_to(const State& there, const mesh::MeshDelta& delta, const char* what, Findings& findings)
        {
            now_ = std::make_unique<State>(session_);
            mirror_.follow(delta, findings);
            mirror_.compare(*now_, findings);
            if (!same_bits(*now_, there))
                findings.push_back({ "undo is exact", what });
        }

        void finish(const mesh::CutResult& result, const mesh::Blade& blade, const State& before, Findings& findings)
        {
            Tally& tally = result_.tally;
            if (result.status != mesh::CutStatus::done) {
                ++tally.missed;
                if (!same_bits(*now_, before))
                    findings.push_back({ "refusal leaves no trace", result.message });
                report(findings);
                return;
            }
            ++tally.done;
            ++tally.attempts[result.report.attempts];
            last_blade_ = blade;
            check_cut(before, *now_, body_.mesh, blade, options_, result.report, findings);
            if (findings.empty())
                check_account(before, *now_, copies_, topology_before_, topology_, findings);
            report(findings);
            const mesh::CutReport& r = result.report;
            tally.crossed += static_cast<double>(r.tets_crossed);
            tally.increase += static_cast<double>(r.tets_created) - static_cast<double>(r.tets_removed);
            tally.seconds += r.seconds;
            tally.worst.push_back(r.worst_dihedral_deg);
            tally.p01.push_back(r.p01_dihedral_deg);
            count_flat(before);
        }

        void single(const mesh::Blade& blade, const State& before)
        {
            const mesh::CutResult result = timed([&] { return session_.cut(blade, options_); });
            Findings findings;
            follow(result.delta, findings);
            finish(result, blade, before, findings);
        }

        void freehand(const mesh::Blade& blade, const State& before)
        {
            Findings findings;
            mesh::Blade drawn; // as far as it was accepted
            for (std::size_t points = 2; points <= blade.line.size(); ++points) {
                mesh::Blade so_far = blade;
                so_far.line.resize(points);
                try {
                    const mesh::CutResult step = timed([&] { return session_.extend_stroke(so_far, options_); });
                    follow(step.delta, findings);
                    drawn = so_far;
                } catch (const SolverError&) { // the next step tries again
                    ++result_.tally.refused_steps;
                    const State same(session_);
                    if (!same_bits(same, *now_))
                        findings.push_back({ "refusal leaves no trace", "a step of a freehand stroke" });
                }
            }
            if (!session_.stroke_open())
                throw SolverError("no step of a freehand stroke could be made");
            const mesh::CutResult result = timed([&] { return session_.finish_stroke(); });
            follow(result.delta, findings);
            finish(result, drawn, before, findings);
        }

        /// Elements with their middle in a ball, or in a half space that takes off a corner of the body.
        std::vector<TetId> marked()
        {
            const mesh::TetMesh& mesh = now_->mesh;
            const auto uniform = [&] { return std::generate_canonical<double, 53>(random_); };
            const auto middle = [&](std::size_t t) {
                Vec3 sum = Vec3::Zero();
                for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                    sum += 0.25 * mesh.vertices.row(v).transpose();
                return sum;
            };
            const Vec3 centre = middle(random_() % mesh.tet_count());
            const double radius = (0.3 + 2.0 * uniform()) * body_.edge;
            const bool half_space = random_() % 3 == 0;
            const Vec3 mean = mesh.vertices.colwise().mean().transpose();
            const Vec3 out = (centre - mean).stableNormalized();
            std::vector<TetId> tets;
            for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
                const Vec3 p = middle(t) - centre;
                if (half_space ? out.dot(p) > 0.3 * radius : p.norm() < radius)
                    tets.push_back(now_->map.tet_slot[t]);
            }
            return tets;
        }

        void ablate()
        {
            const std::vector<TetId> tets = marked();
            if (tets.empty() || 2 * tets.size() > now_->tets)
                return;
            name_ += ", ablation";
            last_blade_ = {};
            const State before = *now_;
            try {
                const mesh::CutResult result = session_.ablate(tets);
                Findings findings;
                follow(result.delta, findings);
                if (result.status != mesh::CutStatus::done)
                    findings.push_back({ "ablation", result.message });
                if (now_->cuts != before.cuts + 1)
                    findings.push_back({ "ablation", "is no cut" });
                check_ablation(before, *now_, tets, result.report, findings);
                report(findings);
                ++result_.tally.ablations;
                result_.tally.ablated += tets.size();
            } catch (const std::exception& error) {
                report({ { "exception", error.what() } });
                now_ = std::make_unique<State>(session_);
                if (!same_bits(*now_, before))
                    report({ { "refusal leaves no trace", error.what() } });
            }
        }

        void back_and_forth()
        {
            const int steps = 1 + static_cast<int>(random_() % 2);
            for (int i = 0; i < steps && session_.can_undo(); ++i) {
                const State there = *now_;
                Findings findings;
                follow(session_.undo(), findings);
                const State back = *now_;
                follow_back_to(there, session_.redo(), "redo after undo", findings);
                follow_back_to(back, session_.undo(), "undo after redo", findings);
                report(findings);
            }
        }

        void all_back(const State& first)
        {
            name_ = "undo of all";
            const State last = *now_;
            std::size_t undone = 0;
            for (; session_.can_undo(); ++undone)
                static_cast<void>(session_.undo());
            if (!same_bits(State(session_), first))
                report({ { "undo is exact", "the first state does not come back" } });
            for (; undone > 0; --undone)
                static_cast<void>(session_.redo());
            if (!same_bits(State(session_), last))
                report({ { "undo is exact", "the last state does not come back" } });
        }

        /// New elements, and the flat ones among them by what holds them.
        void count_flat(const State& before)
        {
            const mesh::TetMesh& mesh = now_->mesh;
            std::vector<char> old_wound(mesh.vertex_count(), 0), held(mesh.vertex_count(), 0);
            for (const mesh::LipFace& lip : now_->lips)
                for (const VertexId v : mesh::face_vertices(mesh, lip.face))
                    (lip.cut < static_cast<int>(before.cuts) ? old_wound : held)[static_cast<std::size_t>(v)] = 1;
            for (const mesh::TetFace& face : now_->boundary)
                for (const VertexId v : mesh::face_vertices(mesh, face))
                    held[static_cast<std::size_t>(v)] = 1;
            std::vector<Label> label(mesh.vertex_count(), 0);
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
                for (const VertexId v : mesh.tet(t)) {
                    const Label own = mesh.labels[static_cast<std::size_t>(t)];
                    Label& first = label[static_cast<std::size_t>(v)];
                    if (first != 0 && first != own)
                        held[static_cast<std::size_t>(v)] = 1;
                    first = own;
                }
            const auto has
                = [](const std::vector<char>& set, VertexId v) { return set[static_cast<std::size_t>(v)] != 0; };
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
                const TetId id = now_->map.tet_slot[static_cast<std::size_t>(t)];
                if (!is_new(t, id, before))
                    continue;
                ++result_.tally.born;
                const auto n = mesh.tet(t);
                const auto p = [&](std::size_t i) { return Vec3(mesh.vertices.row(n[i])); };
                const auto angles = mesh::dihedral_angles_deg(p(0), p(1), p(2), p(3));
                if (*std::min_element(angles.begin(), angles.end()) >= kFlat)
                    continue;
                const auto count
                    = std::count_if(n.begin(), n.end(), [&](VertexId v) { return has(held, v) || has(old_wound, v); });
                const bool wound = std::any_of(n.begin(), n.end(), [&](VertexId v) { return has(old_wound, v); });
                ++result_.tally.flat[wound ? "wound" : count == 4 ? "thin" : count > 0 ? "surface" : "free"];
            }
        }

        bool is_new(TetId t, TetId id, const State& before) const
        {
            if (static_cast<std::size_t>(id) >= before.map.compact_tet.size())
                return true;
            const TetId was = before.map.compact_tet[static_cast<std::size_t>(id)];
            if (was < 0)
                return true;
            const auto now = now_->mesh.tet(t), then = before.mesh.tet(was);
            for (std::size_t i = 0; i < 4; ++i)
                if (now_->map.vertex_slot[static_cast<std::size_t>(now[i])]
                    != before.map.vertex_slot[static_cast<std::size_t>(then[i])])
                    return true;
            return false;
        }

        const Body& body_;
        std::mt19937_64 random_;
        mesh::CutSession session_;
        std::unique_ptr<State> now_;
        Mirror mirror_;
        Topology topology_, topology_before_; ///< now, and before the stroke
        std::map<VertexId, VertexId> copies_; ///< vertices that the stroke copied onto other lips, by the copy
        mesh::CutOptions options_;
        RandomStroke last_;
        mesh::Blade last_blade_; ///< of the stroke that was done last, for the message
        std::string name_;
        bool ablates_ = false;
        SeedResult result_;
    };

} // namespace

void Tally::add(const Tally& other)
{
    strokes += other.strokes;
    done += other.done;
    missed += other.missed;
    refused_steps += other.refused_steps;
    for (const auto& [reason, count] : other.refused)
        refused[reason] += count;
    for (const auto& [invariant, count] : other.broken)
        broken[invariant] += count;
    crossed += other.crossed;
    increase += other.increase;
    seconds += other.seconds;
    slowest = std::max(slowest, other.slowest);
    worst.insert(worst.end(), other.worst.begin(), other.worst.end());
    p01.insert(p01.end(), other.p01.begin(), other.p01.end());
    for (const auto& [attempt, count] : other.attempts)
        attempts[attempt] += count;
    ablations += other.ablations;
    ablated += other.ablated;
    born += other.born;
    for (const auto& [cause, count] : other.flat)
        flat[cause] += count;
}

SeedResult run_seed(const Body& body, std::uint64_t seed, bool twice)
{
    Runner runner(body, seed);
    SeedResult result = runner.run();
    if (twice) {
        Runner again(body, seed);
        const SeedResult second = again.run();
        if (!same_bits(runner.state(), again.state()) || second.failures != result.failures) {
            ++result.tally.broken["determinism"];
            result.failures.push_back("determinism: two runs differ");
        }
    }
    return result;
}

} // namespace retractor::fuzz
