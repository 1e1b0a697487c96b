// The conference, enlarged pictures, labels on slices and the log, by mouse and keyboard events.

#include "tests/support/synthetic_patient.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/window/dialog_help.h"
#include "tests/support/window/window_help.h"
#include "tests/support/window/window_pictures.h"

#include "ui/workstation/conference/notes_window.h"
#include "ui/workstation/help/manual_window.h"
#include "ui/workstation/help/session_log.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"

#include <gtest/gtest.h>

#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMenuBar>
#include <QMouseEvent>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QRadioButton>
#include <QTest>
#include <QTextBlock>
#include <QTextBrowser>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui {
namespace conference_window_test {

    using test_support::button_of;
    using test_support::fill_next_dialog;
    using test_support::name_next_file;

    std::filesystem::path picture_file(const test_support::TemporaryFolder& folder, const char* name)
    {
        return test_support::picture_file(folder.path, name);
    }

    bool keep_picture(QDialog& dialog, const test_support::TemporaryFolder& folder, const char* name)
    {
        return test_support::keep_picture(dialog, picture_file(folder, name));
    }

    class ConferenceTest : public testing::Test {
    protected:
        void open_synthetic()
        {
            test_support::show_window(window_);
            window_.open(test_support::synthetic_case());
            test_support::wait_until_idle(window_);
        }
        planner::Case open_on_disk(const std::filesystem::path& folder)
        {
            test_support::show_window(window_);
            planner::Case planned_case = test_support::synthetic_case();
            planned_case.folder = folder;
            window_.open(planned_case);
            test_support::wait_until_idle(window_);
            return planned_case;
        }
        void plan(const std::string& name)
        {
            window_.select(name);
            window_.plan_selected();
            test_support::wait_until_idle(window_);
        }
        void press(Qt::Key key, Qt::KeyboardModifiers with = {})
        {
            QTest::keyClick(&window_, key, with);
            test_support::wait_until_idle(window_);
        }
        std::string title() { return window_.conference_bar().title().toStdString(); }

        std::shared_ptr<test_support::SyntheticControl> control_ = std::make_shared<test_support::SyntheticControl>();
        MainWindow window_ { [this](const planner::Case&) { return test_support::synthetic_backend(control_); } };
    };

