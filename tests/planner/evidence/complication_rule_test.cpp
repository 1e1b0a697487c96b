#include "planner/evidence/complication_rule.h"

#include "mesh/base/error.h"
#include "planner/evidence/hospital_records.h"
#include "planner/evidence/published_rules.h"
#include "planner/evidence/record_generator.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace retractor::planner {
namespace complication_rule_test {

    namespace fs = std::filesystem;

    std::string published(std::string_view name)
    {
        for (const PublishedRule& rule : published_rules())
            if (rule.name == name)
                return std::string(rule.sql);
        return {};
    }

    /// Records in a database in memory.
    struct Records {
        explicit Records(const fs::path& folder, BadRowPolicy policy = BadRowPolicy::refuse)
            : loaded(load_hospital_records(folder, database, policy))
        {
        }
        datasets::SqliteDatabase database = datasets::open_sqlite(":memory:", "the records cannot be used");
        LoadedRecords loaded;
    };

    fs::path study(unsigned seed = 1)
    {
        const fs::path folder = fs::path(testing::TempDir()) / ("study" + std::to_string(seed));
        if (!fs::exists(folder))
            write_complication_records(folder, kPublishedExaminations, seed);
        return folder;
    }

    TEST(ComplicationRule, FindsFiveAndFourOfWhomThreeHadShockAsPublished)
    {
        for (const unsigned seed : { 1U, 2U, 3U }) {
            const Records records(study(seed));
            EXPECT_TRUE(records.loaded.has_truth);
            EXPECT_EQ(records.loaded.bad.count, 0U);
            const RuleResult accounting
                = apply_rule(records.database, published("shock-accounting"), records.loaded.has_truth);
            EXPECT_EQ(accounting.examinations, 14255U);
            EXPECT_EQ(accounting.found.size(), 5U);
            EXPECT_EQ(accounting.patients, 5U);
            ASSERT_TRUE(accounting.judgement);
            EXPECT_EQ(accounting.judgement->right, 3U);
            EXPECT_EQ(accounting.judgement->missed, 0U);
            const RuleResult orders = apply_rule(records.database, published("shock-orders"), true);
            EXPECT_EQ(orders.found.size(), 4U);
            EXPECT_EQ(orders.judgement->right, 3U);
            EXPECT_EQ(orders.judgement->wrong, 1U) << "the steroid that was given to prevent shock";
            std::size_t of_months = 0;
            for (const auto& [month, count] : accounting.months)
                of_months += count.examinations;
            EXPECT_EQ(of_months, 14255U);
            EXPECT_EQ(accounting.months.size(), 12U);
            EXPECT_EQ(accounting.months.begin()->first, "2003-04");
        }
    }

    /// One patient of the rule, changed by one line.
    struct Changed {
        const char* what;
        const char* administrations;
        const char* oxygen = "P,2003-05-10\n";
        const char* surgery = "";
        const char* contrast = "1";
        std::size_t found = 1;
    };

