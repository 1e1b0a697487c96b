#include "tests/benchmarks/cutting/bench_soak.h"

#include "tests/benchmarks/framework/bench_bodies.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/framework/cpu_watch.h"

#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/surface_follower.h"

#include <Eigen/Geometry>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <random>

namespace retractor::benchmarks {

namespace {

    constexpr int kBlocks = 10; ///< number of blocks of cuts, each measured separately
    constexpr int kMostTriesPerCut = 4; ///< attempts at other places when a stroke is refused
    /// Largest rise of the straight fit, relative to the mean over the whole run, that counts as flat. The value is
    /// the spread of medians on a machine with other load.
    constexpr double kFlat = 0.25;
    constexpr int kProbes = 9; ///< probe cuts per block
    constexpr double kKeptFree = 8.0; ///< distance without other cuts round the probe, in edges at the probe
    /// limits of length and depth of a cut, in local edges
    constexpr double kShortest = 1.5, kLongest = 2.5, kShallowest = 1.0, kDeepest = 1.5;
    constexpr int kCandidates = 16; ///< random places among which each cut chooses
    constexpr double kMiB = 1024.0 * 1024.0;

    double resident_mib()
    {
        std::ifstream file("/proc/self/statm");
        double size = 0.0, resident = 0.0;
        file >> size >> resident;
        return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / kMiB;
    }

    /// All observable state of a session, for comparison bit by bit.
    struct Seen {
        explicit Seen(const mesh::CutSession& session)
            : mesh(session.compact_mesh(&map))
            , lips(session.lips())
        {
            for (const TetId t : map.tet_slot)
                origins.push_back(session.origin(t));
        }
        bool operator==(const Seen& other) const
        {
            const auto same_lip = [](const mesh::LipFace& a, const mesh::LipFace& b) {
                return a.face.tet == b.face.tet && a.face.corner == b.face.corner && a.side == b.side && a.cut == b.cut;
            };
            return mesh.nodes == other.mesh.nodes && mesh.labels == other.mesh.labels
                && mesh.vertices.rows() == other.mesh.vertices.rows()
                && (mesh.vertices.array() == other.mesh.vertices.array()).all() && origins == other.origins
                && map.vertex_slot == other.map.vertex_slot && map.tet_slot == other.map.tet_slot
                && std::equal(lips.begin(), lips.end(), other.lips.begin(), other.lips.end(), same_lip);
        }
        mesh::SlotMap map;
        mesh::TetMesh mesh;
        std::vector<mesh::LipFace> lips;
        std::vector<TetId> origins;
    };

    /// Places where cuts may begin: faces of the body's first surface. Each place is as far as possible from earlier
    /// cuts, so that a late cut has as much work as an early one.
    class Places {
    public:
        Places(const BenchBody& body, const mesh::SurfaceFollower& surface, std::uint64_t seed)
            : random_(seed)
        {
            for (const mesh::SurfaceFace& face : surface.faces()) {
                Place place { Vec3::Zero(), Vec3::Zero(), 0.0 };
                std::array<Vec3, 3> p;
                for (std::size_t i = 0; i < 3; ++i)
                    p[i] = surface.position(face.vertices[i]);
                for (std::size_t i = 0; i < 3; ++i) {
                    place.centre += p[i] / 3.0;
                    place.edge += (p[(i + 1) % 3] - p[i]).norm() / 3.0;
                }
                place.out = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
                if (body.skin.empty() ? place.out.z() > 0.9 // in a box: the top
                                      : std::binary_search(body.skin.begin(), body.skin.end(), face.label))
                    places_.push_back(place);
            }
            const Vec3 middle = body.blade.line[body.blade.line.size() / 2];
            const auto nearer = [&](const Place& a, const Place& b) {
                return (a.centre - middle).norm() < (b.centre - middle).norm();
            };
            const auto probe = std::min_element(places_.begin(), places_.end(), nearer);
            if (probe == places_.end())
                throw InputError("the body has no skin to cut", body.name);
            probe_ = blade_at(*probe);
            const Place kept = *probe;
            std::erase_if(places_, [&](const Place& p) {
                return (p.centre - kept.centre).norm() < kKeptFree * kept.edge + kLongest * p.edge;
            });
            if (places_.empty())
                throw InputError("the body is too small to be cut in many places", body.name);
        }

        /// A blade at a place that no other cut comes near.
        const mesh::Blade& probe() const { return probe_; }

