// The whole way with the real planner, by keys and clicks: a phantom's files, a case, three plans, what is felt through
// the wound, what is compared and chosen, the six questions, the conference, its movie and the report. The pictures are
// kept where RETRACTOR_PICTURES says, to be looked at.

#include "tests/support/block_case.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/window/dialog_help.h"
#include "tests/support/window/window_help.h"
#include "tests/support/window/window_pictures.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "planner/case/case_io.h"
#include "planner/decision/decisions.h"
#include "planner/palpation/palpable.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"

#include <gtest/gtest.h>

#include <QPlainTextEdit>
#include <QRadioButton>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

namespace retractor::ui {
namespace whole_way_test {

    using test_support::target_pixels;

    constexpr std::array<double, 3> kOpeningsMm { 10.0, 16.0, 22.0 };

    /// A block with a CT and three approaches that open it more and more.
    planner::Case three_openings(const std::filesystem::path& folder)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        planner::Case planned_case = test_support::block_case("whole_way", phantom);
        planned_case.folder = folder;
        datasets::write_volume(folder / "ct.nrrd", phantom.ct);
        datasets::write_label_volume(folder / "labels.nrrd", phantom.labels);
        planned_case.ct = planner::make_reference(folder, folder / "ct.nrrd");
        planned_case.labels = planner::make_reference(folder, folder / "labels.nrrd");
        planned_case.solution.element = planner::ElementKind::p1; // quick: no force is looked at
        for (const double opening_mm : kOpeningsMm) {
            planner::Approach approach
                = test_support::block_approach(phantom.labels, Eigen::Isometry3d::Identity(), opening_mm);
            approach.name = "open_" + std::to_string(static_cast<int>(opening_mm)) + "_mm";
            planner::add_approach(planned_case, approach);
        }
        planner::write_case(planned_case);
        return planned_case;
    }

    class WholeWay : public testing::Test {
    protected:
        void press(Qt::Key key, Qt::KeyboardModifiers with = {})
        {
            QTest::keyClick(&window_, key, with);
            test_support::wait_until_idle(window_);
        }
        void shoot(const char* name)
        {
            window_.save_screenshot(test_support::picture_file(folder_.path, name));
            EXPECT_EQ(window_.error_line(), "") << name;
            EXPECT_EQ(window_.view().drawing_errors(), "") << name;
        }
        std::string bytes_of(const char* name)
        {
            std::ifstream in(folder_ / name, std::ios::binary);
            return { std::istreambuf_iterator<char>(in), {} };
        }
        std::string title() { return window_.conference_bar().title().toStdString(); }

        static constexpr MovieSettings kSmall { .width = 320, .height = 240, .frames_per_second = 5, .hold_s = 1.0 };
        test_support::TemporaryFolder folder_;
        MainWindow window_ { [](const planner::Case& one) { return make_planning_backend(one, {}, kSmall); } };
    };

    TEST_F(WholeWay, FromTheFilesToTheMovieAndTheReport)
    {
        const planner::Case planned_case = three_openings(folder_.path);
        std::optional<ShownWound> wound;
        window_.on_palpable_wound = [&](ShownWound made) { wound = std::move(made); };
        test_support::show_window(window_);
        window_.open_file(folder_ / "case.json");
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.approach_list().count(), 3) << window_.error_line();

        press(Qt::Key_P, Qt::ShiftModifier);
        for (std::size_t n = 0; n < 3; ++n)
            ASSERT_EQ(window_.model()->state(n).status, FieldStatus::planned) << n << window_.error_line();
        shoot("way-planned.png");
        EXPECT_GT(window_.model()->state(0).field->metrics.visible_fraction, 0.0);
        EXPECT_GT(test_support::distinct_colours(window_.view().picture()), test_support::kColoursOfAPicture);
        EXPECT_GT(target_pixels(window_.view().picture()), 0);

        press(Qt::Key_T, Qt::ControlModifier);
        ASSERT_TRUE(wound) << window_.error_line();
        EXPECT_EQ(wound->ways.size(), 2U);
        const std::vector<std::string>& names = wound->ways.front().access->around().names();
        EXPECT_NE(std::ranges::find(names, "skin"), names.end()) << "the wall is round it";

        press(Qt::Key_5);
        ASSERT_EQ(window_.view().scenes().size(), 3U);
        shoot("way-compared.png");
        const QImage compared = window_.view().picture();
        const int wide = compared.width() / 2, high = compared.height() / 2;
        const int narrowest = target_pixels(compared.copy(0, 0, wide, high)),
                  middle = target_pixels(compared.copy(wide, 0, wide, high));
        EXPECT_GT(narrowest, 0);
        EXPECT_GT(middle, narrowest) << "what is opened more shows more";

        test_support::fill_next_dialog(window_, [](QDialog& dialog) {
            QTest::keyClicks(dialog.findChild<QLineEdit*>("by"), "Team A");
            QTest::keyClicks(dialog.findChild<QPlainTextEdit*>("why"), "it shows most");
            QTest::mouseClick(test_support::button_of(dialog, "Choose"), Qt::LeftButton);
        });
        press(Qt::Key_C, Qt::ShiftModifier);
        test_support::fill_next_dialog(window_, [](QDialog& dialog) {
            for (const planner::Question& question : planner::kQuestions)
                dialog.findChild<QRadioButton*>(QString(question.key) + "4")->click();
            QTest::mouseClick(test_support::button_of(dialog, "Keep the answers"), Qt::LeftButton);
        });
        press(Qt::Key_Q, Qt::ShiftModifier);
        const planner::Decisions decided = planner::read_decisions(planner::decisions_file(planned_case));
        ASSERT_EQ(decided.choices.size(), 1U) << window_.error_line();
        EXPECT_FALSE(decided.choices[0].plan.empty()) << "what the plan says is kept with the choice";
        EXPECT_EQ(decided.answers.size(), 1U);

        press(Qt::Key_F5);
        press(Qt::Key_Home);
        const std::size_t steps = window_.conference_bar().count();
        EXPECT_EQ(steps, 3U * 6U + 1U) << "incision, blade, cut, opened, seen, reached; compared";
        for (std::size_t step = 0; step < steps; ++step) {
            EXPECT_GT(test_support::distinct_colours(window_.view().picture()), test_support::kColoursOfAPicture)
                << title();
            if (step < 6 || step + 1 == steps)
                shoot(("way-step-" + std::to_string(step + 1) + ".png").c_str());
            press(Qt::Key_Right);
        }
        EXPECT_NE(window_.conference_bar().text().indexOf("Chosen: "), -1);

        test_support::name_next_file(window_, folder_ / "movie.webm");
        press(Qt::Key_M, Qt::ControlModifier);
        EXPECT_EQ(window_.error_line(), "");
        EXPECT_EQ(bytes_of("movie.webm").substr(0, 4), "\x1A\x45\xDF\xA3") << "EBML, as WebM begins";
        constexpr std::size_t kLeastBytes = 20000; // a hundred frames are more
        EXPECT_GT(bytes_of("movie.webm").size(), kLeastBytes);
        test_support::name_next_file(window_, folder_ / "report.html");
        press(Qt::Key_R, Qt::ControlModifier);
        EXPECT_EQ(window_.error_line(), "");
        const std::string page = bytes_of("report.html");
        EXPECT_NE(page.find("it shows most"), std::string::npos) << "the report has the choice";
        EXPECT_NE(page.find("open_22_mm"), std::string::npos);
    }

} // namespace whole_way_test
} // namespace retractor::ui
