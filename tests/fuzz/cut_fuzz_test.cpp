// The short run of the cut fuzzer, and the seeds that once broke a promise.

#include "tests/fuzz/cut_fuzz.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>

namespace retractor::fuzz {
namespace {

    /// Two promises are not kept by all strokes yet: some stay more than 0.1 local edges short of the blade somewhere
    /// (the wound's corner lies in slivers), or carry a curved surface a little further than 0.05 local edges (its
    /// normals turn while vertices move one after the other). All others are kept by every stroke.
    constexpr double kShare = 0.02;
    constexpr std::array<const char*, 2> kNotAlways { "not too short", "surface kept" };

    bool may_happen(const std::string& failure)
    {
        return std::any_of(kNotAlways.begin(), kNotAlways.end(),
            [&](const char* name) { return failure.find(name) != std::string::npos; });
    }

    struct Range {
        const char* body;
        std::uint64_t from, to;
    };

    void expect_sound(const Range& range)
    {
        const Body body = make_body(range.body);
        if (!body.missing.empty())
            GTEST_SKIP() << body.missing;
        Tally all;
        for (std::uint64_t seed = range.from; seed < range.to; ++seed) {
            const SeedResult result = run_seed(body, seed, seed % 10 == 0);
            for (const std::string& failure : result.failures)
                if (!may_happen(failure))
                    ADD_FAILURE() << range.body << " seed " << seed << ": " << failure;
            all.add(result.tally);
        }
        EXPECT_GE(2 * all.done + 1, all.strokes) << "most strokes miss: little is tested";
        for (const char* name : kNotAlways)
            EXPECT_LE(static_cast<double>(all.broken[name]), 1.0 + kShare * static_cast<double>(all.strokes)) << name;
    }

    TEST(CutFuzz, Box) { expect_sound({ "box", 0, 30 }); }
    TEST(CutFuzz, Liver) { expect_sound({ "liver", 0, 20 }); }

    TEST(CutFuzz, SeedsThatOnceBrokeAPromise)
    {
        // Lips lost their tags when a short edge was contracted; a vertex left the surface at the border of a bent
        // blade; a freehand step cut one lip of the step before again, or left its end hanging on an edge; a cut
        // without a wound was called done.
        constexpr std::array<std::pair<const char*, std::uint64_t>, 7> kSeeds { { { "box", 119 }, { "box", 104 },
            { "box", 112 }, { "box", 74 }, { "box", 111 }, { "liver", 38 }, { "sphere", 5 } } };
        for (const auto& [body, seed] : kSeeds)
            expect_sound({ body, seed, seed + 1 });
    }

} // namespace
} // namespace retractor::fuzz
