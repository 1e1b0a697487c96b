#include "tests/benchmarks/opening/bench_open.h"

#include "fem/interactive/online_opening.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "tests/benchmarks/framework/bench_bodies.h"
#include "tests/benchmarks/framework/bench_numbers.h"
#include "tests/benchmarks/framework/process_status.h"
#include "tests/benchmarks/opening/bench_nonlinear.h"
#include "tests/benchmarks/opening/full_rebuild.h"
#include "tests/benchmarks/opening/open_scene.h"
#include "tests/support/temporary_folder.h"
#include "ui/cli/framework/run_program.h"

#include <malloc.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace retractor::benchmarks {

namespace {

    namespace fs = std::filesystem;

    // freehand steps after which the whole field is compared
    constexpr std::array<std::size_t, 3> kCheckedSteps { 4, 11, 20 };

    constexpr int kThoraxStrokes = 2;

    /// Memory that is freed is kept, not handed back to the system and fetched again page by page: a full rebuild is a
    /// third faster, and online answers are no slower. Holds for the whole process.
    void keep_freed_memory()
    {
        constexpr int kLarge = 1 << 30;
        ::mallopt(M_MMAP_MAX, 0); // a threshold would not do: beyond 32 MB it is not heeded
        ::mallopt(M_TRIM_THRESHOLD, kLarge);
    }

    mesh::MeshDelta done(mesh::CutResult result)
    {
        if (result.status != mesh::CutStatus::done)
            throw SolverError("the bench's cut was not made: " + result.message);
        return std::move(result.delta);
    }

    void must_be_solved(const fem::OnlineAnswer& answer)
    {
        if (answer.status != fem::OnlineStatus::solved)
            throw SolverError("the bench's wound was not opened: " + answer.message);
    }

    fs::path field_file(const fs::path& folder, std::size_t step)
    {
        return folder / (step == 0 ? std::string("stroke") : "step" + std::to_string(step));
    }

    void write_field(const fs::path& file, const Eigen::VectorXd& field)
    {
        std::ofstream out(file, std::ios::binary);
        out.write(reinterpret_cast<const char*>(field.data()),
            static_cast<std::streamsize>(static_cast<std::size_t>(field.size()) * sizeof(double)));
        if (!out)
            throw IoError("a field could not be written", file.string());
    }

    Eigen::VectorXd read_field(const fs::path& file)
    {
        std::ifstream in(file, std::ios::binary);
        const std::string bytes { std::istreambuf_iterator<char>(in), {} };
        Eigen::VectorXd field(static_cast<Eigen::Index>(bytes.size() / sizeof(double)));
        std::copy_n(bytes.data(), static_cast<std::size_t>(field.size()) * sizeof(double),
            reinterpret_cast<char*>(field.data()));
        if (!in || field.size() == 0)
            throw IoError("a field of the baseline could not be read", file.string());
        return field;
    }

    /// Operations of the factor of the 96k box in GFlop, as counted by CHOLMOD. The factor may take 1.3 times as long
    /// as a matrix product of as many operations, which is 77 % of the product's speed.
    constexpr double kFactorGflop96k = 22.5;

    /// Stiffness of the beds by vertex. Vertices that cuts add have no bed.
    std::vector<double> beds(const OpenScene& scene, const fem::OnlineStiffness& K)
    {
        std::vector<double> stiffness(K.slot_count(), 0.0);
        for (const fem::BeddedVertex& bed : scene.supports.bedded)
            stiffness[static_cast<std::size_t>(bed.vertex)] = bed.stiffness;
        return stiffness;
    }

