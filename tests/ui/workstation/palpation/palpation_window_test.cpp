// Palpation in its window, driven by mouse and keyboard events. main() is in main_window_test.cpp.

#include "tests/planner/session/touchable_tube.h"
#include "tests/support/window/window_help.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "haptics/recording/motion_file.h"
#include "ui/workstation/palpation/palpation_window.h"
#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QMouseEvent>
#include <QPushButton>
#include <QTest>
#include <QWheelEvent>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>

namespace retractor::ui {
namespace palpation_window_test {

    namespace fs = std::filesystem;

    constexpr double kPressedN = 0.02; ///< far above rounding, far below what a press takes

    fs::path picture_folder()
    {
        const char* folder = std::getenv("RETRACTOR_PICTURES");
        return folder != nullptr ? fs::path(folder) : fs::temp_directory_path();
    }

    class PalpationWindowTest : public testing::Test {
    protected:
        void open(const planner::PalpationSetup& setup = {})
        {
            window_ = std::make_unique<PalpationWindow>(planner::tube_backend(control_));
            test_support::show_window(*window_);
            window_->open(planner::tube_scene(), setup);
            test_support::wait_until_idle(*window_);
            ASSERT_EQ(window_->snapshot().phase, planner::PalpationSnapshot::Phase::ready) << window_->error_line();
            ASSERT_TRUE(until([&] { return window_->frame().servo.ticks > 0; }));
            window_->view().picture();
        }
        bool until(const std::function<bool()>& so)
        {
            return QTest::qWaitFor([&] { return so(); }, test_support::kPatienceMs);
        }
        double force(std::size_t finger = 0) const { return window_->frame().servo.contacts[finger].force.norm(); }

        /// Where a place is in the picture.
        QPoint pixel(const Vec3& place) const
        {
            const PictureView& view = window_->view();
            const Camera camera = view.camera();
            const Vec3 sight = (camera.aim - camera.eye).normalized(), right = sight.cross(camera.up).normalized(),
                       up = right.cross(sight), from = place - camera.eye;
            const double slope = std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
            const double per = 0.5 * view.height() / (slope * from.dot(sight));
            return { static_cast<int>(std::lround(0.5 * view.width() + per * from.dot(right))),
                static_cast<int>(std::lround(0.5 * view.height() - per * from.dot(up))) };
        }
        QPoint site(const Vec3& aside = Vec3::Zero()) const
        {
            return pixel(planner::tube_scene().site("centre").point + aside);
        }
        void down(const QPoint& at) { QTest::mousePress(&window_->view(), Qt::LeftButton, {}, at); }
        void up(const QPoint& at) { QTest::mouseRelease(&window_->view(), Qt::LeftButton, {}, at); }
        void move(const QPoint& at, Qt::MouseButtons held = Qt::NoButton)
        {
            QMouseEvent event(QEvent::MouseMove, at, Qt::NoButton, held, {});
            QApplication::sendEvent(&window_->view(), &event);
        }
        void wheel(const QPoint& at, int notches)
        {
            QWheelEvent event(at, window_->view().mapToGlobal(at), {}, { 0, 120 * notches }, Qt::LeftButton, {},
                Qt::NoScrollPhase, false);
            QApplication::sendEvent(&window_->view(), &event);
        }
        void press_key(Qt::Key key) { QTest::keyClick(window_.get(), key); }
        double settled_force()
        {
            constexpr double kApart = 0.1, kStill = 1e-6; // s of the servo's time; N
            double last = -1.0, since = window_->frame().servo.time_s;
            EXPECT_TRUE(until([&] {
                if (window_->frame().servo.time_s < since + kApart)
                    return false;
                const bool still = force() > kPressedN && std::abs(force() - last) < kStill;
                last = force();
                since = window_->frame().servo.time_s;
                return still;
            }));
            return force();
        }

        std::shared_ptr<planner::TubeControl> control_ = std::make_shared<planner::TubeControl>();
        std::unique_ptr<PalpationWindow> window_;
    };

