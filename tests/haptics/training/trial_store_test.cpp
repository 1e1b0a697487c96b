#include "haptics/training/trial_store.h"

#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace retractor;
using namespace retractor::haptics;

TEST(TrialStore, keepsTrialsOverDays)
{
    const test_support::TemporaryFolder folder;
    const auto file = folder.path / "trials.sqlite";
    const auto trials = simulate_learning_study(3);
    {
        TrialStore store(file);
        store.add({ trials.begin(), trials.begin() + 50 });
    }
    TrialStore store(file); // another day
    EXPECT_EQ(store.next_session(trials.front().trainee), 8);
    EXPECT_EQ(store.next_session("nobody yet"), 1);
    store.add({ trials.begin() + 50, trials.end() });
    const auto read = store.trials();
    ASSERT_EQ(read.size(), trials.size());
    EXPECT_EQ(trials_csv(read), trials_csv(trials)); // bit for bit
}

TEST(TrialStore, namesElasticities)
{
    const test_support::TemporaryFolder folder;
    TrialStore store(folder.path / "trials.sqlite");
    store.keep({ "normal aorta", "Dr A", "2026-01-02", 1.0, 0.48 });
    store.keep({ "sclerotic aorta", "Dr A", "2026-01-02", 3.0, 0.48 });
    store.keep({ "normal aorta", "Dr B", "2026-01-03", 1.2, 0.48 });
    ASSERT_EQ(store.elasticities().size(), 2U);
    EXPECT_EQ(store.elasticities().front().modulus_MPa, 1.2);
    EXPECT_NE(test_support::message_of([&] { store.keep({ "x", "", "", -1.0, 0.48 }); }), "");
}

TEST(TrialStore, keepsTheQuestionnaire)
{
    const test_support::TemporaryFolder folder;
    TrialStore store(folder.path / "trials.sqlite");
    store.answer({ "b", true, true, false });
    store.answer({ "a", false, true, false });
    store.answer({ "b", true, false, true }); // thought again
    const auto answers = store.answers();
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_EQ(answers[1].person, "b");
    EXPECT_FALSE(answers[1].ease);
    EXPECT_TRUE(answers[1].stability);
}

TEST(TrialStore, aBadTrialLeavesNothingBehind)
{
    const test_support::TemporaryFolder folder;
    TrialStore store(folder.path / "trials.sqlite");
    auto trials = simulate_modelling_study(1);
    trials.back().session = 0;
    EXPECT_EQ(test_support::message_of([&] { store.add(trials); }), "session: sessions count from 1, got 0");
    EXPECT_TRUE(store.trials().empty());
}

TEST(TrialStore, refusesOtherFiles)
{
    const test_support::TemporaryFolder folder;
    const auto text = folder.path / "text.sqlite";
    std::ofstream(text) << std::string(2000, 'x');
    EXPECT_NE(test_support::message_of([&] { TrialStore { text }; }).find("file is not a database"), std::string::npos);
    EXPECT_NE(
        test_support::message_of([&] { TrialStore { folder.path / "none" / "x.sqlite" }; }).find("unable to open"),
        std::string::npos);
}

TEST(TrialsCsv, quotesNamesWithCommas)
{
    ElasticityTrial trial { .trainee = "Doe, \"Jo\"", .date = "2026-01-31", .chosen_MPa = 1.2, .right_MPa = 1.0 };
    EXPECT_NE(trials_csv({ trial }).find("\"Doe, \"\"Jo\"\"\",none,1,2026-01-31,normal,1.2"), std::string::npos);
}