    /// The child process: the same strokes, where each state of interest is assembled and factorised from nothing.
    ui::cli::Outcome baseline(const OpenBenchOptions& options, const Job& job)
    {
        const OpenScene scene = open_scene(options.sizes.at(0), job);
        std::vector<double> total, assemble, analyse, factor, solve;
        const auto rebuild = [&](const mesh::CutSession& session, std::size_t step, int repeats) {
            fem::OnlineStiffness K(session, scene.materials);
            K.set_bed(beds(scene, K));
            // threads as in the rest of the benchmark
            FullRebuild full(K, scene.supports.fixed, scene.hooks, std::min(job.threads, 2));
            for (int i = 0; i < repeats && !job.cancelled(); ++i) {
                full.run();
                assemble.push_back(full.assemble_ms);
                analyse.push_back(full.analyse_ms);
                factor.push_back(full.factor_ms);
                solve.push_back(full.solve_ms);
                total.push_back(full.total_ms());
            }
            write_field(field_file(options.baseline_to, step), full.solution());
        };
        double gemm = full_rebuild_gemm_gflops();
        mesh::CutSession session(scene.mesh);
        done(session.cut(scene.blade, scene.cut));
        rebuild(session, 0, options.repeats);
        session.undo();
        for (std::size_t step = 1; step < scene.blade.line.size(); ++step) {
            done(session.extend_stroke(beginning(scene.blade, step + 1), scene.cut));
            if (std::find(kCheckedSteps.begin(), kCheckedSteps.end(), step) != kCheckedSteps.end())
                rebuild(session, step, 1);
        }
        // Other programs may have slowed the first measurement, so the fastest times of both are compared.
        gemm = std::max(gemm, full_rebuild_gemm_gflops());
        ui::cli::Outcome outcome;
        outcome.document = { { "full_rebuild_ms_median", median(total) },
            { "full_rebuild_ms_p95", percentile(total, 0.95) }, { "baseline_assemble_ms", median(assemble) },
            { "baseline_analyse_ms", median(analyse) }, { "baseline_factor_ms", median(factor) },
            { "baseline_factor_ms_least", factor.empty() ? 0.0 : *std::min_element(factor.begin(), factor.end()) },
            { "baseline_solve_ms", median(solve) }, { "baseline_gemm_gflops", gemm } };
        return outcome;
    }

    /// Runs the child process and reads its output.
    ui::cli::Json run_baseline(
        const std::string& size, const fs::path& folder, const OpenBenchOptions& options, const Job& job)
    {
        const std::string self = fs::read_symlink("/proc/self/exe").string();
        const ui::cli::ProgramRun run = ui::cli::run_program(
            { self, "--json", "--threads", std::to_string(job.threads), "open", "--sizes", size, "--repeats",
                std::to_string(std::min(options.repeats, 5)), "--baseline-to", folder.string() },
            std::chrono::minutes(5));
        if (run.exit_code != 0)
            throw SolverError("the baseline's process failed", run.out);
        return ui::cli::Json::parse(run.out);
    }

    /// Vertices that the planned cut touches, in one cut or freehand. The cut is rehearsed on the session and undone.
    std::vector<VertexId> rehearsed_corridor(mesh::CutSession& session, const OpenScene& scene)
    {
        fem::OnlineStiffness K(session, scene.materials);
        std::vector<VertexId> corridor = K.touched_by(done(session.cut(scene.blade, scene.cut)));
        session.undo();
        const std::size_t planned = K.slot_count();
        for (std::size_t step = 1; step < scene.blade.line.size(); ++step) {
            const mesh::MeshDelta delta = done(session.extend_stroke(beginning(scene.blade, step + 1), scene.cut));
            const std::vector<VertexId> touched = K.touched_by(delta);
            corridor.insert(corridor.end(), touched.begin(), touched.end());
            K.apply(delta);
        }
        done(session.finish_stroke());
        session.undo();
        for (const fem::OnlineHook& hook : scene.hooks)
            corridor.insert(corridor.end(), hook.nodes.begin(), hook.nodes.end());
        std::sort(corridor.begin(), corridor.end());
        corridor.erase(std::unique(corridor.begin(), corridor.end()), corridor.end());
        std::erase_if(corridor, [&](VertexId v) { return v >= static_cast<VertexId>(planned); });
        return corridor;
    }

    struct Times {
        std::vector<double> cut, corridor, total, dense_route;
    };

    /// Measures the time from the blade to the deformed frame, including whole field and residual.
    fem::OnlineAnswer timed_change(
        fem::OnlineOpening& opening, Times& times, const std::function<mesh::MeshDelta()>& cut)
    {
        const Stopwatch watch;
        const mesh::MeshDelta delta = cut();
        times.cut.push_back(1e3 * watch.seconds());
        opening.follow(delta);
        fem::OnlineAnswer answer = opening.answer();
        times.corridor.push_back(1e3 * watch.seconds());
        opening.complete(answer);
        times.total.push_back(1e3 * watch.seconds());
        times.dense_route.push_back(opening.route() == "dense" ? 1.0 : 0.0);
        must_be_solved(answer);
        return answer;
    }

