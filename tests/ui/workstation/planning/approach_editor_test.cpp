// Incisions are drawn, moved and taken back in the window with the mouse.

#include "tests/support/synthetic_patient.h"
#include "tests/support/window/window_help.h"

#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_dialog.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/planning/site_dialog.h"
#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QAbstractButton>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QLineEdit>
#include <QPushButton>
#include <QTest>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

namespace retractor::ui {
namespace approach_editor_test {

    namespace fs = std::filesystem;

    constexpr double kPixelMm = 1.0; // the box is 120 mm wide on a few hundred pixels
    constexpr int kDragSteps = 12;

    class ApproachEditorTest : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::path(testing::TempDir()) / "approach_editor";
            fs::remove_all(folder_);
            fs::create_directories(folder_);
            planner::Case planned_case = test_support::synthetic_case();
            planned_case.folder = folder_;
            planned_case.labels = { "labels.nrrd", std::string(64, '0') };
            planned_case.supports.labels.clear();
            control_->incision_slices = true;
            test_support::show_window(window_);
            window_.open(std::move(planned_case));
            test_support::wait_until_idle(window_);
            window_.set_view(ViewPreset::overview);
            test_support::wait_until_idle(window_);
        }
        void press(Qt::Key key, Qt::KeyboardModifiers with = {}) { QTest::keyClick(&window_, key, with); }
        PictureView& view() { return window_.view(); }
        QPoint pixel_of(const Vec3& place) { return view().shown_at(place)->toPoint(); }
        void click(const Vec3& place)
        {
            QTest::mouseClick(&view(), Qt::LeftButton, {}, pixel_of(place));
            QTest::qWait(QApplication::doubleClickInterval() + 10); // two clicks are no double click
        }
        void drag(const Vec3& from, const Vec3& to)
        {
            QTest::mousePress(&view(), Qt::LeftButton, {}, pixel_of(from));
            for (int n = 1; n <= kDragSteps; ++n) {
                const Vec3 at = from + (to - from) * n / kDragSteps;
                QMouseEvent event(QEvent::MouseMove, pixel_of(at), Qt::NoButton, Qt::LeftButton, Qt::NoModifier);
                QCoreApplication::sendEvent(&view(), &event);
            }
            QTest::mouseRelease(&view(), Qt::LeftButton, {}, pixel_of(to));
        }
        ApproachDialog* dialog() { return window_.findChild<ApproachDialog*>(); }
        void accept_dialog()
        {
            ASSERT_NE(dialog(), nullptr);
            for (QAbstractButton* button : dialog()->findChild<QDialogButtonBox*>()->buttons())
                if (button->text() != "Cancel" && button->text() != "&Cancel")
                    QTest::mouseClick(button, Qt::LeftButton);
            test_support::wait_until_idle(window_);
            QCoreApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
            QApplication::setActiveWindow(&window_); // no window manager does it here
        }
        std::string file_text() const
        {
            std::ifstream in(folder_ / "case.json");
            return { std::istreambuf_iterator<char>(in), {} };
        }

