#include "ui/movie/video_file.h"

#include "mesh/base/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"
#include "tests/ui/movie/video_reader.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace retractor::ui {
namespace video_file_test {

    /// Loss of the encoder and of halved colours, of 255. Neighbouring pictures of the test differ by ten times as
    /// much.
    constexpr double kLoss = 3.0;

    /// A bright square on a smooth ground, further to the right in each picture.
    Image picture(int number, int width = 64, int height = 48)
    {
        Image image { .width = width, .height = height, .rgb = {} };
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool inside = x >= 8 * number && x < 8 * number + 16 && y >= 16 && y < 32;
                image.rgb.push_back(static_cast<std::uint8_t>(inside ? 240 : 60 + y));
                image.rgb.push_back(static_cast<std::uint8_t>(inside ? 200 : 60));
                image.rgb.push_back(static_cast<std::uint8_t>(inside ? 40 : 60 + x));
            }
        return image;
    }

    TEST(VideoFile, PlaysThePicturesThatWereWritten)
    {
        const test_support::TemporaryFolder folder;
        const auto path = folder.path / "moving.webm";
        VideoFile video(path, 64, 48, 10);
        video.add(picture(0), 1);
        video.add(picture(2), 4);
        video.add(picture(4), 2);
        video.finish();
        const test_support::ReadVideo read = test_support::read_video(path);
        EXPECT_EQ(read.codec, "vp9");
        EXPECT_NE(read.format.find("webm"), std::string::npos);
        EXPECT_NEAR(read.frames_per_second, 10.0, 1e-9);
        EXPECT_NEAR(read.seconds, 0.7, 0.02); // WebM counts milliseconds
        ASSERT_EQ(read.frames.size(), 7U);
        for (std::size_t n = 0; n < read.frames.size(); ++n) {
            const int shown = n == 0 ? 0 : n < 5 ? 2 : 4;
            EXPECT_LT(test_support::mean_difference(read.frames[n], picture(shown)), kLoss) << n;
        }
        EXPECT_GT(test_support::mean_difference(picture(0), picture(2)), 2.0 * kLoss);
    }

    TEST(VideoFile, TheSamePicturesGiveTheSameBytes)
    {
        const test_support::TemporaryFolder folder;
        std::string content[2];
        for (std::string& bytes : content) {
            const auto path = folder.path / "same.webm";
            VideoFile video(path, 64, 48, 10);
            for (int n = 0; n < 6; ++n)
                video.add(picture(n), 1);
            video.finish();
            std::ifstream in(path, std::ios::binary);
            bytes.assign(std::istreambuf_iterator<char>(in), {});
        }
        EXPECT_FALSE(content[0].empty());
        EXPECT_EQ(content[0], content[1]); // no time of writing, nothing by chance
    }

    TEST(VideoFile, WhatMakesNoMovieIsRefused)
    {
        const test_support::TemporaryFolder folder;
        EXPECT_THROW(VideoFile(folder.path / "odd.webm", 63, 48, 10), InputError);
        EXPECT_THROW(VideoFile(folder.path / "empty.webm", 0, 48, 10), InputError);
        EXPECT_THROW(VideoFile(folder.path / "still.webm", 64, 48, 0), InputError);
        EXPECT_THROW(VideoFile(folder.path / "nowhere" / "a.webm", 64, 48, 10), IoError);
        VideoFile video(folder.path / "sizes.webm", 64, 48, 10);
        EXPECT_THROW(video.add(picture(0, 32, 48), 1), InputError);
    }

} // namespace video_file_test
} // namespace retractor::ui
