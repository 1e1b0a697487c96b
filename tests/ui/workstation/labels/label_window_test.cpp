// Labels corrected in the window, by mouse and keyboard events, on a case on disk.

#include "tests/support/temporary_folder.h"
#include "tests/support/window/window_help.h"

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "planner/case/patient.h"
#include "planner/case/unsaved_labels.h"
#include "ui/workstation/labels/label_editor.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QAbstractButton>
#include <QApplication>
#include <QInputDialog>
#include <QListWidget>
#include <QMessageBox>
#include <QPushButton>
#include <QSlider>
#include <QTest>
#include <QTimer>
#include <QWheelEvent>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui {
namespace label_window_test {

    constexpr Label kMuscle = 1, kVessel = 2;

    /// A block of muscle with a vessel along the body, in a CT of 2 mm.
    planner::Case block_case(const std::filesystem::path& folder)
    {
        planner::ImportedCase imported;
        auto ct = std::make_shared<mesh::Volume>();
        auto labels = std::make_shared<mesh::LabelVolume>();
        ct->grid.size = labels->grid.size = { 50, 40, 45 };
        ct->grid.spacing = labels->grid.spacing = Vec3(2.0, 2.0, 2.0);
        labels->table = { { kMuscle, "muscle", "muscle", mesh::Role::wall },
            { kVessel, "aneurysm", "vessel", mesh::Role::target } };
        ct->voxels.assign(ct->grid.voxel_count(), 50);
        labels->voxels.assign(labels->grid.voxel_count(), kMuscle);
        for (int k = 0; k < 45; ++k)
            for (int j = 16; j < 24; ++j)
                for (int i = 20; i < 30; ++i) {
                    ct->voxels[ct->grid.offset(i, j, k)] = 300;
                    labels->voxels[labels->grid.offset(i, j, k)] = kVessel;
                }
        imported.ct = ct;
        imported.labels = labels;
        imported.structures = { { .name = "aneurysm", .volume_ml = 1.0, .rough = true, .how = "guessed" } };
        return planner::write_import(imported, folder / "case.json");
    }

    class LabelWindowTest : public testing::Test {
    protected:
        void open_labels()
        {
            test_support::show_window(window_);
            window_.open(block_case(folder_.path));
            test_support::wait_until_idle(window_);
            QTest::keyClick(&window_, Qt::Key_C);
            test_support::wait_until_idle(window_);
            ASSERT_NE(session(), nullptr) << window_.error_line();
        }
        const planner::LabelSession* session() { return window_.label_editor().session(); }
        std::size_t voxels(Label label) { return count(*session()->labels(), label); }
        static std::size_t count(const mesh::LabelVolume& labels, Label label)
        {
            return static_cast<std::size_t>(std::ranges::count(labels.voxels, label));
        }
        /// A point of the picture: fractions of its width and height from the upper left corner. The axial slice is
        /// the first of four.
        QPoint at(double across, double down)
        {
            return { static_cast<int>(across * window_.view().width()),
                static_cast<int>(down * window_.view().height()) };
        }
        void drag(const QPoint& from, const QPoint& to)
        {
            QWidget* view = &window_.view();
            QTest::mousePress(view, Qt::LeftButton, {}, from);
            for (int step = 1; step <= 4; ++step) {
                const QPoint place = from + (to - from) * step / 4;
                QMouseEvent move(QEvent::MouseMove, place, view->mapToGlobal(place), Qt::NoButton, Qt::LeftButton, {});
                QApplication::sendEvent(view, &move);
            }
            QTest::mouseRelease(view, Qt::LeftButton, {}, to);
            test_support::wait_until_idle(window_);
        }
        QAbstractButton* tool(const QString& text)
        {
            for (QAbstractButton* button : window_.label_panel().findChildren<QAbstractButton*>())
                if (button->text() == text)
                    return button;
            return nullptr;
        }
        void press(LabelPanel::Action action)
        {
            QTest::mouseClick(&window_.label_panel().button(action), Qt::LeftButton);
            test_support::wait_until_idle(window_);
        }

        test_support::TemporaryFolder folder_;
        MainWindow window_ { [](const planner::Case& planned_case) { return make_planning_backend(planned_case); } };
    };

    /// Presses a button of the message box that opens next, after some work in the background.
    void answer_next_box(QWidget& window, const QString& answer)
    {
        auto* timer = new QTimer(&window);
        QObject::connect(timer, &QTimer::timeout, &window, [timer, answer] {
            auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
            if (box == nullptr)
                return;
            timer->stop();
            for (QAbstractButton* button : box->buttons())
                if (button->text() == answer)
                    return button->click();
            box->reject();
            FAIL() << "there is no button " << answer.toStdString();
        });
        timer->start(20);
    }

