// Writes the sample picture with whichever context is linked: the two executables made of this file are compared.
// Usage: scene_picture_<backend> OUT.png; exits with 77 when there is no such context here.

#include "mesh/base/error.h"
#include "tests/ui/scene/sample_scenes.h"
#include "ui/scene/vtk/render.h"

#include <exception>
#include <iostream>
#include <span>

int main(int argc, char** argv)
{
    constexpr int kNotHere = 77;
    const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
    if (arguments.size() < 2) {
        std::cerr << "usage: scene_picture OUT.png [WIDTH HEIGHT]\n";
        return 2;
    }
    std::unique_ptr<retractor::ui::OffscreenContext> context;
    try {
        context = retractor::ui::make_offscreen_context();
    } catch (const retractor::IoError& error) {
        std::cerr << error.what() << '\n';
        return kNotHere;
    }
    try {
        retractor::ui::Picture picture;
        if (arguments.size() > 3) {
            picture.width = std::stoi(arguments[2]);
            picture.height = std::stoi(arguments[3]);
        }
        picture.viewports.push_back({ .scene = retractor::ui::samples::little_chest() });
        retractor::ui::OffscreenRenderer renderer(std::move(context));
        for (int repeat = 0; repeat < 2; ++repeat) {
            const retractor::Stopwatch watch;
            const retractor::ui::Image image = renderer.render(picture);
            std::cerr << watch.seconds() << " s\n";
            retractor::ui::write_png(arguments[1], image);
        }
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    return 0;
}
