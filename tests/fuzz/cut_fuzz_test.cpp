// The short run of the cut fuzzer, and the seeds that once broke a promise.

#include "tests/fuzz/cut_fuzz.h"

#include <gtest/gtest.h>

namespace retractor::fuzz {
namespace {

    struct Range {
        const char* body;
        std::uint64_t from, to;
    };

    void expect_no_failure(const Range& range)
    {
        const Body body = make_body(range.body);
        if (!body.missing.empty())
            GTEST_SKIP() << body.missing;
        Tally all;
        for (std::uint64_t seed = range.from; seed < range.to; ++seed) {
            const SeedResult result = run_seed(body, seed, seed % 10 == 0);
            for (const std::string& failure : result.failures)
                ADD_FAILURE() << range.body << " seed " << seed << ": " << failure;
            all.add(result.tally);
        }
        EXPECT_GT(all.done, all.strokes / 2) << "most strokes miss: little is tested";
    }

    TEST(CutFuzz, Box) { expect_no_failure({ "box", 0, 60 }); }
    TEST(CutFuzz, Liver) { expect_no_failure({ "liver", 0, 40 }); }

} // namespace
} // namespace retractor::fuzz