    TEST_F(ConferenceTest, ShowsThePlansStepByStep)
    {
        open_synthetic();
        plan("median");
        plan("lateral");
        window_.select("median");
        press(Qt::Key_F5);
        ASSERT_TRUE(window_.in_conference());
        EXPECT_FALSE(window_.menuBar()->isVisible());
        EXPECT_FALSE(window_.approach_list().isVisible());
        EXPECT_TRUE(window_.conference_bar().isVisible());
        // median: the incision, what is cut, opened, what is seen and reached; lateral: the same; broken: the incision
        // and what is cut; both plans beside each other.
        const std::vector<ViewPreset> views { ViewPreset::overview, ViewPreset::overview, ViewPreset::overview,
            ViewPreset::surgeon, ViewPreset::surgeon, ViewPreset::overview, ViewPreset::overview, ViewPreset::overview,
            ViewPreset::surgeon, ViewPreset::surgeon, ViewPreset::overview, ViewPreset::overview, ViewPreset::compare };
        const test_support::TemporaryFolder folder;
        const auto is_shown = [&](const char* name) {
            return std::ranges::count(window_.view().scenes().front().surfaces, name, &SurfaceItem::name) > 0;
        };
        for (std::size_t step = 0; step < views.size(); ++step) {
            EXPECT_EQ(window_.model()->shown_view(), views[step]) << step << " " << title();
            const bool reaches = title().find("reaches") != std::string::npos;
            EXPECT_EQ(reaches, step == 4 || step == 9) << title();
            const bool cuts = title().find("what is cut") != std::string::npos;
            EXPECT_EQ(cuts, step == 1 || step == 6 || step == 11) << title();
            EXPECT_EQ(window_.model()->wall_look(), cuts ? WallLook::see_through : WallLook::solid) << title();
            EXPECT_EQ(is_shown("planned cut"), cuts) << title();
            EXPECT_EQ(is_shown("heart"), cuts) << title();
            if (step == 1)
                window_.save_screenshot(picture_file(folder, "window-cut.png"));
            EXPECT_EQ(window_.model()->map(), reaches ? std::optional(FieldMapKind::reach) : std::nullopt);
            if (reaches) {
                EXPECT_EQ(window_.view().scenes().front().legend.front().key, "reach through the wound");
            }
            EXPECT_FALSE(window_.conference_bar().text().isEmpty()) << title();
            if (step + 1 < views.size())
                press(step % 2 == 0 ? Qt::Key_Right : Qt::Key_PageDown);
        }
        EXPECT_EQ(title(), "Comparison");
        press(Qt::Key_Right); // there is no further step
        EXPECT_EQ(title(), "Comparison");
        window_.save_screenshot(picture_file(folder, "window-conference.png"));
        press(Qt::Key_Home);
        EXPECT_FALSE(window_.model()->show_opened()) << "it begins before the cut";
        press(Qt::Key_PageDown);
        EXPECT_FALSE(window_.model()->show_opened()) << "it is cut and not opened";
        press(Qt::Key_PageDown);
        EXPECT_TRUE(window_.model()->show_opened());
        EXPECT_NE(title().find("opened"), std::string::npos);
        press(Qt::Key_Escape);
        EXPECT_FALSE(window_.in_conference());
        EXPECT_TRUE(window_.menuBar()->isVisible());
        EXPECT_TRUE(window_.approach_list().isVisible());
        EXPECT_FALSE(window_.conference_bar().isVisible());
    }

    TEST_F(ConferenceTest, TheMapOfWhatIsReachedEndsWithItsStep)
    {
        open_synthetic();
        plan("median");
        window_.select("median");
        press(Qt::Key_1);
        press(Qt::Key_1, Qt::ControlModifier);
        ASSERT_EQ(window_.model()->map(), FieldMapKind::strain);
        press(Qt::Key_F5);
        press(Qt::Key_Right);
        press(Qt::Key_Right);
        EXPECT_EQ(window_.model()->map(), FieldMapKind::strain) << "another map stays";
        press(Qt::Key_Right);
        press(Qt::Key_Right);
        ASSERT_EQ(window_.model()->map(), FieldMapKind::reach) << title();
        press(Qt::Key_Left);
        EXPECT_EQ(window_.model()->map(), FieldMapKind::strain) << title();
        press(Qt::Key_Right);
        press(Qt::Key_Escape);
        EXPECT_EQ(window_.model()->map(), FieldMapKind::strain) << "as before the conference";
        EXPECT_EQ(window_.view().scenes().front().legend.front().key, "largest elongation");
    }

    TEST_F(ConferenceTest, TheManualOpensAtTheConference)
    {
        open_synthetic();
        press(Qt::Key_F5);
        press(Qt::Key_F1);
        auto* manual = window_.findChild<QWidget*>("manual");
        ASSERT_NE(manual, nullptr) << window_.message_line();
        EXPECT_EQ(manual->findChild<QTextBrowser*>()->textCursor().block().text(), "In the case conference");
        manual->close();
    }

