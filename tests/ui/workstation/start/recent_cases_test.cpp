#include "ui/workstation/start/recent_cases.h"

#include <gtest/gtest.h>

#include <QSettings>

#include <filesystem>
#include <fstream>
#include <string>

namespace retractor::ui {
namespace recent_cases_test {

    namespace fs = std::filesystem;

    /// Settings and cache in a folder of the test's own.
    class RecentCases : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::path(testing::TempDir()) / "recent_cases";
            fs::remove_all(folder_);
            fs::create_directories(folder_);
            for (const char* name : { "XDG_CONFIG_HOME", "XDG_CACHE_HOME" })
                qputenv(name, QByteArray::fromStdString((folder_ / name).string()));
            QSettings::setPath(QSettings::NativeFormat, QSettings::UserScope,
                QString::fromStdString((folder_ / "XDG_CONFIG_HOME").string()));
        }
        fs::path case_file(const std::string& name)
        {
            fs::create_directories(folder_ / name);
            std::ofstream(folder_ / name / "case.json") << "{}";
            return folder_ / name / "case.json";
        }
        fs::path folder_;
    };

    TEST_F(RecentCases, TheNewestIsFirstAndNoneIsThereTwice)
    {
        EXPECT_TRUE(recent_cases().empty());
        const fs::path first = case_file("first"), second = case_file("second");
        remember_case(first);
        remember_case(second);
        remember_case(first);
        const std::vector<RecentCase> cases = recent_cases();
        ASSERT_EQ(cases.size(), 2U);
        EXPECT_EQ(cases[0].file, first);
        EXPECT_EQ(cases[1].file, second);
        fs::remove(second);
        EXPECT_EQ(recent_cases().size(), 1U) << "what is gone is not listed";
    }

    TEST_F(RecentCases, APictureIsKeptWithItsCase)
    {
        const fs::path file = case_file("pictured");
        remember_case(file);
        EXPECT_TRUE(recent_cases().front().picture.isNull());
        QImage picture(800, 500, QImage::Format_RGB32);
        picture.fill(Qt::red);
        keep_case_picture(file, picture);
        ASSERT_FALSE(recent_cases().front().picture.isNull());
        EXPECT_LE(recent_cases().front().picture.width(), 240);
        EXPECT_GT(qRed(recent_cases().front().picture.pixel(10, 10)), 240);
    }

} // namespace recent_cases_test
} // namespace retractor::ui
