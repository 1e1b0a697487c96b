#include "mesh/base/triple_buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace retractor {
namespace triple_buffer_test {

    TEST(TripleBuffer, GivesTheNewestValueAndKeepsItUntilTheNext)
    {
        TripleBuffer<int> buffer(7);
        EXPECT_FALSE(buffer.has_news());
        EXPECT_EQ(buffer.latest(), 7);
        for (int value : { 1, 2, 3 }) {
            buffer.draft() = value;
            buffer.publish();
        }
        EXPECT_TRUE(buffer.has_news());
        EXPECT_EQ(buffer.latest(), 3);
        EXPECT_FALSE(buffer.has_news());
        EXPECT_EQ(buffer.latest(), 3);
    }

    TEST(TripleBuffer, NeverShowsAHalfWrittenValueNorAnOlderOneAfterANewer)
    {
        constexpr int kPublished = 200'000;
        using Record = std::array<int, 16>; // all entries alike when whole
        TripleBuffer<Record> buffer(Record {});
        std::thread writer([&] {
            for (int value = 1; value <= kPublished; ++value) {
                buffer.draft().fill(value);
                buffer.publish();
            }
        });
        int last = 0;
        while (last < kPublished) {
            const Record& seen = buffer.latest();
            for (const int entry : seen)
                ASSERT_EQ(entry, seen.front());
            ASSERT_GE(seen.front(), last);
            last = seen.front();
        }
        writer.join();
    }

} // namespace triple_buffer_test
} // namespace retractor