    TEST_F(ConferenceTest, ThreePlansTurnTogetherBesideEachOther)
    {
        open_synthetic();
        plan("median");
        plan("lateral");
        press(Qt::Key_D, Qt::ControlModifier); // a copy of the lateral approach
        press(Qt::Key_P);
        press(Qt::Key_5);
        PictureView& view = window_.view();
        ASSERT_EQ(view.scenes().size(), 3U) << window_.error_line();
        const std::vector<Camera> before = view.cameras();
        const QPoint from(view.width() / 4, view.height() / 4), by(60, 20);
        QTest::mousePress(&view, Qt::LeftButton, {}, from);
        QMouseEvent move(QEvent::MouseMove, from + by, Qt::LeftButton, Qt::LeftButton, {});
        QApplication::sendEvent(&view, &move);
        QTest::mouseRelease(&view, Qt::LeftButton, {}, from + by);
        test_support::wait_until_idle(window_);
        EXPECT_TRUE(QTest::qWaitFor([&] { return !view.coarse(); }, test_support::kPatienceMs));
        for (std::size_t n = 0; n < before.size(); ++n)
            EXPECT_GT((view.cameras()[n].eye - before[n].eye).norm(), 5.0) << "picture " << n;
        const test_support::TemporaryFolder folder;
        window_.save_screenshot(picture_file(folder, "window-three.png"));
    }

    TEST_F(ConferenceTest, TheLookOfTheWallComesBackAfterTheConference)
    {
        open_synthetic();
        window_.set_wall_look(WallLook::hidden);
        press(Qt::Key_F5);
        EXPECT_EQ(window_.model()->wall_look(), WallLook::hidden);
        press(Qt::Key_Right);
        EXPECT_EQ(window_.model()->wall_look(), WallLook::see_through) << title();
        press(Qt::Key_Escape);
        EXPECT_EQ(window_.model()->wall_look(), WallLook::hidden);
    }

    TEST_F(ConferenceTest, AKeyThatChoosesAnotherPictureThanTheStepsLeavesItsCamera)
    {
        open_synthetic();
        plan("median");
        press(Qt::Key_1);
        const Camera surgeon = window_.view().camera();
        press(Qt::Key_F5);
        press(Qt::Key_Right);
        ASSERT_NE(title().find("what is cut"), std::string::npos);
        const Camera turned = window_.view().camera();
        const Vec3 outside = window_.model()->shown_state().closed->patient.camera.eye;
        EXPECT_GT((turned.eye - outside).norm(), 50.0) << "seen from the side";
        press(Qt::Key_1);
        EXPECT_LT((window_.view().camera().eye - surgeon.eye).norm(), 1e-6);
        EXPECT_EQ(window_.conference_bar().note(), "The picture is not that of this step.");
        press(Qt::Key_2);
        EXPECT_EQ(window_.conference_bar().note(), "");
        EXPECT_LT((window_.view().camera().eye - turned.eye).norm(), 1e-6);
        press(Qt::Key_Left);
        press(Qt::Key_Right);
        EXPECT_LT((window_.view().camera().eye - turned.eye).norm(), 1e-6);
        press(Qt::Key_Escape);
        EXPECT_EQ(window_.model()->view(), ViewPreset::surgeon) << "as before the conference";
        EXPECT_LT((window_.view().camera().eye - surgeon.eye).norm(), 1e-6);
    }

