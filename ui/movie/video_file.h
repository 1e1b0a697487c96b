#pragma once
// A movie as a file: VP9 in WebM. The file holds no time, no name of a program and nothing of the patient but the
// pictures.

#include "ui/scene/vtk/render.h"

#include <filesystem>
#include <memory>

namespace retractor::ui {

/// Writes pictures into a file. A file without finish() is not playable.
class VideoFile {
public:
    /// @param width, height pixels, both even
    /// @throws InputError on odd or empty sizes or a rate below 1; IoError naming the file when it cannot be begun
    VideoFile(const std::filesystem::path& path, int width, int height, int frames_per_second);
    ~VideoFile();
    VideoFile(const VideoFile&) = delete;
    VideoFile& operator=(const VideoFile&) = delete;

    /// Adds a picture, shown for this number of frames. @pre frames at least 1
    /// @throws InputError on a picture of another size; IoError naming the file
    void add(const Image& image, int frames);
    /// Writes what is kept back and closes the file. @throws IoError naming the file
    void finish();

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
