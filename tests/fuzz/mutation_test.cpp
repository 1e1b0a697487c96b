// The deterministic part of fuzzing: a fixed seed, a few thousand damaged files.

#include "tests/fuzz/fuzz_targets.h"
#include "tests/fuzz/mutations.h"

#include <gtest/gtest.h>

#include <exception>
#include <functional>

namespace retractor::fuzz {
namespace mutation_test {

    constexpr int kRounds = 4000; // a few seconds
    constexpr int kMostChanges = 3; // beyond that nearly everything is refused at its first byte

    struct Tally {
        int accepted = 0, refused = 0;
    };

    /// Feeds damaged seeds; a broken guarantee fails the test and shows the text.
    Tally feed_damaged(const std::vector<std::string>& seeds, const std::function<Answer(const std::string&)>& feed,
        const std::function<std::string(const std::string&, std::mt19937_64&)>& damage)
    {
        Tally tally;
        std::mt19937_64 random(20260101);
        for (int round = 0; round < kRounds; ++round) {
            std::string text = seeds[static_cast<std::size_t>(round) % seeds.size()];
            for (int change = 0; change <= round % kMostChanges; ++change)
                text = damage(text, random);
            try {
                ++(feed(text) == Answer::accepted ? tally.accepted : tally.refused);
            } catch (const std::exception& error) {
                ADD_FAILURE() << "round " << round << ": " << error.what() << "\n" << text;
            }
        }
        return tally;
    }

    void expect_both_answers(const Tally& tally)
    {
        // Harmless changes (a digit, a name) are accepted, in a small table few; were none, nothing past the parser
        // would be tested.
        EXPECT_GT(tally.accepted, kRounds / 200);
        EXPECT_GT(tally.refused, kRounds / 4);
        EXPECT_EQ(tally.accepted + tally.refused, kRounds);
    }

    TEST(CaseFuzz, SeedsAreAccepted)
    {
        for (const std::string& seed : case_seeds())
            EXPECT_EQ(feed_case(seed), Answer::accepted);
        for (const std::string& seed : label_table_seeds())
            EXPECT_EQ(feed_label_table(seed), Answer::accepted);
    }

    TEST(CaseFuzz, DamagedBytesGiveACaseOrAReason)
    {
        expect_both_answers(feed_damaged(case_seeds(), feed_case, damage_bytes));
    }

    TEST(CaseFuzz, DamagedValuesGiveACaseOrAReason)
    {
        expect_both_answers(feed_damaged(case_seeds(), feed_case, damage_values));
    }

    TEST(LabelTableFuzz, DamagedBytesGiveATableOrAReason)
    {
        expect_both_answers(feed_damaged(label_table_seeds(), feed_label_table, damage_bytes));
    }

    TEST(LabelTableFuzz, DamagedValuesGiveATableOrAReason)
    {
        expect_both_answers(feed_damaged({ label_table_seeds().back() }, feed_label_table, damage_values));
    }

    TEST(CaseFuzz, NeitherDepthNorDoubledKeysNorEmptyTextsGetThrough)
    {
        const std::vector<std::string> texts { "", "null", "[]", "3", "\"\"", "{}", "\xef\xbb\xbf{}",
            std::string(200000, '['), std::string(200000, '{'), "{\"schema\":1,\"schema\":1}",
            "{\"frame\":\"LPS\",\"labels\":[],\"labels\":[]}", "{\"\":1,\"\":2}" };
        for (const std::string& text : texts) {
            EXPECT_EQ(feed_case(text), Answer::refused) << text.substr(0, 40);
            EXPECT_EQ(feed_label_table(text), Answer::refused) << text.substr(0, 40);
        }
    }

} // namespace mutation_test
} // namespace retractor::fuzz
