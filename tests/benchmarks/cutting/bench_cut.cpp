#include "tests/benchmarks/cutting/bench_cut.h"

#include "tests/benchmarks/framework/bench_bodies.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/framework/cpu_watch.h"
#include "tests/benchmarks/opening/bench_gape.h"
#include "ui/cli/framework/out_folder.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/surface_follower.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace retractor::benchmarks {

namespace {

    /// Required limits.
    constexpr double kMostIncrease = 3.6;
    constexpr double kLeastP01Deg = 8.0, kLeastWorstDeg = 5.0;
    constexpr double kMostLipToBlade = 0.1; ///< largest distance from the lip to the blade, in local edges
    constexpr double kMostMsPerThousand = 20.0, kMostStepMs = 5.0;
    constexpr double kMostStepRatio = 1.5;

    /// Ratio of wall time to processor time above which times get a warning.
    constexpr double kBusy = 1.1;

    /// Published mean increase of elements with adaptive subdivision [Nakao and others 2006, doi
    /// 10.1007/s10916-006-9021-4, table 1].
    constexpr double kSourceIncrease = 4.8;

    /// Index of the value that is the percentile.
    std::size_t percentile_at(const std::vector<double>& values, double share)
    {
        const double value = percentile(values, share);
        return static_cast<std::size_t>(std::find(values.begin(), values.end(), value) - values.begin());
    }

    void must_be_done(const mesh::CutResult& result)
    {
        if (result.status != mesh::CutStatus::done)
            throw SolverError("the bench's cut was not made: " + result.message);
    }

    struct Row {
        std::string mesh;
        mesh::CutReport report;
        mesh::CutReport freehand; ///< report of the same stroke in steps, as a whole
        mesh::CutReport hand, hand_at_once; ///< reports of the stroke drawn by hand: in steps, and in one cut
        std::vector<double> hand_step_cpu_ms;
        std::size_t surface_faces = 0; ///< faces of the surface that the stroke updates
        std::vector<std::size_t> step_crossed; ///< crossed elements by freehand step, as step_cpu_ms
        std::vector<double> stroke_ms, stroke_cpu_ms, surface_stroke_ms, step_ms, step_cpu_ms, surface_step_ms,
            finish_ms, undo_ms;
    };

    /// Measures one stroke.
    void measure_stroke(Row& row, mesh::CutSession& session, mesh::SurfaceFollower& surface, const BenchBody& body,
        const mesh::CutOptions& options)
    {
        mesh::CutResult result;
        const CpuWatch cpu;
        row.stroke_ms.push_back(milliseconds([&] { result = session.cut(body.blade, options); }));
        row.stroke_cpu_ms.push_back(cpu.milliseconds());
        must_be_done(result);
        row.report = result.report;
        row.surface_stroke_ms.push_back(milliseconds([&] { surface.follow(result.delta); }));
        row.surface_faces = surface.changed().size();
        mesh::MeshDelta back;
        row.undo_ms.push_back(milliseconds([&] { back = session.undo(); }));
        surface.follow(back);
    }

    /// Measures a freehand stroke in steps.
    void measure_freehand(Row& row, mesh::CutSession& session, mesh::SurfaceFollower& surface, const BenchBody& body,
        const mesh::CutOptions& options)
    {
        mesh::CutResult result;
        const auto follow = [&] {
            must_be_done(result);
            return milliseconds([&] { surface.follow(result.delta); });
        };
        for (std::size_t points = 2; points <= body.blade.line.size(); ++points) {
            const mesh::Blade drawn = beginning(body.blade, points);
            const CpuWatch cpu;
            row.step_ms.push_back(milliseconds([&] { result = session.extend_stroke(drawn, options); }));
            row.step_cpu_ms.push_back(cpu.milliseconds());
            row.step_crossed.push_back(result.report.tets_crossed);
            row.surface_step_ms.push_back(follow());
        }
        row.finish_ms.push_back(milliseconds([&] { result = session.finish_stroke(); }));
        follow();
        row.freehand = result.report;
        surface.follow(session.undo());
    }

