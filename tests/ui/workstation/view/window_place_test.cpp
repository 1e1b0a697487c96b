#include "ui/workstation/view/window_place.h"

#include <gtest/gtest.h>

#include <QGuiApplication>
#include <QScreen>
#include <QSettings>
#include <QWidget>

namespace retractor::ui {
namespace window_place_test {

    class WindowPlace : public testing::Test {
    protected:
        void SetUp() override
        {
            const QString folder = QString::fromStdString(testing::TempDir()) + "retractor_window_place";
            QSettings::setPath(QSettings::NativeFormat, QSettings::UserScope, folder);
            QSettings("Retractor", "retractor-workstation").clear();
        }
        QRect screen() const { return QGuiApplication::primaryScreen()->availableGeometry(); }
    };

    TEST_F(WindowPlace, AFirstWindowHasItsUsualSizeWithinTheScreen)
    {
        QWidget usual, large;
        restore_place(usual, "one", { 500, 400 });
        EXPECT_EQ(usual.size(), QSize(500, 400));
        restore_place(large, "one", { 5000, 4000 });
        EXPECT_EQ(large.size(), screen().size());
        EXPECT_TRUE(screen().contains(large.geometry()));
    }

    TEST_F(WindowPlace, AWindowComesBackWhereItWas)
    {
        QWidget before, after, other;
        before.setGeometry(120, 90, 640, 480);
        keep_place(before, "one");
        restore_place(after, "one", { 500, 400 });
        EXPECT_EQ(after.geometry(), before.geometry());
        restore_place(other, "another", { 500, 400 });
        EXPECT_EQ(other.size(), QSize(500, 400));
    }

    TEST_F(WindowPlace, APlaceBesideTheScreenIsBroughtBack)
    {
        QWidget before, after;
        before.setGeometry(screen().right() + 500, screen().bottom() + 300, 640, 480);
        keep_place(before, "one");
        restore_place(after, "one", { 500, 400 });
        EXPECT_TRUE(screen().contains(after.geometry())) << after.x() << " " << after.y();
    }

} // namespace window_place_test
} // namespace retractor::ui