    TEST_F(LabelWindowTest, ACrashLosesNoCorrections)
    {
        const planner::Case planned_case = block_case(folder_.path);
        const std::filesystem::path file = planner::unsaved_labels_file(planned_case);
        std::vector<Label> painted;
        const auto opened = [&] {
            auto window
                = std::make_unique<MainWindow>([](const planner::Case& one) { return make_planning_backend(one); });
            test_support::show_window(*window);
            window->open(planned_case);
            test_support::wait_until_idle(*window);
            return window;
        };
        {
            const auto window = opened();
            QTest::keyClick(window.get(), Qt::Key_C);
            test_support::wait_until_idle(*window);
            ASSERT_NE(window->label_editor().session(), nullptr);
            window->label_panel().choose("aneurysm");
            QTest::mouseClick(
                &window->view(), Qt::LeftButton, {}, QPoint(window->view().width() / 8, window->view().height() / 5));
            test_support::wait_until_idle(*window);
            painted = window->label_editor().session()->labels()->voxels;
            ASSERT_TRUE(window->label_editor().changed());
            ASSERT_TRUE(QTest::qWaitFor([&] { return std::filesystem::exists(file); }, test_support::kPatienceMs));
        } // the window ends without being closed
        {
            const auto window = opened();
            EXPECT_NE(window->message_line().find("not saved"), std::string::npos) << window->message_line();
            answer_next_box(*window, "Make them again");
            QTest::keyClick(window.get(), Qt::Key_C);
            test_support::wait_until_idle(*window);
            ASSERT_TRUE(window->label_editor().changed()) << window->error_line();
            EXPECT_EQ(window->label_editor().session()->labels()->voxels, painted);
        }
        const auto window = opened();
        answer_next_box(*window, "Forget them");
        QTest::keyClick(window.get(), Qt::Key_C);
        test_support::wait_until_idle(*window);
        EXPECT_FALSE(window->label_editor().changed());
        EXPECT_TRUE(QTest::qWaitFor([&] { return !std::filesystem::exists(file); }, test_support::kPatienceMs));
    }

    TEST_F(LabelWindowTest, ADragPaintsOneStepAndUndoTakesItBack)
    {
        open_labels();
        EXPECT_EQ(window_.model()->view(), ViewPreset::slices);
        EXPECT_EQ(window_.label_panel().list().count(), 2);
        window_.label_panel().choose("aneurysm");
        const std::size_t before = voxels(kVessel);
        drag(at(0.15, 0.2), at(0.3, 0.2));
        EXPECT_GT(voxels(kVessel), before + 20) << window_.message_line();
        EXPECT_TRUE(window_.label_editor().changed());
        const std::size_t painted = voxels(kVessel);
        const QString volume = QString("%1 ml").arg(static_cast<double>(painted) * 8e-3, 0, 'f', 1); // voxels of 2 mm
        EXPECT_TRUE(window_.label_panel().list().item(1)->text().contains(volume)) << volume.toStdString();
        QTest::keyClick(&window_, Qt::Key_Z, Qt::ControlModifier);
        EXPECT_EQ(voxels(kVessel), before);
        QTest::keyClick(&window_, Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
        EXPECT_EQ(voxels(kVessel), painted);
        const char* pictures = std::getenv("RETRACTOR_PICTURES");
        window_.save_screenshot(
            (pictures != nullptr ? std::filesystem::path(pictures) : folder_.path) / "window-labels.png");
        // The slices show what was painted.
        EXPECT_EQ(window_.view().scenes().front().slices.front().labels, session()->labels());
        QTest::mouseClick(tool("Erase"), Qt::LeftButton);
        drag(at(0.12, 0.2), at(0.33, 0.2));
        EXPECT_LT(voxels(kVessel), painted);
        press(LabelPanel::Action::discard);
        EXPECT_EQ(voxels(kVessel), before);
        EXPECT_FALSE(window_.label_editor().changed());
    }

    TEST_F(LabelWindowTest, ALargerBrushAndABallPaintMore)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        const auto painted_by_click = [&] {
            const std::size_t before = voxels(kVessel);
            drag(at(0.15, 0.15), at(0.15, 0.15));
            const std::size_t painted = voxels(kVessel) - before;
            QTest::keyClick(&window_, Qt::Key_Z, Qt::ControlModifier);
            return painted;
        };
        window_.label_panel().size().setValue(4);
        const std::size_t small = painted_by_click();
        window_.label_panel().size().setValue(8);
        const std::size_t large = painted_by_click();
        // Discs of 4 and 8 mm on voxels of 2 mm.
        EXPECT_NEAR(static_cast<double>(small), 12.6, 5.0);
        EXPECT_NEAR(static_cast<double>(large), 50.3, 10.0);
        QTest::mouseClick(tool("In all slices within reach"), Qt::LeftButton, {}, QPoint(8, 8));
        EXPECT_NEAR(static_cast<double>(painted_by_click()), 268.0, 30.0);
    }