    TEST(ComplicationRule, EachConditionCounts)
    {
        const Changed cases[] = {
            { "all", "P,2003-05-10,steroid,iv,,\n" },
            { "at the time of the examination, not intravenous", "P,2003-05-10,antihistamine,oral,E,\n" },
            { "by mouth", "P,2003-05-10,steroid,oral,,\n", "P,2003-05-10\n", "", "1", 0 },
            { "another drug", "P,2003-05-10,other,iv,E,\n", "P,2003-05-10\n", "", "1", 0 },
            { "another day", "P,2003-05-11,steroid,iv,,\n", "P,2003-05-10\n", "", "1", 0 },
            { "three days before", "P,2003-05-10,steroid,iv,,\nP,2003-05-07,steroid,oral,,\n", "P,2003-05-10\n", "",
                "1", 0 },
            { "four days before", "P,2003-05-10,steroid,iv,,\nP,2003-05-06,steroid,oral,,\n" },
            { "three days after", "P,2003-05-10,steroid,iv,,\nP,2003-05-13,antihistamine,iv,,\n", "P,2003-05-10\n", "",
                "1", 0 },
            { "another patient's drug", "P,2003-05-10,steroid,iv,,\nQ,2003-05-09,steroid,iv,,\n" },
            { "no oxygen", "P,2003-05-10,steroid,iv,,\n", "P,2003-05-09\n", "", "1", 0 },
            { "surgery", "P,2003-05-10,steroid,iv,,\n", "P,2003-05-10\n", "P,2003-05-10\n", "1", 0 },
            { "surgery the day after", "P,2003-05-10,steroid,iv,,\n", "P,2003-05-10\n", "P,2003-05-11\n" },
            { "no contrast medium", "P,2003-05-10,steroid,iv,,\n", "P,2003-05-10\n", "", "0", 0 },
            { "over the end of a month", "P,2003-05-10,steroid,iv,,\nP,2003-04-30,steroid,iv,,\n" },
        };
        const fs::path folder = fs::path(testing::TempDir()) / "one";
        fs::create_directories(folder);
        for (const Changed& one : cases) {
            std::ofstream(folder / "examinations.csv")
                << "examination,patient,date,contrast,inpatient\nE,P,2003-05-10," << one.contrast << ",0\n";
            std::ofstream(folder / "administrations.csv") << "patient,date,drug,route,examination,ordered\n"
                                                          << one.administrations;
            std::ofstream(folder / "oxygen.csv") << "patient,date\n" << one.oxygen;
            std::ofstream(folder / "surgery.csv") << "patient,date\n" << one.surgery;
            const Records records(folder);
            for (const char* rule : { "shock-accounting", "shock-orders" })
                EXPECT_EQ(apply_rule(records.database, published(rule), false).found.size(), one.found)
                    << one.what << ", " << rule;
        }
        // An order makes the difference between the two rules.
        std::ofstream(folder / "administrations.csv")
            << "patient,date,drug,route,examination,ordered\nP,2003-05-10,steroid,iv,E,yes\n";
        std::ofstream(folder / "examinations.csv")
            << "examination,patient,date,contrast,inpatient\nE,P,2003-05-10,1,1\n";
        const Records records(folder);
        EXPECT_EQ(apply_rule(records.database, published("shock-accounting"), false).found.size(), 1U);
        EXPECT_EQ(apply_rule(records.database, published("shock-orders"), false).found.size(), 0U);
    }

    TEST(ComplicationRule, WrongRulesAreRefusedAndChangeNothing)
    {
        const Records records(study());
        for (const char* sql : { "", "  ", "SELECT", "SELECT patient FROM examination", "DELETE FROM examination",
                 "SELECT examination FROM examination; DELETE FROM examination", "SELECT 'E' AS examination",
                 "SELECT NULL AS examination", "SELECT examination FROM nowhere" })
            EXPECT_THROW((void)apply_rule(records.database, sql, true), InputError) << sql;
        EXPECT_EQ(apply_rule(records.database, published("shock-accounting"), true).examinations, 14255U);
        EXPECT_EQ(
            apply_rule(records.database, "SELECT examination FROM examination WHERE 0; -- done\n", true).found.size(),
            0U);
        const std::atomic<bool> cancelled { true };
        EXPECT_TRUE(apply_rule(records.database,
            "SELECT a.examination FROM examination AS a, examination AS b, examination AS c", true,
            { .on_progress = {}, .cancel = &cancelled })
                        .found.empty());
    }

