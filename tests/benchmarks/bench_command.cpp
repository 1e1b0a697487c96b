#include "tests/benchmarks/bench_command.h"

#include "tests/benchmarks/cutting/bench_cut.h"
#include "tests/benchmarks/cutting/bench_soak.h"
#include "tests/benchmarks/opening/bench_gape.h"
#include "tests/benchmarks/opening/bench_open.h"
#include "tests/benchmarks/palpation/bench_palpate.h"
#include "tests/benchmarks/palpation/bench_servo.h"
#include "tests/benchmarks/palpation/bench_spheres.h"
#include "tests/benchmarks/palpation/bench_springs.h"
#include "tests/benchmarks/segmentation/bench_segment.h"
#include "ui/cli/framework/number_range.h"

#include <CLI/CLI.hpp>

#include <memory>

namespace retractor::benchmarks {

namespace {

    void add_palpate_bench(ui::cli::Commands& commands)
    {
        auto options = std::make_shared<PalpateBenchOptions>();
        CLI::App* command = commands.app.add_subcommand(
            "palpate", "Fingers on a beating aorta: time per tick, whole surface, and error beside it");
        command->footer("Example: retractor-bench palpate --out palpate");
        command->add_option("--out", options->out, "Folder for bench_palpate.json and the plot of error against time");
        command->add_option("--ticks", options->ticks, "Timed ticks per row")
            ->check(CLI::Range(1000, 10000000))
            ->capture_default_str();
        command->add_option("--seconds", options->seconds, "Of each run at 1 kHz; 0: none")
            ->check(ui::cli::in_range(0.0, 3600.0))
            ->capture_default_str();
        command->add_flag("!--small", options->largest, "Without the body of 20,000 surface vertices");
        command->callback([&commands, options] {
            commands.run = [options](const Job& job) { return bench_palpate(*options, job); };
        });
    }

    void add_open_benches(ui::cli::Commands& commands)
    {
        const auto add = [&](const char* name, const char* help, auto run) {
            auto options = std::make_shared<OpenBenchOptions>();
            CLI::App* command = commands.app.add_subcommand(name, help);
            command->footer(std::string("Example: retractor-bench ") + name + " --sizes 67k,96k --json");
            command
                ->add_option("--sizes", options->sizes, "Boxes, and the graded chest wall: 12k, 67k, 96k, 175k, thorax")
                ->delimiter(',')
                ->check(CLI::IsMember({ "12k", "67k", "96k", "175k", "thorax" }))
                ->capture_default_str();
            command->add_option("--repeats", options->repeats, "Strokes per box")
                ->check(CLI::Range(1, 1000))
                ->capture_default_str();
            command->add_option("--out", options->out, std::string("Folder for bench_") + name + ".json");
            // hidden: the program passes this option to its child process
            command->add_option("--baseline-to", options->baseline_to)->group("");
            command->callback([&commands, options, run] {
                commands.run = [options, run](const Job& job) { return run(*options, job); };
            });
        };
        add("open", "Wounds that follow the knife: freehand steps and strokes beside a full rebuild", bench_open);
        add("drag", "Wounds that follow the hooks: attaching and dragging", bench_drag);
    }

    void add_springs_bench(ui::cli::Commands& commands)
    {
        auto options = std::make_shared<SpringBenchOptions>();
        CLI::App* command = commands.app.add_subcommand("springs",
            "Mass-spring tissue under a finger: time per tick, frames per second, error against finite elements");
        command->footer("Example: retractor-bench springs --out springs    (curves and pictures of the sheet)");
        command->add_flag("--curves", options->curves, "Instead: frames per second over time of three sheets");
        command->add_option("--seconds", options->seconds, "Of each sheet's curve")
            ->check(ui::cli::in_range(2.0, 3600.0))
            ->capture_default_str();
        command->add_option("--out", options->out, "Folder for bench_springs.json, curves and pictures");
        command->callback([&commands, options] {
            commands.run = [options](const Job& job) { return bench_springs(*options, job); };
        });
    }

