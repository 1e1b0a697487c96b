#include "ui/workstation/view/background_picture.h"

#include "tests/ui/scene/sample_scenes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace retractor::ui {
namespace background_picture_test {

    constexpr int kWidth = 240, kHeight = 200;

    PictureRequest request_of(std::vector<Scene> scenes, int number)
    {
        PictureRequest request { .width = kWidth, .height = kHeight, .number = number };
        for (const Scene& scene : scenes)
            request.cameras.push_back(scene.camera);
        request.scenes = std::make_shared<const std::vector<Scene>>(std::move(scenes));
        return request;
    }

    Scene chest(int i)
    {
        Scene scene = samples::little_chest(false);
        scene.title = "Chest " + std::to_string(i);
        scene.legend.push_back({ .key = "Number", .value = std::to_string(i) });
        scene.camera.eye += Vec3(2.0 * i, 0.0, 0.0);
        return scene;
    }

    TEST(BackgroundPicture, TwoThreadsDrawWhatOneDraws)
    {
        constexpr int kPictures = 12;
        const auto draw_all = [](std::vector<QImage>& images) {
            BackgroundPicture picture([](const PictureAnswer&) {});
            for (int i = 0; i < kPictures; ++i) {
                const PictureAnswer answer = picture.draw(request_of({ chest(i) }, i));
                EXPECT_EQ(answer.error, "");
                EXPECT_EQ(answer.number, i);
                images.push_back(answer.image);
            }
        };
        std::vector<QImage> alone, one, other;
        draw_all(alone);
        std::thread first([&] { draw_all(one); });
        std::thread second([&] { draw_all(other); });
        first.join();
        second.join();
        ASSERT_EQ(alone.size(), static_cast<std::size_t>(kPictures));
        EXPECT_EQ(one, alone);
        EXPECT_EQ(other, alone);
        EXPECT_NE(alone.front(), alone.back());
    }

    TEST(BackgroundPicture, TheNewestRequestIsDeliveredAndAFailureIsReported)
    {
        std::mutex mutex;
        std::vector<PictureAnswer> answers;
        const auto last = [&] {
            const std::lock_guard lock(mutex);
            return answers.empty() ? -1 : answers.back().number;
        };
        {
            BackgroundPicture picture([&](PictureAnswer answer) {
                const std::lock_guard lock(mutex);
                answers.push_back(std::move(answer));
            });
            constexpr int kRequests = 20;
            for (int i = 0; i < kRequests; ++i)
                picture.request(request_of({ chest(0) }, i));
            const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(2);
            while (last() < kRequests - 1 && std::chrono::steady_clock::now() < limit)
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
            ASSERT_EQ(last(), kRequests - 1);
            EXPECT_EQ(answers.back().error, "");
            EXPECT_FALSE(answers.back().image.isNull());
            EXPECT_LT(answers.size(), static_cast<std::size_t>(kRequests)) << "older requests are replaced";
            Scene broken = chest(0);
            broken.camera.eye = broken.camera.aim;
            const PictureAnswer refused = picture.draw(request_of({ broken }, 7));
            EXPECT_TRUE(refused.image.isNull());
            EXPECT_NE(refused.error, "");
            EXPECT_FALSE(picture.draw(request_of({ chest(1) }, 8)).image.isNull()) << "the next picture is drawn";
        }
    }

} // namespace background_picture_test
} // namespace retractor::ui