    /// Measures a stroke as drawn by hand: the line bends and the directions turn.
    void measure_drawn(Row& row, mesh::CutSession& session, const BenchBody& body, const mesh::CutOptions& options)
    {
        const mesh::Blade hand = drawn_by_hand(body.blade);
        mesh::CutResult result = session.cut(hand, options);
        must_be_done(result);
        row.hand_at_once = result.report;
        (void)session.undo();
        for (std::size_t points = 2; points <= hand.line.size(); ++points) {
            const CpuWatch cpu;
            must_be_done(session.extend_stroke(beginning(hand, points), options));
            row.hand_step_cpu_ms.push_back(cpu.milliseconds());
        }
        result = session.finish_stroke();
        must_be_done(result);
        row.hand = result.report;
        (void)session.undo();
    }

    Row run_row(
        mesh::CutSession& session, mesh::SurfaceFollower& surface, const BenchBody& body, int repeats, const Job& job)
    {
        Row row;
        row.mesh = body.name;
        mesh::CutOptions options;
        options.uncut_labels = body.uncut_labels;
        for (int i = 0; i < repeats && !job.cancelled(); ++i) {
            measure_stroke(row, session, surface, body, options);
            measure_freehand(row, session, surface, body, options);
        }
        if (!job.cancelled())
            measure_drawn(row, session, body, options);
        return row;
    }

    /// Number of crossed elements in the freehand step whose processor time is the 95th percentile.
    std::size_t crossed_at_p95(const Row& row)
    {
        return row.step_crossed.empty() ? 0 : row.step_crossed[percentile_at(row.step_cpu_ms, 0.95)];
    }

    ui::cli::Json as_json(const mesh::CutReport& r)
    {
        return { { "cut_elements", r.tets_crossed }, { "mean_increase", r.mean_increase() },
            { "min_dihedral_deg", r.worst_dihedral_deg }, { "p01_dihedral_deg", r.p01_dihedral_deg },
            { "lip_to_blade_max", r.lip_to_blade } };
    }

    ui::cli::Json as_json(const Row& row)
    {
        const mesh::CutReport& r = row.report;
        ui::cli::Json json { { "mesh", row.mesh }, { "tets", r.tets_before }, { "cut_elements", r.tets_crossed },
            { "mean_increase", r.mean_increase() }, { "min_dihedral_before_deg", r.worst_dihedral_before_deg },
            { "min_dihedral_deg", r.worst_dihedral_deg }, { "p01_dihedral_deg", r.p01_dihedral_deg },
            { "lip_to_blade_max", r.lip_to_blade }, { "surface_deviation_max", r.surface_deviation },
            { "smallest_volume_ratio", r.smallest_volume_ratio }, { "stroke_ms", percentile(row.stroke_ms, 0.5) },
            { "stroke_cpu_ms", percentile(row.stroke_cpu_ms, 0.5) },
            { "surface_stroke_ms", percentile(row.surface_stroke_ms, 0.5) }, { "surface_faces", row.surface_faces },
            { "step_ms_median", percentile(row.step_ms, 0.5) }, { "step_ms_p95", percentile(row.step_ms, 0.95) },
            { "step_cpu_ms_median", percentile(row.step_cpu_ms, 0.5) },
            { "step_cpu_ms_p95", percentile(row.step_cpu_ms, 0.95) }, { "step_p95_cut_elements", crossed_at_p95(row) },
            { "surface_ms_median", percentile(row.surface_step_ms, 0.5) },
            { "surface_ms_p95", percentile(row.surface_step_ms, 0.95) },
            { "finish_ms", percentile(row.finish_ms, 0.5) }, { "undo_ms", percentile(row.undo_ms, 0.5) } };
        if (row.freehand.tets_crossed > 0)
            json["freehand"] = as_json(row.freehand);
        if (row.hand.tets_crossed > 0) {
            json["drawn_by_hand"] = as_json(row.hand);
            json["drawn_by_hand_at_once"] = as_json(row.hand_at_once);
            json["drawn_by_hand"]["step_cpu_ms_median"] = percentile(row.hand_step_cpu_ms, 0.5);
            json["drawn_by_hand"]["step_cpu_ms_p95"] = percentile(row.hand_step_cpu_ms, 0.95);
        }
        return json;
    }