        mesh::Blade next()
        {
            const Place& place = farthest();
            used_.push_back(place.centre);
            return blade_at(place);
        }

    private:
        struct Place {
            Vec3 centre, out;
            double edge;
        };

        mesh::Blade blade_at(const Place& place)
        {
            const double turn = in(0.0, 2.0 * std::numbers::pi);
            const Vec3 u = place.out.unitOrthogonal(), w = place.out.cross(u);
            const Vec3 along = std::cos(turn) * u + std::sin(turn) * w;
            const double half = 0.5 * in(kShortest, kLongest) * place.edge;
            return { .line = { place.centre - half * along, place.centre + half * along },
                .directions = { -place.out + in(-0.2, 0.2) * u + in(-0.2, 0.2) * w },
                .depth_mm = in(kShallowest, kDeepest) * place.edge };
        }

        double in(double low, double high)
        {
            // equal with every standard library
            return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
        }
        /// The place, among some random ones, that is farthest from earlier cuts in local edges.
        const Place& farthest()
        {
            const Place* best = nullptr;
            double most = -1.0;
            for (int i = 0; i < kCandidates; ++i) {
                const Place& place = places_[random_() % places_.size()];
                double least = std::numeric_limits<double>::infinity();
                for (const Vec3& used : used_)
                    least = std::min(least, (used - place.centre).norm() / place.edge);
                if (least > most) {
                    most = least;
                    best = &place;
                }
            }
            return *best;
        }

        std::vector<Place> places_;
        std::vector<Vec3> used_;
        mesh::Blade probe_;
        std::mt19937_64 random_;
    };

    struct Block {
        int cuts = 0; ///< number of cuts so far
        std::size_t tets = 0, crossed = 0;
        double cut_ms = 0.0, per_thousand_ms = 0.0, surface_ms = 0.0, probe_ms = 0.0; ///< medians, processor time
        double resident_mib = 0.0, mesh_mib = 0.0, journal_mib = 0.0;
        double resident_per_tet = 0.0; ///< resident bytes per element, without the journal
        double journal_per_cut = 0.0, journal_per_crossed = 0.0; ///< bytes of the journal, for this block's cuts
    };

    struct Line {
        double first = 0.0, last = 0.0; ///< values of the fit at both ends
        /// Rise of the fit over its mean. The first value is no reference, because a fit may begin near zero or
        /// below.
        double growth() const { return first + last > 0.0 ? 2.0 * (last - first) / (last + first) : 0.0; }
    };

    Line fitted(const std::vector<double>& values)
    {
        const auto n = static_cast<double>(values.size());
        double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const auto x = static_cast<double>(i);
            sx += x;
            sy += values[i];
            sxx += x * x;
            sxy += x * values[i];
        }
        const double slope = n > 1.0 ? (n * sxy - sx * sy) / (n * sxx - sx * sx) : 0.0;
        const double start = (sy - slope * sx) / n;
        return { start, start + slope * (n - 1.0) };
    }

    struct Judged {
        const char* what;
        const char* unit;
        Line line;
    };

    template <class Value> Line fit_of(const std::vector<Block>& blocks, Value value)
    {
        std::vector<double> values;
        for (const Block& block : blocks)
            values.push_back(value(block));
        return fitted(values);
    }

    class Soak {
    public:
        Soak(const BenchBody& body, const SoakOptions& options, const Job& job)
            : options_(options)
            , job_(job)
            , session_(body.mesh)
            , surface_(body.mesh)
            , places_(body, surface_, options.seed)
        {
            cut_options_.uncut_labels = body.uncut_labels;
        }

        ui::cli::Outcome run()
        {
            const Seen first(session_);
            for (int b = 1; b <= kBlocks && !job_.cancelled(); ++b)
                block(options_.cuts * b / kBlocks);
            if (job_.cancelled()) {
                ui::cli::Outcome outcome;
                outcome.text = "cancelled\n";
                outcome.exit_code = 1;
                return outcome;
            }
            const Seen last(session_);
            CpuWatch watch;
            while (session_.can_undo())
                surface_.follow(session_.undo());
            const double undo_ms = watch.milliseconds() / done_;
            const bool undone = Seen(session_) == first;
            watch = {};
            for (int i = 0; i < done_; ++i) // without the last probe
                surface_.follow(session_.redo());
            const double redo_ms = watch.milliseconds() / done_;
            return report(undone, Seen(session_) == last, undo_ms, redo_ms);
        }

