#include "planner/case/opening_protocol.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace retractor::planner {
namespace opening_protocol_test {

    std::string refused_at(const OpeningProtocol& protocol)
    {
        try {
            check_opening_protocol(protocol, "/approaches/0/opening_protocol");
        } catch (const InputError& error) {
            return error.where();
        }
        return "accepted";
    }

    TEST(OpeningProtocol, TakesWholeSteps)
    {
        const OpeningProtocol protocol; // 7 mm every 10 s
        EXPECT_EQ(step_count(protocol, 0.0), 1);
        EXPECT_EQ(step_count(protocol, 7.0), 1);
        EXPECT_EQ(step_count(protocol, 7.1), 2);
        EXPECT_EQ(step_count(protocol, 70.0), 10);
        EXPECT_EQ(opening_time(protocol, 7.0), 0.0);
        EXPECT_EQ(opening_time(protocol, 60.0), 80.0);
        // 2.1 mm are seven steps of 0.3 mm, although 2.1 / 0.3 > 7 in binary numbers
        EXPECT_EQ(step_count({ .turn_mm = 1.0, .turns_per_step = 0.3 }, 2.1), 7);
    }

    TEST(OpeningProtocol, IsFastBeyondHalfATurnIn10Seconds)
    {
        EXPECT_FALSE(is_fast({}));
        EXPECT_FALSE(is_fast({ .turns_per_step = 1.0, .wait_s = 20.0 }));
        EXPECT_TRUE(is_fast({ .wait_s = 9.0 }));
        EXPECT_TRUE(is_fast({ .turns_per_step = 1.0 }));
        EXPECT_TRUE(is_fast({ .wait_s = 0.0 }));
    }

    TEST(OpeningProtocol, IsReadAsASurgeonSaysIt)
    {
        EXPECT_EQ(opening_protocol_text({}), "half a turn of the crank (7 mm) every 10 s");
        EXPECT_EQ(opening_protocol_text({ .turn_mm = 10.0, .turns_per_step = 1.0, .wait_s = 150.0 }),
            "one turn of the crank (10 mm) every 2.5 minutes");
        EXPECT_EQ(opening_protocol_text({ .turns_per_step = 2.0, .wait_s = 0.0 }),
            "2 turns of the crank (28 mm) without a wait");
    }

    TEST(OpeningProtocol, NamesTheNumberThatIsOutOfRange)
    {
        EXPECT_EQ(refused_at({}), "accepted");
        for (const double bad : { -1.0, 1e6, std::numeric_limits<double>::quiet_NaN() }) {
            EXPECT_EQ(refused_at({ .turn_mm = bad }), "/approaches/0/opening_protocol/turn_mm");
            EXPECT_EQ(refused_at({ .turns_per_step = bad }), "/approaches/0/opening_protocol/turns_per_step");
            EXPECT_EQ(refused_at({ .wait_s = bad }), "/approaches/0/opening_protocol/wait_s");
            EXPECT_EQ(refused_at({ .hold_s = bad }), "/approaches/0/opening_protocol/hold_s");
        }
        EXPECT_EQ(refused_at({ .turn_mm = 0.0 }), "/approaches/0/opening_protocol/turn_mm");
        EXPECT_EQ(refused_at({ .turns_per_step = 0.0 }), "/approaches/0/opening_protocol/turns_per_step");
    }

} // namespace opening_protocol_test
} // namespace retractor::planner
