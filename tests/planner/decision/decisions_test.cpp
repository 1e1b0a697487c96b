#include "planner/decision/decisions.h"

#include "mesh/base/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace retractor::planner {
namespace decisions_test {

    using test_support::message_of;

    Decisions some()
    {
        return { .choices
            = { { .approach = "median", .by = "A. Suzuki", .why = "old scar", .when = "2026-11-26T10:00:00Z" },
                { .approach = "midcab",
                    .by = "the team",
                    .why = "seen best",
                    .when = "2026-11-27T10:00:00Z",
                    .plan = "Shows 53 % of the aneurysm." } },
            .answers
            = { { .by = "B", .when = "2026-11-27T11:00:00Z", .points = { 1, 2, 3, 4, 5, 1 }, .note = "colours" } } };
    }

    Decisions decisions_of(const std::string& text)
    {
        const test_support::TemporaryFolder folder;
        std::ofstream(folder / "case.decisions.json") << text;
        return read_decisions(folder / "case.decisions.json");
    }

    TEST(Decisions, AreReadAsTheyWereWritten)
    {
        const test_support::TemporaryFolder folder;
        const std::filesystem::path file = folder / "written.decisions.json";
        EXPECT_TRUE(read_decisions(file).choices.empty()) << "no file, no decision";
        write_decisions(file, some());
        const Decisions read = read_decisions(file);
        ASSERT_EQ(read.choices.size(), 2U);
        EXPECT_EQ(read.choices[1].approach, "midcab");
        EXPECT_EQ(read.choices[1].plan, "Shows 53 % of the aneurysm.");
        EXPECT_EQ(read.choices[0].plan, "");
        ASSERT_EQ(read.answers.size(), 1U);
        EXPECT_EQ(read.answers[0].points, some().answers[0].points);
        EXPECT_EQ(read.answers[0].note, "colours");
    }

    TEST(Decisions, ADamagedFileIsRefusedWithThePlace)
    {
        const auto message = [](const std::string& text) { return message_of([&] { (void)decisions_of(text); }); };
        EXPECT_NE(message("{").find("this is not JSON"), std::string::npos);
        EXPECT_NE(message("[]").find("an object is expected"), std::string::npos);
        EXPECT_NE(message(R"({"schema":2,"choices":[],"answers":[]})").find("/schema"), std::string::npos);
        EXPECT_NE(message(R"({"schema":1,"choices":[],"answers":[],"more":1})").find("/more"), std::string::npos);
        EXPECT_NE(message(R"({"schema":1,"choices":[{"approach":"a","by":"b","when":"c"}],"answers":[]})")
                      .find("/choices/0/why"),
            std::string::npos);
        EXPECT_NE(message(R"({"schema":1,"choices":[{"approach":"a","by":" ","why":"w","when":"c"}],"answers":[]})")
                      .find("/choices/0/by"),
            std::string::npos);
        const auto with = [](const std::string& shape) {
            return R"({"schema":1,"choices":[],"answers":[{"by":"B","when":"c","points":{"shape":)" + shape
                + R"(,"location":1,"quality":1,"planning":1,"crisis":1,"necessity":1}}]})";
        };
        EXPECT_EQ(decisions_of(with("5")).answers[0].points[0], 5);
        for (const char* wrong : { "0", "6", "2.5", "\"3\"", "null" })
            EXPECT_NE(message(with(wrong)).find("/answers/0/points/shape"), std::string::npos) << wrong;
    }

    TEST(Decisions, NothingIsWrittenThatCouldNotBeRead)
    {
        const test_support::TemporaryFolder folder;
        const std::filesystem::path file = folder / "kept.decisions.json";
        write_decisions(file, some());
        Decisions wrong = some();
        wrong.answers[0].points[2] = 6;
        EXPECT_THROW(write_decisions(file, wrong), InputError);
        wrong = some();
        wrong.choices[0].why = "\n";
        EXPECT_THROW(write_decisions(file, wrong), InputError);
        EXPECT_EQ(read_decisions(file).choices.size(), 2U) << "what was there stays";
    }

