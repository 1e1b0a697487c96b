#include "ui/cli/framework/progress_line.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

namespace retractor::ui::cli {
namespace progress_line_test {

    /// A log, which is no terminal.
    struct Log {
        std::unique_ptr<std::FILE, int (*)(std::FILE*)> file { std::tmpfile(), std::fclose };

        std::string text() const
        {
            std::string all;
            std::array<char, 256> part {};
            std::rewind(file.get());
            while (std::fgets(part.data(), static_cast<int>(part.size()), file.get()) != nullptr)
                all += part.data();
            return all;
        }
    };

    TEST(ProgressLine, ALogHasLinesWithStageAndShare)
    {
        const Log log;
        ASSERT_TRUE(log.file);
        ProgressLine progress(log.file.get(), 0.0);
        progress.update("opening", 0.0);
        progress.update("opening", 0.5);
        progress.clear();
        EXPECT_EQ(log.text(), "after 0 s: opening   0 %\nafter 0 s: opening  50 %\n");
    }

    TEST(ProgressLine, AShortCommandWritesNothingIntoALog)
    {
        const Log log;
        ASSERT_TRUE(log.file);
        ProgressLine progress(log.file.get());
        for (const double done : { 0.0, 0.5, 1.0 })
            progress.update("mesh", done);
        progress.clear();
        EXPECT_EQ(log.text(), "");
    }

} // namespace progress_line_test
} // namespace retractor::ui::cli