    std::vector<double> drag_frames(fem::OnlineOpening& opening, std::size_t hooks)
    {
        constexpr int kFrames = 200;
        std::vector<double> ms;
        double sum = 0.0; // uses the frame, so that the compiler keeps it
        for (int frame = 0; frame < kFrames; ++frame) {
            std::vector<Vec3> moved;
            for (std::size_t h = 0; h < hooks; ++h)
                moved.push_back(Vec3(0.1 * frame, (h % 2 == 0 ? 0.05 : -0.05) * frame, 0.01));
            ms.push_back(milliseconds([&] { sum += opening.drag(moved)[3]; }));
        }
        if (!std::isfinite(sum))
            throw SolverError("a dragged frame is not finite");
        return ms;
    }

    /// Measures attaching one more hook until it can be dragged, and dragging with 8 and 4 hooks.
    void measure_hooks(fem::OnlineOpening& opening, const OpenScene& scene, std::vector<fem::HookId> ids, int repeats,
        ui::cli::Json& row)
    {
        std::vector<double> attach, first;
        double worst = 0.0;
        for (int i = 0; i < repeats; ++i) {
            opening.detach(ids.back());
            worst = std::max(worst, opening.prepare_drag());
            ids.pop_back();
            const Stopwatch watch;
            ids.push_back(opening.attach(scene.hooks.back()));
            fem::OnlineAnswer answer = opening.answer();
            opening.complete(answer);
            first.push_back(1e3 * watch.seconds());
            must_be_solved(answer);
            attach.push_back(milliseconds([&] { worst = std::max(worst, opening.prepare_drag()); }));
        }
        row["attach_ms"] = median(first);
        row["columns_ms"] = median(attach);
        row["drag_residual"] = worst;
        row["drag_ms_8"] = median(drag_frames(opening, ids.size()));
        row["drag_ms_8_p95"] = percentile(drag_frames(opening, ids.size()), 0.95);
        row["solver_mb"] = static_cast<double>(opening.bytes()) / 1e6; // including all memory of a steady state
        while (ids.size() > kOpenSceneHooks / 2) {
            opening.detach(ids.back());
            ids.pop_back();
        }
        opening.prepare_drag();
        row["drag_ms_4"] = median(drag_frames(opening, ids.size()));
        row["drag_ms_4_p95"] = percentile(drag_frames(opening, ids.size()), 0.95);
    }

    struct OpenedScene {
        mesh::CutSession session;
        std::unique_ptr<fem::OnlineOpening> opening;
        std::vector<fem::HookId> ids;
    };

    OpenedScene lay_out(const OpenScene& scene, ui::cli::Json& row)
    {
        OpenedScene opened { mesh::CutSession(scene.mesh), nullptr, {} };
        std::vector<VertexId> corridor;
        row["rehearse_ms"] = milliseconds([&] { corridor = rehearsed_corridor(opened.session, scene); });
        row["plan_ms"] = milliseconds([&] {
            opened.opening
                = std::make_unique<fem::OnlineOpening>(opened.session, scene.materials, scene.supports, corridor);
        });
        for (const fem::OnlineHook& hook : scene.hooks)
            opened.ids.push_back(opened.opening->attach(hook));
        fem::OnlineAnswer answer = opened.opening->answer();
        opened.opening->complete(answer);
        must_be_solved(answer);
        return opened;
    }

    double assembly_ms(const OpenScene& scene)
    {
        fem::OnlineStiffness K(mesh::CutSession(scene.mesh), scene.materials);
        std::vector<double> ms;
        constexpr int kTimes = 5;
        for (int i = 0; i < kTimes; ++i)
            ms.push_back(milliseconds([&] { K.assemble(); }));
        return median(ms);
    }

