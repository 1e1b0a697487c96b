// The window under a virtual display, driven by mouse and keyboard events.

#include "tests/support/synthetic_patient.h"
#include "tests/support/window/window_help.h"
#include "tests/support/window/window_pictures.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/elastic_model.h"
#include "datasets/phantoms/phantom.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "planner/palpation/palpable.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/arrange_scenes.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/tissue_colors.h"
#include "ui/workstation/benchmark/window_benchmark.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/start/start_page.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"
#include "ui/workstation/view/theme.h"

#include <gtest/gtest.h>

#include <QAbstractButton>
#include <QAction>
#include <QApplication>
#include <QLabel>
#include <QMessageBox>
#include <QMouseEvent>
#include <QProgressBar>
#include <QStatusBar>
#include <QSurfaceFormat>
#include <QTabWidget>
#include <QTest>
#include <QTimer>
#include <QWheelEvent>

#include <QVTKInteractor.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <utility>

namespace retractor::ui {
namespace main_window_test {

    namespace fs = std::filesystem;

    using test_support::distinct_colours;
    using test_support::kColoursOfAPicture;
    using test_support::target_pixels;

    fs::path picture_folder()
    {
        const char* folder = std::getenv("RETRACTOR_PICTURES");
        return folder != nullptr ? fs::path(folder) : fs::temp_directory_path();
    }

    class MainWindowTest : public testing::Test {
    protected:
        void open_synthetic()
        {
            test_support::show_window(window_);
            window_.open(test_support::synthetic_case());
            test_support::wait_until_idle(window_);
        }
        void click(int row)
        {
            ApproachList& list = window_.approach_list();
            QTest::mouseClick(list.viewport(), Qt::LeftButton, {}, list.visualItemRect(list.item(row)).center());
        }
        void press(Qt::Key key, Qt::KeyboardModifiers with = {}) { QTest::keyClick(&window_, key, with); }
        FieldStatus status(std::size_t index) const { return window_.model()->state(index).status; }

        std::shared_ptr<test_support::SyntheticControl> control_ = std::make_shared<test_support::SyntheticControl>();
        MainWindow window_ { [this](const planner::Case&) { return test_support::synthetic_backend(control_); } };
    };

    TEST_F(MainWindowTest, IsEmptyButUsableBeforeACaseIsOpen)
    {
        test_support::show_window(window_);
        press(Qt::Key_P);
        press(Qt::Key_3);
        EXPECT_EQ(window_.approach_list().count(), 0);
        EXPECT_TRUE(window_.idle());
        EXPECT_EQ(window_.error_line(), "");
        EXPECT_TRUE(window_.start_page_shown());
    }

