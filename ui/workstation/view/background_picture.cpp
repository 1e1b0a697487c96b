#include "ui/workstation/view/background_picture.h"

#include "mesh/base/error.h"
#include "ui/scene/arrange_scenes.h"

#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <future>
#include <utility>

namespace retractor::ui {

void lower_priority()
{
    constexpr int kNice = 5;
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

QImage as_image(const Image& image)
{
    constexpr int kBytes = 3;
    return QImage(image.rgb.data(), image.width, image.height, kBytes * image.width, QImage::Format_RGB888)
        .convertToFormat(QImage::Format_RGB32);
}

BackgroundPicture::BackgroundPicture(std::function<void(PictureAnswer)> deliver)
    : deliver_(std::move(deliver))
{
    executor_.post([](const Job&) { lower_priority(); });
}

BackgroundPicture::~BackgroundPicture()
{
    // The context belongs to the drawing thread.
    executor_.post([this](const Job&) { renderer_.reset(); });
}

void BackgroundPicture::request(PictureRequest request)
{
    executor_.post_latest("picture", [this, request = std::move(request)](const Job& job) {
        if (!job.cancelled())
            deliver_(answer(request));
    });
}

PictureAnswer BackgroundPicture::draw(PictureRequest request)
{
    std::promise<PictureAnswer> promise;
    executor_.post([&](const Job&) { promise.set_value(answer(request)); });
    return promise.get_future().get();
}

PictureAnswer BackgroundPicture::answer(const PictureRequest& request)
{
    try {
        if (renderer_ == nullptr)
            renderer_ = std::make_unique<OffscreenRenderer>(make_offscreen_context());
        if (shown_.scenes != request.scenes || shown_.layout != request.layout || shown_.width != request.width
            || shown_.height != request.height) {
            shown_ = {};
            Picture picture { .width = request.width, .height = request.height };
            picture.viewports = arrange_scenes(*request.scenes, request.width, request.height, request.layout);
            for (std::size_t i = 0; i < picture.viewports.size(); ++i)
                picture.viewports[i].scene.camera = request.cameras.at(i);
            renderer_->show(picture);
            shown_ = request;
        }
        renderer_->set_stereo(request.stereo);
        return { .image = as_image(renderer_->draw(request.cameras)), .number = request.number };
    } catch (const std::exception& error) {
        return { .error = error.what(), .number = request.number };
    }
}

} // namespace retractor::ui
