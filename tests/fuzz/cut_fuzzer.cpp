// The long run of the cut fuzzer: seeds of one body, or of all in turn. Prints each failure with its seed, progress
// with the seed to go on from, and a table at the end. Ends with 1 when an invariant was broken.

#include "tests/fuzz/cut_fuzz.h"

#include "mesh/base/error.h"

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

constexpr const char* kUsage
    = "usage: cut_fuzzer [--from SEED] [--to SEED] [--body NAME] [--twice-every N] [--minutes M] [--quiet]\n";
constexpr std::uint64_t kReportEvery = 1000;

struct Options {
    std::uint64_t from = 0, to = 1000, twice_every = 10, minutes = 0;
    std::string body = "box";
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
        if (name == "--body") {
            options.body = value;
            continue;
        }
        std::uint64_t* target = name == "--from" ? &options.from
            : name == "--to"                     ? &options.to
            : name == "--twice-every"            ? &options.twice_every
            : name == "--minutes"                ? &options.minutes
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

int run(const Options& options)
{
    const Body body = make_body(options.body);
    if (!body.missing.empty()) {
        std::printf("SKIPPED %s: %s\n", options.body.c_str(), body.missing.c_str());
        return 0;
    }
    Findings findings;
    check_sound(State(CutSession(body.mesh)), findings);
    if (!findings.empty()) {
        std::printf("SKIPPED %s: not a body: %s: %s\n", options.body.c_str(), findings.front().invariant.c_str(),
            findings.front().detail.c_str());
        return 0;
    }
    std::printf("%s: %zu elements, mean edge %.2f mm\n", body.name.c_str(), body.mesh.tet_count(), body.edge);
    const auto start = std::chrono::steady_clock::now();
    std::array<Tally, kSnaps.size()> tallies;
    std::uint64_t seed = options.from;
    for (; seed < options.to; ++seed) {
        const SeedResult result = run_seed(body, seed, options.twice_every > 0 && seed % options.twice_every == 0);
        tallies[seed % kSnaps.size()].add(result.tally);
        if (!options.quiet)
            for (const std::string& failure : result.failures)
                std::printf("FAILED --body %s --from %llu --to %llu: %s\n", body.name.c_str(),
                    static_cast<unsigned long long>(seed), static_cast<unsigned long long>(seed + 1), failure.c_str());
        if ((seed + 1) % kReportEvery == 0) {
            std::printf("at --from %llu\n", static_cast<unsigned long long>(seed + 1));
            std::fflush(stdout);
        }
        if (options.minutes > 0 && std::chrono::steady_clock::now() - start > std::chrono::minutes(options.minutes))
            break;
    }
    std::printf("next: --from %llu\n", static_cast<unsigned long long>(std::min(seed + 1, options.to)));
    Tally all;
    for (std::size_t i = 0; i < kSnaps.size(); ++i) {
        char snap[16];
        std::snprintf(snap, sizeof snap, "%.2f", kSnaps[i]);
        print(body.name, snap, tallies[i]);
        all.add(tallies[i]);
    }
    print(body.name, "all", all);
    print_counts("refused", all.refused, all.strokes);
    print_counts("broken ", all.broken, all.strokes);
    return all.broken.empty() ? 0 : 1;
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
