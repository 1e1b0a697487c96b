// The long run of the cut fuzzer: seeds of one body, or of all in turn. Prints each failure with its seed, progress
// with the seed to go on from, and a table at the end (also as JSON). Ends with 1 when an invariant was
// broken, with 3 when nothing was run.

#include "tests/fuzz/cut_fuzz.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace {

using namespace retractor;
using namespace retractor::fuzz;
using namespace retractor::fuzz;

constexpr const char* kUsage
    = "usage: cut_fuzzer [--from SEED] [--to SEED] [--body NAME] [--twice-every N] [--minutes M] [--quiet]\n"
      "                  [--strokes N] [--out FILE.json]\n       NAME is a body or \"all\"\n";
constexpr std::uint64_t kReportEvery = 100;
constexpr int kNothingRun = 3; // the exit code

struct Options {
    std::uint64_t from = 0, to = 1000, twice_every = 10, minutes = 0, strokes = 0;
    std::string body = "box", out;
    bool quiet = false;
};

Options parse(int argc, char** argv)
{
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string_view name = argv[i];
        if (name == "--quiet") {
            options.quiet = true;
            continue;
        }
        if (i + 1 >= argc)
            throw InputError(kUsage);
        const std::string_view value = argv[++i];
        if (name == "--body" || name == "--out") {
            (name == "--body" ? options.body : options.out) = value;
            continue;
        }
        std::uint64_t* target = name == "--from" ? &options.from
            : name == "--to"                     ? &options.to
            : name == "--twice-every"            ? &options.twice_every
            : name == "--minutes"                ? &options.minutes
            : name == "--strokes"                ? &options.strokes
                                                 : nullptr;
        if (target == nullptr
            || std::from_chars(value.data(), value.data() + value.size(), *target).ptr != value.data() + value.size())
            throw InputError(kUsage, std::string(name));
    }
    return options;
}

double percentile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(const std::string& body, const std::string& snap, const Tally& t)
{
    std::size_t refused = 0, flat = 0;
    for (const auto& [reason, count] : t.refused)
        refused += count;
    for (const auto& [cause, count] : t.flat)
        flat += count;
    std::printf(
        "%-9s snap %-5s strokes %6zu done %6zu missed %5zu refused %5zu | increase %5.2f | worst dihedral p1 %5.2f "
        "p10 %5.2f median %5.2f | p01 dihedral p1 %5.2f p10 %5.2f median %5.2f | below 5 deg %6.2f per 1000 of %zu",
        body.c_str(), snap.c_str(), t.strokes, t.done, t.missed, refused,
        t.crossed > 0.0 ? t.increase / t.crossed : 0.0, percentile(t.worst, 0.01), percentile(t.worst, 0.1),
        percentile(t.worst, 0.5), percentile(t.p01, 0.01), percentile(t.p01, 0.1), percentile(t.p01, 0.5),
        t.born > 0 ? 1000.0 * static_cast<double>(flat) / static_cast<double>(t.born) : 0.0, t.born);
    for (const auto& [cause, count] : t.flat)
        std::printf(" %s %zu", cause.c_str(), count);
    std::printf(" | slowest %.3f s mean %.2f ms\n", t.slowest,
        t.done > 0 ? 1000.0 * t.seconds / static_cast<double>(t.done) : 0.0);
}

void print_counts(const char* what, const std::map<std::string, std::size_t>& counts, std::size_t strokes)
{
    for (const auto& [name, count] : counts)
        std::printf("  %s %6zu (%.2f per 1000 strokes): %s\n", what, count,
            1000.0 * static_cast<double>(count) / static_cast<double>(strokes), name.c_str());
}

/// Bodies in turn, four seeds (one of each snap) at a time; large ones less often, as they take longer.
constexpr std::uint64_t kSmall = 4, kLarge = 1;
constexpr std::size_t kLargeFrom = 10000; // elements

struct Run {
    std::vector<Body> bodies;
    std::vector<std::size_t> schedule; ///< body per four seeds
    std::map<std::string, std::array<Tally, kSnaps.size()>> tallies; ///< per body, by snap
};

/// False, with a message, when the body is missing.
bool usable(const Body& body)
{
    if (!body.missing.empty()) {
        std::printf("SKIPPED %s: %s\n", body.name.c_str(), body.missing.c_str());
        return false;
    }
    Findings findings;
    check_sound(State(mesh::CutSession(body.mesh)), findings);
    if (!findings.empty()) {
        std::printf("SKIPPED %s: not a body: %s: %s\n", body.name.c_str(), findings.front().invariant.c_str(),
            findings.front().detail.c_str());
        return false;
    }
    std::printf("%s: %zu elements, mean edge %.2f mm\n", body.name.c_str(), body.mesh.tet_count(), body.edge);
    return true;
}

Run prepare(const std::string& name)
{
    Run run;
    for (const std::string& each : name == "all" ? body_names() : std::vector<std::string> { name }) {
        Body body = make_body(each);
        if (!usable(body))
            continue;
        const std::uint64_t share = body.mesh.tet_count() < kLargeFrom ? kSmall : kLarge;
        run.schedule.insert(run.schedule.end(), share, run.bodies.size());
        run.bodies.push_back(std::move(body));
    }
    return run;
}

