// Proposals of a search, and the weights of the score, in the window.

#include "ui/workstation/planning/search_dialog.h"

#include "tests/support/synthetic_patient.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/window/window_help.h"
#include "tests/support/window/window_pictures.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/planning/weights_dialog.h"

#include <gtest/gtest.h>

#include <QCheckBox>
#include <QComboBox>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QTableWidget>

#include <algorithm>
#include <memory>

namespace retractor::ui {
namespace search_dialog_test {

    class SearchWindowTest : public testing::Test {
    protected:
        void SetUp() override
        {
            test_support::show_window(window_);
            window_.open(test_support::synthetic_case());
            test_support::wait_until_idle(window_);
        }
        void press(Qt::Key key, Qt::KeyboardModifiers with = {}) { QTest::keyClick(&window_, key, with); }
        SearchDialog& dialog() { return *window_.search_dialog(); }
        void click(const QString& text)
        {
            for (QPushButton* button : dialog().findChildren<QPushButton*>())
                if (button->text() == text && button->isVisible())
                    return QTest::mouseClick(button, Qt::LeftButton);
            FAIL() << "there is no button " << text.toStdString();
        }
        void open_dialog()
        {
            press(Qt::Key_F, Qt::ControlModifier);
            ASSERT_NE(window_.search_dialog(), nullptr);
        }
        void wait_until_gone()
        {
            ASSERT_TRUE(QTest::qWaitFor(
                [&] {
                    QCoreApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);
                    return window_.search_dialog() == nullptr;
                },
                test_support::kPatienceMs));
        }

        std::shared_ptr<test_support::SyntheticControl> control_ = std::make_shared<test_support::SyntheticControl>();
        MainWindow window_ { [this](const planner::Case&) { return test_support::synthetic_backend(control_); } };
    };

    TEST_F(SearchWindowTest, TakesProposalsIntoTheCase)
    {
        open_dialog();
        EXPECT_EQ(dialog().request().target.label, "target");
        auto* const lowest = dialog().findChild<QSpinBox*>("lowest");
        dialog().findChild<QSpinBox*>("highest")->setValue(5);
        lowest->setValue(3);
        EXPECT_EQ(dialog().request().limits.highest_space, 3) << "neither passes the other";
        dialog().findChild<QComboBox*>("side")->setCurrentIndex(1);
        EXPECT_TRUE(dialog().request().limits.left);
        EXPECT_FALSE(dialog().request().limits.right);
        click("Search");
        test_support::wait_until_idle(window_);
        const auto* const table = dialog().findChild<QTableWidget*>("proposals");
        ASSERT_EQ(table->rowCount(), 2);
        EXPECT_EQ(table->item(0, 0)->checkState(), Qt::Checked);
        EXPECT_TRUE(table->item(0, 0)->text().contains("Left space 4")) << table->item(0, 0)->text().toStdString();
        EXPECT_EQ(table->item(0, 2)->text(), "46 %");
        EXPECT_EQ(window_.approach_list().count(), 3) << "nothing is taken yet";
        const test_support::TemporaryFolder folder;
        EXPECT_TRUE(test_support::keep_picture(dialog(), test_support::picture_file(folder.path, "dialog-search.png")));
        table->item(1, 0)->setCheckState(Qt::Checked);
        click("Add to the case");
        wait_until_gone();
        test_support::wait_until_idle(window_);
        ASSERT_EQ(window_.approach_list().count(), 5);
        EXPECT_EQ(window_.model()->approach(3).name, "left_space_4_110mm");
        EXPECT_EQ(window_.model()->selected(), 3U);
        press(Qt::Key_Z, Qt::ControlModifier);
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 3) << "one step of the history";
    }

    TEST_F(SearchWindowTest, IsCancelledAndFailsWithTheReason)
    {
        control_->hold = true;
        open_dialog();
        click("Search");
        EXPECT_FALSE(window_.idle());
        press(Qt::Key_2); // the window can be used meanwhile
        EXPECT_EQ(window_.model()->view(), ViewPreset::overview);
        click("Cancel");
        test_support::wait_until_idle(window_);
        ASSERT_NE(window_.search_dialog(), nullptr) << "cancelling leaves the request";
        EXPECT_EQ(dialog().failure(), "");
        control_->hold = false;
        dialog().findChild<QCheckBox*>("saw")->setChecked(false);
        click("Search");
        test_support::wait_until_idle(window_);
        EXPECT_EQ(dialog().failure(), "None of 7 incisions is a proposal");
        // Another case ends a search.
        control_->hold = true;
        dialog().findChild<QCheckBox*>("saw")->setChecked(true);
        click("Search");
        window_.open(test_support::synthetic_case());
        wait_until_gone();
        test_support::wait_until_idle(window_);
        EXPECT_EQ(window_.approach_list().count(), 3);
    }

    TEST_F(SearchWindowTest, WeightsChangeTheScoreOfTheComparison)
    {
        window_.plan_all();
        test_support::wait_until_idle(window_);
        press(Qt::Key_5);
        ASSERT_EQ(window_.model()->shown_view(), ViewPreset::compare) << window_.error_line();
        const auto panel_says = [&](const QString& words) {
            const auto labels = window_.findChildren<QLabel*>();
            return std::any_of(
                labels.begin(), labels.end(), [&](QLabel* label) { return label->text().contains(words); });
        };
        EXPECT_TRUE(panel_says("target seen 3, "));
        press(Qt::Key_W, Qt::ShiftModifier);
        auto* const weights = window_.findChild<WeightsDialog*>("weights");
        ASSERT_NE(weights, nullptr);
        EXPECT_EQ(weights->weights(), planner::default_weights());
        auto* const seen = weights->findChild<QSlider*>("seen");
        ASSERT_NE(seen, nullptr);
        seen->setValue(seen->maximum());
        EXPECT_EQ(window_.model()->weights().front(), 5.0);
        EXPECT_TRUE(panel_says("target seen 5, "));
        // All at 0: the last weights stay.
        for (QSlider* slider : weights->findChildren<QSlider*>())
            slider->setValue(0);
        double sum = 0.0;
        for (const double weight : window_.model()->weights())
            sum += weight;
        EXPECT_GT(sum, 0.0);
        for (QPushButton* button : weights->findChildren<QPushButton*>())
            if (button->text() == "Defaults")
                QTest::mouseClick(button, Qt::LeftButton);
        EXPECT_EQ(window_.model()->weights(), planner::default_weights());
    }

} // namespace search_dialog_test
} // namespace retractor::ui