    TEST(Decisions, TheLastAnswersOfAPersonToACaseCount)
    {
        const Answers first { .by = "A", .when = {}, .points = { 1, 1, 1, 1, 1, 1 } };
        const Answers again { .by = "A", .when = {}, .points = { 5, 4, 3, 2, 1, 5 } };
        const Answers other { .by = "B", .when = {}, .points = { 2, 4, 3, 3, 3, 5 } };
        const auto summary = summary_of({ { first, other, again }, {}, { first } });
        EXPECT_EQ(summary[0].answers, 3);
        constexpr double kRoundOff = 1e-12;
        EXPECT_NEAR(summary[0].mean, (5.0 + 2.0 + 1.0) / 3.0, kRoundOff);
        EXPECT_EQ(summary[0].least, 1);
        EXPECT_EQ(summary[0].most, 5);
        EXPECT_EQ(summary[1].count, (std::array<int, kMostPoints> { 1, 0, 0, 2, 0 }));
        EXPECT_EQ(summary_of({})[3].answers, 0);
        EXPECT_FALSE(summary_of({})[3].least);
    }

    TEST(Decisions, TheChoiceIsOneSentence)
    {
        EXPECT_EQ(
            choice_sentence(some().choices[1], "MIDCAB"), "Chosen: MIDCAB, by the team on 2026-11-27: seen best.");
    }

    NamedView from_the_left()
    {
        return { .name = "from the left",
            .approach = "median",
            .opened = false,
            .eye = { 100.25, -200.5, 300.0 },
            .aim = { 1, 2, 3 },
            .up = Vec3::UnitZ(),
            .view_angle_deg = 22.5 };
    }

    TEST(Decisions, NamedViewsAreReadAsTheyWereWritten)
    {
        const test_support::TemporaryFolder folder;
        Decisions with_view = some();
        with_view.views = { from_the_left() };
        write_decisions(folder / "case.decisions.json", with_view);
        const Decisions read = read_decisions(folder / "case.decisions.json");
        ASSERT_EQ(read.views.size(), 1U);
        EXPECT_EQ(read.views[0].name, "from the left");
        EXPECT_EQ(read.views[0].approach, "median");
        EXPECT_FALSE(read.views[0].opened);
        EXPECT_EQ(read.views[0].eye, from_the_left().eye);
        EXPECT_EQ(read.views[0].aim, from_the_left().aim);
        EXPECT_EQ(read.views[0].up, from_the_left().up);
        EXPECT_EQ(read.views[0].view_angle_deg, 22.5);
        EXPECT_EQ(read.choices.size(), 2U);
    }

    TEST(Decisions, NotesAreKeptByStepAndTakenOutWhenTheyAreEmpty)
    {
        Decisions decisions;
        set_note(decisions, "median: the incision", "show the scar first");
        set_note(decisions, "Comparison", "ask Dr. Mori");
        set_note(decisions, "median: the incision", "show the \"scar\" first\nthen the CT");
        const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "notes.decisions.json";
        write_decisions(file, decisions);
        Decisions read = read_decisions(file);
        ASSERT_EQ(read.notes.size(), 2U);
        EXPECT_EQ(note_of(read, "median: the incision"), "show the \"scar\" first\nthen the CT");
        EXPECT_EQ(note_of(read, "Comparison"), "ask Dr. Mori");
        EXPECT_EQ(note_of(read, "another"), "");
        set_note(read, "Comparison", "");
        EXPECT_EQ(read.notes.size(), 1U);
    }