    void add_servo_bench(ui::cli::Commands& commands)
    {
        auto options = std::make_shared<ServoBenchOptions>();
        CLI::App* servo = commands.app.add_subcommand("servo",
            "The 1 kHz loop: two simulated hands on tissue while other threads cut and edit, beside an empty loop");
        servo->footer("Example: retractor-bench servo --out servo");
        servo->add_option("--model", options->model, "The beating aorta (fem) or the sheet (springs)")
            ->check(CLI::IsMember({ "fem", "springs" }))
            ->capture_default_str();
        servo->add_option("--seconds", options->seconds, "Of the servo, and of the empty loop")
            ->check(ui::cli::in_range(0.5, 80.0))
            ->capture_default_str();
        servo->add_option("--soak", options->soak, "Instead: so many ticks at 1 kHz, without other work")
            ->check(CLI::Range(1000, 100000000));
        servo->add_flag("!--no-load", options->load, "Without cutting and editing meanwhile");
        servo->add_option("--out", options->out, "Folder for bench_servo.json and the histograms (servo.png)");
        servo->callback(
            [&commands, options] { commands.run = [options](const Job& job) { return bench_servo(*options, job); }; });
    }

    void add_spheres_bench(ui::cli::Commands& commands)
    {
        auto options = std::make_shared<SphereBenchOptions>();
        CLI::App* command = commands.app.add_subcommand("spheres",
            "Sphere-filled organs under fingers: frames against spheres, layers and fingers; volume and force");
        command->footer("Example: retractor-bench spheres --out spheres    (liver and abdomen pressed, as pictures)");
        command->add_option("--surface", options->surface, "A liver as a closed OBJ surface instead of the phantom's")
            ->check(CLI::ExistingFile);
        command->add_option("--unit", options->unit_mm, "What one unit of that file is, mm")
            ->check(CLI::PositiveNumber)
            ->capture_default_str();
        command->add_option("--out", options->out, "Folder for bench_spheres.json and the pictures");
        command->callback([&commands, options] {
            commands.run = [options](const Job& job) { return bench_spheres(*options, job); };
        });
    }

    void add_segment_bench(ui::cli::Commands& commands)
    {
        auto options = std::make_shared<SegmentBenchOptions>();
        CLI::App* command = commands.app.add_subcommand(
            "segment", "Labels found in phantoms of a chest: overlap with the truth, by shape, noise and resolution");
        command->footer("Example: retractor-bench segment --out segment");
        command->add_flag("--quick", options->quick, "One phantom on a coarse grid");
        command->add_option("--out", options->out, "Folder for bench_segment.json");
        command->callback([&commands, options] {
            commands.run = [options](const Job& job) { return bench_segment(*options, job); };
        });
    }

} // namespace

void add_benchmarks(ui::cli::Commands& commands)
{
    commands.app.require_subcommand(1);
    auto options = std::make_shared<CutBenchOptions>();
    CLI::App* cut
        = commands.app.add_subcommand("cut", "The knife: elements made, their angles, time per stroke and step");
    cut->footer("Example: retractor-bench cut --json");
    cut->add_option("--repeats", options->repeats, "Strokes per row")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    cut->add_flag("!--small", options->largest, "Without the box of a million elements");
    cut->add_flag("!--no-thorax", options->thorax, "Without the graded chest wall, whose meshing takes some seconds");
    cut->add_option("--out", options->out, "Folder for bench_cut.json");
    auto soak = std::make_shared<SoakOptions>();
    CLI::Option* cuts = cut->add_option("--soak", soak->cuts, "Instead: so many cuts in a row on one body, undo, redo")
                            ->check(CLI::Range(10, 100000));
    cut->add_option("--soak-body", soak->body, "The body: thorax, 12k, 96k or 1M")
        ->check(CLI::IsMember({ "thorax", "12k", "96k", "1M" }))
        ->capture_default_str();
    cut->add_option("--seed", soak->seed, "Of the soak's places")->capture_default_str();
    cut->callback([&commands, options, soak, cuts] {
        const bool soaks = cuts->count() > 0;
        commands.run = [options, soak, soaks](
                           const Job& job) { return soaks ? soak_cut(*soak, job) : bench_cut(*options, job); };
    });
    auto gape_options = std::make_shared<GapeBenchOptions>();
    CLI::App* gape = commands.app.add_subcommand(
        "gape", "A cut under 2, 4 and 6 % tension: springs, finite elements, closed form");
    gape->footer("Example: retractor-bench gape --out gape    (pictures of a wound on the thorax phantom)");
    gape->add_flag("--quick", gape_options->quick, "One mesh only");
    gape->add_option("--out", gape_options->out, "Folder for bench_gape.json and the pictures");
    gape->callback([&commands, gape_options] {
        commands.run = [gape_options](const Job& job) { return bench_gape(*gape_options, job); };
    });
    add_open_benches(commands);
    add_springs_bench(commands);
    add_servo_bench(commands);
    add_palpate_bench(commands);
    add_spheres_bench(commands);
    add_segment_bench(commands);
}

} // namespace retractor::benchmarks