    private:
        bool try_cut(
            Block& block, std::vector<double>& cut_ms, std::vector<double>& rate, std::vector<double>& surface_ms)
        {
            const mesh::Blade blade = places_.next();
            try {
                CpuWatch watch;
                const mesh::CutResult result = session_.cut(blade, cut_options_);
                const double ms = watch.milliseconds();
                if (result.status != mesh::CutStatus::done) {
                    ++missed_;
                    return false;
                }
                watch = {};
                surface_.follow(result.delta);
                surface_ms.push_back(watch.milliseconds());
                cut_ms.push_back(ms);
                if (result.report.tets_crossed > 0)
                    rate.push_back(1e3 * ms / static_cast<double>(result.report.tets_crossed));
                block.crossed += result.report.tets_crossed;
                return true;
            } catch (const SolverError& error) {
                ++refused_[error.what()];
                return false;
            }
        }

        /// Time of the same cut in every block, at a place without other cuts; the cut is undone.
        double probe()
        {
            std::vector<double> ms;
            for (int i = 0; i < kProbes; ++i) {
                const CpuWatch watch;
                const mesh::CutResult result = session_.cut(places_.probe(), cut_options_);
                ms.push_back(watch.milliseconds());
                if (result.status != mesh::CutStatus::done)
                    throw SolverError("the soak's probe was not cut: " + result.message);
                session_.undo();
            }
            return median(ms);
        }

        void block(int until)
        {
            Block block;
            std::vector<double> cut_ms, rate, surface_ms;
            for (int tries = 0; done_ < until && !job_.cancelled(); ++tries) {
                if (tries > kMostTriesPerCut * (options_.cuts / kBlocks + 1))
                    throw SolverError("most strokes of the soak are refused or miss");
                done_ += try_cut(block, cut_ms, rate, surface_ms) ? 1 : 0;
                job_.report("soak", static_cast<double>(done_) / options_.cuts);
            }
            block.probe_ms = probe();
            block.cuts = done_;
            block.tets = session_.tet_count();
            block.cut_ms = median(cut_ms);
            block.per_thousand_ms = median(rate);
            block.surface_ms = median(surface_ms);
            const mesh::SessionBytes bytes = session_.bytes();
            block.mesh_mib = static_cast<double>(bytes.mesh) / kMiB;
            block.journal_mib = static_cast<double>(bytes.journal) / kMiB;
            block.resident_mib = resident_mib();
            block.resident_per_tet = kMiB * (block.resident_mib - block.journal_mib) / static_cast<double>(block.tets);
            const double journal_before = blocks_.empty() ? 0.0 : blocks_.back().journal_mib;
            const int cuts_before = blocks_.empty() ? 0 : blocks_.back().cuts;
            block.journal_per_cut = kMiB * (block.journal_mib - journal_before) / std::max(1, block.cuts - cuts_before);
            if (block.crossed > 0)
                block.journal_per_crossed
                    = kMiB * (block.journal_mib - journal_before) / static_cast<double>(block.crossed);
            blocks_.push_back(block);
        }

