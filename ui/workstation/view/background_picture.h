#pragma once
// Draws scenes in full quality on a thread of its own, with an OpenGL context of its own, so that the window never
// waits for a slow picture.

#include "mesh/base/serial_executor.h"
#include "ui/scene/arrange_scenes.h"
#include "ui/scene/scene.h"
#include "ui/scene/vtk/render.h"

#include <QImage>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui {

struct PictureRequest {
    std::shared_ptr<const std::vector<Scene>> scenes {}; ///< arranged as arrange_scenes() does
    SceneLayout layout = SceneLayout::grid;
    std::vector<Camera> cameras {}; ///< one for each scene
    int width = 0, height = 0; ///< pixels
    Stereo stereo = Stereo::off;
    int number = 0; ///< comes back with the answer
};

struct PictureAnswer {
    QImage image {}; ///< null when the picture could not be drawn
    std::string error {}; ///< why it could not be drawn
    int number = 0;
};

/// Lets the window's own drawing go before what the calling thread does. Linux keeps a priority for each thread, and
/// the driver's threads inherit the priority of the thread that makes a context. Without permission nothing changes.
void lower_priority();

/// A copy of the picture for Qt.
QImage as_image(const Image& image);

/// Its functions belong to one thread.
class BackgroundPicture {
public:
    /// @param deliver called on the drawing thread for each request that was not replaced
    explicit BackgroundPicture(std::function<void(PictureAnswer)> deliver);
    /// Waits for the end of the picture that is being drawn.
    ~BackgroundPicture();

    /// Asks for a picture. A request that still waits is replaced.
    void request(PictureRequest request);
    /// Draws the picture while the caller waits; it is not delivered.
    PictureAnswer draw(PictureRequest request);

private:
    PictureAnswer answer(const PictureRequest& request);

    std::function<void(PictureAnswer)> deliver_;
    // Used on the drawing thread only.
    std::unique_ptr<OffscreenRenderer> renderer_;
    PictureRequest shown_; ///< the scenes that the renderer holds, and their size
    SerialExecutor executor_ { { .when_destroyed = WaitingTasks::run } }; ///< ends before the data of its tasks
};

} // namespace retractor::ui
