#include "mesh/base/open_address_map.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace retractor {
namespace open_address_map_test {

    struct Entry {
        int number = 0;
    };

    // Few keys, near each other and far apart, so that they meet in the table, leave it and come again; and enough of
    // them at once that it grows.
    TEST(OpenAddressMap, AnswersAsAMapWhateverIsErasedAndAddedAgain)
    {
        std::mt19937_64 random(11);
        OpenAddressMap<Entry> slots;
        std::map<std::uint64_t, int> expected;
        std::map<std::uint64_t, const Entry*> place;
        for (int i = 0; i < 200000; ++i) {
            const std::uint64_t key = (random() % 1500) << (random() % 2 == 0 ? 0U : 40U);
            if (random() % 3 == 0) {
                slots.erase(key);
                expected.erase(key);
                place.erase(key);
                continue;
            }
            bool is_new = false;
            Entry& entry = slots.at(key, is_new);
            const auto [at, added] = expected.try_emplace(key, i);
            ASSERT_EQ(is_new, added) << i;
            if (is_new) {
                ASSERT_EQ(entry.number, 0) << "a value used before was not made new";
                entry.number = i;
                place[key] = &entry;
            }
            ASSERT_EQ(entry.number, at->second) << i;
            ASSERT_EQ(&entry, place.at(key)) << "a reference did not stay good";
        }
        ASSERT_GT(expected.size(), 1000U);
        for (const auto& [key, number] : expected) {
            bool is_new = true;
            EXPECT_EQ(slots.at(key, is_new).number, number);
            EXPECT_FALSE(is_new);
        }
    }

    TEST(OpenAddressMap, ErasingWhatIsNotThereChangesNothing)
    {
        OpenAddressMap<Entry> slots;
        slots.erase(3);
        bool is_new = false;
        slots.at(3, is_new).number = 8;
        EXPECT_TRUE(is_new);
        slots.erase(4);
        EXPECT_EQ(slots.at(3, is_new).number, 8);
        EXPECT_FALSE(is_new);
    }

} // namespace open_address_map_test
} // namespace retractor