        ui::cli::Outcome report(bool undone, bool redone, double undo_ms, double redo_ms) const
        {
            ui::cli::Outcome outcome;
            std::array<char, 256> text {};
            const auto add = [&](const char* format, auto... values) {
                std::snprintf(text.data(), text.size(), format, values...);
                outcome.text += text.data();
            };
            ui::cli::Json rows = ui::cli::Json::array();
            add("%d cuts in a row on %s\n", done_, options_.body.c_str());
            add("   cuts elements  crossed   ms per cut  per 1,000   surface  same cut   resident  session: mesh   "
                "journal   resident  journal\n                             (median)    crossed        ms   elsewhere   "
                "   MiB       "
                "     MiB       MiB  B/element  B/cut\n");
            for (const Block& b : blocks_) {
                add("%7d %8zu %8zu %12.2f %10.1f %9.3f %9.2f %10.1f %14.1f %9.1f %10.0f %6.0f\n", b.cuts, b.tets,
                    b.crossed, b.cut_ms, b.per_thousand_ms, b.surface_ms, b.probe_ms, b.resident_mib, b.mesh_mib,
                    b.journal_mib, b.resident_per_tet, b.journal_per_cut);
                rows.push_back({ { "cuts", b.cuts }, { "tets", b.tets }, { "crossed", b.crossed },
                    { "cut_ms_median", b.cut_ms }, { "ms_per_1000_crossed_median", b.per_thousand_ms },
                    { "surface_ms_median", b.surface_ms }, { "probe_ms_median", b.probe_ms },
                    { "resident_MiB", b.resident_mib }, { "mesh_MiB", b.mesh_mib }, { "journal_MiB", b.journal_mib },
                    { "resident_without_journal_bytes_per_element", b.resident_per_tet },
                    { "journal_bytes_per_cut", b.journal_per_cut } });
            }
            const Line time = fit_of(blocks_, [](const Block& b) { return b.cut_ms; });
            const Line rate = fit_of(blocks_, [](const Block& b) { return b.per_thousand_ms; });
            std::size_t refused = 0;
            ui::cli::Json reasons = ui::cli::Json::object();
            for (const auto& [reason, count] : refused_) {
                refused += count;
                reasons[reason] = count;
                add("refused %zu: %s\n", count, reason.c_str());
            }
            add("missed or too small for the elements there: %zu\n", missed_);
            bool flat = true;
            ui::cli::Json flatness = ui::cli::Json::array();
            for (const auto& [what, unit, line] : {
                     Judged { "time of the same cut at a place left free", "ms",
                         fit_of(blocks_, [](const Block& b) { return b.probe_ms; }) },
                     Judged { "resident memory without the journal, per living element", "bytes",
                         fit_of(blocks_, [](const Block& b) { return b.resident_per_tet; }) },
                     Judged { "journal per element crossed", "bytes",
                         fit_of(blocks_, [](const Block& b) { return b.journal_per_crossed; }) },
                 }) {
                const bool met = line.growth() <= kFlat;
                flat = flat && met;
                add("flat within %.0f %%: %s: %.2f -> %.2f %s (%+.0f %%): %s\n", 100.0 * kFlat, what, line.first,
                    line.last, unit, 100.0 * line.growth(), met ? "met" : "missed");
                flatness.push_back({ { "what", what }, { "unit", unit }, { "first", line.first }, { "last", line.last },
                    { "growth", line.growth() }, { "met", met } });
            }
            const Line journal = fit_of(blocks_, [](const Block& b) { return b.journal_per_cut; });
            add("A cut among many others crosses more elements, the small ones that these left: its time and its "
                "journal grow with them.\n"
                "fit: journal per cut: %.0f -> %.0f bytes (%+.0f %%)\n",
                journal.first, journal.last, 100.0 * journal.growth());
            add("fit: the cuts of the row, which meet more and more of what former ones left: %.2f -> %.2f ms (%+.0f "
                "%%), "
                "%.0f -> %.0f ms per 1,000 crossed (%+.0f %%)\n",
                time.first, time.last, 100.0 * time.growth(), rate.first, rate.last, 100.0 * rate.growth());
            add("undo of all: %s, %.2f ms each; redo of all: %s, %.2f ms each\n",
                undone ? "the first state, bit for bit" : "NOT the first state", undo_ms,
                redone ? "the last state, bit for bit" : "NOT the last state", redo_ms);
            outcome.document = { { "body", options_.body }, { "seed", options_.seed }, { "cuts", done_ },
                { "missed", missed_ }, { "refused", refused }, { "refused_reasons", reasons }, { "results", rows },
                { "flatness", flatness }, { "cut_ms_growth", time.growth() },
                { "ms_per_1000_crossed_growth", rate.growth() }, { "journal_per_cut_growth", journal.growth() },
                { "flat", flat }, { "undo_exact", undone }, { "redo_exact", redone }, { "undo_ms_mean", undo_ms },
                { "redo_ms_mean", redo_ms } };
            outcome.exit_code = undone && redone && flat ? 0 : 1;
            return outcome;
        }

        const SoakOptions& options_;
        const Job& job_;
        mesh::CutSession session_;
        mesh::SurfaceFollower surface_;
        Places places_;
        mesh::CutOptions cut_options_;
        int done_ = 0;
        std::size_t missed_ = 0;
        std::map<std::string, std::size_t> refused_;
        std::vector<Block> blocks_;
    };

} // namespace

ui::cli::Outcome soak_cut(const SoakOptions& options, const Job& job)
{
    const BenchBody body = options.body == "thorax" ? bench_thorax(job) : bench_box(options.body);
    Soak soak(body, options, job);
    return soak.run();
}

} // namespace retractor::benchmarks