    TEST_F(MainWindowTest, ADraftSaysSoAndThePlanTakesItsPlace)
    {
        open_synthetic();
        const auto detail = [&] { return window_.approach_list().item(0)->toolTip().toStdString(); };
        press(Qt::Key_P, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_NE(detail().find("Draft: "), std::string::npos) << detail();
        const auto says_draft = [&] {
            const auto labels = window_.findChildren<QLabel*>();
            return std::ranges::any_of(
                labels, [](const QLabel* label) { return label->text().startsWith("This is a draft"); });
        };
        EXPECT_TRUE(says_draft()) << "over the verdict";
        EXPECT_EQ(control_->plans_made, 1);
        press(Qt::Key_P, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(control_->plans_made, 1) << "there is a draft";
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(control_->plans_made, 2);
        EXPECT_EQ(detail().find("Draft: "), std::string::npos) << detail();
        EXPECT_FALSE(says_draft());
        press(Qt::Key_P, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(control_->plans_made, 2) << "a plan says more than a draft";
    }

    TEST_F(MainWindowTest, ThePlannedTargetIsPalpatedThroughItsWound)
    {
        open_synthetic();
        std::vector<std::string> wounds;
        window_.on_palpable_wound = [&](const ShownWound& wound) { wounds.push_back(wound.scene.title); };
        press(Qt::Key_T, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_TRUE(wounds.empty()) << "nothing is planned";
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        press(Qt::Key_T, Qt::ControlModifier);
        EXPECT_FALSE(window_.idle());
        test_support::wait_until_idle(window_);
        EXPECT_EQ(wounds, std::vector<std::string> { "median" });
        EXPECT_EQ(window_.error_line(), "");
        control_->hold = true;
        press(Qt::Key_T, Qt::ControlModifier);
        press(Qt::Key_Escape);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.message_line(), "The palpation was cancelled.");
        EXPECT_EQ(wounds.size(), 1U);
        control_->hold = false;
        window_.select("lateral");
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        press(Qt::Key_T, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(wounds.size(), 1U);
        EXPECT_NE(window_.error_line().find("plan it again"), std::string::npos) << window_.error_line();
    }

    TEST_F(MainWindowTest, ClosingTheCaseGoesBackToTheStartPage)
    {
        open_synthetic();
        EXPECT_FALSE(window_.start_page_shown());
        window_.close_case();
        EXPECT_TRUE(window_.start_page_shown());
        EXPECT_EQ(window_.approach_list().count(), 0);
        press(Qt::Key_P);
        press(Qt::Key_D);
        EXPECT_TRUE(window_.idle());
        open_synthetic();
        EXPECT_EQ(window_.approach_list().count(), 3);
    }

    TEST_F(MainWindowTest, WLooksThroughTheWallAndAClickSaysWhatIsThere)
    {
        open_synthetic();
        window_.set_view(ViewPreset::overview);
        test_support::wait_until_idle(window_);
        const auto has = [&](std::string_view name) {
            const std::vector<SurfaceItem>& items = window_.view().scenes().front().surfaces;
            return std::any_of(items.begin(), items.end(), [&](const SurfaceItem& item) { return item.name == name; });
        };
        const int behind_skin = target_pixels(window_.view().picture());
        EXPECT_FALSE(has("heart"));
        press(Qt::Key_W);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.model()->wall_look(), WallLook::see_through);
        EXPECT_TRUE(has("heart"));
        constexpr int kOfATarget = 500;
        EXPECT_GT(target_pixels(window_.view().picture()), behind_skin + kOfATarget);

        const auto click_at = [&](const Vec3& place) {
            QTest::mouseClick(&window_.view(), Qt::LeftButton, {}, window_.view().shown_at(place)->toPoint());
            QTest::qWait(QApplication::doubleClickInterval() + 10); // two clicks are no double click
        };
        const Vec3 target(0.0, 50.0, 0.0); // the sphere's middle, 20 mm deep in it
        click_at(target);
        EXPECT_EQ(window_.message_line().rfind("Target. T makes this place the target", 0), 0U)
            << window_.message_line();
        ASSERT_TRUE(window_.model()->slice_place());
        EXPECT_NEAR((*window_.model()->slice_place() - target).norm(), 20.0, 2.0);
        const auto is_mark = [](const LineItem& line) { return line.name == "mark"; };
        ASSERT_TRUE(QTest::qWaitFor(
            [&] {
                const auto& lines = window_.view().scenes().front().lines;
                return std::count_if(lines.begin(), lines.end(), is_mark) == 3;
            },
            test_support::kPatienceMs));
        // A turn is no click.
        press(Qt::Key_R); // measuring says what to do, and its end nothing
        press(Qt::Key_Escape);
        QTest::mousePress(&window_.view(), Qt::LeftButton, {}, { 200, 200 });
        QMouseEvent move(QEvent::MouseMove, QPoint(260, 220), Qt::NoButton, Qt::LeftButton, Qt::NoModifier);
        QCoreApplication::sendEvent(&window_.view(), &move);
        QTest::mouseRelease(&window_.view(), Qt::LeftButton, {}, { 260, 220 });
        EXPECT_EQ(window_.message_line(), "");

        press(Qt::Key_W);
        EXPECT_FALSE(has(kBodyName));
        press(Qt::Key_W);
        EXPECT_EQ(window_.model()->wall_look(), WallLook::solid);
        EXPECT_TRUE(has(kBodyName));
        EXPECT_FALSE(has("heart"));
    }

    TEST_F(MainWindowTest, AnAreaIsMeasuredOnASlice)
    {
        open_synthetic();
        window_.set_view(ViewPreset::slices);
        test_support::wait_until_idle(window_);
        press(Qt::Key_R, Qt::ShiftModifier);
        PictureView& view = window_.view();
        const auto click_at = [&](double across, double up) { // shares of the view
            const QPoint at(static_cast<int>(across * view.width()), static_cast<int>((1.0 - up) * view.height()));
            EXPECT_TRUE(view.slice_place_at(at));
            QTest::mouseClick(&view, Qt::LeftButton, {}, at);
            QTest::qWait(QApplication::doubleClickInterval() + 10); // two clicks are no double click
            return view.slice_place_at(at).value_or(Vec3::Zero());
        };
        const Vec3 a = click_at(0.2, 0.7), b = click_at(0.3, 0.7), c = click_at(0.3, 0.8);
        const double triangle = 0.5 * (b - a).cross(c - a).norm();
        EXPECT_GT(triangle, 10.0);
        EXPECT_EQ(window_.message_line().find(QString::number(triangle / 100.0, 'f', 1).toStdString() + " cm"), 0U)
            << window_.message_line();
        press(Qt::Key_Z, Qt::ControlModifier);
        press(Qt::Key_Return); // the next area
        click_at(0.25, 0.75);
        EXPECT_EQ(window_.message_line(), "Click the next corner.");
        press(Qt::Key_Escape);
        EXPECT_EQ(window_.message_line(), "");
    }

    TEST_F(MainWindowTest, AnEndoscopeLooksFromTheWoundAndIsTurned)
    {
        open_synthetic();
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        const Camera surgeon = window_.model()->state(0).field->surgeon.camera;
        press(Qt::Key_6);
        EXPECT_NEAR((window_.view().camera().eye - surgeon.aim).norm(), 50.0, 1e-6) << window_.error_line();
        press(Qt::Key_7);
        const Camera up = window_.view().camera();
        press(Qt::Key_7);
        const Camera right = window_.view().camera();
        EXPECT_NEAR((up.eye - right.eye).norm(), 0.0, 1e-6);
        EXPECT_GT((up.aim - right.aim).norm(), 20.0);
        EXPECT_NE(window_.message_line().find("30\u00b0 off its shaft"), std::string::npos);
        press(Qt::Key_0);
        EXPECT_NEAR((window_.view().camera().eye - surgeon.eye).norm(), 0.0, 1e-6);
    }

    TEST_F(MainWindowTest, OnePictureIsLargeBesideTheSlices)
    {
        open_synthetic();
        window_.set_view(ViewPreset::slices);
        test_support::wait_until_idle(window_);
        press(Qt::Key_L, Qt::ShiftModifier);
        EXPECT_EQ(window_.view().layout_of_scenes(), SceneLayout::one_large);
        EXPECT_FALSE(window_.view().slice_place_at({ 0.3 * window_.view().width(), 0.5 * window_.view().height() }));
        EXPECT_TRUE(window_.view().slice_place_at({ 0.85 * window_.view().width(), 0.5 * window_.view().height() }));
        EXPECT_GT(distinct_colours(window_.view().picture()), kColoursOfAPicture);
        press(Qt::Key_1);
        EXPECT_EQ(window_.view().layout_of_scenes(), SceneLayout::grid);
    }

    TEST_F(MainWindowTest, TheTourGoesThroughEightStepsAndEnds)
    {
        EXPECT_NE(window_.start_page().findChild<QAbstractButton*>("tour"), nullptr);
        open_synthetic();
        for (QAction* action : window_.findChildren<QAction*>())
            if (action->text() == "Tour")
                action->trigger();
        ASSERT_TRUE(window_.tour_bar().isVisible());
        std::set<QString> titles;
        for (std::size_t step = 1;; ++step) {
            test_support::wait_until_idle(window_);
            EXPECT_EQ(window_.tour_bar().number(), step);
            titles.insert(window_.tour_bar().title());
            EXPECT_FALSE(window_.tour_bar().text().isEmpty());
            if (step == window_.tour_bar().count())
                break;
            for (auto* button : window_.tour_bar().findChildren<QAbstractButton*>())
                if (button->text() == "Next")
                    QTest::mouseClick(button, Qt::LeftButton);
        }
        EXPECT_EQ(titles.size(), 8U);
        EXPECT_EQ(window_.error_line(), "");
        press(Qt::Key_Escape);
        EXPECT_FALSE(window_.tour_bar().isVisible());
        // Another case ends a tour.
        for (QAction* action : window_.findChildren<QAction*>())
            if (action->text() == "Tour")
                action->trigger();
        EXPECT_TRUE(window_.tour_bar().isVisible());
        EXPECT_EQ(window_.model()->shown_view(), ViewPreset::overview);
        window_.close_case();
        EXPECT_FALSE(window_.tour_bar().isVisible());
    }

    TEST_F(MainWindowTest, ThePatientIsCutAwayUpToTheSlices)
    {
        open_synthetic();
        window_.set_view(ViewPreset::slices);
        test_support::wait_until_idle(window_);
        for (QAction* action : window_.findChildren<QAction*>())
            if (action->text() == "The front")
                action->trigger();
        test_support::wait_until_idle(window_);
        const auto cut = [&] { return window_.view().scenes().back().cut_away; };
        ASSERT_TRUE(cut());
        EXPECT_TRUE(cut()->face) << "the CT lies on the cut";
        EXPECT_EQ(cut()->point, *window_.model()->slice_place());
        window_.view().on_slice_point({ 0.0, 40.0, 0.0 });
        EXPECT_EQ(cut()->point.y(), 40.0) << "the cut follows the slices";
        window_.set_view(ViewPreset::overview);
        test_support::wait_until_idle(window_);
        const auto wheel = [&](Qt::KeyboardModifiers with) {
            const QPointF at(window_.view().width() / 2, window_.view().height() / 2);
            QWheelEvent event(at, window_.view().mapToGlobal(at.toPoint()), {}, { 0, 120 }, Qt::NoButton, with,
                Qt::NoScrollPhase, false);
            QCoreApplication::sendEvent(&window_.view(), &event);
        };
        wheel(Qt::ShiftModifier);
        EXPECT_EQ(cut()->point.y(), 45.0);
        const double distance = (window_.view().camera().eye - window_.view().camera().aim).norm();
        wheel(Qt::NoModifier);
        EXPECT_EQ(cut()->point.y(), 45.0);
        EXPECT_LT((window_.view().camera().eye - window_.view().camera().aim).norm(), distance) << "this zooms";
        EXPECT_GT(distinct_colours(window_.view().picture()), kColoursOfAPicture);
        for (QAction* action : window_.findChildren<QAction*>())
            if (action->text() == "Nothing")
                action->trigger();
        EXPECT_FALSE(cut());
    }

    TEST_F(MainWindowTest, ListsTheApproachesAndShowsTheClosedPatient)
    {
        open_synthetic();
        ASSERT_EQ(window_.approach_list().count(), 3);
        EXPECT_EQ(window_.approach_list().item(0)->text(), "median");
        EXPECT_EQ(window_.approach_list().item(1)->text(), "lateral");
        const QImage picture = window_.view().picture();
        EXPECT_GT(distinct_colours(picture), kColoursOfAPicture);
        EXPECT_EQ(target_pixels(picture), 0) << "the skin is closed";
        EXPECT_EQ(control_->closed_made, 3) << "each closed picture is made once";
        EXPECT_EQ(window_.view().drawing_errors(), "");
        EXPECT_EQ(window_.error_line(), "");
    }

    TEST_F(MainWindowTest, AVesselOfTheCaseIsMadePalpable)
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 30, 30, 40 };
        labels.grid.spacing = { 2.0, 2.0, 2.0 };
        labels.table = { { 1, "aorta", "vessel", mesh::Role::target } };
        for (int k = 0; k < 40; ++k)
            for (int j = 0; j < 30; ++j)
                for (int i = 0; i < 30; ++i)
                    labels.voxels.push_back(std::hypot(i - 14.0, j - 14.0) <= 6.0 ? 1 : 0);
        const auto folder = std::filesystem::path(testing::TempDir()) / "palpable_case";
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        planner::ImportedCase imported;
        imported.labels = std::make_shared<const mesh::LabelVolume>(labels);
        test_support::show_window(window_);
        window_.open(planner::write_import(imported, folder / "case.json"));
        std::optional<planner::Palpable> made;
        window_.on_palpable = [&](planner::Palpable palpable) { made = std::move(palpable); };
        window_.palpate("aorta");
        EXPECT_FALSE(window_.idle());
        test_support::wait_until_idle(window_);
        ASSERT_TRUE(made) << window_.error_line();
        EXPECT_EQ(made->scene.name, "aorta");
        EXPECT_TRUE(datasets::has_inner_wall(made->scene.body));
        EXPECT_TRUE(std::any_of(made->notes.begin(), made->notes.end(),
            [](const std::string& note) { return note.starts_with("its outline is smoothed"); }));
        made.reset();
        window_.palpate("spleen");
        test_support::wait_until_idle(window_);
        EXPECT_FALSE(made);
        EXPECT_NE(window_.error_line().find("there is no structure \"spleen\""), std::string::npos);
        std::filesystem::remove_all(folder);
    }

    TEST_F(MainWindowTest, AClickSelectsAndAKeyPlansAndTheTargetAppears)
    {
        open_synthetic();
        click(1);
        ASSERT_EQ(window_.model()->selected(), 1U);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(1) == FieldStatus::planned; }, test_support::kPatienceMs));
        EXPECT_EQ(status(0), FieldStatus::closed);
        const QImage picture = window_.view().picture();
        EXPECT_GT(distinct_colours(picture), kColoursOfAPicture);
        // The target's disc, 40 mm of a picture 160 mm high, is a twentieth of the square of the height.
        EXPECT_GT(target_pixels(picture), picture.height() * picture.height() / 50);