nlohmann::json as_json(const Tally& t)
{
    nlohmann::json json { { "strokes", t.strokes }, { "done", t.done }, { "missed", t.missed },
        { "mean_increase", t.crossed > 0.0 ? t.increase / t.crossed : 0.0 },
        { "worst_dihedral_p10_deg", percentile(t.worst, 0.1) },
        { "worst_dihedral_median_deg", percentile(t.worst, 0.5) }, { "p01_dihedral_p10_deg", percentile(t.p01, 0.1) },
        { "p01_dihedral_median_deg", percentile(t.p01, 0.5) }, { "elements_born", t.born }, { "slowest_s", t.slowest },
        { "mean_ms", t.done > 0 ? 1000.0 * t.seconds / static_cast<double>(t.done) : 0.0 } };
    json["refused"] = t.refused;
    for (const auto& [attempt, count] : t.attempts)
        json["attempts"][std::to_string(attempt)] = count;
    json["refused_steps"] = t.refused_steps;
    json["ablations"] = t.ablations;
    json["elements_ablated"] = t.ablated;
    json["broken"] = t.broken;
    json["below_5_deg"] = t.flat;
    return json;
}

/// The table, and the file if one is asked for. True when nothing was broken.
bool finish(const Run& run, const Options& options, std::uint64_t next)
{
    std::printf("next: --from %llu\n", static_cast<unsigned long long>(next));
    nlohmann::json json { { "from", options.from }, { "next", next }, { "bodies", nlohmann::json::object() } };
    Tally total, snapped; // snapped: where vertices may move at all
    for (const auto& [name, tallies] : run.tallies) {
        Tally all;
        for (std::size_t i = 0; i < kSnaps.size(); ++i) {
            char snap[16];
            std::snprintf(snap, sizeof snap, "%.2f", kSnaps[i]);
            print(name, snap, tallies[i]);
            json["bodies"][name]["snap_" + std::string(snap)] = as_json(tallies[i]);
            all.add(tallies[i]);
            if (kSnaps[i] > 0.0)
                snapped.add(tallies[i]);
        }
        print(name, "all", all);
        json["bodies"][name]["all"] = as_json(all);
        total.add(all);
    }
    print("total", "all", total);
    json["total"] = as_json(total);
    print("total", "> 0", snapped);
    json["total_snapped"] = as_json(snapped);
    print_counts("refused", total.refused, total.strokes);
    print_counts("broken ", total.broken, total.strokes);
    for (const auto& [attempt, count] : total.attempts)
        if (attempt > 1)
            std::printf("  done at attempt %d: %zu (%.2f per 1000 strokes)\n", attempt, count,
                1000.0 * static_cast<double>(count) / static_cast<double>(total.strokes));
    std::printf("  refused steps of freehand strokes %zu\n", total.refused_steps);
    std::printf("  ablations %zu, elements %zu\n", total.ablations, total.ablated);
    if (!options.out.empty())
        write_file_atomically(options.out, json.dump(2) + "\n");
    return total.broken.empty();
}

int run(const Options& options)
{
    Run run = prepare(options.body);
    if (run.bodies.empty()) {
        std::fprintf(stderr, "nothing was run: no body can be used\n");
        return kNothingRun;
    }
    const auto start = std::chrono::steady_clock::now();
    const auto late = [&] {
        return options.minutes > 0 && std::chrono::steady_clock::now() - start > std::chrono::minutes(options.minutes);
    };
    const std::uint64_t to
        = options.strokes > 0 ? options.from + (options.strokes + kStrokesPerSeed - 1) / kStrokesPerSeed : options.to;
    std::uint64_t seed = options.from;
    std::size_t failed = 0;
    for (; seed < to && !late(); ++seed) {
        const Body& body = run.bodies[run.schedule[seed / kSnaps.size() % run.schedule.size()]];
        const SeedResult result = run_seed(body, seed, options.twice_every > 0 && seed % options.twice_every == 0);
        run.tallies[body.name][seed % kSnaps.size()].add(result.tally);
        failed += result.failures.size();
        for (const std::string& failure : result.failures)
            if (!options.quiet)
                std::printf("FAILED --body %s --from %llu --to %llu: %s\n", body.name.c_str(),
                    static_cast<unsigned long long>(seed), static_cast<unsigned long long>(seed + 1), failure.c_str());
        for (const std::string& refusal : result.refusals)
            if (!options.quiet)
                std::printf("refused --body %s --from %llu: %s\n", body.name.c_str(),
                    static_cast<unsigned long long>(seed), refusal.c_str());
        for (const std::string& slow : result.slow)
            if (!options.quiet)
                std::printf("slow --body %s --from %llu: %s\n", body.name.c_str(),
                    static_cast<unsigned long long>(seed), slow.c_str());
        if ((seed + 1) % kReportEvery == 0)
            std::printf("at --from %llu, %zu failures\n", static_cast<unsigned long long>(seed + 1), failed);
        std::fflush(stdout);
    }
    const bool sound = finish(run, options, seed);
    if (seed == options.from) {
        std::fprintf(stderr, "nothing was run: there is no seed from %llu to %llu\n",
            static_cast<unsigned long long>(options.from), static_cast<unsigned long long>(to));
        return kNothingRun;
    }
    return sound ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    try {
        return run(parse(argc, argv));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
