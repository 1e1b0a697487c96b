#include "planner/measures/metrics.h"

#include "planner/measures/sight/table_position.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>

namespace retractor::planner {
namespace metrics_test {

    nlohmann::ordered_json document_of(const FieldMetrics& field)
    {
        return metrics_document({ field }).at("approaches").at(0);
    }

    TEST(Metrics, TheSolutionNamesItsMeshAndWhetherItIsADraft)
    {
        FieldMetrics field;
        field.name = "straight";
        field.solution.mesh = { .corridor_radius_mm = 12.0,
            .corridor_edge_mm = 8.0,
            .coarse_edge_mm = 15.0,
            .region_mm = 50.0,
            .mesh_seed = 7 };
        const nlohmann::ordered_json solution = document_of(field).at("solution");
        EXPECT_EQ(solution.at("draft"), false);
        const nlohmann::ordered_json expected { { "corridor_radius_mm", 12.0 }, { "corridor_edge_mm", 8.0 },
            { "coarse_edge_mm", 15.0 }, { "region_mm", 50.0 }, { "seed", 7U } };
        EXPECT_EQ(solution.at("mesh"), expected);
        EXPECT_TRUE(solution_text(field).starts_with("solved as ")) << solution_text(field);
        field.solution.draft = true;
        EXPECT_EQ(document_of(field).at("solution").at("draft"), true);
        EXPECT_TRUE(solution_text(field).starts_with("a draft, solved as ")) << solution_text(field);
    }

    TEST(Metrics, AcceptedImplausibleNumbersAreRecorded)
    {
        FieldMetrics field;
        field.name = "straight";
        EXPECT_FALSE(document_of(field).contains("implausible"));
        field.implausible = { "the depth of the cut is 0.04 mm" };
        EXPECT_EQ(document_of(field).at("implausible").at(0), "the depth of the cut is 0.04 mm");
    }

    TEST(Metrics, EstimatedLabelsAndHigherOrgansAreSaid)
    {
        FieldMetrics field;
        field.name = "straight";
        EXPECT_EQ(estimated_text(field), "");
        EXPECT_EQ(shifted_sight_text(field), "");
        EXPECT_EQ(document_of(field).at("estimated").size(), 0U);
        field.estimated = { "aorta", "rib_left_4" };
        field.if_organs_shift
            = { { .shift_mm = 10.0, .seen_best_eye = 0.12 }, { .shift_mm = 20.0, .seen_best_eye = 0.0 } };
        EXPECT_EQ(estimated_text(field), "estimated, not seen in the image: aorta, left rib 4");
        EXPECT_EQ(shifted_sight_text(field),
            "with the organs 10 mm nearer to the head the best eye sees 12.0 %, 20 mm 0.0 %");
        EXPECT_EQ(document_of(field).at("estimated").at(1), "rib_left_4");
        EXPECT_DOUBLE_EQ(document_of(field).at("if_organs_shift").at(0).at("seen_best_eye").get<double>(), 0.12);
    }

    TEST(Metrics, WhatIsSeenInEachPositionOnTheTableIsSaid)
    {
        FieldMetrics field;
        field.name = "straight";
        EXPECT_EQ(turned_sight_text(field), "");
        field.if_turned = { { 0.0, 0.05 }, { -30.0, 0.12 }, { 90.0, 0.2 } };
        EXPECT_EQ(turned_sight_text(field),
            "from above the table the best eye sees 5.0 % supine, 12.0 % with the right side up by 30 degrees, 20.0 % "
            "lying on the right side");
        const auto turned = document_of(field).at("if_turned");
        EXPECT_EQ(turned.at(1).at("left_side_up_deg"), -30.0);
        EXPECT_EQ(turned.at(1).at("seen_best_eye"), 0.12);
        field.at_risk = { { .name = "mammary_artery_left", .distance_mm = 3.0, .is_assumed = true } };
        EXPECT_TRUE(document_of(field).at("at_risk").at(0).at("is_assumed").get<bool>());
        EXPECT_EQ(risk_text(field.at_risk[0]), "left mammary artery (assumed place) 3.0 mm");
    }

} // namespace metrics_test
} // namespace retractor::planner
