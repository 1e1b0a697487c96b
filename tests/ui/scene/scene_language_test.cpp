#include "ui/scene/scene_language.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace retractor::ui {
namespace scene_language_test {

    using Lines = std::vector<std::string>;

    TEST(SceneLanguage, EveryTextOfASceneIsSaid)
    {
        Scene scene;
        scene.title = "a";
        scene.notes = { "b" };
        scene.legend = { { "c", "d", {} } };
        scene.words = { { .text = "e" } };
        say_texts(scene, [](const std::string& english) { return english + "!"; });
        EXPECT_EQ(scene.title, "a!");
        EXPECT_EQ(scene.notes, Lines { "b!" });
        EXPECT_EQ(scene.legend.front().key, "c!");
        EXPECT_EQ(scene.legend.front().value, "d!");
        EXPECT_EQ(scene.words.front().text, "e!");
        say_texts(scene, {});
        EXPECT_EQ(scene.title, "a!") << "no language: nothing changes";
        EXPECT_EQ(said({}, "f"), "f");
    }

    TEST(SceneLanguage, LinesBreakBetweenWords)
    {
        EXPECT_EQ(in_lines("the blade goes deep", 10), (Lines { "the blade", "goes deep" }));
        EXPECT_EQ(in_lines("unbreakable it is", 5), (Lines { "unbreakable", "it is" }));
        EXPECT_EQ(in_lines("", 5), Lines {});
        EXPECT_EQ(in_lines("  two  blanks ", 20), Lines { "two blanks" });
    }

    TEST(SceneLanguage, JapaneseBreaksBetweenLettersAndNotBeforeAMark)
    {
        EXPECT_EQ(in_lines("最良の眼", 4), (Lines { "最良", "の眼" }));
        EXPECT_EQ(in_lines("最良。眼", 4), (Lines { "最", "良。", "眼" })) << "the mark stays with its letter";
        EXPECT_EQ(in_lines("眼に 51 % が", 6), (Lines { "眼に", "51 %", "が" }));
        EXPECT_EQ(in_lines("深さ47mm", 8), Lines { "深さ47mm" });
        EXPECT_EQ(in_lines("深さ47mm", 7), (Lines { "深さ", "47mm" })) << "a number stays whole";
    }

} // namespace scene_language_test
} // namespace retractor::ui