    template <class... Values> std::string line(const char* format, Values... values)
    {
        std::array<char, 256> text {};
        std::snprintf(text.data(), text.size(), format, values...);
        return text.data();
    }

    /// The row as in table 1 of [Nakao and others 2006, doi 10.1007/s10916-006-9021-4]: a blade through the whole body,
    /// so that no border of a wound adds to the subdivision.
    Row severing_row()
    {
        const BenchBody body = bench_box_severed();
        mesh::SurfaceFollower surface(body.mesh);
        mesh::CutSession session(body.mesh);
        Row row;
        row.mesh = body.name;
        measure_stroke(row, session, surface, body, {});
        return row;
    }

    constexpr const char* kSubdivisionHeading
        = "Subdivision (increase of elements per element crossed by the blade before anything moves)\n"
          "mesh      tets     cut  increase  Nakao 2006  dihedral deg                 lip off   stroke\n"
          "              elements              table 1   before  worst    p01   (edges)       ms\n";

    std::string subdivision_line(const Row& row)
    {
        const mesh::CutReport& r = row.report;
        return line("%-7s %6zu %7zu %9.2f %11.1f %8.1f %6.1f %6.1f %9.3f %9.2f\n", row.mesh.c_str(), r.tets_before,
            r.tets_crossed, r.mean_increase(), kSourceIncrease, r.worst_dihedral_before_deg, r.worst_dihedral_deg,
            r.p01_dihedral_deg, r.lip_to_blade, percentile(row.stroke_ms, 0.5));
    }

    constexpr const char* kTimeHeading
        = "\nTime of the knife (ms; freehand: steps of 5 mm; cpu: processor time, whatever else the machine "
          "does)\n"
          "mesh        tets    cut   stroke   per 1000 cut  surface    undo      step             step    cpu    cut  "
          "  surface           finish\n"
          "                                  elements    cpu   of stroke       median     cpu     p95    p95 at p95  "
          " median     p95\n";

    double per_thousand(const std::vector<double>& stroke_ms, const Row& row)
    {
        return 1e3 * percentile(stroke_ms, 0.5)
            / static_cast<double>(std::max<std::size_t>(1, row.report.tets_crossed));
    }

    std::string time_line(const Row& row)
    {
        const auto middle = [](const std::vector<double>& ms) { return percentile(ms, 0.5); };
        const auto high = [](const std::vector<double>& ms) { return percentile(ms, 0.95); };
        return line("%-7s %8zu %6zu %8.2f %8.1f %6.1f %8.2f %7.2f %9.2f %7.2f %7.2f %6.2f %6zu %8.2f %7.2f %8.2f\n",
            row.mesh.c_str(), row.report.tets_before, row.report.tets_crossed, middle(row.stroke_ms),
            per_thousand(row.stroke_ms, row), per_thousand(row.stroke_cpu_ms, row), middle(row.surface_stroke_ms),
            middle(row.undo_ms), middle(row.step_ms), middle(row.step_cpu_ms), high(row.step_ms), high(row.step_cpu_ms),
            crossed_at_p95(row), middle(row.surface_step_ms), high(row.surface_step_ms), middle(row.finish_ms));
    }

    constexpr const char* kFreehandHeading
        = "\nWhole strokes: in one cut and in steps of 5 mm; the bench's blade, and one drawn by hand (bends, turns)\n"
          "mesh              increase                  worst dihedral (deg)           lip off (edges)  hand step cpu\n"
          "          one  steps    hand  steps     one  steps    hand  steps    blade   hand  median    p95\n";

