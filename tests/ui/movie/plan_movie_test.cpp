#include "ui/movie/plan_movie.h"

#include "mesh/base/error.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/temporary_folder.h"
#include "tests/ui/movie/video_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>

namespace retractor::ui {
namespace plan_movie_test {

    constexpr MovieSettings kSmall { .width = 160, .height = 120, .frames_per_second = 5, .hold_s = 1.0 };

    class PlanMovie : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
            planner::Case planned_case = test_support::block_case("movie", phantom);
            patient = std::make_unique<planner::Patient>(planned_case);
            content = std::make_unique<MovieContent>();
            content->planned_case = planned_case;
            content->planned_case.approaches
                = { test_support::block_approach(*patient->labels(), Eigen::Isometry3d::Identity(), 16.0) };
            content->fields = { planner::plan_approach(*patient, content->planned_case.approaches.front()) };
        }
        static void TearDownTestSuite()
        {
            content.reset();
            patient.reset();
        }

        struct Played {
            std::vector<Image> pictures;
            std::vector<int> frames;
            bool whole = false;
        };
        static Played play(const MovieContent& shown, const Job& job = {})
        {
            OffscreenRenderer renderer(make_offscreen_context());
            Played played;
            played.whole = play_plans(
                *patient, shown, kSmall, renderer,
                [&](const Image& picture, int frames) {
                    played.pictures.push_back(picture);
                    played.frames.push_back(frames);
                },
                job);
            return played;
        }
        static inline std::unique_ptr<planner::Patient> patient;
        static inline std::unique_ptr<MovieContent> content;
    };

    TEST_F(PlanMovie, ItsTextsAreInTheLanguageThatIsAskedFor)
    {
        MovieContent shown = *content;
        std::vector<std::string> asked;
        shown.language = [&](const std::string& english) {
            asked.push_back(english);
            return std::string("a");
        };
        const Played english = play(*content), other = play(shown);
        ASSERT_EQ(other.pictures.size(), english.pictures.size());
        EXPECT_GT(test_support::mean_difference(english.pictures.front(), other.pictures.front()), 0.1);
        const auto is_title = [](const std::string& text) { return text.find("what the surgeon sees") != text.npos; };
        EXPECT_TRUE(std::ranges::any_of(asked, is_title));
    }

    TEST_F(PlanMovie, TurnsTheClosedPatientOpensTheWoundAndFliesToTheEye)
    {
        ASSERT_EQ(content->fields.front().status, planner::PlanStatus::done);
        const Played played = play(*content);
        EXPECT_TRUE(played.whole);
        // The block has no CT, so no slices: 5 pictures turn it, one shows what is cut, 6 poses open it (the last is
        // held), 10 fly, 1 is held; one more shows what is reached.
        ASSERT_EQ(played.pictures.size(), 5U + 1U + 6U + 10U + 1U + 1U);
        int frames = 0;
        for (const int n : played.frames)
            frames += n;
        EXPECT_EQ(frames, 5 + 5 + 5 * 2 + 5 + 10 + 5 + 5);
        const auto difference = [&](std::size_t a, std::size_t b) {
            return test_support::mean_difference(played.pictures.at(a), played.pictures.at(b));
        };
        EXPECT_GT(difference(0, 1), 0.1) << "the patient turns";
        EXPECT_GT(difference(0, 5), 0.5) << "the skin is looked through";
        EXPECT_GT(difference(6, 11), 0.5) << "the wound opens";
        EXPECT_LT(difference(6, 7), difference(6, 11)) << "bit by bit";
        EXPECT_GT(difference(12, 21), 1.0) << "the eye comes near";
        EXPECT_GT(difference(22, 23), 0.1) << "the target takes the colours of its reach";
    }

    TEST_F(PlanMovie, TheSamePlansGiveTheSamePictures)
    {
        const Played first = play(*content), again = play(*content);
        ASSERT_EQ(first.pictures.size(), again.pictures.size());
        for (std::size_t n = 0; n < first.pictures.size(); ++n)
            EXPECT_EQ(first.pictures[n].rgb, again.pictures[n].rgb) << n;
    }

    TEST_F(PlanMovie, AnApproachWithoutAPlanIsShownClosed)
    {
        MovieContent unplanned = *content;
        unplanned.fields.clear();
        EXPECT_EQ(play(unplanned).pictures.size(), 5U + 1U);
        unplanned.planned_case.approaches.clear();
        EXPECT_EQ(play(unplanned).pictures.size(), 1U) << "the patient alone";
    }

    TEST_F(PlanMovie, TheFileHoldsEveryFrameAndSoDoesTheFolder)
    {
        const test_support::TemporaryFolder folder;
        MovieContent closed = *content;
        closed.fields.clear();
        const auto frames = folder.path / "frames";
        std::filesystem::create_directories(frames);
        std::ofstream(frames / "00012.png") << "of a longer movie";
        ASSERT_TRUE(
            write_movie(folder.path / "movie.webm", frames, *patient, closed, kSmall, make_offscreen_context()));
        EXPECT_EQ(test_support::read_video(folder.path / "movie.webm").frames.size(), 10U);
        for (const char* name : { "00001.png", "00010.png" })
            EXPECT_TRUE(std::filesystem::exists(frames / name)) << name;
        for (const char* name : { "00011.png", "00012.png" })
            EXPECT_FALSE(std::filesystem::exists(frames / name)) << name;
        std::ofstream(frames / "notes.txt") << "of the user";
        EXPECT_THROW(
            (void)write_movie(folder.path / "movie.webm", frames, *patient, closed, kSmall, make_offscreen_context()),
            InputError);
        EXPECT_TRUE(std::filesystem::exists(frames / "notes.txt"));
    }

    TEST_F(PlanMovie, ACancelledMovieLeavesTheEarlierOne)
    {
        const test_support::TemporaryFolder folder;
        const auto path = folder.path / "movie.webm";
        std::ofstream(path) << "earlier";
        std::atomic<bool> cancel = false;
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view stage, double fraction) { cancel = stage == "movie" && fraction > 0.1; };
        EXPECT_FALSE(write_movie(path, {}, *patient, *content, kSmall, make_offscreen_context(), job));
        std::ifstream in(path);
        EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "earlier");
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1) << "nothing else is left";
    }

    TEST_F(PlanMovie, SettingsThatMakeNoMovieAreRefused)
    {
        EXPECT_THROW(check_movie({ .width = 161 }), InputError);
        EXPECT_THROW(check_movie({ .frames_per_second = 0 }), InputError);
        EXPECT_THROW(check_movie({ .hold_s = -1.0 }), InputError);
        EXPECT_NO_THROW(check_movie({}));
    }

} // namespace plan_movie_test
} // namespace retractor::ui
