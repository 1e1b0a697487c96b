// The knife in the window, driven by mouse and keyboard events. main() is in main_window_test.cpp.

#include "tests/support/synthetic_patient.h"
#include "tests/support/window/window_help.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "planner/approach/approach_templates.h"
#include "planner/case/case.h"
#include "planner/case/case_io.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QListWidget>
#include <QMouseEvent>
#include <QPushButton>
#include <QTest>
#include <QToolButton>
#include <QWheelEvent>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace retractor::ui {
namespace knife_window_test {

    namespace fs = std::filesystem;

    // The surgeon's picture of an 80 mm incision: twice its length high, on the skin.
    constexpr double kPictureHeightMm = 160.0;
    // A pixel of the picture, and a tenth of the mesh's 5 mm edges.
    constexpr double kDrawnToleranceMm = 1.0;
    // Skin, seen twice, differs by its shading only; a lip is darker and redder, fat yellower.
    constexpr double kNotSkin = 40.0;

    fs::path picture_folder()
    {
        const char* folder = std::getenv("RETRACTOR_PICTURES");
        return folder != nullptr ? fs::path(folder) : fs::temp_directory_path();
    }

    class KnifeWindowTest : public testing::Test {
    protected:
        KnifeWindowTest() { make_window(); }
        void open_synthetic()
        {
            test_support::show_window(*window_);
            window_->open(test_support::synthetic_case());
            wait_until_idle();
        }
        void take_knife()
        {
            open_synthetic();
            press(Qt::Key_K);
            wait_until_idle();
            ASSERT_NE(window_->knife().scene(), nullptr) << window_->error_line();
            window_->view().picture();
        }
        /// Whether a new window on the same case asks about the former cuts.
        bool reopened_and_asked()
        {
            make_window();
            open_synthetic();
            press(Qt::Key_K);
            return QTest::qWaitFor(
                [&] { return window_->knife().snapshot()->phase == planner::SurgerySnapshot::Phase::asking; },
                test_support::kPatienceMs);
        }
        void wait_until_idle() { retractor::test_support::wait_until_idle(*window_); }
        void press(Qt::Key key, Qt::KeyboardModifiers modifiers = {})
        {
            QTest::keyClick(window_.get(), key, modifiers);
        }

        /// Where a place on the skin is in the surgeon's picture.
        QPoint pixel(double x, double z) const
        {
            const PictureView& view = window_->view();
            const double per_mm = view.height() / kPictureHeightMm;
            return { static_cast<int>(std::lround(0.5 * view.width() + x * per_mm)),
                static_cast<int>(std::lround(0.5 * view.height() - z * per_mm)) };
        }
        void mouse_down(const QPoint& at, Qt::KeyboardModifiers keys = {}, Qt::MouseButton button = Qt::LeftButton)
        {
            QTest::mousePress(&window_->view(), button, keys, at);
        }
        void mouse_to(const QPoint& at, Qt::MouseButton button = Qt::LeftButton)
        {
            QMouseEvent move(QEvent::MouseMove, at, Qt::NoButton, button, {});
            QApplication::sendEvent(&window_->view(), &move);
        }
        void mouse_up(const QPoint& at, Qt::MouseButton button = Qt::LeftButton)
        {
            QTest::mouseRelease(&window_->view(), button, {}, at);
        }
        void draw(double x0, double z0, double x1, double z1)
        {
            begin(x0, z0, x1, z1);
            mouse_up(pixel(x1, z1));
            wait_until_idle();
        }
        void begin(double x0, double z0, double x1, double z1)
        {
            mouse_down(pixel(x0, z0));
            for (int i = 1; i <= 10; ++i)
                mouse_to(pixel(x0 + (x1 - x0) * i / 10.0, z0 + (z1 - z0) * i / 10.0));
        }
        const planner::SurgerySnapshot& snapshot() { return *window_->knife().snapshot(); }
        std::string error() const { return window_->error_line(); }

        std::shared_ptr<test_support::SyntheticControl> control_ = std::make_shared<test_support::SyntheticControl>();
        void make_window()
        {
            window_.reset(); // the old one first: it holds the journal
            window_ = std::make_unique<MainWindow>(
                [this](const planner::Case&) { return test_support::synthetic_backend(control_); });
        }
        std::unique_ptr<MainWindow> window_;
    };

