#include "tests/verification/cli/verify_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::verification {
namespace verify_tables_test {

    VerificationRow solved(const std::string& problem, double size, double error, double seconds)
    {
        VerificationRow row;
        row.problem = problem;
        row.element = "P1";
        row.law = "linear";
        row.quantity = "force, N";
        row.size = size;
        row.error = error;
        row.seconds = seconds;
        return row;
    }

    TEST(VerifyTables, ARowFailsBeyondItsBoundWithoutANumberWithAMissedOrderAndWithoutAReason)
    {
        VerificationRow row = solved("punch", 1.0, 0.1, 1.0);
        EXPECT_EQ(verdict(row), "FAILED") << "nothing judges it, and nothing says why";
        row.in_series = true;
        EXPECT_EQ(verdict(row), "series");
        row.in_series = false;
        show_only(row, "");
        EXPECT_EQ(verdict(row), "FAILED") << "no reason";
        show_only(row, "another material");
        EXPECT_EQ(verdict(row), "shown");
        row.bound = 0.2;
        EXPECT_EQ(verdict(row), "ok");
        row.bound = 0.05;
        EXPECT_EQ(verdict(row), "FAILED");
        row.bound = std::numeric_limits<double>::infinity();
        row.error = std::nan("");
        EXPECT_EQ(verdict(row), "FAILED");
        row.error = 0.1;
        row.order_verdict = OrderVerdict::missed;
        EXPECT_EQ(verdict(row), "FAILED");
        row.order_verdict = OrderVerdict::reached;
        EXPECT_EQ(verdict(row), "ok");
        row.note = "skipped: a file is not there";
        row.error = std::nan("");
        EXPECT_EQ(verdict(row), "skipped");
    }

    TEST(VerifyTables, JsonHoldsTheMeasuredRangeAndTheBar)
    {
        VerificationRow row = solved("spreader", 0.0, 0.0, 2.0);
        EXPECT_FALSE(row_document(row).contains("bar"));
        row.value = 560.0;
        row.measured = MeasuredComparison { .least = 118.0, .most = 470.0, .bar = 329.0 };
        const ui::cli::Json document = row_document(row);
        EXPECT_EQ(document.at("measured_least"), 118.0);
        EXPECT_EQ(document.at("measured_most"), 470.0);
        EXPECT_EQ(document.at("bar"), 329.0);
        EXPECT_EQ(document.at("outcome"), "undecided");
        row.measured->bar = std::numeric_limits<double>::infinity();
        EXPECT_TRUE(row_document(row).at("bar").is_null()) << "JSON has no infinity";
    }

    TEST(VerifyTables, JsonAndCsvHoldEveryColumn)
    {
        VerificationRow row = solved("punch, flat", 0.5, 0.1, 2.0);
        row.order = 1.5;
        row.expected_order = 1.0;
        row.order_verdict = OrderVerdict::reached;
        const ui::cli::Json document = row_document(row);
        EXPECT_TRUE(document.at("bound").is_null()) << "JSON has no infinity";
        EXPECT_EQ(document.at("order"), 1.5);
        EXPECT_EQ(document.at("order_verdict"), "reached");
        const std::string text = csv({ row });
        const std::string head = text.substr(0, text.find('\n'));
        const auto columns = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
        EXPECT_EQ(static_cast<std::size_t>(columns(head)) + 1, document.size());
        EXPECT_NE(text.find("\"punch, flat\",P1,linear,\"force, N\""), std::string::npos) << text;
        EXPECT_EQ(columns(text), 2 * columns(head) + 2) << "but for the two commas within quotes";
    }

    TEST(VerifyTables, TheTablePrintsTheBoundThatAnErrorIsJudgedBy)
    {
        VerificationRow row = solved("punch", 0.5, 0.1, 2.0);
        const std::string shown = table({ row });
        row.bound = 0.125;
        EXPECT_NE(table({ row }).find("1.00e-01     0.125"), std::string::npos) << table({ row });
        EXPECT_NE(shown.find("bound"), std::string::npos);
        EXPECT_EQ(shown.find("0.125"), std::string::npos);
    }

    TEST(VerifyTables, ChartsHaveAPanelForEachQuantityAndACurveForEachElement)
    {
        std::vector<VerificationRow> rows { solved("punch", 1.0, 0.2, 0.1), solved("punch", 0.5, 0.1, 0.4) };
        VerificationRow other = rows[0];
        other.element = "P2";
        rows.push_back(other);
        other.quantity = "sinking, mm";
        rows.push_back(other);
        rows.push_back(solved("no series", 0.0, 0.1, 1.0));
        other.note = "skipped: not there";
        rows.push_back(other);
        const ui::ChartPicture picture = charts(rows);
        ASSERT_EQ(picture.panels.size(), 2U);
        EXPECT_EQ(picture.panels[0].title, "punch, force");
        EXPECT_EQ(picture.panels[1].title, "punch, sinking");
        ASSERT_EQ(picture.panels[0].series.size(), 2U);
        EXPECT_EQ(picture.panels[0].series[0].x, (std::vector<double> { 0.1, 0.4 }));
        EXPECT_EQ(picture.panels[0].series[0].y, (std::vector<double> { 0.2, 0.1 }));
        EXPECT_EQ(picture.panels[0].series[1].name, "P2");
        EXPECT_EQ(picture.panels[1].series.at(0).y.size(), 1U) << "what was skipped is no point";
    }

} // namespace verify_tables_test
} // namespace retractor::verification