    TEST_F(PalpationWindowTest, ThroughAWoundItSaysWhatAFingerReachesAndWhatStopsIt)
    {
        open();
        EXPECT_TRUE(window_->reach_text().isEmpty()) << "nothing is round the tissue";
        ShownWound wound { .palpable = { planner::tube_scene(), {} },
            .scene = palpation_scene(planner::tube_scene(), {}),
            .ways = planner::slit_before_tube(20.0) };
        window_->open_through(std::move(wound));
        test_support::wait_until_idle(*window_);
        ASSERT_TRUE(until([&] { return window_->reach_text().contains("% of the whole surface"); }));
        EXPECT_TRUE(window_->windowTitle().contains("through the wound"));
        window_->view().picture();
        move(site());
        down(site());
        EXPECT_GT(settled_force(), kPressedN) << "through the slit";
        EXPECT_FALSE(window_->reach_text().contains("stopped")) << window_->reach_text().toStdString();
        const QImage with_finger = window_->view().picture();
        with_finger.save(QString::fromStdString((picture_folder() / "palpation_wound.png").string()));
        up(site());
        // Along the tube, under the lip: the finger stays behind the hand.
        move(site(22.0 * planner::tube_axis()));
        EXPECT_TRUE(until([&] { return window_->reach_text().contains("stopped by: "); }))
            << window_->reach_text().toStdString();
        QComboBox& through = window_->panel().through();
        ASSERT_EQ(through.count(), 2);
        through.setCurrentIndex(1);
        emit through.activated(1);
        EXPECT_TRUE(until([&] { return window_->reach_text().startsWith("A straight instrument, 8 mm thick"); }))
            << window_->reach_text().toStdString();
        window_->open(planner::tube_scene());
        test_support::wait_until_idle(*window_);
        EXPECT_TRUE(window_->reach_text().isEmpty()) << "the plain palpation is as before";
    }

    TEST_F(PalpationWindowTest, AMousePressIsAForceAndADentInTheDrawnTissue)
    {
        open();
        const QImage before = window_->view().picture();
        move(site());
        EXPECT_TRUE(window_->tool().is_out(0));
        EXPECT_EQ(force(), 0.0) << "it hovers";
        down(site());
        const double pressed = settled_force();
        const Vec3 outward = planner::tube_scene().site("centre").outward;
        const Eigen::VectorXd moved = (window_->frame().shown - window_->frame().surface->vertices) * outward;
        EXPECT_LT(moved.minCoeff(), -0.3) << "mm";
        EXPECT_TRUE(until([&] { return window_->panel().force_text(0) == QString("%1 N").arg(pressed, 0, 'f', 3); }))
            << window_->panel().force_text(0).toStdString();
        EXPECT_GT(window_->chart().samples().back().force[0], kPressedN);
        window_->save_screenshot(picture_folder() / "palpation_press.png");
        EXPECT_NE(window_->view().picture(), before);
        // The ball that is drawn lies on the tissue that is drawn.
        const std::array<Vec3, haptics::kMaxFingers> tips = shown_fingertips(window_->frame());
        EXPECT_GE((tips[0] - window_->frame().servo.fingers[0].position).dot(outward), -1e-9);
        wheel(site(), 2);
        EXPECT_NEAR(window_->panel().depth().value(), 2.0, 1e-9) << "0.25 mm a notch";
        EXPECT_TRUE(until([&] { return force() > 1.1 * pressed; }));
        up(site());
        EXPECT_TRUE(until([&] { return force() == 0.0; }));
        EXPECT_EQ(window_->view().drawing_errors(), "");
        EXPECT_EQ(window_->error_line(), "");
    }

    TEST_F(PalpationWindowTest, TwoFingersPinchAndEscapeLiftsThem)
    {
        open();
        const QPoint there = site(Vec3(0.0, 0.0, 12.0));
        down(site());
        ASSERT_TRUE(until([&] { return force(0) > kPressedN; }));
        press_key(Qt::Key_2);
        EXPECT_EQ(window_->tool().finger(), 1U);
        up(site());
        move(there);
        down(there);
        EXPECT_TRUE(until([&] { return force(0) > kPressedN && force(1) > kPressedN; })) << "the first one stays";
        press_key(Qt::Key_H);
        window_->save_screenshot(picture_folder() / "palpation_two_fingers.png");
        up(there);
        EXPECT_TRUE(until([&] { return force(1) == 0.0; }));
        EXPECT_GT(force(0), kPressedN);
        press_key(Qt::Key_3);
        EXPECT_EQ(window_->tool().finger(), 1U) << "there are two fingers";
        press_key(Qt::Key_Escape);
        EXPECT_TRUE(until([&] { return force(0) == 0.0; }));
        EXPECT_EQ(window_->view().drawing_errors(), "");
    }