    TEST(HospitalRecords, BadRowsAreListedWithTheirLinesAndLeftOutOnlyIfAsked)
    {
        const fs::path folder = fs::path(testing::TempDir()) / "bad";
        fs::create_directories(folder);
        // Columns in another order, and one more.
        std::ofstream(folder / "examinations.csv") << "note,patient,examination,date,contrast,inpatient\n"
                                                      "x,P,E1,2003-05-10,1,0\n"
                                                      "x,P,E1,2003-05-11,1,0\n" // again
                                                      "x,P,E2,2003-02-30,1,0\n"
                                                      "x,,E3,2003-05-10,1,0\n"
                                                      "x,P,E4,2003-05-10,yes,0\n"
                                                      "x,P,E5,2003-05-10,1\n";
        std::ofstream(folder / "administrations.csv") << "patient,date,drug,route,examination,ordered\n"
                                                         "P,2003-05-10,steroid,iv,E1,\n"
                                                         "P,2003-05-10,aspirin,iv,E1,\n"
                                                         "P,2003-05-10,steroid,iv,E9,\n"
                                                         "Q,2003-05-10,steroid,iv,E1,\n";
        std::ofstream(folder / "oxygen.csv") << "patient,date\nP,10.5.2003\n";
        std::ofstream(folder / "surgery.csv") << "patient,date\n";
        const std::string message = test_support::message_of([&] { const Records records(folder); });
        for (const char* part : { "9 rows are wrong", "examinations.csv:3: examination \"E1\" occurs before",
                 "examinations.csv:4: date is \"2003-02-30\"", "examinations.csv:5: patient is missing",
                 "examinations.csv:6: contrast is \"yes\", expected 0 or 1", "examinations.csv:7: has 5 fields",
                 "administrations.csv:3: drug is \"aspirin\"",
                 "administrations.csv:4: examination \"E9\" has no right row in examinations.csv",
                 "administrations.csv:5: examination \"E1\" is another patient's", "oxygen.csv:2: date is" })
            EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
        const Records rest(folder, BadRowPolicy::skip);
        EXPECT_EQ(rest.loaded.bad.count, 9U);
        EXPECT_EQ(rest.loaded.rows.at("examination"), 1U);
        EXPECT_EQ(rest.loaded.rows.at("administration"), 1U);
        std::ofstream(folder / "oxygen.csv") << "patient,day\n";
        EXPECT_NE(test_support::message_of([&] { const Records records(folder); }).find("no column \"date\""),
            std::string::npos);
        fs::remove(folder / "surgery.csv");
        std::ofstream(folder / "oxygen.csv") << "patient,date\n";
        EXPECT_THROW(Records(folder, BadRowPolicy::skip), IoError);
    }

    TEST(HospitalRecords, DatesAreDays)
    {
        EXPECT_EQ(day_of("1970-01-01"), 0);
        EXPECT_EQ(day_of("2004-03-01").value() - day_of("2004-02-28").value(), 2) << "a leap year";
        for (int day = -1000; day < 40000; day += 37)
            EXPECT_EQ(day_of(date_of(day)), day);
        for (const char* wrong :
            { "", "2003-4-1", "2003-13-01", "2003-02-29", "2003/04/01", "2003-04-01 ", "-003-04-01" })
            EXPECT_FALSE(day_of(wrong)) << wrong;
    }

    TEST(ExactInterval, SolvesTheEquationsOfTheBinomialsTails)
    {
        // Chance of at least k successes of n, by summing.
        const auto at_least = [](int k, int n, double p) {
            double sum = 0.0;
            for (int i = k; i <= n; ++i)
                sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p)
                    + (n - i) * std::log1p(-p));
            return sum;
        };
        for (const auto& [k, n] : { std::pair { 3, 5 }, { 1, 40 }, { 17, 20 } }) {
            const ShareInterval interval
                = clopper_pearson_interval(static_cast<std::size_t>(k), static_cast<std::size_t>(n));
            EXPECT_NEAR(at_least(k, n, interval.low), 0.025, 1e-9);
            EXPECT_NEAR(1.0 - at_least(k + 1, n, interval.high), 0.025, 1e-9);
        }
        EXPECT_EQ(clopper_pearson_interval(0, 3).low, 0.0);
        EXPECT_NEAR(clopper_pearson_interval(0, 3).high, 1.0 - std::cbrt(0.025), 1e-12);
        EXPECT_EQ(clopper_pearson_interval(3, 3).high, 1.0);
        EXPECT_EQ(clopper_pearson_interval(0, 0).low, 0.0);
        EXPECT_EQ(clopper_pearson_interval(0, 0).high, 1.0);
    }

} // namespace complication_rule_test
} // namespace retractor::planner
