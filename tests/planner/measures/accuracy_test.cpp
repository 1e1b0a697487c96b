#include "planner/measures/accuracy.h"

#include "mesh/base/error.h"
#include "planner/measures/metrics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <limits>
#include <set>
#include <string>

namespace retractor::planner {
namespace accuracy_test {

    FieldMetrics sample(AccuracyEnd ended_by, double force, double opening_mm)
    {
        FieldMetrics field;
        field.name = "median";
        field.accuracy = AccuracyMetrics { .asked = { .force = 0.15, .opening_mm = 2.0, .time_s = 600.0 },
            .reached_force = force,
            .reached_opening_mm = opening_mm,
            .rounds = 3,
            .edge_mm = 5.12,
            .ended_by = ended_by };
        return field;
    }

    nlohmann::ordered_json group_of(const FieldMetrics& field)
    {
        return metrics_document({ field }).at("approaches").at(0).at("accuracy");
    }

    TEST(Accuracy, EveryNumberIsInTheDocument)
    {
        const FieldMetrics field = sample(AccuracyEnd::time, 0.22, 3.5);
        const auto group = group_of(field);
        std::set<std::string> keys;
        for (const AccuracyField& row : accuracy_fields()) {
            EXPECT_TRUE(keys.insert(row.key).second) << row.key << " comes twice";
            EXPECT_EQ(group.at(row.key).get<double>(), row.of(*field.accuracy).value()) << row.key;
            EXPECT_STRNE(row.caption, "") << row.key;
            EXPECT_STRNE(row.meaning, "") << row.key;
        }
        EXPECT_EQ(keys,
            (std::set<std::string> {
                "asked_force", "asked_opening", "asked_time", "edge", "reached_force", "reached_opening" }));
        EXPECT_EQ(group.at("rounds"), 3);
        EXPECT_EQ(group.at("ended_by"), "time");
        EXPECT_EQ(group.at("reached_force"), 0.22);
        EXPECT_EQ(group.at("edge"), 5.12);
        EXPECT_FALSE(group.contains("message"));
    }

    TEST(Accuracy, WhatIsNotKnownIsLeftOut)
    {
        FieldMetrics field = sample(AccuracyEnd::failure, 0.22, 3.5);
        field.accuracy->reached_force.reset();
        field.accuracy->reached_opening_mm.reset();
        field.accuracy->message = "the next finer mesh gave no answer";
        const auto group = group_of(field);
        EXPECT_FALSE(group.contains("reached_force"));
        EXPECT_FALSE(group.contains("reached_opening"));
        EXPECT_EQ(group.at("message"), "the next finer mesh gave no answer");
        field.accuracy->edge_mm = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW((void)group_of(field), InputError);
        EXPECT_FALSE(metrics_document({ FieldMetrics {} }).at("approaches").at(0).contains("accuracy"));
        EXPECT_EQ(accuracy_text(FieldMetrics {}), "");
    }

    TEST(Accuracy, OneSentenceSaysWhatIsKnownAndWhatEndedTheSearch)
    {
        EXPECT_EQ(accuracy_text(sample(AccuracyEnd::reached, 0.09, 1.24)),
            "The force is known to 9 % (asked: 15 %). The opening is known to 1.2 mm (asked: 2 mm).");
        const std::string known = "; the force is known to 22 % and the opening to 3.5 mm.";
        const std::string asked = "The asked accuracy of 15 % and 2 mm was not reached";
        EXPECT_EQ(accuracy_text(sample(AccuracyEnd::time, 0.22, 3.5)), asked + " within 600 s" + known);
        EXPECT_EQ(
            accuracy_text(sample(AccuracyEnd::memory, 0.22, 3.5)), asked + " in the memory of this machine" + known);
        EXPECT_EQ(accuracy_text(sample(AccuracyEnd::rounds, 0.22, 3.5)),
            asked + " on 3 meshes, the finest with edges of 5.1 mm" + known);
        FieldMetrics failed = sample(AccuracyEnd::failure, 0.22, 3.5);
        failed.accuracy->message = "the next finer mesh gave no answer";
        EXPECT_EQ(accuracy_text(failed), asked + ", because the next finer mesh gave no answer" + known);
        failed.accuracy->reached_force.reset();
        failed.accuracy->reached_opening_mm.reset();
        EXPECT_EQ(accuracy_text(failed),
            asked + ", because the next finer mesh gave no answer; the errors of this answer are not known.");
        const std::string fine = accuracy_text(sample(AccuracyEnd::reached, 0.0048, 0.05));
        EXPECT_NE(fine.find("0.48 %"), std::string::npos) << fine;
        const std::string coarse = accuracy_text(sample(AccuracyEnd::time, 1.27, 12.4));
        EXPECT_NE(coarse.find("127 % and the opening to 12 mm"), std::string::npos) << coarse;
    }

    TEST(Accuracy, OfAKnownForceOnlyTheOpeningIsTold)
    {
        FieldMetrics field = sample(AccuracyEnd::reached, 0.0, 1.2);
        field.accuracy->reached_force.reset();
        EXPECT_EQ(accuracy_text(field), "The opening is known to 1.2 mm (asked: 2 mm).");
        field.accuracy->ended_by = AccuracyEnd::memory;
        field.accuracy->reached_opening_mm = 3.0;
        EXPECT_EQ(accuracy_text(field),
            "The asked accuracy of 2 mm was not reached in the memory of this machine; the opening is known to 3 mm.");
    }

    TEST(Accuracy, NumbersAreReadInTheirUnits)
    {
        EXPECT_EQ(accuracy_number({ .key = "", .unit = AccuracyUnit::percent }, 0.0912), "9.1 %");
        EXPECT_EQ(accuracy_number({ .key = "", .unit = AccuracyUnit::mm }, 1.24), "1.2 mm");
        EXPECT_EQ(accuracy_number({ .key = "", .unit = AccuracyUnit::s }, 600.0), "600 s");
    }

} // namespace accuracy_test
} // namespace retractor::planner
