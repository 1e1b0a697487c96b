#include "haptics/training/elasticity_trials.h"

#include "haptics/training/trial_statistics.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace retractor;
using namespace retractor::haptics;

namespace elasticity_trials_test {

std::vector<double> chosen(
    const std::vector<ElasticityTrial>& trials, const std::function<bool(const ElasticityTrial&)>& which)
{
    std::vector<double> values;
    for (const ElasticityTrial& trial : trials)
        if (which(trial))
            values.push_back(trial.chosen_MPa);
    return values;
}

TEST(TrialModels, areTheSources)
{
    const std::vector<double> models = trial_models();
    ASSERT_EQ(models.size(), 20U);
    EXPECT_NEAR(models.front(), 0.2, 1e-12);
    EXPECT_NEAR(models.back(), 4.0, 1e-12);
    EXPECT_NEAR(trial_models(10).back(), 2.0, 1e-12);
}

TEST(TrialOrder, isAPermutationThatTheSeedDecides)
{
    std::vector<int> order = trial_order(20, 7);
    EXPECT_EQ(order, trial_order(20, 7));
    EXPECT_NE(order, trial_order(20, 8));
    std::sort(order.begin(), order.end());
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
    // Fair: over many seeds every model comes first about as often (200 of 4,000, standard deviation 14).
    std::vector<int> first(20, 0);
    for (std::uint64_t seed = 0; seed < 4000; ++seed)
        ++first[static_cast<std::size_t>(trial_order(20, seed)[0])];
    for (const int count : first)
        EXPECT_NEAR(count, 200, 70);
}

TEST(SimulatedTrainee, withoutNoiseFindsTheRightModel)
{
    SimulatedTrainee trainee { .noise = 0.0 };
    EXPECT_NEAR(trainee.choose(trial_models(), trial_order(20, 1), Tissue::normal), 1.0, 1e-12);
    EXPECT_NEAR(trainee.choose(trial_models(), trial_order(20, 2), Tissue::sclerotic), 3.0, 1e-12);
}

TEST(SimulatedTrainee, learningTakesTheBiasAway)
{
    SimulatedTrainee trainee { .noise = 0.0, .bias_normal = 0.7, .learning = 0.5 };
    EXPECT_NEAR(trainee.choose(trial_models(), trial_order(20, 1), Tissue::normal), 2.0, 1e-12); // e^0.7
    for (int i = 0; i < 6; ++i)
        trainee.learn();
    EXPECT_NEAR(trainee.choose(trial_models(), trial_order(20, 1), Tissue::normal), 1.0, 1e-12);
}

// What the source reports of each study must be what the statistics say of people made that way.

TEST(ModellingStudy, surgeonsAgreeOnNormalAndSclerotic)
{
    const auto trials = simulate_modelling_study(1);
    ASSERT_EQ(trials.size(), 16U);
    const BoxNumbers normal = box_numbers(chosen(trials, [](const auto& t) { return t.tissue == Tissue::normal; }));
    EXPECT_GE(normal.lower_quartile, 1.0 - 1e-9);
    EXPECT_LE(normal.upper_quartile, 1.2 + 1e-9);
    const BoxNumbers sclerotic
        = box_numbers(chosen(trials, [](const auto& t) { return t.tissue == Tissue::sclerotic; }));
    EXPECT_GE(sclerotic.lower_quartile, 2.8 - 1e-9);
}

TEST(RecognitionStudy, hapticInstructionNarrowsTheSpreadAndWordsDoNot)
{
    int haptic_differs = 0, verbal_differs = 0, within = 0, count = 0;
    constexpr int kRuns = 20;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
        const auto trials = simulate_recognition_study(seed);
        ASSERT_EQ(trials.size(), 54U);
        const auto of = [&](Instruction instruction) {
            return chosen(trials, [=](const auto& t) { return t.instruction == instruction; });
        };
        const auto none = of(Instruction::none), verbal = of(Instruction::verbal), haptic = of(Instruction::haptic);
        haptic_differs += f_test(none, haptic).p < 0.05 && f_test(verbal, haptic).p < 0.05 ? 1 : 0;
        verbal_differs += f_test(none, verbal).p < 0.05 ? 1 : 0;
        for (const double modulus : haptic) {
            within += modulus > 0.75 && modulus < 1.25 ? 1 : 0;
            ++count;
        }
    }
    EXPECT_GE(haptic_differs, kRuns - 1); // significant, as in fig. 9
    EXPECT_LE(verbal_differs, kRuns / 3);
    EXPECT_GT(static_cast<double>(within) / count, 0.8); // more than 80 % between 0.8 and 1.2
}

TEST(LearningStudy, spreadNarrowsAndTheMedianComesToTheTarget)
{
    int improves = 0, wider = 0;
    constexpr int kRuns = 20;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
        const auto trials = simulate_learning_study(seed);
        ASSERT_EQ(trials.size(), 140U);
        const auto of = [&](Tissue tissue, int session) {
            return chosen(trials, [=](const auto& t) { return t.tissue == tissue && t.session == session; });
        };
        const auto deviation = [&](int session) {
            std::vector<double> values = of(Tissue::normal, session);
            for (double& v : values)
                v = std::abs(v - kNormalMPa);
            return values;
        };
        const TTest test = paired_t_test(deviation(1), deviation(7));
        improves += test.difference > 0.0 && test.p < 0.05 ? 1 : 0;
        EXPECT_NEAR(box_numbers(of(Tissue::normal, 7)).median, 1.0, 0.21);
        EXPECT_NEAR(box_numbers(of(Tissue::sclerotic, 7)).median, 3.0, 0.61);
        const auto spread = [&](Tissue tissue) {
            const BoxNumbers box = box_numbers(of(tissue, 7));
            return box.high - box.low;
        };
        wider += spread(Tissue::sclerotic) > spread(Tissue::normal) ? 1 : 0;
    }
    EXPECT_GE(improves, kRuns * 3 / 4);
    EXPECT_GE(wider, kRuns * 3 / 4); // fig. 11 beside fig. 10
}

TEST(QualityVerdict, passesAtEightOfTen)
{
    std::vector<QualityAnswer> answers;
    for (int i = 0; i < 10; ++i)
        answers.push_back({ "person-" + std::to_string(i), true, i < 8, i < 7 });
    const QualityVerdict verdict = judge(answers);
    EXPECT_TRUE(verdict.passes(verdict.authenticity));
    EXPECT_TRUE(verdict.passes(verdict.ease));
    EXPECT_FALSE(verdict.passes(verdict.stability));
    EXPECT_FALSE(verdict.passes());
    answers.resize(9);
    EXPECT_FALSE(judge(answers).passes(9)); // ten persons are asked
}

TEST(ElasticityTrial, refusesWhatIsNoTrial)
{
    ElasticityTrial trial { .trainee = "a", .date = "2026-01-31", .chosen_MPa = 1.0, .right_MPa = 1.0 };
    EXPECT_NO_THROW(check_trial(trial));
    trial.date = "31.1.2026";
    EXPECT_EQ(test_support::message_of([&] { check_trial(trial); }), "date: a date is YYYY-MM-DD, got 31.1.2026");
    trial.date = "2026-01-31";
    trial.chosen_MPa = -1.0;
    EXPECT_EQ(test_support::message_of([&] { check_trial(trial); }),
        "chosen_MPa: an elasticity must be positive, got -1.000000");
    EXPECT_EQ(test_support::message_of([] { (void)instruction_of("loud"); }),
        "the instruction is none, verbal or haptic, got loud");
}

} // namespace elasticity_trials_test