    ui::cli::Json measure_open(
        const OpenScene& scene, const fs::path& folder, const OpenBenchOptions& options, const Job& job)
    {
        ui::cli::Json row { { "mesh", scene.name }, { "tets", scene.mesh.tet_count() },
            { "nodes", scene.mesh.vertex_count() } };
        const ui::cli::Json rebuilt = run_baseline(scene.name, folder, options, job);
        row["assemble_ms"] = assembly_ms(scene);
        OpenedScene opened = lay_out(scene, row);
        fem::OnlineOpening& opening = *opened.opening;
        mesh::CutSession& session = opened.session;
        Times step, stroke;
        double residual = 0.0, step_diff = 0.0, stroke_diff = 0.0;
        int refinements = 0;
        for (int i = 0; i < options.repeats && !job.cancelled(); ++i) {
            for (std::size_t s = 1; s < scene.blade.line.size(); ++s) {
                const fem::OnlineAnswer answer = timed_change(opening, step,
                    [&] { return done(session.extend_stroke(beginning(scene.blade, s + 1), scene.cut)); });
                residual = std::max(residual, answer.residual);
                refinements = std::max(refinements, answer.refinements);
                if (i == 0 && std::find(kCheckedSteps.begin(), kCheckedSteps.end(), s) != kCheckedSteps.end())
                    step_diff = std::max(
                        step_diff, relative_difference(answer.displacement, read_field(field_file(folder, s))));
            }
            opening.follow(done(session.finish_stroke()));
            opening.follow(session.undo());
            const fem::OnlineAnswer answer
                = timed_change(opening, stroke, [&] { return done(session.cut(scene.blade, scene.cut)); });
            residual = std::max(residual, answer.residual);
            refinements = std::max(refinements, answer.refinements);
            if (i == 0)
                stroke_diff = relative_difference(answer.displacement, read_field(field_file(folder, 0)));
            if (i + 1 < options.repeats)
                opening.follow(session.undo());
        }
        row["kept_vertices"] = opening.corridor_vertices();
        const auto put = [&](const std::string& name, const Times& times) {
            row[name + "_ms_median"] = median(times.total);
            row[name + "_ms_p95"] = percentile(times.total, 0.95);
            // corridor, lips and hooks; the condensed region follows
            row[name + "_first_ms_median"] = median(times.corridor);
            row[name + "_first_ms_p95"] = percentile(times.corridor, 0.95);
            row[name + "_cut_ms_median"] = median(times.cut);
            row[name + "_dense_share"] = Eigen::Map<const Eigen::VectorXd>(
                times.dense_route.data(), static_cast<Eigen::Index>(times.dense_route.size()))
                                             .mean();
        };
        put("step", step);
        put("stroke", stroke);
        row.update(rebuilt);
        const double full = rebuilt.at("full_rebuild_ms_median").get<double>();
        row["step_speedup"] = full / median(step.total);
        row["stroke_speedup"] = full / median(stroke.total);
        row["rel_diff"] = std::max(step_diff, stroke_diff);
        row["residual"] = residual;
        if (scene.name == "96k") // speed of the factor, relative to the present speed of the machine
            row["baseline_factor_share"] = 1e-3 * rebuilt.at("baseline_factor_ms_least").get<double>()
                * rebuilt.at("baseline_gemm_gflops").get<double>() / kFactorGflop96k;
        row["refinements"] = refinements;
        measure_hooks(opening, scene, opened.ids, options.repeats, row);
        row["rss_mb"] = status_mb("VmRSS");
        return row;
    }

    void append(std::string& text, const char* format, auto... values)
    {
        std::array<char, 256> line {};
        std::snprintf(line.data(), line.size(), format, values...);
        text += line.data();
    }

    std::string as_text(const ui::cli::Json& row)
    {
        const auto number = [&](const char* key) { return row.at(key).get<double>(); };
        std::string text;
        append(text, "%s: %zu tetrahedra, %zu nodes, %zu vertices in the corridor\n",
            row.at("mesh").get<std::string>().c_str(), row.at("tets").get<std::size_t>(),
            row.at("nodes").get<std::size_t>(), row.at("kept_vertices").get<std::size_t>());
        append(text, "  planning          rehearsal %.0f ms, factor and corridor %.0f ms, once\n",
            number("rehearse_ms"), number("plan_ms"));
        append(text,
            "  full rebuild      %.0f ms (assemble %.1f, analyse %.0f, factor %.0f, solve %.1f; gemm %.0f GFlop/s)\n",
            number("full_rebuild_ms_median"), number("baseline_assemble_ms"), number("baseline_analyse_ms"),
            number("baseline_factor_ms"), number("baseline_solve_ms"), number("baseline_gemm_gflops"));
        if (row.contains("baseline_factor_share"))
            append(text,
                "                    its factor takes %.2f of the reference's time (at most 1.3 where nothing else "
                "runs)\n",
                number("baseline_factor_share"));
        for (const std::string what : { "step", "stroke" })
            append(text,
                "  %-17s field complete %.1f ms, p95 %.1f: %.1f x faster; lips, hooks and corridor answered first, "
                "after "
                "%.1f, p95 %.1f (cut %.1f)\n",
                (what == "step" ? "freehand 5 mm" : "whole stroke"), number((what + "_ms_median").c_str()),
                number((what + "_ms_p95").c_str()), number((what + "_speedup").c_str()),
                number((what + "_first_ms_median").c_str()), number((what + "_first_ms_p95").c_str()),
                number((what + "_cut_ms_median").c_str()));
        append(text, "  difference        %.1e of the largest displacement, whole field; residual %.1e\n",
            number("rel_diff"), number("residual"));
        append(text, "  a hook attached   %.1f ms whole field, %.1f ms more until all can be dragged\n",
            number("attach_ms"), number("columns_ms"));
        append(text, "  drag frame        %.2f ms with 4 hooks, %.2f ms with 8\n", number("drag_ms_4"),
            number("drag_ms_8"));
        append(text, "  assembly          %.1f ms, all elements\n", number("assemble_ms"));
        append(text, "  solver memory     %.0f MB (process %.0f MB)\n", number("solver_mb"), number("rss_mb"));
        return text;
    }

