#include "planner/measures/verdict.h"

#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/metrics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::planner {
namespace verdict_test {

    /// A field against which nothing speaks.
    FieldMetrics good_field()
    {
        FieldMetrics field;
        field.target = "left_atrium";
        field.target_spec.label = "left_atrium";
        field.seen_best_eye = 0.337;
        field.mechanics_status = "converged";
        field.attainable = Attainable::yes;
        field.opening_width_mm = 47.6;
        field.hook_force_N = 80.0;
        field.error.emplace();
        field.error->hook_force_N = 12.0;
        field.region.rim_motion_mm = 0.2;
        return field;
    }

    bool says(const Verdict& verdict, const std::string& sentence)
    {
        return std::ranges::find(verdict.sentences, sentence) != verdict.sentences.end();
    }

    TEST(Verdict, NumbersHaveTwoDigits)
    {
        EXPECT_EQ(two_digits(0.0), "0");
        EXPECT_EQ(two_digits(0.0347), "0.035");
        EXPECT_EQ(two_digits(3.449), "3.4");
        EXPECT_EQ(two_digits(9.96), "10");
        EXPECT_EQ(two_digits(47.6), "48");
        EXPECT_EQ(two_digits(213.0), "210");
        EXPECT_EQ(two_digits(-1267.0), "-1300");
    }

    TEST(Verdict, AGoodFieldIsToldInThreeSentences)
    {
        const Verdict verdict = verdict_of(good_field());
        EXPECT_EQ(verdict.light, Light::clear);
        EXPECT_TRUE(says(verdict, "Shows 34 % of what could be seen of the left atrium."));
        EXPECT_TRUE(says(verdict, "Opens 48 mm wide."));
        EXPECT_TRUE(says(verdict, "Force 80 N (68 to 92)."));
        EXPECT_EQ(verdict.sentences.size(), 3U);
    }

    TEST(Verdict, BoneThatStaysWholeUnderTheIncisionIsNamed)
    {
        const std::string sentence
            = "The incision crosses bone that stays whole: rib 4 on the left, rib 5 on the left.";
        FieldMetrics field = good_field();
        field.crossed_bones = { "rib_left_4", "rib_left_5" };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_TRUE(says(verdict_of(field), sentence));
        field.hook_force_N = 9727.0; // pulled apart all the same
        const Verdict impossible = verdict_of(field);
        EXPECT_EQ(impossible.light, Light::unknown);
        ASSERT_EQ(impossible.sentences.size(), 2U);
        EXPECT_EQ(impossible.sentences[1], sentence);
    }

    TEST(Verdict, DividedCartilageAndAMediastinumHeldAsideAsOneAreNamed)
    {
        FieldMetrics field = good_field();
        field.divided_cartilages = { "costal_cartilages" };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_TRUE(says(verdict_of(field), "The incision divides cartilage: costal cartilages."));
        field = good_field();
        field.retracted = { "lung_left", "mediastinum" };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_EQ(verdict_of(field).sentences.front().find("The mediastinum is held aside in one piece."), 0U);
        field.retracted = { "lung_left", "mediastinal_fat" };
        EXPECT_EQ(verdict_of(field).light, Light::clear);
    }

    TEST(Verdict, BladesThatBearOnNoBoneAreACaution)
    {
        FieldMetrics field = good_field();
        field.retractor.emplace();
        field.hooks.resize(2);
        field.hooks[0].name = "left_blade";
        field.hooks[1].name = "right_blade";
        const std::string both = "The blades bear on soft tissue only, on no bone.";
        EXPECT_FALSE(says(verdict_of(field), both)) << "an abdomen has no bone to bear on";
        field.bones.resize(1);
        EXPECT_TRUE(says(verdict_of(field), both));
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        field.hooks[1].bears_on = { "rib_left_4" };
        EXPECT_FALSE(says(verdict_of(field), both));
        EXPECT_TRUE(says(verdict_of(field), "The left blade bears on soft tissue only, on no bone."));
        field.hooks[0].bears_on = { "rib_left_5" };
        EXPECT_EQ(verdict_of(field).light, Light::clear);
        field.hooks[0].bears_on.clear();
        field.retractor.reset();
        EXPECT_EQ(verdict_of(field).light, Light::clear) << "hooks are small: they often hold soft tissue";
    }