    TEST_F(ConferenceTest, AClickOnAComparedPictureSelectsItsApproach)
    {
        open_synthetic();
        plan("median");
        plan("lateral");
        window_.select("median");
        press(Qt::Key_5);
        ASSERT_EQ(window_.view().scenes().size(), 2U);
        const QPoint right(3 * window_.view().width() / 4, window_.view().height() / 2);
        QTest::mouseClick(&window_.view(), Qt::LeftButton, {}, right);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.model()->approach(*window_.model()->selected()).name, "lateral");
        EXPECT_EQ(window_.model()->shown_view(), ViewPreset::compare) << "the comparison stays";
    }

    TEST_F(ConferenceTest, WhatIsComparedIsChosenAndKept)
    {
        const test_support::TemporaryFolder folder;
        const planner::Case planned_case = open_on_disk(folder.path);
        plan("median");
        plan("lateral");
        press(Qt::Key_D, Qt::ControlModifier); // a copy of the lateral approach
        press(Qt::Key_P);
        press(Qt::Key_5);
        ASSERT_EQ(window_.view().scenes().size(), 3U) << window_.error_line();
        const auto click_box = [&](const QString& name) {
            auto* box = window_.findChild<QCheckBox*>("compare-" + name);
            ASSERT_NE(box, nullptr) << name.toStdString();
            ASSERT_TRUE(box->isEnabled());
            QTest::mouseClick(box, Qt::LeftButton, {}, QPoint(8, box->height() / 2));
            test_support::wait_until_idle(window_);
            QCoreApplication::processEvents();
            test_support::wait_until_idle(window_);
        };
        const std::string copy = window_.model()->approach(*window_.model()->selected()).name;
        click_box("lateral");
        ASSERT_EQ(window_.view().scenes().size(), 2U);
        EXPECT_EQ(window_.view().scenes()[0].title, "A  median");
        EXPECT_EQ(window_.view().scenes()[1].title.substr(0, 1), "C") << "letters stay with their plans";
        EXPECT_FALSE(window_.findChild<QCheckBox*>("compare-median")->isEnabled()) << "two at least";
        EXPECT_EQ(planner::read_decisions(planner::decisions_file(planned_case)).compared,
            (std::vector<std::string> { "median", copy }))
            << window_.error_line();
        window_.save_screenshot(picture_file(folder, "window-two-of-three.png"));
        press(Qt::Key_F5);
        press(Qt::Key_End);
        EXPECT_EQ(window_.view().scenes().size(), 2U) << "the conference shows the same";
        EXPECT_NE(window_.conference_bar().text().indexOf("Not shown here: lateral."), -1)
            << window_.conference_bar().text().toStdString();
        press(Qt::Key_Escape);
        click_box("lateral");
        EXPECT_EQ(window_.view().scenes().size(), 3U);
    }

    TEST_F(ConferenceTest, TheButtonsDoTheSameAndAnotherCaseEndsIt)
    {
        open_synthetic();
        plan("median");
        press(Qt::Key_F5);
        const std::string first = title();
        for (QPushButton* button : window_.conference_bar().findChildren<QPushButton*>())
            if (button->text() == "Next")
                QTest::mouseClick(button, Qt::LeftButton);
        EXPECT_NE(title(), first);
        window_.open(test_support::synthetic_case());
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(window_.in_conference());
        EXPECT_TRUE(window_.menuBar()->isVisible());
    }

    TEST_F(ConferenceTest, WithoutApproachesThePatientIsShown)
    {
        test_support::show_window(window_);
        planner::Case none = test_support::synthetic_case();
        none.approaches.clear();
        window_.open(none);
        test_support::wait_until_idle(window_);
        press(Qt::Key_F5);
        EXPECT_EQ(title(), "The patient");
        press(Qt::Key_Right);
        press(Qt::Key_End);
        EXPECT_EQ(title(), "The patient");
    }

    TEST_F(ConferenceTest, ChoicesAndAnswersAreKept)
    {
        const test_support::TemporaryFolder folder;
        const planner::Case planned_case = open_on_disk(folder.path);
        plan("lateral");
        fill_next_dialog(window_, [&folder](QDialog& dialog) {
            QPushButton* choose = button_of(dialog, "Choose");
            ASSERT_NE(choose, nullptr);
            EXPECT_FALSE(choose->isEnabled()) << "nobody and no reason is named";
            QTest::keyClicks(dialog.findChild<QLineEdit*>("by"), "Team A");
            QTest::keyClicks(dialog.findChild<QPlainTextEdit*>("why"), "shortest way");
            EXPECT_TRUE(choose->isEnabled());
            EXPECT_TRUE(keep_picture(dialog, folder, "dialog-choice.png"));
            QTest::mouseClick(choose, Qt::LeftButton);
        });
        press(Qt::Key_C, Qt::ShiftModifier);
        EXPECT_EQ(window_.error_line(), "");
        EXPECT_EQ(window_.model()->chosen_approach(), "lateral");
        EXPECT_TRUE(window_.approach_list().item(1)->text().startsWith("✓"));
        EXPECT_FALSE(window_.approach_list().item(0)->text().startsWith("✓"));
        fill_next_dialog(window_, [&folder](QDialog& dialog) {
            QPushButton* keep = button_of(dialog, "Keep the answers");
            ASSERT_NE(keep, nullptr);
            EXPECT_EQ(dialog.findChild<QLineEdit*>("by")->text(), "Team A") << "as before";
            for (const planner::Question& question : planner::kQuestions) {
                EXPECT_FALSE(keep->isEnabled());
                dialog.findChild<QRadioButton*>(QString(question.key) + "4")->click();
            }
            EXPECT_TRUE(keep_picture(dialog, folder, "dialog-questions.png"));
            QTest::mouseClick(keep, Qt::LeftButton);
        });
        press(Qt::Key_Q, Qt::ShiftModifier);
        EXPECT_NE(window_.message_line().find("1 person answered: 3D shape 4.0"), std::string::npos)
            << window_.message_line();
        const planner::Decisions kept = planner::read_decisions(planner::decisions_file(planned_case));
        ASSERT_EQ(kept.choices.size(), 1U);
        EXPECT_EQ(kept.choices[0].by, "Team A");
        EXPECT_EQ(kept.choices[0].why, "shortest way");
        EXPECT_FALSE(kept.choices[0].when.empty());
        ASSERT_EQ(kept.answers.size(), 1U);
        EXPECT_EQ(kept.answers[0].points.front(), 4);
        // Opened again it is still chosen.
        window_.open(planned_case);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.model()->chosen_approach(), "lateral");
        // A dialog that is closed decides nothing.
        fill_next_dialog(window_, [](QDialog& dialog) { dialog.reject(); });
        press(Qt::Key_C, Qt::ShiftModifier);
        EXPECT_EQ(planner::read_decisions(planner::decisions_file(planned_case)).choices.size(), 1U);
    }

    /// The first lines of a file.
    std::string text_of(const std::filesystem::path& file)
    {
        std::ifstream in(file);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    TEST_F(ConferenceTest, MovieAndReportAreSavedFromTheConference)
    {
        const test_support::TemporaryFolder folder;
        open_synthetic();
        press(Qt::Key_R, Qt::ControlModifier); // no dialog opens: there is no plan to report
        plan("median");
        press(Qt::Key_F5);
        name_next_file(window_, folder.path / "film"); // the ending is added
        press(Qt::Key_M, Qt::ControlModifier);
        EXPECT_EQ(text_of(folder.path / "film.webm"), "median");
        EXPECT_TRUE(window_.in_conference());
        EXPECT_NE(window_.message_line().find("Saved"), std::string::npos);
        auto* note = window_.conference_bar().findChild<QLabel*>("note");
        ASSERT_NE(note, nullptr);
        EXPECT_TRUE(note->isVisible());
        EXPECT_TRUE(note->text().startsWith("Saved")) << note->text().toStdString();
        name_next_file(window_, folder.path / "case.html");
        for (QPushButton* button : window_.conference_bar().findChildren<QPushButton*>())
            if (button->text() == "Report…")
                QTest::mouseClick(button, Qt::LeftButton);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(text_of(folder.path / "case.html"), "report");
        window_.save_movie(folder.path / "frames.webm", true);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(text_of(folder.path / "frames.webm"), "median with pictures");
    }

    TEST_F(ConferenceTest, ThePresenterHasNotesThatAreKeptByStep)
    {
        const test_support::TemporaryFolder folder;
        const planner::Case planned_case = open_on_disk(folder.path);
        press(Qt::Key_F6);
        EXPECT_FALSE(window_.notes().isVisible()) << "there is no conference";
        press(Qt::Key_F5);
        press(Qt::Key_F6);
        ASSERT_TRUE(window_.notes().isVisible());
        EXPECT_TRUE(window_.notes().next().startsWith("Next: ")) << window_.notes().next().toStdString();
        auto* note = window_.notes().findChild<QPlainTextEdit*>("note");
        ASSERT_NE(note, nullptr);
        const std::string first = title();
        note->setPlainText("show the scar first");
        QTest::keyClick(note, Qt::Key_PageDown); // while notes are written
        test_support::wait_until_idle(window_);
        EXPECT_NE(title(), first);
        EXPECT_EQ(window_.notes().note(), "");
        const auto kept = [&] { return planner::read_decisions(planner::decisions_file(planned_case)); };
        EXPECT_EQ(planner::note_of(kept(), first), "show the scar first") << window_.error_line();
        QApplication::setActiveWindow(&window_);
        press(Qt::Key_PageUp);
        EXPECT_EQ(window_.notes().note(), "show the scar first");
        note->setPlainText("");
        press(Qt::Key_Escape); // the end keeps what was written
        EXPECT_FALSE(window_.notes().isVisible());
        EXPECT_TRUE(kept().notes.empty());
    }

    TEST_F(ConferenceTest, AnswersOverCasesAreSummedUp)
    {
        const test_support::TemporaryFolder folder;
        std::vector<std::filesystem::path> cases;
        for (const auto& [name, points] : { std::pair { "first", 4 }, { "second", 2 }, { "none", 0 } }) {
            std::filesystem::create_directories(folder / name);
            cases.push_back(folder / name / "case.json");
            planner::Answers answers { .by = "A. Suzuki", .when = "2026-11-27T09:30:00Z" };
            answers.points.fill(points);
            if (points > 0)
                planner::write_decisions(
                    planner::decisions_file(cases.back()), { .choices = {}, .answers = { answers } });
        }
        std::filesystem::create_directories(folder / "damaged");
        cases.push_back(folder / "damaged" / "case.json");
        std::ofstream(planner::decisions_file(cases.back())) << "{";
        test_support::show_window(window_);
        window_.summarize_answers(cases);
        auto* dialog = window_.findChild<QDialog*>("summary");
        ASSERT_NE(dialog, nullptr);
        const auto cell = [&](const char* name) { return dialog->findChild<QLabel*>(name)->text(); };
        EXPECT_EQ(cell("shape-0"), "2");
        EXPECT_EQ(cell("shape-1"), "3.0");
        EXPECT_EQ(cell("necessity-2"), "2 to 4");
        EXPECT_EQ(cell("necessity-4"), "1") << "one gave 2 points";
        QString said;
        for (const QLabel* label : dialog->findChildren<QLabel*>())
            said += label->text() + "\n";
        EXPECT_TRUE(said.contains("none: nobody has answered yet")) << said.toStdString();
        EXPECT_TRUE(said.contains("damaged: this is not JSON")) << said.toStdString();
        EXPECT_TRUE(keep_picture(*dialog, folder, "dialog-summary.png"));
        dialog->close();
    }

    TEST_F(ConferenceTest, ANamedViewIsAStepAndCanBeForgotten)
    {
        const test_support::TemporaryFolder folder;
        const planner::Case planned_case = open_on_disk(folder.path);
        plan("median");
        press(Qt::Key_2);
        Camera camera = window_.view().camera();
        camera.eye += Vec3(40.0, 10.0, 0.0);
        window_.view().set_camera(camera);
        fill_next_dialog(window_, [](QDialog& dialog) {
            auto* name = dialog.findChild<QLineEdit*>();
            ASSERT_NE(name, nullptr);
            EXPECT_EQ(name->text(), "View 1");
            name->setText("from the side");
            dialog.accept();
        });
        press(Qt::Key_V, Qt::ShiftModifier);
        EXPECT_EQ(window_.error_line(), "");
        const auto kept = [&] { return planner::read_decisions(planner::decisions_file(planned_case)).views; };
        ASSERT_EQ(kept().size(), 1U);
        EXPECT_TRUE(kept()[0].opened);
        press(Qt::Key_1); // another view, and the conference begins there
        press(Qt::Key_F5);
        for (int step = 0; step < 5; ++step)
            press(Qt::Key_Right);
        EXPECT_EQ(title(), "median: from the side");
        EXPECT_LT((window_.view().camera().eye - camera.eye).norm(), 1e-6);
        for (int step = 0; step < 3; ++step)
            press(Qt::Key_Left); // opened, from outside, as the kept view
        EXPECT_GT((window_.view().camera().eye - camera.eye).norm(), 1.0) << "other steps keep their own camera";
        press(Qt::Key_Escape);
        press(Qt::Key_2);
        fill_next_dialog(window_, [](QDialog& dialog) { // the same name again
            dialog.findChild<QLineEdit*>()->setText("from the side");
            dialog.accept();
        });
        press(Qt::Key_V, Qt::ShiftModifier);
        EXPECT_NE(window_.error_line().find("of this name already"), std::string::npos);
        EXPECT_EQ(kept().size(), 1U);
        fill_next_dialog(window_, [](QDialog& dialog) { dialog.accept(); });
        for (QAction* action : window_.findChildren<QAction*>())
            if (action->text().startsWith("Forget a kept view"))
                action->trigger();
        test_support::wait_until_idle(window_);
        EXPECT_TRUE(kept().empty());
    }

    TEST_F(ConferenceTest, SavingCanBeCancelledAndItsFailureIsSaid)
    {
        const test_support::TemporaryFolder folder;
        open_synthetic();
        plan("median");
        control_->hold_files = true;
        window_.save_movie(folder.path / "film.webm");
        auto* cancel = window_.findChild<QPushButton*>("cancel");
        ASSERT_NE(cancel, nullptr);
        EXPECT_TRUE(cancel->isVisible());
        EXPECT_FALSE(window_.idle());
        QTest::mouseClick(cancel, Qt::LeftButton);
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(std::filesystem::exists(folder.path / "film.webm"));
        EXPECT_EQ(window_.message_line(), "Not saved: cancelled");
        EXPECT_FALSE(cancel->isVisible());
        control_->hold_files = false;
        window_.save_movie(folder.path / "nowhere" / "film.webm");
        test_support::wait_until_idle(window_);
        EXPECT_NE(window_.error_line(), "");
    }

    TEST_F(ConferenceTest, ADoubleClickLetsOnePictureFillTheView)
    {
        open_synthetic();
        press(Qt::Key_3);
        PictureView& view = window_.view();
        ASSERT_EQ(view.scenes().size(), 4U);
        const auto twice = [&](double across, double down) {
            QTest::mouseDClick(&view, Qt::LeftButton, {},
                QPoint(static_cast<int>(across * view.width()), static_cast<int>(down * view.height())));
            test_support::wait_until_idle(window_);
        };
        const Vec3 place = *window_.model()->slice_place();
        const QPoint coronal(static_cast<int>(0.7 * view.width()), static_cast<int>(0.2 * view.height()));
        QTest::mouseClick(&view, Qt::LeftButton, {}, coronal); // as the first click of a real double click
        QTest::mouseDClick(&view, Qt::LeftButton, {}, coronal);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(view.scenes().size(), 1U);
        EXPECT_LT((*window_.model()->slice_place() - place).norm(), 1e-9) << "the slices stay where they were";
        EXPECT_EQ(view.scenes().front().slices.front().plane, SlicePlane::coronal);
        twice(0.5, 0.5);
        EXPECT_EQ(view.scenes().size(), 4U);
        twice(0.75, 0.75); // the picture in space
        ASSERT_EQ(view.scenes().size(), 1U);
        EXPECT_TRUE(view.scenes().front().slices.empty());
        press(Qt::Key_2);
        press(Qt::Key_3);
        EXPECT_EQ(view.scenes().size(), 4U) << "another view shows all again";
    }

    TEST_F(ConferenceTest, LabelsOnSlicesCanBeHidden)
    {
        open_synthetic();
        press(Qt::Key_3);
        const auto slice = [&] { return window_.view().scenes().front().slices.front(); };
        press(Qt::Key_N, Qt::ShiftModifier);
        EXPECT_TRUE(slice().outline_of_label.empty());
        press(Qt::Key_O, Qt::ShiftModifier);
        EXPECT_EQ(slice().fill, 0.0);
        press(Qt::Key_F, Qt::ShiftModifier);
        EXPECT_GT(slice().fill, 0.0);
    }

    TEST_F(ConferenceTest, TheLogHoldsWhatTheWindowSaidAndNoPath)
    {
        open_synthetic();
        window_.open_file("/no/such/Doe_John/case.json");
        test_support::wait_until_idle(window_);
        EXPECT_NE(window_.error_line().find("Doe_John"), std::string::npos);
        const std::string log = window_.log_text();
        EXPECT_NE(log.find("error: "), std::string::npos);
        EXPECT_NE(log.find("Retractor "), std::string::npos);
        EXPECT_NE(log.find("OpenGL: "), std::string::npos);
        EXPECT_EQ(log.find("Doe"), std::string::npos) << log;
    }

    TEST(SessionLog, LeavesPathsOut)
    {
        EXPECT_EQ(without_paths("cannot read /home/doe/ct.nrrd: it is short"), "cannot read …: it is short");
        EXPECT_EQ(without_paths("~/x and ./y and ../z/w"), "… and … and …");
        EXPECT_EQ(without_paths("3 mm/s at 3/4"), "3 mm/s at 3/4");
        EXPECT_EQ(without_paths("\"/a/b\""), "\"…\"");
        EXPECT_EQ(
            without_paths("must be above 0 (/approaches/0/depth_mm)"), "must be above 0 (/approaches/0/depth_mm)");
    }

    TEST(SessionLog, LeavesTheNamesOfKnownFilesOut)
    {
        SessionLog log;
        log.hide("/data/Doe John/Doe_John.png");
        log.hide("Miller/case.json");
        log.add("message", "Saved /data/Doe John/Doe_John.png");
        log.add("error", "Miller/case.json is damaged; Doe_John");
        const std::string text = log.text("none");
        for (const char* name : { "Doe", "John", "Miller" })
            EXPECT_EQ(text.find(name), std::string::npos) << text;
        EXPECT_NE(text.find("is damaged"), std::string::npos);
        EXPECT_EQ(log.size(), 2U);
    }

    TEST(Manual, IsFoundAboveTheProgramAndOpensAtAHeading)
    {
        const test_support::TemporaryFolder folder;
        std::filesystem::create_directories(folder.path / "docs/user");
        std::filesystem::create_directories(folder.path / "build/release/bin");
        std::ofstream(folder.path / "docs/user/workstation.md")
            << "# The workstation\n\n[more](more.md)\n\n"
            << std::string(20000, 'x') << "\n\n## Measuring\n\nWith R.\n";
        const auto found = manual_folder(folder.path / "build/release/bin");
        ASSERT_TRUE(found);
        EXPECT_FALSE(manual_folder(folder.path / "build"));
        QWidget* window = show_manual(*found, "workstation.md", "Measuring");
        auto* browser = window->findChild<QTextBrowser*>();
        ASSERT_NE(browser, nullptr);
        EXPECT_TRUE(browser->toPlainText().contains("With R."));
        EXPECT_EQ(browser->textCursor().block().text(), "Measuring");
        delete window;
    }

} // namespace conference_window_test
} // namespace retractor::ui
