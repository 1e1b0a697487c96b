#include "ui/scene/vtk/render.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "ui/scene/vtk/scene_view.h"
#include "mesh/base/vtk_errors.h"

#include <vtk_glew.h>

#include <vtkCamera.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    /// VTK's window for contexts that it did not make. Without an X display, glewInit loads every OpenGL function and
    /// then reports that the GLX part is missing. This window ignores the report, because it does not use GLX.
    class ContextWindow : public vtkGenericOpenGLRenderWindow {
    public:
        static ContextWindow* New();
        vtkTypeMacro(ContextWindow, vtkGenericOpenGLRenderWindow)

            OffscreenContext* context = nullptr;

        void MakeCurrent() override { context->make_current(); }
        bool IsCurrent() override { return context->is_current(); }

        void OpenGLInitContext() override
        {
            if (!this->Initialized) {
                constexpr GLenum kNoGlxDisplay = 4; // GLEW_ERROR_NO_GLX_DISPLAY, from GLEW 2.2 on
                // The functions serve the whole process. Another thread may be drawing with them already.
                const GLenum code = GLEW_VERSION_3_2 == GL_TRUE ? static_cast<GLenum>(GLEW_OK) : glewInit();
                if (code != GLEW_OK && code != kNoGlxDisplay)
                    throw IoError("the OpenGL functions cannot be loaded (GLEW code " + std::to_string(code) + ")",
                        std::string(context->backend()));
                if (GLEW_VERSION_3_2 == GL_FALSE)
                    throw IoError("the OpenGL context offers less than version 3.2", std::string(context->backend()));
                this->GlewInitValid = true;
                this->Initialized = true;
                GLfloat range[2] = { 1.0F, 1.0F };
                this->GetState()->vtkglGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, range);
                this->MaximumHardwareLineWidth = range[1];
            }
            this->Superclass::OpenGLInitContext();
        }
    };
    vtkStandardNewMacro(ContextWindow)

        Image read_pixels(vtkRenderWindow& window)
    {
        Image image;
        image.width = window.GetSize()[0];
        image.height = window.GetSize()[1];
        auto pixels = vtkSmartPointer<vtkUnsignedCharArray>::New();
        if (window.GetPixelData(0, 0, image.width - 1, image.height - 1, 0, pixels) != 1)
            throw IoError("the picture's pixels cannot be read back", "vtk");
        const std::size_t row = 3UL * static_cast<std::size_t>(image.width);
        image.rgb.resize(row * static_cast<std::size_t>(image.height));
        for (int y = 0; y < image.height; ++y) // OpenGL's first row is the lowest
            std::copy_n(
                pixels->GetPointer(static_cast<vtkIdType>(row * static_cast<std::size_t>(image.height - 1 - y))), row,
                image.rgb.data() + row * static_cast<std::size_t>(y));
        return image;
    }

} // namespace

struct OffscreenRenderer::State {
    std::unique_ptr<OffscreenContext> context;
    vtkSmartPointer<ContextWindow> window;
    std::unique_ptr<VolumeCache> volumes;
    std::vector<SceneView> views; ///< of the last show()
    TextLanguage language;

    void resize(int width, int height) const { window->SetSize(width, height); }

    ~State()
    {
        views.clear();
        volumes.reset();
        if (window != nullptr) {
            const VtkErrorTrap silent; // nobody can receive an error here
            window->Finalize();
        }
    }
};

OffscreenRenderer::OffscreenRenderer(std::unique_ptr<OffscreenContext> context, const Job& job)
    : state_(std::make_unique<State>())
{
    if (context == nullptr)
        throw InputError("a renderer needs a context");
    const Stopwatch watch;
    const VtkErrorTrap trap;
    state_->context = std::move(context);
    state_->volumes = std::make_unique<VolumeCache>(job);
    state_->window = vtkSmartPointer<ContextWindow>::New();
    ContextWindow& window = *state_->window;
    window.context = state_->context.get();
    window.SetIsCurrent(true);
    window.SetReadyForRendering(true);
    window.SetSupportsOpenGL(1);
    window.SetMapped(1);
    window.SetOwnContext(0);
    window.SetOffScreenRendering(1);
    window.SetFrameBlitModeToNoBlit();
    window.SetMultiSamples(0);
    constexpr int kFirstSize = 64;
    window.SetSize(kFirstSize, kFirstSize);
    window.MakeCurrent();
    window.OpenGLInitContext();
    trap.throw_if_error("starting the renderer");
    // The window's colour and depth buffers at the size of a usual picture.
    record_part(job, "renderer", watch, 1280UL * 960UL * 8UL);
}
OffscreenRenderer::~OffscreenRenderer() = default;

void OffscreenRenderer::set_stereo(Stereo stereo) { ui::set_stereo(*state_->window, stereo); }

void OffscreenRenderer::set_language(TextLanguage language) { state_->language = std::move(language); }

Image OffscreenRenderer::render(const Picture& picture)
{
    show(picture);
    std::vector<Camera> cameras;
    for (const Viewport& viewport : picture.viewports)
        cameras.push_back(viewport.scene.camera);
    Image image = draw(cameras);
    state_->views.clear();
    return image;
}

void OffscreenRenderer::show(const Picture& picture)
{
    check_picture(picture);
    const VtkErrorTrap trap;
    state_->views.clear();
    state_->resize(picture.width, picture.height);
    for (const Viewport& viewport : picture.viewports) {
        state_->views.emplace_back(*state_->window, viewport, *state_->volumes);
        if (!state_->language) {
            state_->views.back().show(viewport.scene);
            continue;
        }
        Scene scene = viewport.scene;
        say_texts(scene, state_->language);
        state_->views.back().show(scene);
    }
    state_->volumes->sweep();
    trap.throw_if_error("preparing a picture");
}

Image OffscreenRenderer::draw(const std::vector<Camera>& cameras)
{
    RETRACTOR_ASSERT(cameras.size() == state_->views.size());
    const VtkErrorTrap trap;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        state_->views[i].set_camera(cameras[i]);
    state_->window->Render();
    Image image = read_pixels(*state_->window);
    trap.throw_if_error("drawing a picture");
    return image;
}

Image OffscreenRenderer::render(const ChartPicture& picture)
{
    if (picture.panels.empty() || picture.columns < 1 || picture.panel_width < 1 || picture.panel_height < 1)
        throw InputError("a picture of charts needs panels with a size");
    const VtkErrorTrap trap;
    state_->views.clear();
    const int columns = std::min(picture.columns, static_cast<int>(picture.panels.size()));
    state_->resize(columns * picture.panel_width, picture.rows() * picture.panel_height);
    const ChartView view(*state_->window, picture);
    state_->window->Render();
    Image image = read_pixels(*state_->window);
    trap.throw_if_error("drawing charts");
    return image;
}

} // namespace retractor::ui
