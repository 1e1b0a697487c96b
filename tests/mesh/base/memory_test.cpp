#include "mesh/base/memory.h"

#include <gtest/gtest.h>

namespace retractor {

TEST(Memory, WhatIsAvailableIsAPartOfWhatTheMachineHas)
{
    const Memory memory = memory_of_machine();
    ASSERT_TRUE(memory.total && memory.available);
    EXPECT_GT(*memory.available, 0.0);
    EXPECT_LT(*memory.available, *memory.total);
}

TEST(Memory, AContainersLimitCounts)
{
    const Memory memory = memory_of_machine();
    const auto available = available_memory();
    ASSERT_TRUE(available);
    if (memory.left_in_container) {
        EXPECT_LE(*available, 1.01 * *memory.left_in_container); // other programs free and take memory meanwhile
    }
}

} // namespace retractor
