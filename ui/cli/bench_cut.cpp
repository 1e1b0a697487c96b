#include "ui/cli/bench_cut.h"

#include "mesh/base/error.h"
#include "mesh/cut_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace retractor::cli {

namespace {

    constexpr double kSpacing = 4.0;
    constexpr double kLength = 60.0, kDepth = 12.0, kStep = 5.0;
    constexpr double kHeadingDeg = 7.3, kTiltDeg = 10.0;

    struct BenchBox {
        const char* name;
        std::array<int, 3> cells;
    };
    constexpr std::array<BenchBox, 3> kBoxes { { { "12k", { 20, 20, 5 } }, { "96k", { 40, 40, 10 } },
        { "1M", { 100, 100, 17 } } } };

    struct CutModel {
        const char* name;
        CutOptions options;
    };

    /// What is compared: the product's way, and plane splits of all crossed elements with nothing moved.
    std::vector<CutModel> cut_models() { return { { "adaptive", {} }, { "unsnapped", { .snap = 0.0 } } }; }

    Blade bench_blade(const BenchBox& box)
    {
        const double heading = kHeadingDeg * std::numbers::pi / 180.0, tilt = kTiltDeg * std::numbers::pi / 180.0;
        const Vec3 along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
        const Vec3 centre(
            0.5 * box.cells[0] * kSpacing + 1.3, 0.5 * box.cells[1] * kSpacing + 0.9, box.cells[2] * kSpacing);
        return { .line = { centre - 0.5 * kLength * along, centre + 0.5 * kLength * along },
            .directions = { -std::cos(tilt) * Vec3::UnitZ() + std::sin(tilt) * across },
            .depth_mm = kDepth };
    }

    double percentile(std::vector<double> values, double share)
    {
        if (values.empty())
            return 0.0;
        std::sort(values.begin(), values.end());
        const auto last = static_cast<double>(values.size() - 1);
        return values[static_cast<std::size_t>(std::lround(share * last))];
    }

    template <class Work> double milliseconds(Work&& work)
    {
        const Stopwatch watch;
        work();
        return 1e3 * watch.seconds();
    }

    void must_be_done(const CutResult& result)
    {
        if (result.status != CutStatus::done)
            throw SolverError("the bench's cut was not made: " + result.message);
    }

    struct Row {
        CutReport report;
        std::vector<double> stroke_ms, step_ms, finish_ms, undo_ms;
    };

    Row run_row(CutSession& session, const Blade& blade, const CutOptions& options, int repeats, const Job& job)
    {
        Row row;
        for (int i = 0; i < repeats && !job.cancelled(); ++i) {
            CutResult result;
            row.stroke_ms.push_back(milliseconds([&] { result = session.cut(blade, options); }));
            must_be_done(result);
            row.report = result.report;
            row.undo_ms.push_back(milliseconds([&] { session.undo(); }));

            Blade drawn = blade;
            const Vec3 along = (blade.line[1] - blade.line[0]) / kLength;
            drawn.line = { blade.line[0] };
            for (double at = kStep; at <= kLength; at += kStep) {
                drawn.line.push_back(blade.line[0] + at * along);
                row.step_ms.push_back(milliseconds([&] { must_be_done(session.extend_stroke(drawn, options)); }));
            }
            row.finish_ms.push_back(milliseconds([&] { must_be_done(session.finish_stroke()); }));
            session.undo();
        }
        return row;
    }

    Json as_json(const char* model, const char* mesh, const Row& row)
    {
        const CutReport& r = row.report;
        return { { "model", model }, { "mesh", mesh }, { "tets", r.tets_before }, { "cut_elements", r.tets_crossed },
            { "mean_increase", r.mean_increase() },
            { "created_per_cut_element",
                static_cast<double>(r.tets_created) / static_cast<double>(std::max<std::size_t>(1, r.tets_crossed)) },
            { "min_dihedral_before_deg", r.worst_dihedral_before_deg }, { "min_dihedral_deg", r.worst_dihedral_deg },
            { "p01_dihedral_deg", r.p01_dihedral_deg }, { "lip_to_blade_max", r.lip_to_blade },
            { "surface_deviation_max", r.surface_deviation }, { "smallest_volume_ratio", r.smallest_volume_ratio },
            { "stroke_ms", percentile(row.stroke_ms, 0.5) }, { "step_ms_median", percentile(row.step_ms, 0.5) },
            { "step_ms_p95", percentile(row.step_ms, 0.95) }, { "finish_ms", percentile(row.finish_ms, 0.5) },
            { "undo_ms", percentile(row.undo_ms, 0.5) } };
    }

    std::string as_text(const Json& row)
    {
        std::array<char, 256> line {};
        std::snprintf(line.data(), line.size(),
            "%-10s %-5s %8zu %6zu %9.2f %8.1f %8.1f %8.1f %9.3f %8.2f %8.2f %8.2f\n",
            row["model"].get<std::string>().c_str(), row["mesh"].get<std::string>().c_str(),
            row["tets"].get<std::size_t>(), row["cut_elements"].get<std::size_t>(), row["mean_increase"].get<double>(),
            row["min_dihedral_before_deg"].get<double>(), row["min_dihedral_deg"].get<double>(),
            row["p01_dihedral_deg"].get<double>(), row["lip_to_blade_max"].get<double>(),
            row["stroke_ms"].get<double>(), row["step_ms_median"].get<double>(), row["step_ms_p95"].get<double>());
        return line.data();
    }

} // namespace

Outcome bench_cut(const CutBenchOptions& options, const Job& job)
{
    Outcome outcome;
    Json rows = Json::array();
    outcome.text
        = "model      mesh      tets    cut  increase  min deg   min deg p01 deg  lip off   stroke   step    step\n"
          "                            elements           before                     (edges)       ms  median     "
          "p95\n";
    const std::size_t boxes = options.largest ? kBoxes.size() : kBoxes.size() - 1;
    for (std::size_t b = 0; b < boxes; ++b) {
        const BenchBox& box = kBoxes[b];
        CutSession session(kuhn_box(box.cells[0], box.cells[1], box.cells[2], kSpacing));
        for (const CutModel& model : cut_models()) {
            job.report("bench cut", static_cast<double>(b) / static_cast<double>(boxes));
            rows.push_back(
                as_json(model.name, box.name, run_row(session, bench_blade(box), model.options, options.repeats, job)));
            outcome.text += as_text(rows.back());
            if (job.cancelled()) {
                outcome.text += "cancelled\n";
                outcome.exit_code = 1;
                outcome.document["results"] = rows;
                return outcome;
            }
        }
    }
    outcome.document["results"] = rows;
    return outcome;
}

} // namespace retractor::cli