    std::string freehand_line(const Row& row)
    {
        const mesh::CutReport &r = row.report, &f = row.freehand, &o = row.hand_at_once, &h = row.hand;
        return line("%-7s %6.2f %6.2f %7.2f %6.2f %6.1f %6.1f %7.1f %6.1f %8.3f %6.3f %6.2f %6.2f\n", row.mesh.c_str(),
            r.mean_increase(), f.mean_increase(), o.mean_increase(), h.mean_increase(), r.worst_dihedral_deg,
            f.worst_dihedral_deg, o.worst_dihedral_deg, h.worst_dihedral_deg, r.lip_to_blade, h.lip_to_blade,
            percentile(row.hand_step_cpu_ms, 0.5), percentile(row.hand_step_cpu_ms, 0.95));
    }

    /// The row of a body, if measured.
    const Row* row_of(const std::vector<Row>& rows, const std::string& mesh)
    {
        for (const Row& row : rows)
            if (row.mesh == mesh)
                return &row;
        return nullptr;
    }

    /// Wall time over processor time of all strokes: 1 on an otherwise idle machine.
    double busy(const std::vector<Row>& rows)
    {
        double wall = 0.0, cpu = 0.0;
        for (const Row& row : rows) {
            for (const double ms : row.stroke_ms)
                wall += ms;
            for (const double ms : row.stroke_cpu_ms)
                cpu += ms;
        }
        return cpu > 0.0 ? wall / cpu : 1.0;
    }

    std::optional<double> step_ratio(const std::vector<Row>& rows)
    {
        const Row *small = row_of(rows, "12k"), *large = row_of(rows, "1M");
        if (small == nullptr || large == nullptr)
            return std::nullopt;
        return percentile(large->step_cpu_ms, 0.5) / percentile(small->step_cpu_ms, 0.5);
    }

    struct Target {
        const char* name;
        double value, bound;
        bool at_least;
        std::string where;
        bool met() const { return at_least ? value >= bound : value <= bound; }
    };

    /// The worst row by a measure.
    template <class Measure>
    Target worst_of(const char* name, const std::vector<const Row*>& rows, double bound, bool at_least, Measure measure)
    {
        Target target { name, 0.0, bound, at_least, {} };
        for (const Row* row : rows)
            if (const double value = measure(*row);
                target.where.empty() || (at_least ? value < target.value : value > target.value)) {
                target.value = value;
                target.where = row->mesh;
            }
        return target;
    }

    /// Limits for the boxes with the common blade; the thorax is reported without limits.
    std::vector<Target> targets(const std::vector<Row>& rows)
    {
        std::vector<const Row*> boxes;
        for (const Row& row : rows)
            if (row.mesh != "thorax")
                boxes.push_back(&row);
        std::vector<Target> all {
            worst_of(
                "mean increase", boxes, kMostIncrease, false, [](const Row& r) { return r.report.mean_increase(); }),
            worst_of("1st percentile of dihedral angles (degrees)", boxes, kLeastP01Deg, true,
                [](const Row& r) { return r.report.p01_dihedral_deg; }),
            worst_of("worst dihedral angle (degrees)", boxes, kLeastWorstDeg, true,
                [](const Row& r) { return r.report.worst_dihedral_deg; }),
            worst_of("lips off the blade (local edges)", boxes, kMostLipToBlade, false,
                [](const Row& r) { return r.report.lip_to_blade; }),
            worst_of("ms per 1,000 cut elements", boxes, kMostMsPerThousand, false,
                [](const Row& r) { return per_thousand(r.stroke_ms, r); }),
            worst_of("the same in processor time", boxes, kMostMsPerThousand, false,
                [](const Row& r) { return per_thousand(r.stroke_cpu_ms, r); }),
            worst_of("ms per freehand step, 95th percentile", boxes, kMostStepMs, false,
                [](const Row& r) { return percentile(r.step_ms, 0.95); }),
            worst_of("the same in processor time", boxes, kMostStepMs, false,
                [](const Row& r) { return percentile(r.step_cpu_ms, 0.95); }),
            worst_of("ms per freehand step and its surface, medians", boxes, kMostStepMs, false,
                [](const Row& r) { return percentile(r.step_ms, 0.5) + percentile(r.surface_step_ms, 0.5); }),
        };
        if (const auto ratio = step_ratio(rows))
            all.push_back(
                { "median step at 1M over that at 12k, processor time", *ratio, kMostStepRatio, false, "1M" });
        return all;
    }