    void save(const OpenBenchOptions& options, const char* name, const ui::cli::Outcome& outcome)
    {
        if (options.out.empty())
            return;
        fs::create_directories(options.out);
        write_file_atomically(fs::path(options.out) / name, outcome.document.dump(2) + "\n");
    }

} // namespace

ui::cli::Outcome bench_open(const OpenBenchOptions& options, const Job& job)
{
    keep_freed_memory(); // the baseline as well
    if (!options.baseline_to.empty())
        return baseline(options, job);
    const test_support::TemporaryFolder folder;
    ui::cli::Outcome outcome;
    outcome.document["results"] = ui::cli::Json::array();
    for (std::size_t i = 0; i < options.sizes.size() && !job.cancelled(); ++i) {
        job.report("bench open", static_cast<double>(i) / static_cast<double>(options.sizes.size()));
        const OpenScene scene = open_scene(options.sizes[i], job);
        OpenBenchOptions of_scene = options;
        if (scene.name == "thorax") // each stroke in the thorax takes seconds
            of_scene.repeats = std::min(options.repeats, kThoraxStrokes);
        ui::cli::Json row = measure_open(scene, folder.path, of_scene, job);
        outcome.text += as_text(row);
        if (scene.name != "thorax") { // required in the boxes only
            const ui::cli::Json nonlinear = measure_nonlinear(scene, job);
            row.update(nonlinear);
            outcome.text += nonlinear_text(row);
        }
        outcome.document["results"].push_back(row);
    }
    if (job.cancelled()) {
        outcome.text += "cancelled\n";
        outcome.exit_code = 1;
    }
    save(options, "bench_open.json", outcome);
    return outcome;
}

ui::cli::Outcome bench_drag(const OpenBenchOptions& options, const Job& job)
{
    keep_freed_memory();
    ui::cli::Outcome outcome;
    outcome.document["results"] = ui::cli::Json::array();
    for (std::size_t i = 0; i < options.sizes.size() && !job.cancelled(); ++i) {
        job.report("bench drag", static_cast<double>(i) / static_cast<double>(options.sizes.size()));
        if (options.sizes[i] == "thorax") {
            outcome.document["results"].push_back(measure_under_hand(job));
            outcome.text += under_hand_text(outcome.document["results"].back());
            continue;
        }
        const OpenScene scene = open_scene_of_box(options.sizes[i]);
        ui::cli::Json row { { "mesh", scene.name }, { "tets", scene.mesh.tet_count() },
            { "nodes", scene.mesh.vertex_count() } };
        OpenedScene opened = lay_out(scene, row);
        opened.opening->follow(done(opened.session.cut(scene.blade, scene.cut)));
        measure_hooks(*opened.opening, scene, opened.ids, options.repeats, row);
        append(outcome.text,
            "%-5s %8zu tetrahedra: drag frame %.2f ms with 4 hooks, %.2f with 8; attaching %.1f ms + columns %.1f ms\n",
            scene.name.c_str(), scene.mesh.tet_count(), row["drag_ms_4"].get<double>(), row["drag_ms_8"].get<double>(),
            row["attach_ms"].get<double>(), row["columns_ms"].get<double>());
        row.update(measure_nonlinear(scene, job));
        outcome.text += nonlinear_text(row);
        outcome.document["results"].push_back(row);
    }
    if (job.cancelled()) {
        outcome.text += "cancelled\n";
        outcome.exit_code = 1;
    }
    save(options, "bench_drag.json", outcome);
    return outcome;
}

} // namespace retractor::benchmarks