    TEST(Verdict, ALungThatWouldHideMostIsACaution)
    {
        FieldMetrics field = good_field();
        field.if_lung_keeps
            = { { .lung_share = 0.2, .seen_best_eye = 0.40 }, { .lung_share = 0.5, .seen_best_eye = 0.12 } };
        const Verdict verdict = verdict_of(field);
        EXPECT_EQ(verdict.light, Light::caution);
        EXPECT_TRUE(says(verdict,
            "A lung that keeps 50 % of its volume instead of 30 % leaves only 12 % of the left atrium in sight."));
        field.if_lung_keeps[1].seen_best_eye = 0.6 * field.seen_best_eye;
        EXPECT_EQ(verdict_of(field).light, Light::clear);
        field.if_lung_keeps[1].seen_best_eye = 0.001;
        EXPECT_TRUE(says(verdict_of(field),
            "A lung that keeps 50 % of its volume instead of 30 % leaves nothing of the left atrium in sight."));
    }

    TEST(Verdict, APositionThatShowsMuchMoreIsNamed)
    {
        FieldMetrics field = good_field();
        field.if_turned = { { 0.0, 0.04 }, { 15.0, 0.08 }, { 30.0, 0.12 } };
        const Verdict verdict = verdict_of(field);
        EXPECT_EQ(verdict.light, Light::clear) << "any patient can be turned";
        EXPECT_TRUE(
            says(verdict, "From above the table 12 % is seen with the left side up by 30 degrees, and 4.0 % supine."));
        const std::size_t sentences = verdict.sentences.size();
        field.if_turned = { { 0.0, 0.11 }, { 30.0, 0.12 } };
        EXPECT_EQ(verdict_of(field).sentences.size(), sentences - 1U) << "not worth it";
    }

    TEST(Verdict, TheForceHasBothIntervals)
    {
        FieldMetrics field = good_field();
        field.parameters = ParameterInterval {};
        field.parameters->force_low_N = 64.0;
        field.parameters->force_high_N = 100.0;
        const ForceInterval interval = force_interval(field);
        EXPECT_NEAR(interval.low_N, 80.0 - std::hypot(12.0, 16.0), 1e-12);
        EXPECT_NEAR(interval.high_N, 80.0 + std::hypot(12.0, 20.0), 1e-12);
        field.force_moments = ForceMoments { .message = {}, .peak_N = 160.0, .held_N = 70.0, .hold_s = 1800.0 };
        const Verdict verdict = verdict_of(field);
        EXPECT_TRUE(std::ranges::any_of(verdict.sentences, [](const std::string& sentence) {
            return sentence.starts_with("Peak 160 N (120 to 210), held 70 N after ");
        })) << verdict.sentences.back();
    }

    TEST(Verdict, AForceOfUnknownOrWideIntervalIsACaution)
    {
        FieldMetrics field = good_field();
        field.error.reset();
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_TRUE(says(verdict_of(field), "Force 80 N."));
        field.error.emplace();
        field.error->hook_force_N = 50.0;
        EXPECT_EQ(verdict_of(field).light, Light::caution);
    }

    TEST(Verdict, ARetractorThatAHandHoldsIsToldEverywhere)
    {
        FieldMetrics field = good_field();
        field.retractor = RetractorMetrics { .kind = "midcab", .opening_mm = 30.0, .tilt_deg = 3.0 };
        EXPECT_EQ(verdict_of(field).light, Light::clear);
        EXPECT_FALSE(metrics_document({ field })["approaches"][0]["retractor"].contains("hand_moment_Nm"));
        EXPECT_NE(retractor_text(field).find("tilted by 3.0 degrees"), std::string::npos);
        field.retractor->hand_moment_Nm = 1.234;
        const Verdict verdict = verdict_of(field);
        EXPECT_EQ(verdict.light, Light::caution);
        EXPECT_TRUE(says(verdict, "A hand or an arm at the table must keep the retractor from tilting (1.2 N m)."));
        EXPECT_EQ(metrics_document({ field })["approaches"][0]["retractor"]["hand_moment_Nm"], 1.234);
        EXPECT_NE(retractor_text(field).find("holds its direction with 1.2 N m"), std::string::npos)
            << retractor_text(field);
    }

