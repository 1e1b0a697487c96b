#include "planner/measures/bones/bone_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace bone_limits_test {

    /// The patient's axes along those of the frame: left x, back y, head z.
    AnatomicalFrame upright() { return { Vec3::Zero(), Vec3::UnitZ(), -Vec3::UnitY(), Vec3::UnitX() }; }

    constexpr double kChestMm = 100.0; // radius

    /// A left rib as an arc round the chest from 15 to 165 degrees, with one bending moment.
    BoneBar arc(double bending_Nm, double torsion_Nm = 0.0)
    {
        BoneBar bar { .length_mm = kChestMm * 150.0 * std::numbers::pi / 180.0, .sections = {} };
        for (double angle = 20.0; angle < 165.0; angle += 5.0) {
            const double a = angle * std::numbers::pi / 180.0;
            bar.sections.push_back({ .at_mm = kChestMm * (a - 15.0 * std::numbers::pi / 180.0),
                .centre = kChestMm * Vec3(std::sin(a), std::cos(a), 0.0),
                .area_mm2 = kTestedRibAreaMm2,
                .bending_Nm = bending_Nm,
                .torsion_Nm = torsion_Nm });
        }
        return bar;
    }

    FieldMetrics opened(double opening_mm, std::vector<BoneMetrics> bones)
    {
        FieldMetrics field;
        for (const int side : { 1, -1 })
            field.hooks.push_back({ .name = side > 0 ? "left" : "right", .side = side, .moved_mm = 0.5 * opening_mm });
        field.bones = std::move(bones);
        return field;
    }

    BoneMetrics rib(const std::string& name, double bending_Nm)
    {
        return bone_limit(name, std::vector { arc(bending_Nm) }, upright());
    }

    constexpr double kRoundOff = 1e-9;

    TEST(BoneLimits, TheCapacityOfARibIsThatOfItsPlace)
    {
        EXPECT_NEAR(rib_capacity_Nm(20.0, kTestedRibAreaMm2), 3.9, kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(45.0, kTestedRibAreaMm2), 3.9, kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(67.5, kTestedRibAreaMm2), 3.4, kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(90.0, kTestedRibAreaMm2), 2.9, kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(150.0, kTestedRibAreaMm2), 2.0, kRoundOff);
    }

    TEST(BoneLimits, TheCapacityGrowsAsTheSectionModulusWithinLimits)
    {
        const double larger = 1.2; // of the thickness in both directions
        EXPECT_NEAR(rib_capacity_Nm(90.0, std::pow(0.9, 2) * kTestedRibAreaMm2), 2.9 * std::pow(0.9, 3), kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(90.0, std::pow(larger, 2) * kTestedRibAreaMm2), 2.9 * 1.5, kRoundOff);
        EXPECT_NEAR(rib_capacity_Nm(90.0, 1.0), 2.9 * 0.6, kRoundOff);
    }

    TEST(BoneLimits, BendingAndTorsionHaveTheTensionOfOneMoment)
    {
        EXPECT_NEAR(equivalent_moment_Nm(3.0, 0.0), 3.0, kRoundOff);
        EXPECT_NEAR(equivalent_moment_Nm(3.0, 4.0), 4.0, kRoundOff);
        EXPECT_NEAR(equivalent_moment_Nm(0.0, 2.0), 1.0, kRoundOff); // pure torsion: tension equals shear
    }

    TEST(BoneLimits, AnEvenMomentIsWorstInFrontWhereverTheBarBegins)
    {
        for (const BoneBar& bar : { arc(2.4), reversed(arc(2.4)) }) {
            const BoneMetrics bone = bone_limit("rib_left_5", std::vector { bar }, upright());
            EXPECT_EQ(bone.part, "anterior");
            EXPECT_NEAR(bone.capacity_Nm.value(), 2.0, kRoundOff);
            EXPECT_NEAR(bone.utilisation, 1.2, kRoundOff);
            EXPECT_GT(bone.at_mm, 0.5 * bone.length_mm);
        }
    }

    TEST(BoneLimits, TheSternumHasNoPublishedNumber)
    {
        const BoneMetrics bone = bone_limit("sternum", std::vector { BoneBar {}, arc(5.0) }, upright());
        EXPECT_FALSE(bone.capacity_Nm.has_value());
        EXPECT_EQ(bone.utilisation, 0.0);
        EXPECT_NEAR(bone.moment_Nm, 5.0, kRoundOff);
        FieldMetrics field = opened(40.0, { bone });
        set_attainable(field, true);
        EXPECT_EQ(field.attainable, Attainable::yes);
        EXPECT_NE(bones_text(field).find("no published number"), std::string::npos);
    }

    TEST(BoneLimits, APlanBeyondALimitIsAttainableWithInjury)
    {
        FieldMetrics field = opened(48.0, { rib("rib_left_4", 1.5), rib("rib_left_5", 3.1), rib("rib_right_6", 2.4) });
        set_attainable(field, true);
        EXPECT_EQ(field.attainable, Attainable::with_injury);
        EXPECT_EQ(field.bones[0].name, "rib_left_5");
        EXPECT_NEAR(field.bones[0].opening_at_limit_mm.value(), 48.0 * 2.0 / 3.1, kRoundOff); // 30.97 mm
        EXPECT_NEAR(field.bones[1].opening_at_limit_mm.value(), 40.0, kRoundOff);
        EXPECT_FALSE(field.bones[2].opening_at_limit_mm.has_value());
        EXPECT_NEAR(field.largest_uninjured_opening_mm.value(), 48.0 * 2.0 / 3.1, kRoundOff);
        EXPECT_EQ(attainable_text(field), "with injury: rib 5 on the left, rib 6 on the right");
        const std::string text = bones_text(field);
        for (const char* part : { "Rib 5 on the left would break in its anterior part", "about 30 mm on",
                 "rib 6 on the right from about 40 mm on", "without a fracture is about 30 mm (estimate)" })
            EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
        EXPECT_EQ(text.find("rough"), std::string::npos);
        field.bones_rough = true;
        EXPECT_NE(bones_text(field).find("rough"), std::string::npos);
    }

    TEST(BoneLimits, BelowEveryLimitTheReachedOpeningIsUninjured)
    {
        FieldMetrics field = opened(48.0, { rib("rib_left_4", 1.0) });
        set_attainable(field, true);
        EXPECT_EQ(field.attainable, Attainable::yes);
        EXPECT_NEAR(field.largest_uninjured_opening_mm.value(), 48.0, kRoundOff);
        EXPECT_NE(bones_text(field).find("Rib 4 on the left comes nearest: 1.0 N m"), std::string::npos)
            << bones_text(field);
        EXPECT_NE(bones_text(field).find("50 %"), std::string::npos);
    }

    TEST(BoneLimits, WithoutEquilibriumOrMomentsThereIsNoOpening)
    {
        FieldMetrics field = opened(48.0, { rib("rib_left_4", 9.0) });
        set_attainable(field, false);
        EXPECT_EQ(field.attainable, Attainable::no);
        EXPECT_FALSE(field.largest_uninjured_opening_mm.has_value());
        EXPECT_EQ(to_string(field.attainable), "no");
        field.bones.clear();
        field.bones_message = "tissue far from the wound is linear";
        set_attainable(field, true);
        EXPECT_EQ(field.attainable, Attainable::unknown);
        EXPECT_NE(bones_text(field).find("tissue far from the wound is linear."), std::string::npos);
    }

    TEST(BoneLimits, OnlyRibsAndTheSternumAreLongBones)
    {
        for (const char* label : { "rib_left_1", "rib_right_12", "sternum" })
            EXPECT_TRUE(is_long_bone(label)) << label;
        for (const char* label : { "spine", "scapula_left", "costal_cartilages", "rib" })
            EXPECT_FALSE(is_long_bone(label)) << label;
        EXPECT_EQ(bone_in_words("sternum"), "the sternum");
    }

} // namespace bone_limits_test
} // namespace retractor::planner
