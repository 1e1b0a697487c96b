// The two executables scene_picture_osmesa and scene_picture_egl must draw the same picture.

#include "tests/ui/scene/png_files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/wait.h>

namespace retractor::ui {
namespace backends_test {

    constexpr int kNotHere = 77;
    constexpr double kSamePicture = 40.0; ///< dB: differences that no eye finds

    int run(const std::string& program, const std::filesystem::path& picture)
    {
        const std::string command = "env -u DISPLAY '" + program + "' '" + picture.string() + "' 640 480 2>/dev/null";
        const int status = std::system(command.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    TEST(Backends, OsmesaAndEglDrawTheSamePicture)
    {
        const std::filesystem::path folder = testing::TempDir();
        const auto osmesa = folder / "retractor_osmesa.png", egl = folder / "retractor_egl.png";
        ASSERT_EQ(run(SCENE_PICTURE_OSMESA, osmesa), 0);
        const int status = run(SCENE_PICTURE_EGL, egl);
        if (status == kNotHere)
            GTEST_SKIP() << "this machine has no surfaceless EGL context";
        ASSERT_EQ(status, 0);
        EXPECT_GE(samples::psnr_db(samples::read_png(osmesa), samples::read_png(egl)), kSamePicture);
        std::filesystem::remove(osmesa);
        std::filesystem::remove(egl);
    }

} // namespace backends_test
} // namespace retractor::ui
