#include "tests/support/synthetic_patient.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/window/window_help.h"

#include "planner/case/case_io.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/start/case_lock.h"

#include <gtest/gtest.h>

#include <QAbstractButton>

#include <filesystem>
#include <fstream>
#include <memory>

namespace retractor::ui {
namespace case_lock_test {

    TEST(CaseLock, OneHasTheCaseUntilItIsGivenBack)
    {
        const test_support::TemporaryFolder folder;
        auto first = std::make_unique<CaseLock>(folder / "case.json");
        EXPECT_TRUE(first->is_mine());
        EXPECT_TRUE(std::filesystem::exists(folder / "case.lock"));
        {
            const CaseLock second(folder / "case.json");
            EXPECT_FALSE(second.is_mine());
            EXPECT_EQ(second.holder(), "on this computer");
            EXPECT_TRUE(CaseLock(folder / "other.json").is_mine());
        }
        EXPECT_FALSE(CaseLock(folder / "case.json").is_mine()) << "the second gave back what it did not have";
        first.reset();
        EXPECT_TRUE(CaseLock(folder / "case.json").is_mine());
        EXPECT_FALSE(std::filesystem::exists(folder / "case.lock"));
    }

    TEST(CaseLock, AWindowThatCrashedDoesNotKeepTheCase)
    {
        const test_support::TemporaryFolder folder;
        constexpr const char* kNoProcess = "999999999";
        std::ofstream(folder / "case.lock") << kNoProcess << "\nretractor-workstation\n"
                                            << QSysInfo::machineHostName().toStdString() << "\n";
        EXPECT_TRUE(CaseLock(folder / "case.json").is_mine());
    }

    TEST(CaseLock, AnotherComputerIsNamed)
    {
        const test_support::TemporaryFolder folder;
        std::ofstream(folder / "case.lock") << "1\nretractor-workstation\nward-3\n";
        const CaseLock lock(folder / "case.json");
        EXPECT_FALSE(lock.is_mine());
        EXPECT_EQ(lock.holder(), "on ward-3");
    }

    TEST(CaseLock, WithoutAFolderTheCaseIsOnes) { EXPECT_TRUE(CaseLock("/nowhere/at/all/case.json").is_mine()); }

    TEST(CaseLockWindow, ASecondWindowOnlyLooks)
    {
        const test_support::TemporaryFolder folder;
        planner::Case planned_case = test_support::synthetic_case();
        planned_case.folder = folder.path;
        constexpr const char* kOfNothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        std::ofstream(folder / "labels.nrrd").flush(); // nobody reads them here
        planned_case.labels = { "labels.nrrd", kOfNothing };
        planned_case.supports.labels.clear();
        const auto control = std::make_shared<test_support::SyntheticControl>();
        const auto factory = [&](const planner::Case&) { return test_support::synthetic_backend(control); };
        MainWindow first(factory), second(factory);
        test_support::show_window(second);
        second.open(test_support::synthetic_case());
        second.set_knife(KnifeMode::freehand); // the tab of the knife is open when the locked case comes
        test_support::wait_until_idle(second);
        const int setups = control->setups_made;
        for (MainWindow* window : { &first, &second }) {
            test_support::show_window(*window);
            window->open(planned_case);
            test_support::wait_until_idle(*window);
        }
        EXPECT_FALSE(first.only_looks());
        ASSERT_TRUE(second.only_looks());
        EXPECT_EQ(control->setups_made, setups) << "no knife is prepared, which would keep its cuts beside the case";
        for (const auto& [key, with] :
            { std::pair { Qt::Key_D, Qt::ControlModifier }, { Qt::Key_Delete, Qt::NoModifier },
                { Qt::Key_K, Qt::NoModifier }, { Qt::Key_C, Qt::NoModifier }, { Qt::Key_D, Qt::NoModifier } })
            QTest::keyClick(&second, key, with);
        test_support::wait_until_idle(second);
        EXPECT_EQ(second.approach_list().count(), 3);
        EXPECT_FALSE(second.editor().drawing());
        EXPECT_EQ(second.knife().mode(), KnifeMode::away);
        QTest::keyClick(&second, Qt::Key_P); // a plan changes no case
        test_support::wait_until_idle(second);
        EXPECT_EQ(second.model()->state(0).status, FieldStatus::planned) << second.error_line();
        EXPECT_FALSE(std::filesystem::exists(folder / "case.json"));

        QApplication::setActiveWindow(&first); // no window manager does it here
        QTest::keyClick(&first, Qt::Key_D, Qt::ControlModifier);
        test_support::wait_until_idle(first);
        EXPECT_TRUE(std::filesystem::exists(folder / "case.json"));
        const auto look_again = [&] {
            for (auto* button : second.findChildren<QAbstractButton*>())
                if (button->text() == "Look again")
                    QTest::mouseClick(button, Qt::LeftButton);
            test_support::wait_until_idle(second);
        };
        look_again();
        EXPECT_EQ(second.approach_list().count(), 4) << second.error_line();
        EXPECT_TRUE(second.only_looks());
        first.close_case();
        look_again();
        QApplication::setActiveWindow(&second);
        EXPECT_FALSE(second.only_looks());
        QTest::keyClick(&second, Qt::Key_Delete);
        test_support::wait_until_idle(second);
        EXPECT_EQ(second.approach_list().count(), 3);
        EXPECT_EQ(planner::read_case(folder / "case.json").approaches.size(), 3U);
    }

} // namespace case_lock_test
} // namespace retractor::ui