    TEST(Verdict, WhatBreaksOrTearsComesFirst)
    {
        FieldMetrics field = good_field();
        field.attainable = Attainable::with_injury;
        BoneMetrics rib { .name = "rib_left_4" };
        rib.capacity_Nm = 2.9;
        rib.utilisation = 1.4;
        rib.opening_at_limit_mm = 21.3;
        field.bones = { rib };
        const Verdict broken = verdict_of(field);
        EXPECT_EQ(broken.light, Light::injury);
        EXPECT_EQ(broken.sentences.front(), "Rib 4 on the left would break from 21 mm on.");
        field.bones[0].opening_at_limit_mm.reset();
        field.bones[0].utilisation = 0.8;
        field.at_risk = { { .name = "heart", .distance_mm = 0.0 } };
        EXPECT_EQ(verdict_of(field).sentences.front(), "The blade cuts the heart.") << "an injury before a caution";
        EXPECT_EQ(verdict_of(field).sentences[1], "Rib 4 on the left comes near breaking.");
        field.at_risk.clear();
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        field.bones.clear();
        field.tissue_strain = { { .tissue = "skin", .strain = 0.5 } };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_EQ(verdict_of(field).sentences.front(), "Skin may tear.");
        field.tissue_strain[0].strain = 0.9;
        EXPECT_EQ(verdict_of(field).light, Light::injury);
        EXPECT_EQ(verdict_of(field).sentences.front(), "Skin would tear.");
    }

    TEST(Verdict, NothingImpossibleIsGreen)
    {
        FieldMetrics field = good_field();
        field.mechanics_status = "the hooks pull too far";
        EXPECT_EQ(verdict_of(field).light, Light::unknown);
        field = good_field();
        field.inverted_elements = 1;
        EXPECT_EQ(verdict_of(field).light, Light::unknown);
        field = good_field();
        field.volume_failures = VolumeFailures {};
        field.volume_failures->believable = false;
        EXPECT_EQ(verdict_of(field).light, Light::unknown);
        field = good_field();
        field.implausible = { "skin of 100 MPa" };
        EXPECT_EQ(verdict_of(field).light, Light::unknown);
        field = good_field();
        field.hook_force_N = 20900.0; // two hooks that hold a swinging half of the sternum straight
        EXPECT_EQ(verdict_of(field).light, Light::unknown);
        EXPECT_TRUE(says(verdict_of(field),
            "No retractor pulls with 21000 N: do not use these numbers. Check what the hooks hold."));
        field = good_field();
        field.at_risk = { { .name = "heart", .distance_mm = 0.0 } };
        EXPECT_EQ(verdict_of(field).light, Light::injury);
        EXPECT_TRUE(says(verdict_of(field), "The blade cuts the heart."));
        field.at_risk.front().is_assumed = true;
        EXPECT_EQ(verdict_of(field).light, Light::caution) << "nobody has seen it there";
        EXPECT_TRUE(says(verdict_of(field), "The blade may cut the heart (assumed place)."));
        field.at_risk.front().is_assumed = false;
        field.at_risk.front().distance_mm = 0.4; // a saw whose foot runs between bone and heart
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_TRUE(says(verdict_of(field), "The cut comes within 2 mm of the heart."));
        field.at_risk.clear();
        field.steel_at_risk = { { .name = "heart", .distance_mm = 0.7, .from = "left_blade" } };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_EQ(verdict_of(field).sentences.front(), "The left blade lies against the heart.");
    }

    TEST(Verdict, WhatIsNotSeenOrOnlyEstimatedIsSaid)
    {
        FieldMetrics field = good_field();
        field.seen_best_eye = 0.001;
        EXPECT_EQ(verdict_of(field).light, Light::injury);
        EXPECT_TRUE(says(verdict_of(field), "The left atrium is not seen."));
        field.seen_best_eye = 0.05;
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        field = good_field();
        field.estimated = { "left_atrium" };
        EXPECT_EQ(verdict_of(field).light, Light::caution);
        EXPECT_TRUE(says(verdict_of(field), "The left atrium is only estimated."));
        field.target = "annulus on left_atrium"; // of a site, the organ is estimated
        EXPECT_TRUE(says(verdict_of(field), "The left atrium is only estimated."));
    }

} // namespace verdict_test
} // namespace retractor::planner
