#include "haptics/recording/csv_field.h"

#include <gtest/gtest.h>

namespace retractor::haptics {
namespace csv_field_test {

    TEST(CsvField, QuotesOnlyWhatWouldBreakARow)
    {
        EXPECT_EQ(csv_field("normal"), "normal");
        EXPECT_EQ(csv_field(""), "");
        EXPECT_EQ(csv_field("arch, left"), "\"arch, left\"");
        EXPECT_EQ(csv_field("the \"hard\" one"), "\"the \"\"hard\"\" one\"");
        EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
    }

} // namespace csv_field_test
} // namespace retractor::haptics