    TEST_F(KnifeWindowTest, AStrokeIsACutWhereItWasDrawnAndUndoTakesItBack)
    {
        take_knife();
        const QImage before = window_->view().picture();
        draw(-35.0, 10.0, 25.0, -8.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        const planner::WallSurface& surface = *snapshot().picture->surface;
        double west = 1e9, east = -1e9;
        for (const auto& rim : planner::wound_rims(surface))
            for (const VertexId v : rim) {
                const double x = surface.rest(v, 0);
                west = std::min(west, x);
                east = std::max(east, x);
                EXPECT_NEAR(surface.rest(v, 2), 10.0 - 18.0 * (x + 35.0) / 60.0, kDrawnToleranceMm);
            }
        EXPECT_NEAR(west, -35.0, kDrawnToleranceMm);
        EXPECT_NEAR(east, 25.0, kDrawnToleranceMm);
        EXPECT_EQ(window_->knife_panel().list().count(), 1);
        EXPECT_GT(snapshot().gape_mm, 0.5) << "the usual tension opens it";
        window_->save_screenshot(picture_folder() / "workstation_knife.png");
        EXPECT_NE(window_->view().picture(), before);
        EXPECT_EQ(error(), "");

        press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_FALSE(snapshot().cuts.front().in_force);
        EXPECT_EQ(window_->view().picture(), before) << "the skin is whole again";
        press(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
        wait_until_idle();
        EXPECT_TRUE(snapshot().cuts.front().in_force);
        EXPECT_EQ(window_->view().drawing_errors(), "");
    }

    TEST_F(KnifeWindowTest, AllToolsFitIntoASmallWindow)
    {
        window_->resize(1280, 860);
        take_knife();
        ASSERT_EQ(window_->width(), 1280);
        window_->save_screenshot(picture_folder() / "workstation_1280.png");
        const auto* more = window_->findChild<QToolButton*>("qt_toolbar_ext_button");
        ASSERT_NE(more, nullptr);
        EXPECT_FALSE(more->isVisible()) << "tools have gone behind >>";
    }

    TEST_F(KnifeWindowTest, EscapeTakesTheStrokeUnderWayBack)
    {
        take_knife();
        const QImage before = window_->view().picture();
        begin(-30.0, 0.0, 30.0, 0.0);
        press(Qt::Key_Escape);
        mouse_up(pixel(30.0, 0.0));
        wait_until_idle();
        EXPECT_TRUE(snapshot().cuts.empty());
        EXPECT_FALSE(snapshot().stroke_open);
        EXPECT_EQ(window_->view().picture(), before);
        draw(-30.0, 0.0, 30.0, 0.0);
        EXPECT_EQ(snapshot().cuts.size(), 1U);
    }

    TEST_F(KnifeWindowTest, WhatIsNoStrokeIsRefusedInWords)
    {
        take_knife();
        draw(-75.0, 0.0, -70.0, 0.0);
        EXPECT_NE(error().find("beside the body"), std::string::npos) << error();
        draw(0.0, 0.0, 0.0, 0.0);
        EXPECT_NE(error().find("did not move"), std::string::npos) << error();
        draw(50.0, 20.0, 50.0, -20.0);
        EXPECT_NE(error().find("rib"), std::string::npos) << error();
        EXPECT_TRUE(snapshot().cuts.empty());
        draw(-30.0, 0.0, 30.0, 0.0);
        EXPECT_EQ(error(), "");
        EXPECT_EQ(snapshot().cuts.size(), 1U);
    }

    TEST_F(KnifeWindowTest, ARefusalThatComesLateDoesNotEndTheNextStroke)
    {
        take_knife();
        begin(50.0, 20.0, 50.0, -20.0); // on bone
        mouse_up(pixel(50.0, -20.0));
        begin(-30.0, 0.0, 0.0, 0.0); // before anything is heard of it
        ASSERT_TRUE(
            QTest::qWaitFor([&] { return error().find("rib") != std::string::npos; }, test_support::kPatienceMs));
        mouse_to(pixel(30.0, 0.0));
        mouse_up(pixel(30.0, 0.0));
        wait_until_idle();
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_NEAR(snapshot().cuts.front().length_mm, 60.0, 2.0 * kDrawnToleranceMm);
        EXPECT_FALSE(snapshot().stroke_open);
    }

    TEST_F(KnifeWindowTest, ASecondStrokeMayCrossTheFirst)
    {
        take_knife();
        draw(-30.0, 0.0, 30.0, 0.0);
        draw(2.0, 30.0, -3.0, -30.0);
        EXPECT_EQ(snapshot().cuts.size(), 2U) << error();
        window_->save_screenshot(picture_folder() / "workstation_knife_cross.png");
        press(Qt::Key_Z, Qt::ControlModifier);
        press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_EQ(snapshot().to_undo, "");
    }

    TEST_F(KnifeWindowTest, ALineIsCutBetweenTwoClicks)
    {
        take_knife();
        press(Qt::Key_L);
        ASSERT_EQ(window_->knife().mode(), KnifeMode::line);
        mouse_down(pixel(-20.0, 20.0));
        mouse_up(pixel(-20.0, 20.0));
        mouse_to(pixel(0.0, 0.0), Qt::NoButton);
        mouse_down(pixel(20.0, -20.0));
        mouse_up(pixel(20.0, -20.0));
        wait_until_idle();
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_NEAR(snapshot().cuts.front().length_mm, std::hypot(40.0, 40.0), 2.0 * kDrawnToleranceMm);
        // Escape forgets a first click.
        mouse_down(pixel(-20.0, -20.0));
        mouse_up(pixel(-20.0, -20.0));
        press(Qt::Key_Escape);
        mouse_down(pixel(20.0, 20.0));
        mouse_up(pixel(20.0, 20.0));
        wait_until_idle();
        EXPECT_EQ(snapshot().cuts.size(), 1U);
    }

    TEST_F(KnifeWindowTest, TissueIsTakenOutWithAClickAndComesBack)
    {
        take_knife();
        const QImage whole = window_->view().picture();
        press(Qt::Key_X);
        ASSERT_EQ(window_->knife().mode(), KnifeMode::take_out);
        const auto click = [&](double x, double z) {
            mouse_down(pixel(x, z));
            mouse_up(pixel(x, z));
            wait_until_idle();
        };
        click(0.0, 0.0);
        EXPECT_NE(error().find("cut it free first"), std::string::npos) << error();
        QComboBox& removal = window_->knife_panel().removal();
        removal.setCurrentIndex(removal.findData(20));
        click(0.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_EQ(error(), "");
        const QString entry = window_->knife_panel().list().item(0)->text();
        EXPECT_TRUE(entry.startsWith("Taken out 1")) << entry.toStdString();
        EXPECT_TRUE(entry.contains("cm³ of skin")) << entry.toStdString();
        EXPECT_NE(window_->view().picture(), whole);
        window_->save_screenshot(picture_folder() / "workstation_take_out.png");
        press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_EQ(window_->view().picture(), whole);
    }

    TEST_F(KnifeWindowTest, ARetractorIsSetWithAClickAndCrankedByDragAndWheel)
    {
        take_knife();
        window_->knife_panel().set_tension(0.0);
        draw(-30.0, 0.0, 30.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        press(Qt::Key_H);
        QComboBox& instruments = window_->knife_panel().instruments();
        instruments.setCurrentIndex(instruments.findData(QString("finochietto")));
        mouse_down(pixel(0.0, 3.0));
        mouse_up(pixel(0.0, 3.0));
        wait_until_idle();
        ASSERT_EQ(snapshot().hooks.retractors.size(), 1U) << error();
        ASSERT_EQ(snapshot().hooks.hooks.size(), 2U);
        EXPECT_EQ(snapshot().hooks.hooks[0].name, "upper blade");
        // A blade is dragged up by 6 mm: the other goes down by about as much.
        mouse_down(pixel(0.0, 1.0));
        for (int i = 1; i <= 6; ++i)
            mouse_to(pixel(0.0, 1.0 + i));
        mouse_up(pixel(0.0, 7.0));
        wait_until_idle();
        const planner::RetractorState dragged = snapshot().hooks.retractors.at(0);
        EXPECT_NEAR(dragged.opening_mm, 12.0, 2.0 * kDrawnToleranceMm);
        EXPECT_LE(dragged.imbalance, planner::RackBalance::kTolerance);
        // Where the turned blades bear, deeper than their arms, the lips move less.
        EXPECT_LT(snapshot().gape_mm, dragged.opening_mm);
        EXPECT_GT(snapshot().gape_mm, 0.5 * dragged.opening_mm);
        // Three notches of the wheel over the blade, before the first is answered: 2 mm each.
        const QPoint over = pixel(0.0, 7.0);
        mouse_to(over, Qt::NoButton);
        for (int i = 0; i < 3; ++i) {
            QWheelEvent notch(over, over, {}, { 0, 120 }, Qt::NoButton, Qt::NoModifier, Qt::NoScrollPhase, false);
            QApplication::sendEvent(&window_->view(), &notch);
        }
        wait_until_idle();
        EXPECT_NEAR(snapshot().hooks.retractors.at(0).opening_mm, dragged.opening_mm + 6.0, 1e-9);
        EXPECT_GT(snapshot().hooks.retractors.at(0).force_N, dragged.force_N);
        EXPECT_TRUE(window_->knife_panel().hook_numbers().contains("Finochietto rib spreader open 1"))
            << window_->knife_panel().hook_numbers().toStdString();
        window_->save_screenshot(picture_folder() / "workstation_retractor.png");
        // It becomes an approach to plan, and the wound is still there.
        const double cranked_mm = snapshot().hooks.retractors.at(0).opening_mm;
        const std::size_t before = window_->model()->planned_case().approaches.size();
        window_->knife_panel().plan_retractor_button().click();
        wait_until_idle();
        ASSERT_EQ(window_->model()->planned_case().approaches.size(), before + 1) << error();
        const planner::Approach& added = window_->model()->planned_case().approaches.back();
        ASSERT_TRUE(added.retractor.has_value());
        EXPECT_EQ(added.retractor->kind, "finochietto");
        EXPECT_EQ(added.retractor->opening_mm, std::round(cranked_mm));
        window_->select("median");
        press(Qt::Key_H);
        wait_until_idle();
        ASSERT_EQ(snapshot().hooks.retractors.size(), 1U);
        window_->knife_panel().hook_list().setCurrentRow(1);
        const auto buttons = window_->knife_panel().findChildren<QPushButton*>();
        const auto off = std::find_if(
            buttons.begin(), buttons.end(), [](const QPushButton* button) { return button->text() == "Take off"; });
        ASSERT_NE(off, buttons.end());
        (*off)->click();
        wait_until_idle();
        EXPECT_TRUE(snapshot().hooks.hooks.empty()) << "both blades";
        EXPECT_EQ(error(), "");
    }

    TEST_F(KnifeWindowTest, HooksAreSetAndDrawnByHandAndTheWoundFollowsFurtherCuts)
    {
        take_knife();
        window_->knife_panel().set_tension(0.0);
        draw(-30.0, 0.0, 30.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        const QImage closed = window_->view().picture();
        press(Qt::Key_H);
        ASSERT_EQ(window_->knife().mode(), KnifeMode::hooks);
        const auto click = [&](double x, double z) {
            mouse_down(pixel(x, z));
            mouse_up(pixel(x, z));
            wait_until_idle();
        };
        click(0.0, 40.0);
        EXPECT_NE(error().find("no wound within"), std::string::npos) << error();
        click(0.0, 3.0);
        click(0.0, -3.0);
        ASSERT_EQ(snapshot().hooks.hooks.size(), 2U) << error();
        EXPECT_EQ(error(), "");
        // By the mouse: the upper hook is drawn up by 8 mm.
        mouse_down(pixel(0.0, 1.0));
        for (int i = 1; i <= 8; ++i)
            mouse_to(pixel(0.0, 1.0 + i));
        mouse_up(pixel(0.0, 9.0));
        wait_until_idle();
        const planner::HookReport drawn = snapshot().hooks;
        ASSERT_EQ(drawn.hooks.size(), 2U) << error();
        EXPECT_NEAR(drawn.hooks[0].displacement.z(), 8.0, kDrawnToleranceMm);
        EXPECT_EQ(drawn.hooks[1].displacement.norm(), 0.0);
        EXPECT_EQ(drawn.shown, planner::ShownAnswer::nonlinear) << drawn.shown_text;
        EXPECT_LT(drawn.residual, 1e-6);
        EXPECT_TRUE(drawn.settled);
        EXPECT_NE(window_->view().picture(), closed);
        EXPECT_EQ(window_->knife_panel().opening().value(), 4) << "the slider shows what the hooks are drawn by";
        // By the slider: both.
        window_->knife_panel().opening().setValue(6);
        wait_until_idle();
        EXPECT_NEAR(snapshot().gape_mm, 12.0, 2.0) << "under the hooks; the middle of the wound may bulge";
        const QString numbers = window_->knife_panel().hook_numbers();
        EXPECT_TRUE(numbers.contains("N on one side")) << numbers.toStdString();
        const QString technical = window_->knife_panel().technical_text();
        for (const char* word : { "99th percentile", "nonlinear within", "residual" }) {
            EXPECT_TRUE(technical.contains(word)) << technical.toStdString();
            EXPECT_FALSE(numbers.contains(word)) << "a surgeon need not read it";
        }
        EXPECT_EQ(window_->knife_panel().hook_list().count(), 2);
        window_->save_screenshot(picture_folder() / "workstation_hooks.png");
        // She cuts further, on the open wound, and it follows.
        press(Qt::Key_K);
        draw(20.0, 8.0, 20.0, 40.0);
        ASSERT_EQ(snapshot().cuts.size(), 2U) << error();
        EXPECT_EQ(snapshot().hooks.hooks.size(), 2U);
        EXPECT_EQ(snapshot().hooks.refusal, "");
        EXPECT_EQ(snapshot().hooks.shown, planner::ShownAnswer::nonlinear);
        EXPECT_LT(snapshot().hooks.residual, 1e-6);
        EXPECT_NEAR(snapshot().hooks.hooks[0].displacement.z(), 6.0, 1e-9);
        // Off and on again: the same wound, linear and not.
        window_->knife_panel().nonlinear_box().setChecked(false);
        wait_until_idle();
        EXPECT_EQ(snapshot().hooks.shown, planner::ShownAnswer::linear);
        EXPECT_LT(snapshot().hooks.residual, 1e-8);
        window_->knife_panel().nonlinear_box().setChecked(true);
        wait_until_idle();
        EXPECT_EQ(snapshot().hooks.shown, planner::ShownAnswer::nonlinear);
        window_->save_screenshot(picture_folder() / "workstation_hooks_cut.png");
        press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_EQ(snapshot().hooks.hooks.size(), 2U);
        EXPECT_GE(snapshot().gape_mm, 11.0);
        const auto step = [&](Qt::KeyboardModifiers with) {
            press(Qt::Key_Z, with);
            wait_until_idle();
        };
        // What was done with the hooks is undone step by step: slider, mouse, both hooks, then the cut itself.
        step(Qt::ControlModifier);
        EXPECT_NEAR(snapshot().hooks.hooks[0].displacement.z(), 8.0, kDrawnToleranceMm);
        EXPECT_EQ(window_->knife_panel().opening().value(), 4);
        step(Qt::ControlModifier);
        EXPECT_NEAR(snapshot().hooks.hooks[0].displacement.z(), 0.0, 1e-9);
        step(Qt::ControlModifier);
        EXPECT_EQ(snapshot().hooks.hooks.size(), 1U);
        step(Qt::ControlModifier);
        EXPECT_TRUE(snapshot().hooks.hooks.empty());
        EXPECT_EQ(window_->knife_panel().opening().value(), 0);
        step(Qt::ControlModifier);
        EXPECT_FALSE(snapshot().cuts.front().in_force);
        for (int i = 0; i < 5; ++i)
            step(Qt::ControlModifier | Qt::ShiftModifier);
        ASSERT_EQ(snapshot().hooks.hooks.size(), 2U) << error();
        EXPECT_NEAR(snapshot().hooks.hooks[0].displacement.z(), 6.0, 1e-9);
        EXPECT_EQ(error(), "");
        EXPECT_EQ(window_->view().drawing_errors(), "");
    }

    TEST_F(KnifeWindowTest, WhatIsSeenThroughTheWoundIsSaid)
    {
        take_knife();
        EXPECT_EQ(window_->knife_panel().sight_text(), "") << "nothing is cut yet";
        draw(-30.0, 0.0, 30.0, 0.0);
        wait_until_idle();
        const QString said = window_->knife_panel().sight_text();
        EXPECT_EQ(said.toStdString().find("The best eye sees 25 % of the target (\u00b1 2), 12\u00b0 off"), 0U)
            << said.toStdString();
        const std::size_t without_steel = control_->hiding_triangles;
        press(Qt::Key_H);
        for (const double z : { 3.0, -3.0 }) {
            mouse_down(pixel(0.0, z));
            mouse_up(pixel(0.0, z));
            wait_until_idle();
        }
        ASSERT_EQ(snapshot().hooks.hooks.size(), 2U) << error();
        EXPECT_EQ(window_->knife_panel().sight_text().toStdString().find("The best eye sees 25 %"), 0U)
            << window_->knife_panel().sight_text().toStdString();
        EXPECT_GT(control_->hiding_triangles, without_steel) << "steel is among what hides";
        for (int undone = 0; undone < 3; ++undone)
            press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_EQ(window_->knife_panel().sight_text(), "");
    }

    TEST_F(KnifeWindowTest, TheDepthIsTheOneAskedFor)
    {
        take_knife();
        window_->knife_panel().depth().setValue(8.0);
        draw(-30.0, 0.0, 30.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_EQ(snapshot().cuts.front().depth_mm, 8.0);
    }

    TEST_F(KnifeWindowTest, TheRightButtonAndShiftTurnTheCamera)
    {
        take_knife();
        const PictureView& view = window_->view();
        const QPoint middle = view.rect().center();
        for (const bool shift : { false, true }) {
            const Vec3 eye = view.camera().eye;
            const Qt::MouseButton button = shift ? Qt::LeftButton : Qt::RightButton;
            mouse_down(middle, shift ? Qt::ShiftModifier : Qt::NoModifier, button);
            mouse_to(middle + QPoint(40, 10), button);
            mouse_up(middle + QPoint(40, 10), button);
            EXPECT_GT((view.camera().eye - eye).norm(), 1.0) << "the camera has turned (mm)";
        }
        wait_until_idle();
        EXPECT_TRUE(snapshot().cuts.empty());
        const Vec3 eye = view.camera().eye;
        press(Qt::Key_K); // put away: the left button turns again
        mouse_down(middle);
        mouse_to(middle + QPoint(40, 10));
        mouse_up(middle + QPoint(40, 10));
        EXPECT_GT((view.camera().eye - eye).norm(), 1.0);
        wait_until_idle();
        EXPECT_TRUE(snapshot().cuts.empty());
        press(Qt::Key_2);
        press(Qt::Key_1);
        EXPECT_LT((view.camera().eye - Vec3(0.0, -400.0, 0.0)).norm(), 1e-6) << "the surgeon's place again (mm)";
    }

    TEST_F(KnifeWindowTest, EachApproachKeepsItsCuts)
    {
        take_knife();
        EXPECT_EQ(control_->setups_made, 1) << "only where the knife was taken";
        draw(-30.0, 0.0, 30.0, 0.0);
        window_->select("lateral");
        wait_until_idle();
        EXPECT_TRUE(snapshot().cuts.empty());
        window_->select("median");
        wait_until_idle();
        EXPECT_EQ(snapshot().cuts.size(), 1U);
        EXPECT_EQ(control_->setups_made, 2);
        window_->select("broken");
        wait_until_idle();
        EXPECT_EQ(error(), "approach broken: there is no wall to cut");
        press(Qt::Key_P);
        wait_until_idle();
        EXPECT_EQ(window_->knife().snapshot(), nullptr) << "planning shows the plan";
    }

    TEST_F(KnifeWindowTest, ReopeningOffersTheLastCuts)
    {
        control_->cuts_folder = picture_folder() / "saved_cuts";
        fs::remove_all(control_->cuts_folder);
        fs::create_directories(control_->cuts_folder); // the case's
        take_knife();
        draw(-30.0, 0.0, 30.0, 0.0);
        draw(-30.0, 20.0, 30.0, 25.0);
        for (const bool wanted : { true, false }) {
            ASSERT_TRUE(reopened_and_asked());
            // The session waits for the answer, and what was asked of it meanwhile waits too: it is not idle.
            ASSERT_TRUE(QTest::qWaitFor(
                [&] { return window_->knife_panel().restore_button().isVisible(); }, test_support::kPatienceMs));
            EXPECT_EQ(snapshot().saved_cuts, 2U);
            window_->save_screenshot(picture_folder() / "workstation_knife_restore.png");
            mouse_down(pixel(0.0, 0.0));
            mouse_up(pixel(0.0, 0.0));
            EXPECT_NE(error().find("Answer on the right first"), std::string::npos) << error();
            KnifePanel& panel = window_->knife_panel();
            QTest::mouseClick(wanted ? &panel.restore_button() : &panel.discard_button(), Qt::LeftButton);
            ASSERT_TRUE(QTest::qWaitFor(
                [&] { return window_->knife().snapshot()->phase == planner::SurgerySnapshot::Phase::ready; },
                test_support::kPatienceMs));
            wait_until_idle();
            EXPECT_EQ(snapshot().cuts.size(), wanted ? 2U : 0U);
            EXPECT_EQ(error(), "");
            if (!wanted)
                continue;
            // Undo is at hand at once, and also where a number is being written.
            QWidget* number = &panel.depth();
            for (QWidget* focus : { QApplication::focusWidget(), number }) {
                ASSERT_NE(focus, nullptr);
                focus->setFocus();
                QTest::keyClick(focus, Qt::Key_Z, Qt::ControlModifier);
                wait_until_idle();
                EXPECT_FALSE(snapshot().cuts.back().in_force) << focus->metaObject()->className();
                QTest::keyClick(focus, Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
                wait_until_idle();
                EXPECT_TRUE(snapshot().cuts.back().in_force) << focus->metaObject()->className();
            }
            // So are the tools.
            number->setFocus();
            const QList<QAction*> actions = window_->findChildren<QAction*>();
            for (const auto& [key, name] : { std::pair(Qt::Key_H, "Hooks"), std::pair(Qt::Key_K, "Knife") }) {
                QTest::keyClick(number, key);
                const auto action = std::find_if(
                    actions.begin(), actions.end(), [&, name = name](QAction* a) { return a->text() == name; });
                ASSERT_NE(action, actions.end()) << name;
                EXPECT_TRUE((*action)->isChecked()) << name;
            }
            QTest::keyClick(number, Qt::Key_K); // and away again
        }
        EXPECT_TRUE(fs::exists(control_->cuts_folder / "cuts" / "median.jsonl.1")) << "set aside, not lost";
    }

    TEST_F(KnifeWindowTest, CutsThatCannotBeSavedAreSaidUntilTheyAre)
    {
        control_->cuts_folder = picture_folder() / "refused_cuts";
        fs::remove_all(control_->cuts_folder);
        fs::create_directories(control_->cuts_folder);
        const fs::path in_the_way = control_->cuts_folder / "cuts"; // a file where the folder must be
        std::ofstream(in_the_way) << "a file\n";
        take_knife();
        draw(-30.0, 0.0, 30.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        auto* banner = window_->findChild<QWidget*>("cuts not saved");
        ASSERT_NE(banner, nullptr);
        EXPECT_TRUE(banner->isVisible());
        EXPECT_TRUE(window_->knife().would_lose_cuts());
        window_->save_screenshot(picture_folder() / "workstation_cuts_not_saved.png");
        auto* again = banner->findChild<QPushButton*>();
        QTest::mouseClick(again, Qt::LeftButton);
        wait_until_idle();
        EXPECT_TRUE(banner->isVisible()) << "the file is still in the way";
        EXPECT_NE(error().find("still not saved"), std::string::npos) << error();
        fs::remove(in_the_way);
        QTest::mouseClick(again, Qt::LeftButton);
        wait_until_idle();
        EXPECT_FALSE(banner->isVisible());
        EXPECT_FALSE(window_->knife().would_lose_cuts());
        ASSERT_TRUE(reopened_and_asked());
        EXPECT_EQ(snapshot().saved_cuts, 1U);
    }

    TEST_F(KnifeWindowTest, AStrokeThatLeavesTheWallSaysWhatItCut)
    {
        take_knife();
        draw(-30.0, 0.0, -75.0, 0.0); // off the slab, at -60
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_NE(window_->message_line().find("the line left the wall"), std::string::npos) << window_->message_line();
        EXPECT_TRUE(window_->knife_panel().list().item(0)->text().contains("a part of the line was not cut"));
    }

    TEST_F(KnifeWindowTest, ThereIsNothingAsPlannedWithoutPlannedHooks)
    {
        take_knife();
        draw(-30.0, 0.0, 30.0, 0.0);
        ASSERT_EQ(snapshot().cuts.size(), 1U);
        EXPECT_EQ(snapshot().planned_hooks, 0U);
        EXPECT_FALSE(window_->knife_panel().planned_hooks_button().isEnabled());
    }

    TEST_F(KnifeWindowTest, ThePlannedIncisionIsCutAtAPressAndUndone)
    {
        take_knife();
        KnifePanel& panel = window_->knife_panel();
        ASSERT_TRUE(panel.cut_planned_button().isEnabled());
        EXPECT_FALSE(panel.divide_button().isEnabled()) << "there is no wound";
        ASSERT_GT(panel.tension(), 0.0);
        QTest::mouseClick(&panel.cut_planned_button(), Qt::LeftButton);
        wait_until_idle();
        ASSERT_EQ(snapshot().cuts.size(), 1U) << error();
        EXPECT_EQ(panel.tension(), 0.0) << "the case, and so the plan, has none";
        EXPECT_EQ(snapshot().tension, 0.0);
        EXPECT_TRUE(panel.list().item(0)->text().contains("as planned")) << panel.list().item(0)->text().toStdString();
        EXPECT_FALSE(panel.cut_planned_button().isEnabled());
        EXPECT_FALSE(panel.divide_button().isEnabled()) << "this approach divides nothing beyond the skin";
        EXPECT_TRUE(panel.divide_button().toolTip().contains("nothing beyond the skin"));
        press(Qt::Key_Z, Qt::ControlModifier);
        wait_until_idle();
        EXPECT_FALSE(snapshot().cuts.front().in_force);
        EXPECT_TRUE(panel.cut_planned_button().isEnabled());
    }

    TEST(KnifePanelText, WhatIsDividedUnderTheSkinHasItsButtonAndItsLine)
    {
        KnifePanel panel;
        planner::SurgerySnapshot snapshot;
        snapshot.phase = planner::SurgerySnapshot::Phase::ready;
        snapshot.division = planner::DivisionExtent::full;
        snapshot.cuts = { { .number = 1, .length_mm = 170.0, .depth_mm = 47.0 },
            { .number = 2, .length_mm = 98.0, .divides = planner::StrokeWay::backwards } };
        snapshot.cuts[1].report.lip_area_mm2 = 450.0;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_TRUE(panel.divide_button().isEnabled());
        EXPECT_EQ(panel.divide_button().text(), "Divide the space");
        EXPECT_EQ(panel.list().item(0)->text(), "Cut 1   170 mm long, 47 mm deep");
        EXPECT_EQ(panel.list().item(1)->text(), "Cut 2   under the skin, backwards, 4.5 cm²");
        int asked = 0;
        panel.on_command = [&](const planner::surgery::Command& command) {
            asked += std::holds_alternative<planner::surgery::DivideBeyondCut>(command) ? 1 : 0;
        };
        panel.divide_button().click();
        EXPECT_EQ(asked, 1);
        snapshot.division = planner::DivisionExtent::sternum_right;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_EQ(panel.divide_button().text(), "Saw across");
    }

    TEST(PlannedForce, HasTheVerdictsIntervalAndObjectionsOrIsNotToBeReliedOn)
    {
        planner::FieldMetrics field;
        field.mechanics_status = "converged";
        field.hook_force_N = 120.0;
        field.opening_width_mm = 30.0;
        field.seen_best_eye = 0.29;
        field.retractor.emplace();
        field.retractor->kind = "finochietto";
        field.retractor->opening_mm = 30.0;
        field.error.emplace();
        field.error->hook_force_N = 30.0;
        const auto plain = planned_force(field);
        ASSERT_TRUE(plain);
        EXPECT_DOUBLE_EQ(plain->low_N, 90.0);
        EXPECT_DOUBLE_EQ(plain->high_N, 150.0);
        EXPECT_DOUBLE_EQ(plain->seen_share, 0.29);
        EXPECT_EQ(plain->objections, "");
        field.at_risk = { { .name = "aorta", .distance_mm = 0.0 }, { .name = "heart", .distance_mm = 0.0 } };
        const auto objected = planned_force(field);
        ASSERT_TRUE(objected);
        EXPECT_EQ(objected->objections, "The blade cuts the aorta. The blade cuts the heart.");
        field.inverted_elements = 3;
        EXPECT_FALSE(planned_force(field)) << "nobody is to rely on it";
    }

    TEST(KnifePanelText, FlatElementsAreMarkedWithTheReason)
    {
        KnifePanel panel;
        planner::SurgerySnapshot snapshot;
        snapshot.phase = planner::SurgerySnapshot::Phase::ready;
        planner::CutEntry fine { .number = 1 }, grazing { .number = 2 }, flat_before { .number = 3 };
        fine.report.worst_dihedral_deg = 6.0;
        grazing.report.worst_dihedral_deg = 1.2;
        grazing.report.tets_below_half_parent = 4;
        flat_before.report.worst_dihedral_deg = 2.0;
        flat_before.report.worst_dihedral_before_deg = 3.0;
        for (const auto& [cut, why] :
            { std::pair { fine, QString() }, std::pair { grazing, QString("flatter than 5°: the cut passes close to") },
                std::pair { flat_before, QString("flatter than 5°: the elements were flat before the cut (3°)") } }) {
            snapshot.cuts = { cut };
            panel.show_snapshot(&snapshot, 0.0);
            EXPECT_FALSE(panel.list().item(0)->text().contains("flatter")) << "a surgeon need not read it";
            if (why.isEmpty())
                EXPECT_FALSE(panel.technical_text().contains("flatter"));
            else
                EXPECT_TRUE(panel.technical_text().contains(why)) << panel.technical_text().toStdString();
        }
    }

    TEST(KnifePanelText, PlannedHooksNeedAWoundAndForcesBeyondAnyRetractorAreMarked)
    {
        KnifePanel panel;
        panel.show();
        planner::SurgerySnapshot snapshot;
        snapshot.phase = planner::SurgerySnapshot::Phase::ready;
        snapshot.planned_hooks = 2;
        snapshot.cuts = { { .number = 1, .in_force = false } };
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_FALSE(panel.planned_hooks_button().isEnabled()) << "the cut is taken back";
        snapshot.cuts.front().in_force = true;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_TRUE(panel.planned_hooks_button().isEnabled());
        snapshot.hooks.hooks.resize(2);
        snapshot.hooks.side_N = { 60.0, 60.0 };
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_EQ(panel.hook_warning(), "");
        snapshot.hooks.side_N = { 60.0, 6000.0 };
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_EQ(panel.hook_numbers(), "60 N on one side, more than 1000 N on the other");
        EXPECT_TRUE(panel.hook_warning().contains("no retractor pulls this hard"))
            << panel.hook_warning().toStdString();
        EXPECT_FALSE(panel.hook_warning().contains("tissue bears"));
        snapshot.hooks.strain.p99 = 3.2;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_TRUE(panel.hook_warning().contains("no retractor pulls this hard"))
            << panel.hook_warning().toStdString();
        EXPECT_TRUE(panel.hook_warning().contains("tissue bears")) << panel.hook_warning().toStdString();
        snapshot.hooks.settled = false; // that strain is of a former frame
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_FALSE(panel.hook_warning().contains("tissue bears"));
        EXPECT_TRUE(panel.technical_text().contains("residual"));
        snapshot.hooks.shown = planner::ShownAnswer::linear_since;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_FALSE(panel.technical_text().contains("residual")) << panel.technical_text().toStdString();
    }

    TEST(KnifePanelText, EachHookSaysWhatDrivesItWhatItBearsAndHowFarItCame)
    {
        KnifePanel panel;
        panel.show();
        planner::SurgerySnapshot snapshot;
        snapshot.phase = planner::SurgerySnapshot::Phase::ready;
        const fem::HookDrive force { .force_N = Vec3(0.0, 0.0, 30.0) };
        const fem::HookDrive limit { .displacement = Vec3(0.0, 0.0, 15.0), .force_limit_N = 60.0 };
        const fem::HookDrive grip { .displacement = Vec3(0.0, 0.0, 15.0), .grip_N_per_mm = 5.0 };
        const auto add
            = [&](const std::string& name, const fem::HookDrive& drive, const std::optional<fem::HookDrive>& planned) {
                  planner::HookState& hook = snapshot.hooks.hooks.emplace_back();
                  hook.name = name;
                  hook.placement.pull = Vec3::UnitZ();
                  hook.drive = drive;
                  hook.planned = planned;
              };
        add("hand", { .displacement = Vec3(0.0, 0.0, 8.0) }, {});
        add("pulls", fem::between({}, force, 0.5), force);
        add("limited", limit, limit);
        add("grips", grip, grip);
        snapshot.hooks.hooks[2].yielded = true;
        for (planner::HookState& hook : snapshot.hooks.hooks) {
            hook.displacement = Vec3(0.0, 0.0, 8.0);
            hook.force_N = Vec3(0.0, 0.0, 60.0);
        }
        panel.show_snapshot(&snapshot, 0.0);
        const auto text = [&](int row) { return panel.hook_list().item(row)->text().toStdString(); };
        EXPECT_EQ(text(0), "hand   8.0 mm, 60 N");
        EXPECT_EQ(text(1), "pulls   8.0 mm, 60 N: pulls with 15 N");
        EXPECT_EQ(text(2), "limited   8.0 of 15.0 mm, 60 N: yields");
        EXPECT_EQ(text(3), "grips   8.0 of 15.0 mm, 60 N: grip of 5 N/mm");
        snapshot.hooks.hooks[2].yielded = false;
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_EQ(text(2), "limited   8.0 mm, 60 N: holds up to 60 N");
        // Where a hook pulls with a force the slider is of the plan: at half of it is half the force.
        EXPECT_EQ(panel.opening_text(), "50 %");
        EXPECT_EQ(panel.opening().value(), panel.opening().maximum() / 2);
        double share = 0.0;
        int in_mm = 0;
        panel.on_command = [&](const planner::surgery::Command& command) {
            if (const auto* by_share = std::get_if<planner::surgery::PullHooksByShare>(&command))
                share = by_share->share;
            else if (std::holds_alternative<planner::surgery::PullAllHooks>(command))
                ++in_mm;
        };
        panel.opening().setValue(75);
        EXPECT_EQ(share, 0.75);
        EXPECT_EQ(panel.opening_text(), "75 %");
        EXPECT_EQ(in_mm, 0);
        snapshot.hooks.hooks.resize(1);
        panel.show_snapshot(&snapshot, 0.0);
        EXPECT_EQ(panel.opening_text(), "8 mm");
        panel.opening().setValue(9);
        EXPECT_EQ(in_mm, 1);
    }

    /// Where a place in the patient is in the picture.
    QPoint pixel_of(const PictureView& view, const Vec3& place)
    {
        const Camera camera = view.camera();
        const Vec3 sight = (camera.aim - camera.eye).normalized();
        const Vec3 right = sight.cross(camera.up).normalized(), up = right.cross(sight);
        const Vec3 from_eye = place - camera.eye;
        const double half = 0.5 * view.height();
        const double scale = half / (std::tan(0.5 * camera.view_angle_deg * M_PI / 180.0) * from_eye.dot(sight));
        return { static_cast<int>(std::lround(0.5 * view.width() + scale * from_eye.dot(right))),
            static_cast<int>(std::lround(half - scale * from_eye.dot(up))) };
    }

    /// Of two colours, 0 to 441.
    double difference(const QColor& a, const QColor& b)
    {
        return Vec3(a.red() - b.red(), a.green() - b.green(), a.blue() - b.blue()).norm();
    }

    /// A block on disk, with a straight approach.
    planner::Case block_on_disk(const char* name, const Vec3& size_mm, double edge_mm)
    {
        const fs::path folder = picture_folder() / name;
        fs::remove_all(folder);
        fs::create_directories(folder);
        datasets::BlockParameters block;
        block.size_mm = size_mm;
        const datasets::Phantom phantom = datasets::make_block_phantom(block);
        datasets::write_label_volume(folder / "labels.nrrd", phantom.labels);
        planner::Case planned_case;
        planned_case.folder = folder;
        planned_case.label_table = phantom.labels.table;
        planned_case.supports.labels.clear();
        planned_case.labels = planner::make_reference(folder, folder / "labels.nrrd");
        planner::ApproachRequest request;
        request.name = "straight";
        request.target.label = "target";
        request.sizing.corridor_edge_mm = edge_mm;
        request.sizing.coarse_edge_mm = edge_mm + 4.0;
        const std::vector<Vec3> points { { 0.0, 0.0, 30.0 }, { 0.0, 0.0, -30.0 } };
        planned_case.approaches = { planner::approach_from_points(phantom.labels, points, request).approach };
        return planned_case;
    }

    TEST(KnifeOnAPatient, HooksSolveThePlansMaterialsOrSayWhichOthers)
    {
        planner::Case planned_case = block_on_disk("materials_case", { 100.0, 80.0, 100.0 }, 14.0);
        const planner::Approach& approach = planned_case.approaches.front();
        const planner::SurgerySetup alike = make_planning_backend(planned_case).surgery_input(approach, {}).setup;
        EXPECT_EQ(alike.caution, "");
        const std::vector<fem::Material> planned = planner::materials_as_solved(planned_case);
        ASSERT_EQ(alike.materials.size(), planned.size());
        for (std::size_t label = 0; label < planned.size(); ++label) {
            EXPECT_EQ(alike.materials[label].name, planned[label].name);
            EXPECT_EQ(alike.materials[label].poissons_ratio, planned[label].poissons_ratio) << planned[label].name;
        }
        planned_case.solution.element = planner::ElementKind::p2;
        const planner::SurgerySetup finer = make_planning_backend(planned_case).surgery_input(approach, {}).setup;
        EXPECT_EQ(finer.caution,
            "forces by hand may be off by two or three times: plan the approach first, and they are matched to its "
            "plan");
        planned_case.solution.element = planner::ElementKind::locking_free;
        const planner::SurgerySetup other = make_planning_backend(planned_case).surgery_input(approach, {}).setup;
        EXPECT_EQ(other.caution,
            "tissue is more compressible in cutting by hand (Poisson's ratio at most 0.45) than in plans of this case "
            "(skin 0.48)");
    }

    /// The whole way, with the body drawn beyond the wall that is meshed: 40 mm beside the planned line, 10 mm from the
    /// rim, the wound is as open in the picture as it is; beyond the rim there is none to be made.
    TEST(KnifeOnAPatient, AWoundNearTheRimIsSeenOpenAndBeyondItThereIsNone)
    {
        planner::Case planned_case = block_on_disk("rim_case", { 200.0, 80.0, 160.0 }, 6.0);
        const double skin = planned_case.approaches.front().incision.front().y();

        MainWindow window([](const planner::Case& one) { return make_planning_backend(one); });
        test_support::show_window(window);
        window.open(std::move(planned_case));
        const auto wait = [&] { retractor::test_support::wait_until_idle(window); };
        wait();
        QTest::keyClick(&window, Qt::Key_K);
        wait();
        ASSERT_NE(window.knife().scene(), nullptr) << window.error_line();
        PictureView& view = window.view();
        const QImage before = view.picture();
        const auto draw = [&](const Vec3& from, const Vec3& to) {
            QTest::mousePress(&view, Qt::LeftButton, {}, pixel_of(view, from));
            for (int i = 1; i <= 10; ++i) {
                QMouseEvent move(
                    QEvent::MouseMove, pixel_of(view, from + 0.1 * i * (to - from)), Qt::NoButton, Qt::LeftButton, {});
                QApplication::sendEvent(&view, &move);
            }
            QTest::mouseRelease(&view, Qt::LeftButton, {}, pixel_of(view, to));
            wait();
        };
        draw({ 34.0, skin, 20.0 }, { 34.0, skin, -20.0 });
        const planner::SurgerySnapshot& snapshot = *window.knife().snapshot();
        ASSERT_EQ(snapshot.cuts.size(), 1U) << window.error_line();
        const QImage after = view.picture();
        window.save_screenshot(picture_folder() / "workstation_knife_rim.png");
        // The lips' edges on the skin, and what is seen between them: everywhere in the wound's middle, from lip to
        // lip.
        const planner::WallSurface& surface = *snapshot.picture->surface;
        double west = 1e9, east = -1e9;
        for (const auto& rim : planner::wound_rims(surface))
            for (const VertexId v : rim)
                if (std::abs(surface.rest(v, 1) - skin) < 1.0 && std::abs(surface.rest(v, 2)) < 5.0) {
                    west = std::min(west, snapshot.picture->shown(v, 0));
                    east = std::max(east, snapshot.picture->shown(v, 0));
                }
        ASSERT_GT(east - west, 1.5) << "it gapes (mm)";
        const int pixels = pixel_of(view, { east, skin, 0.0 }).x() - pixel_of(view, { west, skin, 0.0 }).x();
        ASSERT_GT(pixels, 5);
        int opened = 0, seen = 0;
        for (int i = 2; i < pixels - 1; ++i, ++seen) {
            const QPoint at = pixel_of(view, { west, skin, 0.0 }) + QPoint(i, 0);
            opened += difference(after.pixelColor(at), before.pixelColor(at)) > kNotSkin ? 1 : 0;
        }
        EXPECT_GE(opened, seen - 1) << "of " << seen << " pixels across the wound; one may be a highlight";

        draw({ 52.0, skin, 20.0 }, { 52.0, skin, -20.0 });
        EXPECT_EQ(snapshot.cuts.size(), 1U);
        EXPECT_NE(window.error_line().find("inside the outline"), std::string::npos) << window.error_line();
        // That outline is drawn 12 mm inside the rim, while there is something to cut.
        const auto brightest = [&](const QImage& picture) {
            double most = 0.0;
            for (int i = -4; i <= 4; ++i)
                most = std::max(
                    most, picture.pixelColor(pixel_of(view, { -38.0, skin, 10.0 }) + QPoint(i, 0)).lightnessF());
            return most;
        };
        const double with_outline = brightest(view.picture());
        QTest::keyClick(&window, Qt::Key_X);
        wait();
        EXPECT_NEAR(brightest(view.picture()), with_outline, 0.01) << "tissue is taken out inside it too";
        QTest::keyClick(&window, Qt::Key_H);
        wait();
        EXPECT_GT(with_outline, brightest(view.picture()) + 0.1);
        EXPECT_EQ(view.drawing_errors(), "");
    }

    TEST_F(KnifeWindowTest, AnotherCaseOrTheEndMayComeInTheMiddleOfAStroke)
    {
        take_knife();
        begin(-30.0, 0.0, 30.0, 0.0);
        window_->open(test_support::synthetic_case());
        wait_until_idle();
        EXPECT_EQ(error(), "");
        EXPECT_TRUE(window_->knife().snapshot() == nullptr || snapshot().cuts.empty());
        mouse_up(pixel(30.0, 0.0));
        press(Qt::Key_K);
        press(Qt::Key_K);
        wait_until_idle();
        begin(-30.0, 0.0, 30.0, 0.0);
        window_.reset(); // closed with the button down
        SUCCEED();
    }

} // namespace knife_window_test
} // namespace retractor::ui
