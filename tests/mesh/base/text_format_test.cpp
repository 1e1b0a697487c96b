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

    TEST(Text, ANumberThatRoundsToZeroHasNoSign)
    {
        EXPECT_EQ(in_words(-0.04, 1), "0.0");
        EXPECT_EQ(in_words(-0.4), "0");
        EXPECT_EQ(in_words(-0.6), "-1");
        EXPECT_EQ(in_words(-0.05, 2), "-0.05");
    }

    TEST(Text, ReadsLabelsWithoutUnderscoresAndTheSideFirst)
    {
        EXPECT_EQ(readable("fat_and_muscle"), "fat and muscle");
        EXPECT_EQ(readable("left_rib_5"), "left rib 5");
        EXPECT_EQ(readable("rib_left_5"), "left rib 5");
        EXPECT_EQ(readable("lung_upper_lobe_right"), "right lung upper lobe");
        EXPECT_EQ(readable("lung_left_deflated"), "left lung deflated");
        EXPECT_EQ(readable("lung_left, rib_right_12 (estimated)"), "left lung, right rib 12 (estimated)");
        EXPECT_EQ(readable("rib_left_"), "left rib ");
        EXPECT_EQ(readable("turned_left_twice"), "turned left twice");
        EXPECT_EQ(readable("lung left"), "lung left") << "words are not turned, only names are";
        EXPECT_EQ(readable(""), "");
    }

} // namespace
} // namespace retractor
