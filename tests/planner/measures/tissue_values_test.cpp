#include "planner/measures/tissue_values.h"

#include "planner/measures/metrics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace retractor::planner {
namespace tissue_values_test {

    BoneStiffness rib(Label label, const std::string& name, double modulus_MPa)
    {
        return { .label = label,
            .name = name,
            .material = "bone",
            .origin = StiffnessOrigin::image,
            .modulus_MPa = modulus_MPa,
            .low_MPa = 0.7 * modulus_MPa,
            .high_MPa = 1.2 * modulus_MPa,
            .share = 0.2,
            .sections = 14,
            .words = "by sections" };
    }

    FieldMetrics field_with_bones()
    {
        FieldMetrics field;
        field.name = "straight";
        field.bone_stiffness = { rib(1, "rib_left_4", 3400.0), rib(2, "rib_left_5", 8000.0) };
        field.bone_stiffness[1].cut_off_MPa = 9100.0;
        field.bone_stiffness.push_back({ .label = 3,
            .name = "costal_cartilages",
            .material = "cartilage",
            .origin = StiffnessOrigin::middle,
            .modulus_MPa = 28.5,
            .low_MPa = 9.5,
            .high_MPa = 47.5,
            .words = "the middle" });
        return field;
    }

    TEST(TissueValues, AreToldForTheBonesOfTheWall)
    {
        const FieldMetrics field = field_with_bones();
        EXPECT_EQ(bone_stiffness_text(field),
            "ribs 3.4 to 8.0 GPa (2 of 2 by their sections in the CT), costal cartilages 28.5 MPa (published range)");
        const std::vector<Label> in_wall { 0, 2, 9 };
        const auto met = bones_in_wall(field.bone_stiffness, in_wall);
        ASSERT_EQ(met.size(), 1U);
        EXPECT_EQ(met[0].name, "rib_left_5");
        EXPECT_EQ(bone_stiffness_text({}), "");
    }

    TEST(TissueValues, NameTheBonesThatWereCutOff)
    {
        EXPECT_EQ(cut_off_text(field_with_bones().bone_stiffness),
            "by the CT the bending stiffness lies beyond the 2 to 8 GPa of tested ribs and is cut off: left rib 5 (9.1 "
            "GPa)");
        EXPECT_EQ(cut_off_text({}), "");
    }

    TEST(TissueValues, StandInMetricsJson)
    {
        const auto document = metrics_document({ field_with_bones() })["approaches"][0]["bone_stiffness"];
        ASSERT_EQ(document.size(), 3U);
        EXPECT_EQ(document[0]["found_by"], "CT");
        EXPECT_EQ(document[0]["cortex_share"], 0.2);
        EXPECT_EQ(document[0]["sections"], 14U);
        EXPECT_FALSE(document[0].contains("cut_off_from_MPa"));
        EXPECT_EQ(document[1]["cut_off_from_MPa"], 9100.0);
        EXPECT_EQ(document[2]["found_by"], "published range");
        EXPECT_FALSE(document[2].contains("calcified_share"));
        EXPECT_EQ(document[2]["range_MPa"][1], 47.5);
    }

    TEST(TissueValues, StandBesideTheBarOfTheMesh)
    {
        FieldMetrics field;
        field.hook_force_N = 197.2;
        EXPECT_EQ(parameter_text(field), "");
        EXPECT_EQ(force_with_intervals(field), "");
        ErrorBars bars;
        bars.hook_force_N = 9.1;
        field.error = bars;
        ParameterInterval interval;
        interval.force_low_N = 120.3;
        interval.force_high_N = 310.4;
        interval.opening_low_mm = 57.04;
        interval.opening_high_mm = 57.01;
        for (const auto& [name, exponent] : { std::pair { "cartilage", 0.5 }, std::pair { "fat", 0.01 } })
            interval.parameters.push_back({ .name = name,
                .unit = "MPa",
                .value = 1.0,
                .low = 0.5,
                .high = 2.0,
                .force_exponent = exponent,
                .source = "test" });
        field.parameters = interval;
        EXPECT_EQ(
            force_with_intervals(field), "197 N; mesh: +- 9 N; tissue values: 120 to 310 N; decided by cartilage");
        EXPECT_EQ(parameter_text(field), "tissue values: force 120 to 310 N, opening 57.0 mm; decided by cartilage");
        field.parameters->message = "nothing opened";
        EXPECT_EQ(parameter_text(field), "no interval from tissue values: nothing opened");
        EXPECT_EQ(force_with_intervals(field), "");
    }

} // namespace tissue_values_test
} // namespace retractor::planner
