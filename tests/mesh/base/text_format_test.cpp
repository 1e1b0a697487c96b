#include "mesh/base/text_format.h"

#include <gtest/gtest.h>

#include <string>

namespace retractor {
namespace {

    TEST(Text, FormatsAsPrintfDoes)
    {
        EXPECT_EQ(formatted("%d of %s: %.2f %%", 3, "four", 0.755), "3 of four: 0.76 %");
        EXPECT_EQ(formatted("%s", ""), "");
    }

    TEST(Text, CutsNothingOff)
    {
        const std::string name(5000, 'x');
        EXPECT_EQ(formatted("<%s>", name.c_str()), "<" + name + ">");
    }

    TEST(Text, WritesNumbersAndPoints)
    {
        EXPECT_EQ(in_words(2.5004, 1), "2.5");
        EXPECT_EQ(in_words(12.6), "13");
        EXPECT_EQ(in_words(Vec3(1.0, -2.25, 0.04)), "(1.0, -2.2, 0.0) mm");
    }

    TEST(Text, JoinsRemarks)
    {
        std::string message;
        remark(message, "");
        EXPECT_EQ(message, "");
        remark(message, "one");
        remark(message, "two");
        EXPECT_EQ(message, "one; two");
    }

    TEST(Text, ReadsLabelsWithoutUnderscores) { EXPECT_EQ(readable("left_rib_5"), "left rib 5"); }

} // namespace
} // namespace retractor