    std::string target_lines(const std::vector<Target>& all)
    {
        std::string text = "\nTargets (boxes; the worst of them)\n";
        for (const Target& t : all)
            text += line("  %-50s %8.3f (%s)   asked: %s %.3g   %s\n", t.name, t.value, t.where.c_str(),
                t.at_least ? ">=" : "<=", t.bound, t.met() ? "met" : "missed");
        return text;
    }

    ui::cli::Json as_json(const std::vector<Target>& all)
    {
        ui::cli::Json json = ui::cli::Json::array();
        for (const Target& t : all)
            json.push_back({ { "target", t.name }, { "value", t.value }, { "asked", t.bound },
                { "sense", t.at_least ? ">=" : "<=" }, { "mesh", t.where }, { "met", t.met() } });
        return json;
    }

    std::vector<std::string> body_names(const CutBenchOptions& options)
    {
        std::vector<std::string> names { "12k", "96k" };
        if (options.largest)
            names.emplace_back("1M");
        if (options.thorax)
            names.emplace_back("thorax");
        return names;
    }

    void measure_body(std::vector<Row>& rows, const BenchBody& body, int repeats, const Job& job)
    {
        mesh::SurfaceFollower surface(body.mesh);
        mesh::CutSession session(body.mesh);
        rows.push_back(run_row(session, surface, body, repeats, job));
    }

} // namespace

ui::cli::Outcome bench_cut(const CutBenchOptions& options, const Job& job)
{
    const Stopwatch watch;
    ui::cli::Outcome outcome;
    std::vector<Row> rows;
    const std::vector<std::string> names = body_names(options);
    for (std::size_t i = 0; i < names.size() && !job.cancelled(); ++i) {
        job.report("bench cut", static_cast<double>(i) / static_cast<double>(names.size()));
        if (names[i] == "thorax") // one stroke of many elements suffices
            measure_body(rows, bench_thorax(job), 1, job);
        else
            measure_body(rows, bench_box(names[i]), options.repeats, job);
    }
    ui::cli::Json results = ui::cli::Json::array();
    std::string times = kTimeHeading, freehand = kFreehandHeading;
    outcome.text = kSubdivisionHeading;
    const Row severing = severing_row();
    outcome.text += subdivision_line(severing);
    for (const Row& row : rows) {
        results.push_back(as_json(row));
        outcome.text += subdivision_line(row);
        times += time_line(row);
        freehand += freehand_line(row);
    }
    outcome.text += times + freehand;
    outcome.document["results"] = results;
    outcome.document["severed"] = as_json(severing);
    outcome.document["source_mean_increase"] = kSourceIncrease;
    if (job.cancelled()) {
        outcome.text += "cancelled\n";
        outcome.exit_code = 1;
        return outcome;
    }
    const std::vector<Target> judged = targets(rows);
    outcome.document["targets"] = as_json(judged);
    const ui::cli::Outcome gape = bench_gape({ .quick = true, .out = {} }, job);
    outcome.document["gape"] = gape.document["results"];
    outcome.document["seconds"] = watch.seconds();
    outcome.document["wall_over_processor_time"] = busy(rows);
    outcome.text += target_lines(judged) + "\n" + gape.text + line("\nwhole bench %.1f s\n", watch.seconds());
    if (busy(rows) > kBusy)
        outcome.text
            += line("The machine did other things too: wall time was %.2f times processor time.\n", busy(rows));
    if (!options.out.empty()) {
        ui::cli::make_folder(options.out);
        const std::filesystem::path folder = options.out;
        write_file_atomically(folder / "bench_cut.json", outcome.document.dump(2) + "\n");
        outcome.text += "written: " + (folder / "bench_cut.json").string() + "\n";
    }
    return outcome;
}

} // namespace retractor::benchmarks