    TEST(Decisions, TwoToFourPlannedApproachesAreCompared)
    {
        Case planned_case;
        for (const char* name : { "a", "b", "c", "d", "e", "f" })
            planned_case.approaches.emplace_back().name = name;
        const auto compared = [&](std::vector<std::size_t> planned, std::vector<std::string> chosen) {
            Decisions decisions;
            decisions.compared = std::move(chosen);
            return compared_approaches(planned_case, planned, decisions);
        };
        using Indices = std::vector<std::size_t>;
        EXPECT_EQ(compared({ 0, 1, 2, 3, 5 }, {}), (Indices { 0, 1, 2, 3 }));
        EXPECT_EQ(compared({ 0, 1, 2, 3, 5 }, { "f", "b" }), (Indices { 1, 5 })) << "in the order of the case";
        EXPECT_EQ(compared({ 0, 1, 2 }, { "f", "b" }), (Indices { 0, 1, 2 })) << "f is not planned";
        EXPECT_EQ(compared({ 0, 1, 2, 3, 4, 5 }, { "a", "b", "c", "d", "e" }), (Indices { 0, 1, 2, 3 }));
        EXPECT_EQ(compared({ 4 }, {}), (Indices { 4 }));
        Decisions chosen;
        chosen.choices.push_back({ .approach = "f", .by = "A", .why = "b", .when = "c" });
        EXPECT_EQ(compared_approaches(planned_case, { 0, 1, 2, 3, 5 }, chosen), (Indices { 0, 1, 2, 5 }))
            << "what is chosen is shown";
        const test_support::TemporaryFolder folder;
        Decisions kept = some();
        kept.compared = { "f", "b" };
        write_decisions(folder / "case.decisions.json", kept);
        EXPECT_EQ(read_decisions(folder / "case.decisions.json").compared, kept.compared);
        EXPECT_NE(message_of([] {
            (void)decisions_of(R"({"schema":1,"choices":[],"answers":[],"compared":["a",2]})");
        }).find("/compared/1"),
            std::string::npos);
    }

    TEST(Decisions, AViewFromWhichNothingCanBeDrawnIsRefused)
    {
        const auto refused = [](auto change) {
            NamedView view = from_the_left();
            change(view);
            return message_of([&] { check_view(view, "/views/0"); });
        };
        EXPECT_EQ(refused([](NamedView&) {}), "");
        EXPECT_NE(refused([](NamedView& view) { view.name.clear(); }).find("/views/0/name"), std::string::npos);
        EXPECT_NE(refused([](NamedView& view) { view.eye = view.aim; }).find("/views/0/eye_mm"), std::string::npos);
        EXPECT_NE(refused([](NamedView& view) { view.aim.x() = std::nan(""); }).find("/eye_mm"), std::string::npos);
        EXPECT_NE(
            refused([](NamedView& view) { view.up = view.aim - view.eye; }).find("/views/0/up"), std::string::npos);
        for (const double angle : { 0.0, 180.0, std::nan("") })
            EXPECT_NE(refused([&](NamedView& view) { view.view_angle_deg = angle; }).find("/view_angle_deg"),
                std::string::npos);
        const std::string begin
            = R"({"schema":1,"choices":[],"answers":[],"views":[{"name":"a","approach":"b","opened":)";
        const auto message
            = [&](const std::string& rest) { return message_of([&] { (void)decisions_of(begin + rest); }); };
        EXPECT_NE(message(R"(1,"eye_mm":[0,0,0],"aim_mm":[1,0,0],"up":[0,0,1],"view_angle_deg":30}]})").find("/opened"),
            std::string::npos);
        EXPECT_NE(
            message(R"(true,"eye_mm":[0,0],"aim_mm":[1,0,0],"up":[0,0,1],"view_angle_deg":30}]})").find("/eye_mm"),
            std::string::npos);
        EXPECT_EQ(message(R"(true,"eye_mm":[0,0,0],"aim_mm":[1,0,0],"up":[0,0,1],"view_angle_deg":30}]})"), "");
    }

} // namespace decisions_test
} // namespace retractor::planner
