#include "planner/measures/sight/finger_text.h"

#include <gtest/gtest.h>

namespace retractor::planner {
namespace finger_text_test {

    TEST(FingerText, SaysWhatIsTouchedOrHowMuchAFingerLacks)
    {
        FieldMetrics field;
        field.target = "lung_left";
        EXPECT_EQ(finger_text(field), "No straight finger comes to the left lung through the opening.");
        field.reached_by_finger = 0.12;
        EXPECT_EQ(finger_text(field), "A finger touches 12 %.");
        field.reached_by_finger = 0.001;
        EXPECT_EQ(finger_text(field), "A finger touches less than 1 %.");
        field.reached_by_finger = 0.0;
        field.finger_lacks_mm = 0.2;
        EXPECT_EQ(finger_text(field), "A finger ends 1 mm before the left lung.");
    }

} // namespace finger_text_test
} // namespace retractor::planner
