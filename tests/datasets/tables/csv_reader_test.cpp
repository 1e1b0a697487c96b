#include "datasets/tables/csv_reader.h"

#include "mesh/base/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace retractor::datasets {
namespace csv_reader_test {

    std::vector<CsvRow> rows_of(const std::string& text)
    {
        const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "rows.csv";
        std::ofstream(file, std::ios::binary) << text;
        std::vector<CsvRow> rows;
        read_csv(file, [&](const CsvRow& row) { rows.push_back(row); });
        return rows;
    }

    using Fields = std::vector<std::string>;

    TEST(CsvReader, GivesFieldsWithTheLineOnWhichTheirRowBegins)
    {
        const auto rows = rows_of("\xEF\xBB\xBFname,note\r\na,1\n\n\"b,\"\"x\"\"\",\"two\nlines\"\nc,\n ,last");
        ASSERT_EQ(rows.size(), 5U);
        EXPECT_EQ(rows[0].fields, (Fields { "name", "note" }));
        EXPECT_EQ(rows[1].fields, (Fields { "a", "1" }));
        EXPECT_EQ(rows[2].fields, (Fields { "b,\"x\"", "two\nlines" }));
        EXPECT_EQ(rows[3].fields, (Fields { "c", "" }));
        EXPECT_EQ(rows[4].fields, (Fields { "", "last" }));
        const std::size_t lines[] = { 1, 2, 4, 6, 7 };
        for (std::size_t n = 0; n < rows.size(); ++n)
            EXPECT_EQ(rows[n].line, lines[n]);
        EXPECT_TRUE(rows_of("").empty());
        EXPECT_TRUE(rows_of("\n\n").empty());
    }

    TEST(CsvReader, RefusesWrongQuotesWithTheirLine)
    {
        for (const char* text : { "a,b\nc\"d,e\n", "a,b\n\"c,d\n", "a,b\n\"c\"x,d\n" })
            EXPECT_NE(test_support::message_of([&] { (void)rows_of(text); }).find("quote"), std::string::npos) << text;
        try {
            (void)rows_of("a,b\nc,d\nc\"d,e\n");
            FAIL();
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "rows.csv:3");
        }
        EXPECT_NE(test_support::message_of([&] { (void)rows_of("a,b\rc,d\r"); }).find("carriage return"),
            std::string::npos);
        EXPECT_THROW(read_csv("/nowhere/x.csv", [](const CsvRow&) {}), IoError);
        // What the caller throws comes through the C library.
        const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "rows.csv";
        std::ofstream(file) << "a\nb\n";
        EXPECT_THROW(read_csv(file, [](const CsvRow&) { throw InputError("no"); }), InputError);
    }

    TEST(CsvReader, QuotedTextIsReadAsItWas)
    {
        const std::string text = "a \"quoted\", long\nnote";
        const auto rows = rows_of(csv_quoted(text) + "," + csv_quoted("") + "\n");
        ASSERT_EQ(rows.size(), 1U);
        EXPECT_EQ(rows[0].fields, (Fields { text, "" }));
    }

    TEST(BadRows, AreCountedAndTheFirstListed)
    {
        BadRows bad;
        EXPECT_EQ(bad_rows_text(bad), "");
        for (std::size_t n = 1; n <= BadRows::kListed + 2; ++n)
            bad.add({ "oxygen.csv", n, "no date" });
        EXPECT_EQ(bad.first.size(), BadRows::kListed);
        EXPECT_NE(bad_rows_text(bad).find("oxygen.csv:1: no date\n"), std::string::npos);
        EXPECT_NE(bad_rows_text(bad).find("and 2 other rows"), std::string::npos);
    }

} // namespace csv_reader_test
} // namespace retractor::datasets