    TEST_F(PalpationWindowTest, AFingerLeftPressingIsLiftedOverToWhereItPressesNext)
    {
        open();
        constexpr double kApart = 12.0, kPixels = 2.0; // mm
        const Vec3 aside(0.0, 0.0, kApart);
        const double z = planner::tube_scene().site("centre").point.z();
        down(site());
        ASSERT_TRUE(until([&] { return force() > kPressedN; }));
        press_key(Qt::Key_2);
        up(site());
        press_key(Qt::Key_1);
        ASSERT_EQ(window_->tool().finger(), 0U);
        window_->start_recording();
        ASSERT_TRUE(until([&] { return window_->frame().recorded_s > 0.0; }));
        ASSERT_GT(force(), kPressedN) << "it was left pressing";
        down(site(aside));
        ASSERT_TRUE(until([&] {
            const Vec3 at = window_->frame().servo.fingers[0].position;
            return std::abs(at.z() - z - kApart) < kPixels && force() > kPressedN;
        }));
        const fs::path file = fs::temp_directory_path() / "palpation_window_hop.motion";
        window_->stop_recording(file);
        ASSERT_TRUE(until([&] { return window_->frame().recorded_s < 0.0 && window_->idle(); }));
        const haptics::MotionRecording recording = haptics::read_motion(file);
        std::size_t between = 0;
        for (std::size_t tick = 0; tick < recording.tick_count(); ++tick) {
            const double along = recording.at(tick, 0).position.z() - z;
            between += along > kPixels && along < kApart - kPixels ? 1 : 0;
        }
        EXPECT_EQ(between, 0U) << "of " << recording.tick_count() << " ticks, swept through the tissue";
        fs::remove(file);
    }

    TEST_F(PalpationWindowTest, ATemplateEditChangesTheForce)
    {
        open();
        PalpationPanel& panel = window_->panel();
        EXPECT_FALSE(panel.apply_button().isEnabled()) << "it has no place yet";
        panel.template_modulus().setValue(4.0);
        panel.template_size().setValue(100.0);
        press_key(Qt::Key_T);
        down(site());
        up(site());
        EXPECT_EQ(force(), 0.0) << "that click said where";
        ASSERT_TRUE(panel.apply_button().isEnabled());
        down(site());
        const double before = settled_force();
        panel.apply_button().click();
        EXPECT_TRUE(until([&] { return std::abs(force() / before - 4.0) < 1e-3; })) << force() / before;
        EXPECT_EQ(window_->snapshot().edits.size(), 1U);
        window_->save_screenshot(picture_folder() / "palpation_template.png");
        EXPECT_EQ(window_->error_line(), "");
    }

    TEST_F(PalpationWindowTest, AFaultIsShownAndArmedAgain)
    {
        control_->can_be_sick = true;
        open();
        EXPECT_EQ(window_->panel().fault_text(), "");
        control_->sick = true;
        ASSERT_TRUE(until([&] { return window_->panel().fault_text().contains("switched off"); }));
        window_->save_screenshot(picture_folder() / "palpation_fault.png");
        EXPECT_FALSE(window_->panel().rearm_button().isHidden());
        control_->sick = false;
        const std::uint64_t ticks = window_->frame().servo.ticks;
        constexpr std::uint64_t kWhile = 200; // ticks without a fault
        ASSERT_TRUE(until([&] { return window_->frame().servo.ticks > ticks + kWhile; }));
        EXPECT_TRUE(window_->panel().fault_text().contains("switched off")) << "until somebody arms it";
        window_->panel().rearm_button().click();
        EXPECT_TRUE(until([&] { return window_->panel().fault_text().isEmpty(); }));
    }