    TEST_F(LabelWindowTest, TheWheelTurnsTheSlicesWhileTheBrushHasTheMouse)
    {
        open_labels();
        const double before = window_.view().scenes().front().slices.front().point.z();
        const QPoint place = at(0.2, 0.2);
        QWheelEvent wheel(
            place, window_.view().mapToGlobal(place), {}, QPoint(0, 120), Qt::NoButton, {}, Qt::NoScrollPhase, false);
        QApplication::sendEvent(&window_.view(), &wheel);
        EXPECT_TRUE(QTest::qWaitFor([&] { return window_.view().scenes().front().slices.front().point.z() != before; },
            test_support::kPatienceMs));
    }

    TEST_F(LabelWindowTest, AClickOnALabelShowsWhereItLies)
    {
        open_labels();
        QListWidget& list = window_.label_panel().list();
        const QRect row = list.visualItemRect(list.item(1));
        QTest::mouseClick(list.viewport(), Qt::LeftButton, {}, row.center());
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.label_panel().chosen(), "aneurysm");
        // The vessel of the block: i from 20 to 29, j from 16 to 23, voxels of 2 mm.
        const Vec3 place = *window_.model()->slice_place();
        EXPECT_NEAR(place.x(), 49.0, 2.0);
        EXPECT_NEAR(place.y(), 39.0, 2.0);
    }

    TEST_F(LabelWindowTest, NothingIsPaintedBeforeALabelIsChosen)
    {
        open_labels();
        EXPECT_EQ(window_.label_panel().chosen(), "");
        drag(at(0.15, 0.2), at(0.3, 0.2));
        EXPECT_FALSE(window_.label_editor().changed());
        EXPECT_NE(window_.message_line().find("Choose a label"), std::string::npos);
    }

    TEST_F(LabelWindowTest, ErasingDependsOnTheWayAndNotOnItsSteps)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        QTest::mouseClick(tool("Erase"), Qt::LeftButton);
        // From the middle of the vessel outwards: what is erased becomes muscle, and nothing is left without a label.
        drag(at(0.25, 0.25), at(0.12, 0.25));
        EXPECT_TRUE(window_.label_editor().changed());
        EXPECT_EQ(voxels(0), 0U);
    }

    TEST_F(LabelWindowTest, ARenamedLabelStaysChosen)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        QTimer::singleShot(0, &window_, [] {
            auto* dialog = qobject_cast<QInputDialog*>(QApplication::activeModalWidget());
            ASSERT_NE(dialog, nullptr);
            dialog->setTextValue("neck of the aneurysm");
            dialog->accept();
        });
        press(LabelPanel::Action::rename);
        EXPECT_EQ(window_.label_panel().chosen(), "neck_of_the_aneurysm");
        QTest::keyClick(&window_, Qt::Key_Z, Qt::ControlModifier);
        EXPECT_EQ(window_.label_panel().chosen(), "aneurysm");
    }

    TEST_F(LabelWindowTest, AWholeLabelIsEditedInTheBackground)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        window_.label_panel().size().setValue(2);
        drag(at(0.1, 0.15), at(0.1, 0.15)); // an island
        const std::size_t with_island = voxels(kVessel);
        press(LabelPanel::Action::largest);
        EXPECT_LT(voxels(kVessel), with_island);
        EXPECT_TRUE(window_.label_panel().isEnabled());
        press(LabelPanel::Action::largest);
        EXPECT_NE(window_.message_line().find("nothing to change"), std::string::npos);
    }

    TEST_F(LabelWindowTest, TheKnifeTakesTheMouseFromTheBrush)
    {
        open_labels();
        QTest::keyClick(&window_, Qt::Key_Escape);
        EXPECT_FALSE(window_.label_editor().active());
        QTest::keyClick(&window_, Qt::Key_C);
        EXPECT_TRUE(window_.label_editor().active());
        window_.close_case();
        window_.open(block_case(folder_.path / "other"));
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(window_.label_editor().active()) << "the mouse turns the picture of another case";
    }

    TEST_F(LabelWindowTest, LabelsThatCannotBeReadAreTriedAgain)
    {
        test_support::show_window(window_);
        window_.open(block_case(folder_.path));
        test_support::wait_until_idle(window_);
        window_.close_case(); // or the other window would only look
        // The patient has read its labels for the picture: a window that has not finds none.
        MainWindow other { [](const planner::Case& planned_case) {
            PlanningBackend backend = make_planning_backend(planned_case);
            backend.labels = [tries = std::make_shared<int>(0), read = backend.labels] {
                if (++*tries == 1)
                    throw IoError("the file is away", "labels.nrrd");
                return read();
            };
            return backend;
        } };
        test_support::show_window(other);
        other.open(planner::read_case(folder_.path / "case.json"));
        test_support::wait_until_idle(other);
        QTest::keyClick(&other, Qt::Key_C);
        test_support::wait_until_idle(other);
        EXPECT_EQ(other.label_editor().session(), nullptr);
        EXPECT_NE(other.error_line().find("the file is away"), std::string::npos);
        QTest::keyClick(&other, Qt::Key_2);
        QTest::keyClick(&other, Qt::Key_C);
        test_support::wait_until_idle(other);
        EXPECT_NE(other.label_editor().session(), nullptr);
    }

    TEST_F(LabelWindowTest, ACaseThatAnotherProgramChangedTakesTheLabelsToo)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        drag(at(0.15, 0.2), at(0.3, 0.2));
        const auto wanted = session()->labels();
        planner::Case other = planner::read_case(folder_.path / "case.json");
        other.accept_implausible = true;
        planner::write_case(other);
        std::filesystem::last_write_time(folder_.path / "case.json",
            std::filesystem::last_write_time(folder_.path / "case.json") + std::chrono::seconds(2));
        QTimer timer;
        bool asked = false;
        QObject::connect(&timer, &QTimer::timeout, [&] {
            if (auto* question = qobject_cast<QMessageBox*>(QApplication::activeModalWidget()); question && !asked) {
                asked = true;
                question->buttons().front()->click();
            }
        });
        timer.start(20);
        press(LabelPanel::Action::save);
        EXPECT_TRUE(asked);
        const planner::Case saved = planner::read_case(folder_.path / "case.json");
        EXPECT_TRUE(saved.accept_implausible) << "what the other program wrote stays";
        planner::Patient patient(saved);
        EXPECT_EQ(patient.labels()->voxels, wanted->voxels);
    }

    TEST_F(LabelWindowTest, SavedLabelsAreThoseOfTheCase)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        drag(at(0.15, 0.2), at(0.3, 0.2));
        EXPECT_TRUE(window_.label_panel().button(LabelPanel::Action::confirm).isEnabled());
        press(LabelPanel::Action::confirm);
        const auto wanted = session()->labels();
        press(LabelPanel::Action::save);
        EXPECT_EQ(window_.error_line(), "");
        EXPECT_FALSE(window_.label_editor().changed());
        EXPECT_TRUE(window_.isEnabled());
        const planner::Case saved = planner::read_case(folder_.path / "case.json");
        EXPECT_TRUE(saved.estimated_labels.empty()) << "it was confirmed";
        EXPECT_EQ(saved.labels.path, "labels-2.nrrd");
        planner::Patient patient(saved);
        EXPECT_EQ(patient.labels()->voxels, wanted->voxels);
        EXPECT_TRUE(std::filesystem::exists(folder_.path / "labels.nrrd")) << "those before stay";
        ASSERT_NE(session(), nullptr) << "one can go on";
        EXPECT_EQ(session()->labels()->voxels, wanted->voxels);
    }

    TEST_F(LabelWindowTest, ClosingAsksBeforeCorrectionsAreLost)
    {
        open_labels();
        window_.label_panel().choose("aneurysm");
        drag(at(0.15, 0.2), at(0.3, 0.2));
        QString asked;
        QTimer::singleShot(0, &window_, [&] {
            auto* question = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
            ASSERT_NE(question, nullptr);
            asked = question->text();
            question->defaultButton()->click();
        });
        window_.close_case();
        EXPECT_TRUE(asked.contains("corrections are lost")) << asked.toStdString();
        EXPECT_FALSE(window_.start_page_shown());
        EXPECT_TRUE(window_.label_editor().changed());
        press(LabelPanel::Action::discard);
        window_.close_case();
        EXPECT_TRUE(window_.start_page_shown());
    }

    TEST_F(LabelWindowTest, OtherViewsAndTabsGiveTheMouseBack)
    {
        open_labels();
        EXPECT_TRUE(window_.label_editor().active());
        QTest::keyClick(&window_, Qt::Key_2);
        EXPECT_FALSE(window_.label_editor().active());
        EXPECT_EQ(window_.model()->shown_view(), ViewPreset::overview);
        QTest::keyClick(&window_, Qt::Key_C);
        EXPECT_TRUE(window_.label_editor().active());
        EXPECT_EQ(window_.model()->view(), ViewPreset::slices);
    }

} // namespace label_window_test
} // namespace retractor::ui