        std::shared_ptr<test_support::SyntheticControl> control_ = std::make_shared<test_support::SyntheticControl>();
        fs::path folder_;
        MainWindow window_ { [this](const planner::Case&) { return test_support::synthetic_backend(control_); } };
    };

    TEST_F(ApproachEditorTest, ClicksDrawAnIncisionThatIsSavedAndTakenBack)
    {
        press(Qt::Key_D);
        ASSERT_TRUE(window_.editor().drawing());
        EXPECT_EQ(window_.model()->wall_look(), WallLook::see_through) << "the ribs are seen while one draws";
        const Vec3 first(-30.0, 0.0, 30.0), second(10.0, 0.0, 20.0), third(35.0, 0.0, -20.0);
        for (const Vec3& place : { first, second, third })
            click(place);
        ASSERT_EQ(window_.editor().tool().points().size(), 3U) << window_.message_line();
        EXPECT_LT((window_.editor().tool().points()[0] - first).norm(), kPixelMm);
        EXPECT_LT((window_.editor().tool().points()[2] - third).norm(), kPixelMm);
        press(Qt::Key_Return);
        accept_dialog();
        ASSERT_EQ(window_.approach_list().count(), 4) << window_.error_line();
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.model()->wall_look(), WallLook::solid);
        EXPECT_EQ(window_.model()->selected(), 3U);
        EXPECT_EQ(window_.model()->approach(3).target.label, "target");
        EXPECT_EQ(window_.not_saved(), "");
        EXPECT_NE(file_text().find("\"drawn\""), std::string::npos);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 3);
        EXPECT_EQ(file_text().find("\"drawn\""), std::string::npos);
        press(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 4);
    }

    TEST_F(ApproachEditorTest, ADragDrawsALineAndUndoTakesItBackWhole)
    {
        press(Qt::Key_D);
        drag({ -40.0, 0.0, 30.0 }, { 40.0, 0.0, 30.0 });
        ASSERT_GT(window_.editor().tool().points().size(), 3U);
        EXPECT_LT((window_.editor().tool().points().back() - Vec3(40.0, 0.0, 30.0)).norm(), kPixelMm);
        press(Qt::Key_Z, Qt::ControlModifier);
        EXPECT_TRUE(window_.editor().tool().points().empty());
        press(Qt::Key_Escape);
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.approach_list().count(), 3);
        EXPECT_FALSE(fs::exists(folder_ / "case.json")) << "nothing was changed";
    }

    TEST_F(ApproachEditorTest, ADoubleClickEndsTheDrawing)
    {
        press(Qt::Key_D);
        click({ -30.0, 0.0, 0.0 });
        const QPoint last = pixel_of({ 30.0, 0.0, 0.0 });
        QTest::mouseClick(&view(), Qt::LeftButton, {}, last);
        QTest::mouseDClick(&view(), Qt::LeftButton, {}, last);
        ASSERT_NE(dialog(), nullptr);
        EXPECT_EQ(window_.editor().tool().points().size(), 2U);
        dialog()->close();
        QCoreApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
        EXPECT_TRUE(window_.editor().drawing()) << "the points are not lost with the dialog";
    }

    TEST_F(ApproachEditorTest, AClickBesideThePatientSaysSo)
    {
        press(Qt::Key_D);
        QTest::mouseClick(&view(), Qt::LeftButton, {}, QPoint(3, 3));
        EXPECT_TRUE(window_.editor().tool().points().empty());
        EXPECT_NE(window_.message_line().find("no skin"), std::string::npos) << window_.message_line();
        press(Qt::Key_Return);
        EXPECT_EQ(dialog(), nullptr);
        EXPECT_NE(window_.message_line().find("two points"), std::string::npos) << window_.message_line();
    }

    TEST_F(ApproachEditorTest, PointsAreDraggedAndThePlanOfTheOldIncisionGoes)
    {
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.model()->state(0).status, FieldStatus::planned);
        press(Qt::Key_M);
        ASSERT_TRUE(window_.editor().moving());
        const Vec3 end = window_.editor().tool().points().back(), wanted(40.0, 0.0, -45.0);
        drag(end, wanted);
        click({ 20.0, 0.0, 0.0 }); // adds no point
        press(Qt::Key_Return);
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.approach_list().count(), 3);
        EXPECT_LT((window_.model()->approach(0).incision.back() - wanted).norm(), kPixelMm);
        EXPECT_EQ(window_.model()->state(0).status, FieldStatus::closed);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_LT((window_.model()->approach(0).incision.back() - end).norm(), kPixelMm);
        EXPECT_EQ(window_.model()->state(0).status, FieldStatus::planned);
    }

    TEST_F(ApproachEditorTest, AMoveThatMovesNothingKeepsThePlan)
    {
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.model()->state(0).status, FieldStatus::planned);
        press(Qt::Key_M);
        press(Qt::Key_Return);
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.model()->state(0).status, FieldStatus::planned);
        EXPECT_FALSE(window_.model()->edit_to_undo());
        EXPECT_EQ(window_.message_line(), "The incision is where it was.");
    }

    TEST_F(ApproachEditorTest, TheOpeningIsChangedWithoutChoosingTheRetractorAgain)
    {
        const auto opening = [this] { return dialog()->findChild<QDoubleSpinBox*>("opening"); };
        press(Qt::Key_E);
        ASSERT_NE(dialog(), nullptr);
        EXPECT_FALSE(opening()->isEnabled()) << "nothing opens the wound yet";
        auto* by = dialog()->findChild<QComboBox*>("opened by");
        by->setCurrentIndex(by->findData("finochietto"));
        opening()->setValue(30.0);
        accept_dialog();
        ASSERT_TRUE(window_.model()->approach(0).retractor) << window_.error_line();
        press(Qt::Key_E);
        ASSERT_NE(dialog(), nullptr);
        EXPECT_TRUE(opening()->isEnabled());
        EXPECT_EQ(opening()->value(), 30.0) << "that of the approach";
        opening()->setValue(25.0);
        accept_dialog();
        EXPECT_EQ(window_.model()->approach(0).retractor->opening_mm, 25.0);
        EXPECT_EQ(window_.model()->approach(0).retractor->kind, "finochietto");
    }

    TEST_F(ApproachEditorTest, ARefusedApproachSaysWhyInTheDialog)
    {
        press(Qt::Key_N);
        ASSERT_NE(dialog(), nullptr);
        accept_dialog(); // a median sternotomy, which the synthetic patient refuses
        ASSERT_NE(dialog(), nullptr) << "the dialog stays open";
        auto* kind = dialog()->findChild<QComboBox*>("kind");
        kind->setCurrentIndex(kind->findText("Upper hemisternotomy, J to the right"));
        EXPECT_EQ(dialog()->draft().template_name, "hemisternotomy-j");
        EXPECT_EQ(dialog()->draft().opened_by.retractor, "finochietto");
        kind->setCurrentIndex(kind->findText("Thoracotomy between two ribs"));
        EXPECT_EQ(dialog()->draft().template_name, "intercostal:4");
        EXPECT_EQ(dialog()->draft().opened_by.retractor, "finochietto");
        accept_dialog();
        EXPECT_EQ(window_.approach_list().count(), 4);
    }

    TEST_F(ApproachEditorTest, ApproachesAreDuplicatedChangedAndRemoved)
    {
        press(Qt::Key_D, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.approach_list().count(), 4);
        EXPECT_EQ(window_.model()->approach(3).name, "median-2");
        press(Qt::Key_Delete);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 3);
        for (int n = 0; n < 3; ++n) {
            press(Qt::Key_Delete);
            test_support::wait_until_idle(window_);
        }
        EXPECT_EQ(window_.approach_list().count(), 0);
        EXPECT_FALSE(window_.view().scenes().empty()) << "the patient alone is shown";
        press(Qt::Key_D);
        EXPECT_TRUE(window_.editor().drawing()) << "an incision can be drawn on the patient alone";
        press(Qt::Key_Escape);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 1);
    }

    TEST_F(ApproachEditorTest, NeighboursAreAddedTogetherAndTakenBackTogether)
    {
        press(Qt::Key_B);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.approach_list().count(), 4) << window_.error_line();
        EXPECT_EQ(window_.model()->approach(3).name, "median_space_3");
        EXPECT_EQ(window_.model()->selected(), 0U) << "the approach stays selected";
        EXPECT_NE(window_.message_line().find("Added one space higher"), std::string::npos) << window_.message_line();
        EXPECT_NE(window_.message_line().find("Not one space lower: the lowest"), std::string::npos);
        press(Qt::Key_B);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 4);
        EXPECT_NE(window_.message_line().find("There already: one space higher"), std::string::npos);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 3);
    }

    TEST_F(ApproachEditorTest, WhatIsNotSavedIsSaidUntilItIs)
    {
        fs::remove_all(folder_);
        std::ofstream(folder_) << "a file where the folder was";
        press(Qt::Key_D, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 4) << "the edit itself is kept";
        EXPECT_NE(window_.not_saved(), "");
        fs::remove(folder_);
        fs::create_directories(folder_);
        press(Qt::Key_D, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.not_saved(), "");
        EXPECT_NE(file_text().find("median-2"), std::string::npos);
        // Another program changes the case: its work is not overwritten.
        std::ofstream(folder_ / "case.json") << "{}";
        fs::last_write_time(folder_ / "case.json", fs::file_time_type::clock::now() + std::chrono::seconds(5));
        press(Qt::Key_Delete);
        test_support::wait_until_idle(window_);
        EXPECT_NE(window_.not_saved().find("nother program"), std::string::npos) << window_.not_saved();
        EXPECT_EQ(file_text(), "{}");
        for (QPushButton* button : window_.findChildren<QPushButton*>())
            if (button->text() == "Overwrite it")
                QTest::mouseClick(button, Qt::LeftButton);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.not_saved(), "");
        EXPECT_NE(file_text().find("median"), std::string::npos);
    }

    TEST_F(ApproachEditorTest, TheBladeIsDraggedOnTheSliceAcrossTheIncision)
    {
        window_.set_view(ViewPreset::incision);
        test_support::wait_until_idle(window_);
        const auto drag_blade = [&](const QPoint& by) {
            ASSERT_TRUE(view().handle_at());
            const QPoint from = view().handle_at()->toPoint();
            QTest::mousePress(&view(), Qt::LeftButton, {}, from);
            for (int n = 1; n <= kDragSteps; ++n) {
                QMouseEvent event(
                    QEvent::MouseMove, from + by * n / kDragSteps, Qt::NoButton, Qt::LeftButton, Qt::NoModifier);
                QCoreApplication::sendEvent(&view(), &event);
            }
            QTest::mouseRelease(&view(), Qt::LeftButton, {}, from + by);
            test_support::wait_until_idle(window_);
        };
        drag_blade({ 0, 60 });
        const double depth = window_.model()->approach(0).depth_mm;
        EXPECT_GT(depth, 25.0) << window_.message_line() << window_.error_line();
        EXPECT_NEAR(window_.model()->approach(0).directions.front().y(), 1.0, 0.01) << "straight down";
        EXPECT_NE(window_.message_line().find("mm deep"), std::string::npos);
        drag_blade({ 40, 0 });
        EXPECT_GT(window_.model()->approach(0).directions.front().x(), 0.1) << "to the patient's left";
        EXPECT_GT(window_.model()->approach(0).depth_mm, depth);
        // A click alone changes nothing; a blade that is refused goes back.
        const double turned = window_.model()->approach(0).depth_mm;
        QTest::mouseClick(&view(), Qt::LeftButton, {}, view().handle_at()->toPoint());
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.model()->approach(0).depth_mm, turned);
        const QPoint handle = view().handle_at()->toPoint();
        const double pixels_per_mm = 60.0 / (depth - 20.0);
        drag_blade({ static_cast<int>(-window_.model()->approach(0).directions.front().x() * turned * pixels_per_mm),
            static_cast<int>(-window_.model()->approach(0).directions.front().y() * turned * pixels_per_mm) });
        EXPECT_NE(window_.error_line().find("5 to 250 mm deep"), std::string::npos) << window_.error_line();
        EXPECT_EQ(window_.model()->approach(0).depth_mm, turned);
        EXPECT_EQ(view().handle_at()->toPoint(), handle);
        press(Qt::Key_Z, Qt::ControlModifier);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.model()->approach(0).depth_mm, 20.0);
    }

    TEST_F(ApproachEditorTest, ADiscardedMoveIsNotCarriedOut)
    {
        const Vec3 end = window_.model()->approach(0).incision.back();
        press(Qt::Key_M);
        drag(window_.editor().tool().points().back(), { 40.0, 0.0, -45.0 });
        press(Qt::Key_Return);
        press(Qt::Key_Escape); // before the approach was made
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.model()->approach(0).incision.back(), end);
        EXPECT_FALSE(window_.model()->edit_to_undo());
    }

    TEST_F(ApproachEditorTest, ANewNameLeavesTheRestAsItIs)
    {
        const std::string name = window_.model()->approach(0).name;
        const std::size_t id = window_.model()->id(0);
        press(Qt::Key_E);
        ASSERT_NE(dialog(), nullptr);
        EXPECT_TRUE(dialog()->keeps_opening());
        dialog()->findChild<QLineEdit*>("name")->setText("second thoughts");
        accept_dialog();
        EXPECT_EQ(window_.model()->approach(0).title, "second thoughts");
        EXPECT_EQ(window_.model()->approach(0).name, name) << "the plan, the choice and the cuts are found by it";
        EXPECT_EQ(window_.model()->id(0), id) << "the plan stays";
        EXPECT_EQ(window_.model()->approach(0).target.label, "target");
        EXPECT_EQ(window_.model()->approach(0).depth_mm, 20.0);
    }

    TEST_F(ApproachEditorTest, SlicesCannotBeDrawnOnAndTheKnifeTakesTheMouse)
    {
        press(Qt::Key_D);
        press(Qt::Key_3);
        EXPECT_EQ(window_.model()->view(), ViewPreset::overview);
        press(Qt::Key_K);
        EXPECT_FALSE(window_.editor().drawing());
        EXPECT_EQ(window_.knife().mode(), KnifeMode::freehand);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.view().cursor().shape(), Qt::CrossCursor) << "the mouse is the knife's";
    }

    TEST_F(ApproachEditorTest, TheTargetIsChosenWhereTheSlicesMeet)
    {
        press(Qt::Key_T);
        EXPECT_EQ(window_.findChild<SiteDialog*>(), nullptr) << "no slices are shown";
        const auto accept = [&](int site, double reach) {
            auto* asked = window_.findChild<SiteDialog*>();
            ASSERT_NE(asked, nullptr) << window_.error_line();
            asked->findChild<QComboBox*>("site")->setCurrentIndex(site);
            if (reach > 0.0)
                asked->findChild<QDoubleSpinBox*>("reach")->setValue(reach);
            asked->accept();
            test_support::wait_until_idle(window_);
            QCoreApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
            QApplication::setActiveWindow(&window_);
        };
        press(Qt::Key_3);
        press(Qt::Key_T);
        accept(1, 9.0);
        EXPECT_FALSE(window_.model()->approach(0).target.is_site());
        EXPECT_NE(window_.error_line().find("the surface of \"target\" is farther away"), std::string::npos)
            << window_.error_line();
        press(Qt::Key_T);
        accept(1, 24.0);
        const planner::TargetSpec site = window_.model()->approach(0).target;
        EXPECT_EQ(site.label, "target");
        EXPECT_EQ(site.site, "clamp site");
        EXPECT_EQ(site.radius_mm, 24.0);
        EXPECT_NEAR((site.centre - Vec3(0.0, 50.0, 0.0)).norm(), 0.0, 1e-9) << "where the slices meet";
        EXPECT_NE(file_text().find("\"clamp site\""), std::string::npos);
        press(Qt::Key_Z, Qt::ControlModifier);
        EXPECT_FALSE(window_.model()->approach(0).target.is_site());
        press(Qt::Key_3);
        test_support::wait_until_idle(window_);
        press(Qt::Key_T);
        accept(static_cast<int>(std::size(planner::kSites)), 0.0);
        EXPECT_EQ(window_.model()->approach(0).target.label, "target") << "the whole";
        EXPECT_FALSE(window_.model()->approach(0).target.is_site());
    }

} // namespace approach_editor_test
} // namespace retractor::ui