    TEST_F(PalpationWindowTest, ModelsAreChosenAndWhatDoesNotServeIsSaid)
    {
        open();
        QComboBox& model = window_->panel().model();
        const auto choose = [&](int index) {
            model.setCurrentIndex(index);
            emit model.activated(index);
            test_support::wait_until_idle(*window_);
        };
        EXPECT_FALSE(window_->panel().spheres_box().isEnabled());
        choose(1);
        EXPECT_NE(window_->error_line().find("springs do not hold this tube"), std::string::npos);
        EXPECT_TRUE(until([&] { return model.currentIndex() == 0; }));
        choose(2);
        ASSERT_TRUE(until([&] { return window_->snapshot().setup.model == "spheres"; }));
        ASSERT_TRUE(until([&] { return window_->frame().spheres != nullptr; }));
        EXPECT_EQ(window_->error_line(), "");
        const QImage surface = window_->view().picture();
        press_key(Qt::Key_S);
        EXPECT_TRUE(until([&] { return window_->view().picture() != surface; }));
        down(site());
        EXPECT_TRUE(until([&] { return force() > 0.0; }));
        window_->save_screenshot(picture_folder() / "palpation_spheres.png");
        press_key(Qt::Key_G);
        EXPECT_TRUE(window_->panel().grip_box().isChecked());
        up(site());
        press_key(Qt::Key_Escape);
        EXPECT_FALSE(window_->panel().grip_box().isChecked());
        EXPECT_TRUE(until([&] { return force() == 0.0; }));
        EXPECT_EQ(window_->view().drawing_errors(), "");
    }

    TEST_F(PalpationWindowTest, WhatFingersDoIsWrittenDown)
    {
        open();
        const fs::path file = fs::temp_directory_path() / "palpation_window_test.csv";
        window_->panel().record_button().click();
        ASSERT_TRUE(until([&] { return window_->frame().recorded_s > 0.0; }));
        down(site());
        ASSERT_TRUE(until([&] { return force() > kPressedN; }));
        window_->stop_recording(file);
        ASSERT_TRUE(until([&] { return window_->frame().recorded_s < 0.0 && window_->idle(); }));
        const haptics::MotionRecording recording = haptics::read_motion(file);
        EXPECT_EQ(recording.devices.size(), 2U);
        double most = 0.0;
        for (std::size_t tick = 0; tick < recording.tick_count(); ++tick)
            most = std::max(most, recording.at(tick, 0).commanded_force.norm());
        EXPECT_GT(most, kPressedN);
        EXPECT_EQ(window_->error_line(), "");
        fs::remove(file);
    }

    TEST_F(PalpationWindowTest, WhatIsToBeSaidOfTheSceneIsShownUntilTheNextOne)
    {
        const std::string note = "the wall is thinner under 7 vertices";
        const auto shown = [&] {
            for (const QLabel* label : window_->panel().findChildren<QLabel*>())
                if (label->text().contains(QString::fromStdString(note)))
                    return true;
            return false;
        };
        open();
        EXPECT_FALSE(shown());
        window_->open(planner::tube_scene(), {}, { note });
        ASSERT_TRUE(until([&] { return window_->idle(); }));
        ASSERT_EQ(window_->snapshot().phase, planner::PalpationSnapshot::Phase::ready) << window_->error_line();
        EXPECT_TRUE(shown());
        window_->open(planner::tube_scene());
        ASSERT_TRUE(until([&] { return window_->idle(); }));
        EXPECT_FALSE(shown());
    }

    TEST_F(PalpationWindowTest, AFileThatIsNoSceneIsRefusedInTheWindow)
    {
        open();
        const fs::path file = fs::temp_directory_path() / "palpation_window_test.json";
        std::ofstream(file) << "{ \"format\": \"retractor palpation scene\", \"schema\": 7, \"frame\": \"LPS\" }";
        EXPECT_TRUE(datasets::is_palpation_scene(file));
        window_->open_file(file);
        EXPECT_NE(window_->error_line().find("palpation_window_test.json#/schema: must be 1"), std::string::npos)
            << window_->error_line();
        down(site());
        EXPECT_TRUE(until([&] { return force() > kPressedN; })) << "what was palpated goes on";
        up(site());
        window_->open_file(file.parent_path() / "no_such_scene.json");
        EXPECT_NE(window_->error_line().find("no_such_scene.json"), std::string::npos) << window_->error_line();
        fs::remove(file);
    }

} // namespace palpation_window_test
} // namespace retractor::ui