        window_.save_screenshot(picture_folder() / "workstation_synthetic.png");
        const QImage shot(QString::fromStdString((picture_folder() / "workstation_synthetic.png").string()));
        EXPECT_EQ(shot.size(), window_.size());
        EXPECT_GT(target_pixels(shot), picture.height() * picture.height() / 50) << "the picture is in the window";
        EXPECT_EQ(window_.view().drawing_errors(), "");
    }

    TEST_F(MainWindowTest, PlansOfAnEarlierSessionAreShown)
    {
        control_->saved_plans = { "lateral" };
        open_synthetic();
        EXPECT_EQ(status(0), FieldStatus::closed);
        ASSERT_EQ(status(1), FieldStatus::planned);
        EXPECT_EQ(control_->plans_made, 0);
        click(1);
        press(Qt::Key_1);
        const QImage picture = window_.view().picture();
        EXPECT_GT(target_pixels(picture), picture.height() * picture.height() / 50);
        press(Qt::Key_P);
        EXPECT_EQ(status(1), FieldStatus::planned) << "it is not planned again";
        EXPECT_EQ(control_->plans_made, 0);
    }

    TEST_F(MainWindowTest, ADamagedSavedPlanIsToldAndTheOthersAreShown)
    {
        control_->saved_plans = { "broken", "lateral" };
        open_synthetic();
        EXPECT_NE(window_.error_line().find("this saved plan is damaged"), std::string::npos) << window_.error_line();
        EXPECT_EQ(status(1), FieldStatus::planned);
        EXPECT_EQ(status(2), FieldStatus::closed);
        EXPECT_TRUE(window_.idle());
    }

    TEST_F(MainWindowTest, NumbersAreShownAsColours)
    {
        open_synthetic();
        press(Qt::Key_1, Qt::ControlModifier); // nothing is planned: nothing happens
        EXPECT_FALSE(window_.model()->map());
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        press(Qt::Key_3);
        press(Qt::Key_1, Qt::ControlModifier);
        EXPECT_EQ(window_.model()->map(), FieldMapKind::strain);
        ASSERT_EQ(window_.view().scenes().size(), 1U) << "from slices to the field";
        EXPECT_EQ(window_.view().scenes().front().legend.front().key, "largest elongation");
        press(Qt::Key_2, Qt::ControlModifier); // this field has no blades
        EXPECT_EQ(window_.model()->map(), FieldMapKind::strain);
        press(Qt::Key_0, Qt::ControlModifier);
        EXPECT_FALSE(window_.model()->map());
        EXPECT_TRUE(window_.view().scenes().front().legend.empty());
    }

    TEST_F(MainWindowTest, PlannedApproachesAreCompared)
    {
        open_synthetic();
        press(Qt::Key_5);
        EXPECT_NE(window_.model()->view(), ViewPreset::compare) << "nothing is planned";
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        press(Qt::Key_5);
        EXPECT_NE(window_.model()->view(), ViewPreset::compare) << "one has nothing to be compared with";
        click(1);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(1) == FieldStatus::planned; }, test_support::kPatienceMs));
        press(Qt::Key_5);
        ASSERT_EQ(window_.model()->shown_view(), ViewPreset::compare);
        const std::vector<Scene>& scenes = window_.view().scenes();
        ASSERT_EQ(scenes.size(), 2U);
        EXPECT_EQ(scenes[0].title, "A  median");
        EXPECT_EQ(scenes[1].title, "B  lateral");
        const auto* chart = window_.findChild<QWidget*>("comparison chart");
        ASSERT_NE(chart, nullptr);
        EXPECT_NE(chart->accessibleDescription().indexOf("A 45.6 %; B 45.6 %;"), -1)
            << chart->accessibleDescription().toStdString();
        const QImage picture = window_.view().picture();
        EXPECT_GT(target_pixels(picture.copy(0, 0, picture.width() / 2, picture.height())), 500);
        EXPECT_GT(target_pixels(picture.copy(picture.width() / 2, 0, picture.width() / 2, picture.height())), 500);
        window_.save_screenshot(picture_folder() / "workstation_compare.png");
        const auto drag_first = [&] {
            const std::vector<Camera> before = window_.view().cameras();
            const QPoint from(window_.view().width() / 5, window_.view().height() / 2), by(60, 20);
            QTest::mousePress(&window_.view(), Qt::LeftButton, {}, from);
            QMouseEvent move(QEvent::MouseMove, from + by, Qt::LeftButton, Qt::LeftButton, {});
            QApplication::sendEvent(&window_.view(), &move);
            QTest::mouseRelease(&window_.view(), Qt::LeftButton, {}, from + by);
            test_support::wait_until_idle(window_);
            EXPECT_TRUE(QTest::qWaitFor([&] { return !window_.view().coarse(); }, test_support::kPatienceMs));
            std::vector<double> turned;
            for (std::size_t i = 0; i < before.size(); ++i)
                turned.push_back((window_.view().cameras()[i].eye - before[i].eye).norm() / before[i].eye.norm());
            return turned;
        };
        const std::vector<double> together = drag_first();
        EXPECT_GT(together[0], 0.01);
        EXPECT_GT(together[1], 0.01) << "the pictures turn together";
        press(Qt::Key_T, Qt::ShiftModifier);
        const std::vector<double> one = drag_first();
        EXPECT_GT(one[0], 0.01);
        EXPECT_LT(one[1], 1e-9);
        press(Qt::Key_0);
        EXPECT_LT((window_.view().cameras()[0].eye - scenes[0].camera.eye).norm(), 1e-6) << "as it was seen first";
        click(0);
        EXPECT_EQ(window_.model()->shown_view(), ViewPreset::surgeon);
        EXPECT_EQ(window_.view().scenes().size(), 1U);
        press(Qt::Key_5);
        press(Qt::Key_D); // an incision is drawn on one picture
        EXPECT_TRUE(window_.editor().drawing());
        EXPECT_EQ(window_.view().scenes().size(), 1U);
        press(Qt::Key_5);
        EXPECT_NE(window_.model()->shown_view(), ViewPreset::compare) << "while drawing";
        press(Qt::Key_Escape);
        press(Qt::Key_5);
        EXPECT_EQ(window_.model()->shown_view(), ViewPreset::compare);
        press(Qt::Key_Delete); // the comparison has one left
        EXPECT_NE(window_.model()->view(), ViewPreset::compare);
        press(Qt::Key_Z, Qt::ControlModifier);
        EXPECT_NE(window_.model()->shown_view(), ViewPreset::compare) << "it does not come back by itself";
    }

    TEST_F(MainWindowTest, KeysChooseTheView)
    {
        open_synthetic();
        press(Qt::Key_3);
        EXPECT_EQ(window_.model()->view(), ViewPreset::slices) << "slices need no plan";
        EXPECT_EQ(window_.view().scenes().size(), 4U);
        press(Qt::Key_1);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        const QImage surgeon = window_.view().picture();
        press(Qt::Key_2);
        EXPECT_EQ(window_.model()->view(), ViewPreset::overview);
        EXPECT_NE(window_.view().picture(), surgeon);
        press(Qt::Key_3);
        EXPECT_EQ(window_.model()->view(), ViewPreset::slices);
        EXPECT_EQ(window_.view().scenes().size(), 4U);
        EXPECT_GT(distinct_colours(window_.view().picture()), kColoursOfAPicture);
        press(Qt::Key_1);
        EXPECT_EQ(window_.model()->view(), ViewPreset::surgeon);
        EXPECT_EQ(window_.view().picture(), surgeon) << "the same view is the same picture";
        press(Qt::Key_O);
        EXPECT_EQ(target_pixels(window_.view().picture()), 0) << "closed again";
        EXPECT_EQ(window_.view().drawing_errors(), "");
        EXPECT_EQ(window_.error_line(), "");
    }

    TEST_F(MainWindowTest, StaysUsableWhilePlanningAndCancels)
    {
        open_synthetic();
        control_->hold = true;
        press(Qt::Key_P);
        auto* progress = window_.statusBar()->findChild<QProgressBar*>();
        ASSERT_NE(progress, nullptr);
        ASSERT_TRUE(
            QTest::qWaitFor([&] { return progress->isVisible() && progress->value() == progress->maximum() / 2; },
                test_support::kPatienceMs));
        EXPECT_TRUE(progress->format().contains("cut")) << progress->format().toStdString();
        click(1); // another approach is looked at meanwhile
        EXPECT_EQ(window_.model()->selected(), 1U);
        EXPECT_GT(distinct_colours(window_.view().picture()), kColoursOfAPicture);
        press(Qt::Key_Escape);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(status(0), FieldStatus::closed);
        EXPECT_FALSE(progress->isVisible());
        EXPECT_EQ(control_->plans_made, 0);
    }

    TEST_F(MainWindowTest, ClosingWhilePlanningAsks)
    {
        open_synthetic();
        control_->hold = true;
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planning; }, test_support::kPatienceMs));
        const auto answer_with = [](const QString& text) {
            QTimer::singleShot(0, [text] {
                auto* question = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
                ASSERT_NE(question, nullptr);
                for (QAbstractButton* button : question->buttons())
                    if (button->text().remove('&') == text)
                        return button->click();
                FAIL() << "no button " << text.toStdString();
            });
        };
        answer_with("Go on planning");
        EXPECT_FALSE(window_.close());
        EXPECT_TRUE(window_.isVisible());
        EXPECT_EQ(status(0), FieldStatus::planning);
        answer_with("Close");
        EXPECT_TRUE(window_.close());
        EXPECT_FALSE(window_.isVisible());
        test_support::wait_until_idle(window_);
        EXPECT_EQ(control_->plans_made, 0);
    }

    TEST_F(MainWindowTest, FitsASmallScreenWithEveryPanel)
    {
        open_synthetic();
        for (auto* tabs = window_.findChild<QTabWidget*>(); const int tab : { 0, 1 }) {
            tabs->setCurrentIndex(tab);
            QCoreApplication::processEvents();
            EXPECT_LE(window_.minimumSizeHint().height(), 600) << tab;
            EXPECT_LE(window_.minimumSizeHint().width(), 800) << tab;
        }
    }

    TEST_F(MainWindowTest, APlannedFieldIsShownAgainWithoutPlanning)
    {
        open_synthetic();
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        click(1);
        EXPECT_EQ(target_pixels(window_.view().picture()), 0);
        click(0);
        EXPECT_GT(target_pixels(window_.view().picture()), 0);
        press(Qt::Key_P);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(control_->plans_made, 1);
    }

    TEST_F(MainWindowTest, AFailureSaysWhatAndWhereAndLeavesTheRestUsable)
    {
        open_synthetic();
        click(2);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(2) == FieldStatus::failed; }, test_support::kPatienceMs));
        EXPECT_EQ(window_.error_line(), "/approaches/2/depth_mm: the depth is negative");
        click(0);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        EXPECT_EQ(window_.error_line(), "");
    }

    TEST_F(MainWindowTest, ACaseThatCannotBeReadLeavesTheOpenOne)
    {
        open_synthetic();
        window_.open_file("no/such/case.json");
        test_support::wait_until_idle(window_);
        EXPECT_NE(window_.error_line().find("no/such/case.json"), std::string::npos) << window_.error_line();
        EXPECT_EQ(window_.approach_list().count(), 3);
    }

    TEST_F(MainWindowTest, TurningIsCoarseAndRestIsFine)
    {
        open_synthetic();
        window_.set_view(ViewPreset::overview);
        press(Qt::Key_P);
        ASSERT_TRUE(QTest::qWaitFor([&] { return status(0) == FieldStatus::planned; }, test_support::kPatienceMs));
        PictureView& view = window_.view();
        const Vec3 eye = view.camera().eye;
        const QPoint middle = view.rect().center();
        QTest::mousePress(&view, Qt::LeftButton, {}, middle);
        // QTest::mouseMove() would move the pointer only, without the button.
        QMouseEvent move(QEvent::MouseMove, middle + QPoint(40, 10), Qt::LeftButton, Qt::LeftButton, {});
        QApplication::sendEvent(&view, &move);
        EXPECT_TRUE(view.coarse());
        QTest::mouseRelease(&view, Qt::LeftButton, {}, middle + QPoint(40, 10));
        ASSERT_TRUE(QTest::qWaitFor([&] { return !view.coarse(); }, test_support::kPatienceMs));
        EXPECT_GT((view.camera().eye - eye).norm(), 1.0) << "the camera has turned (mm)";
        EXPECT_EQ(view.drawing_errors(), "");
    }

    TEST_F(MainWindowTest, WheelAndLeftButtonMoveTheSlicesTogether)
    {
        open_synthetic();
        press(Qt::Key_3);
        PictureView& view = window_.view();
        const auto point = [&](std::size_t slice) { return view.scenes().at(slice).slices.front().point; };
        const Vec3 before = point(0);
        const double step = slice_step(view.scenes().at(0).slices.front());
        const auto turn = [&](const QPointF& at, int notches, Qt::KeyboardModifiers keys) {
            QWheelEvent event(at, view.mapToGlobal(at.toPoint()), {}, { 0, 120 * notches }, Qt::NoButton, keys,
                Qt::NoScrollPhase, false);
            QApplication::sendEvent(&view, &event);
        };
        const QPointF axial(0.25 * view.width(), 0.25 * view.height());
        const auto wait_for_z = [&](double z) {
            ASSERT_TRUE(QTest::qWaitFor([&] { return std::abs(point(0).z() - z) < 1e-9; }, test_support::kPatienceMs))
                << point(0).z() << " instead of " << z;
        };
        turn(axial, 1, Qt::NoModifier);
        turn(axial, 1, Qt::NoModifier); // before the first notch is shown
        wait_for_z(before.z() + 2.0 * step);
        for (std::size_t slice = 0; slice < 3; ++slice)
            EXPECT_NEAR((point(slice) - before - Vec3(0.0, 0.0, 2.0 * step)).norm(), 0.0, 1e-9);
        const double height_mm = view.camera().half_height_mm;
        turn(axial, 1, Qt::ControlModifier);
        EXPECT_LT(view.camera().half_height_mm, height_mm) << "Ctrl and the wheel zoom";
        const mesh::ImageGrid grid = view.scenes().at(0).slices.front().image->grid;
        turn(axial, 100000, Qt::NoModifier);
        wait_for_z(std::max(grid.world(Vec3::Zero()).z(), grid.world(Vec3(0.0, 0.0, grid.size[2] - 1)).z()));
        const QImage mediastinum = view.picture();
        QTest::keyClick(&window_, Qt::Key_2, Qt::ShiftModifier);
        EXPECT_EQ(view.scenes().at(1).slices.front().level_hu, -600.0) << "lung";
        EXPECT_NE(view.picture(), mediastinum);
        // A place left of the middle of the axial slice is on the patient's right.
        QTest::mousePress(&view, Qt::LeftButton, {}, (axial - QPointF(0.05 * view.width(), 0.0)).toPoint());
        QTest::mouseRelease(&view, Qt::LeftButton, {}, (axial - QPointF(0.05 * view.width(), 0.0)).toPoint());
        ASSERT_TRUE(QTest::qWaitFor([&] { return point(0).x() < before.x(); }, test_support::kPatienceMs));
        EXPECT_LT(point(0).x(), before.x() - 1.0);
        EXPECT_EQ(point(2).x(), point(0).x());
        EXPECT_GT(distinct_colours(view.picture()), kColoursOfAPicture);
        EXPECT_EQ(view.drawing_errors(), "");
    }

    TEST_F(MainWindowTest, ClicksOnASliceMeasure)
    {
        open_synthetic();
        press(Qt::Key_3);
        test_support::wait_until_idle(window_);
        press(Qt::Key_R);
        const QPoint from(window_.view().width() / 8, window_.view().height() / 4), to = from + QPoint(40, 30);
        const Vec3 first = *window_.view().slice_place_at(from), second = *window_.view().slice_place_at(to);
        for (const QPoint& at : { from, to })
            QTest::mouseClick(&window_.view(), Qt::LeftButton, {}, at);
        constexpr double kShown = 0.06; // one digit behind the point
        EXPECT_NEAR(std::stod(window_.message_line()), (second - first).norm(), kShown) << window_.message_line();
        EXPECT_GT((second - first).norm(), 1.0);
        press(Qt::Key_Escape);
        const Vec3 point = window_.view().scenes().front().slices.front().point;
        QTest::mouseClick(&window_.view(), Qt::LeftButton, {}, to);
        ASSERT_TRUE(QTest::qWaitFor(
            [&] { return window_.view().scenes().front().slices.front().point != point; }, test_support::kPatienceMs))
            << "the mouse moves the slices again";
        EXPECT_EQ(window_.error_line(), "");
    }

    TEST_F(MainWindowTest, AKnifeOverSlicesIsNoSlice)
    {
        open_synthetic();
        press(Qt::Key_3);
        ASSERT_EQ(window_.view().scenes().size(), 4U);
        press(Qt::Key_K);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.view().scenes().size(), 1U);
        QTest::keyClick(&window_, Qt::Key_3, Qt::ShiftModifier); // grey window
        press(Qt::Key_K);
        auto* tabs = window_.findChild<QTabWidget*>();
        tabs->setCurrentIndex(0);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.view().scenes().size(), 4U);
        EXPECT_EQ(window_.view().scenes().front().slices.front().level_hu, 400.0) << "bone";
        press(Qt::Key_K);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.view().scenes().size(), 1U);
        press(Qt::Key_3);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(tabs->currentIndex(), 0) << "the wound by hand is seen in space only";
        EXPECT_EQ(window_.view().scenes().size(), 4U);
        press(Qt::Key_R);
        for (const int x : { 0, 40 })
            QTest::mouseClick(&window_.view(), Qt::LeftButton, {},
                QPoint(window_.view().width() / 8 + x, window_.view().height() / 4));
        press(Qt::Key_Escape);
        ASSERT_TRUE(window_.model()->has_measurements());
        press(Qt::Key_K);
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.view().scenes().size(), 1U);
        const std::string by_hand = window_.view().scenes().front().title;
        const QList<QAction*> actions = window_.findChildren<QAction*>();
        const auto remove = std::find_if(actions.begin(), actions.end(),
            [](const QAction* action) { return action->text() == "Remove the measurements"; });
        ASSERT_NE(remove, actions.end());
        (*remove)->trigger();
        EXPECT_FALSE(window_.model()->has_measurements());
        EXPECT_EQ(window_.view().scenes().front().title, by_hand) << "the knife's picture stays";
    }

    TEST_F(MainWindowTest, NotchesOfTheWheelShareAPicture)
    {
        open_synthetic();
        PictureView& view = window_.view();
        ASSERT_TRUE(QTest::qWaitFor([&] { return !view.coarse(); }, test_support::kPatienceMs));
        const int pictures = view.pictures();
        const double before = (view.camera().eye - view.camera().aim).norm();
        constexpr int kNotches = 5;
        const QPointF middle = view.rect().center();
        for (int i = 0; i < kNotches; ++i) {
            QWheelEvent notch(middle, view.mapToGlobal(middle.toPoint()), {}, { 0, 120 }, Qt::NoButton, Qt::NoModifier,
                Qt::NoScrollPhase, false);
            QApplication::sendEvent(&view, &notch);
        }
        EXPECT_EQ(view.pictures(), pictures) << "an event does not wait for a picture";
        constexpr double kZoomOfANotch = 1.21; // VTK's, when the wheel's factor is 1
        EXPECT_NEAR(
            (view.camera().eye - view.camera().aim).norm(), before * std::pow(kZoomOfANotch, -kNotches), 0.05 * before)
            << "every notch counts";
        EXPECT_TRUE(view.coarse());
        ASSERT_TRUE(QTest::qWaitFor([&] { return !view.coarse(); }, test_support::kPatienceMs));
        EXPECT_GE(view.pictures(), pictures + 1);
        EXPECT_LT(view.pictures(), pictures + kNotches);
    }

    TEST_F(MainWindowTest, TheFullPictureLiesWhereTheCoarseOneWas)
    {
        open_synthetic();
        PictureView& view = window_.view();
        const QImage full = view.picture().convertToFormat(QImage::Format_RGB32);
        const QImage coarse = view.grabFramebuffer().convertToFormat(QImage::Format_RGB32);
        ASSERT_EQ(full.size(), coarse.size());
        // The mean difference in grey between the coarse picture, shifted, and the full one.
        const auto difference = [&](int dx, int dy) {
            constexpr int kMargin = 20;
            double sum = 0.0;
            for (int y = kMargin; y < full.height() - kMargin; ++y)
                for (int x = kMargin; x < full.width() - kMargin; ++x)
                    sum += std::abs(qGray(full.pixel(x, y)) - qGray(coarse.pixel(x + dx, y + dy)));
            return sum;
        };
        constexpr int kShift = 6;
        for (const auto& [dx, dy] :
            { std::pair { kShift, 0 }, std::pair { -kShift, 0 }, std::pair { 0, kShift }, std::pair { 0, -kShift } })
            EXPECT_LT(difference(0, 0), difference(dx, dy)) << dx << ", " << dy;
    }

    TEST_F(MainWindowTest, TheBenchmarkMeasuresEveryView)
    {
        open_synthetic();
        const std::vector<MotionFigures> figures = measure_window(window_, true, 0.3);
        ASSERT_EQ(figures.size(), 22U);
        EXPECT_EQ(figures[4].picture, "closed, slices");
        EXPECT_EQ(figures[9].picture, "opened, overview");
        EXPECT_EQ(figures[10].picture, "conference, median: what is cut");
        EXPECT_EQ(figures[12].picture, "conference, median: opened");
        EXPECT_EQ(figures[15].picture, "conference, median: what the surgeon sees");
        EXPECT_EQ(figures[17].picture, "conference, median: what the surgeon reaches");
        EXPECT_FALSE(window_.in_conference());
        for (const MotionFigures& f : figures) {
            EXPECT_GT(f.events, 0) << f.picture;
            EXPECT_GT(f.full_ms, 0.0) << f.picture;
            EXPECT_GE(f.delay_largest_ms, f.delay_median_ms) << f.picture;
        }
        EXPECT_NE(to_json(figures, window_).find("pictures_per_s"), std::string::npos);
    }

    TEST_F(MainWindowTest, SavesThePictureAsSeen)
    {
        open_synthetic();
        const fs::path file = picture_folder() / "workstation_picture.png";
        window_.save_picture(file);
        const QImage saved(QString::fromStdString(file.string()));
        EXPECT_EQ(saved.convertToFormat(QImage::Format_RGB32),
            window_.view().picture().convertToFormat(QImage::Format_RGB32));
        EXPECT_ANY_THROW(window_.save_picture(picture_folder() / "no_such_folder" / "x.png"));
    }

    TEST(ArrangeScenes, FillsRowsOfTwoFromTheTop)
    {
        const auto four = arrange_scenes(std::vector<Scene>(4), 800.0, 600.0);
        ASSERT_EQ(four.size(), 4U);
        double area = 0.0;
        for (const Viewport& v : four)
            area += (v.right - v.left) * (v.top - v.bottom);
        EXPECT_DOUBLE_EQ(area, 1.0);
        EXPECT_EQ(four[0].top, 1.0);
        EXPECT_EQ(four[0].left, 0.0);
        EXPECT_EQ(four[3].bottom, 0.0);
        EXPECT_EQ(four[3].right, 1.0);
        EXPECT_TRUE(arrange_scenes({}, 800.0, 600.0).empty());
        const auto large = arrange_scenes(std::vector<Scene>(4), 900.0, 600.0, SceneLayout::one_large);
        EXPECT_EQ(large.back().left, 0.0);
        EXPECT_NEAR(large.back().right, 2.0 / 3.0, 1e-12);
        EXPECT_EQ(large.back().top - large.back().bottom, 1.0);
        double covered = 0.0;
        for (const Viewport& place : large)
            covered += (place.right - place.left) * (place.top - place.bottom);
        EXPECT_NEAR(covered, 1.0, 1e-12);
        EXPECT_EQ(large[0].top, 1.0);
        EXPECT_EQ(large[2].bottom, 0.0);
        const auto three = arrange_scenes(std::vector<Scene>(3), 800.0, 600.0);
        ASSERT_EQ(three.size(), 3U);
        EXPECT_EQ(three[1].right, 1.0);
        EXPECT_EQ(three[2].left, 0.0);
        EXPECT_EQ(three[2].right, 1.0) << "nothing stays empty";
    }

} // namespace main_window_test
} // namespace retractor::ui

int main(int argc, char** argv)
{
    testing::InitGoogleTest(&argc, argv);
    QSurfaceFormat::setDefaultFormat(retractor::ui::PictureView::defaultFormat());
    QApplication application(argc, argv);
    retractor::ui::apply_theme(application);
    return RUN_ALL_TESTS();
}
