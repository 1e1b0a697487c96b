// EGL on the surfaceless platform. It needs no display server and no replacement of symbols, and uses a GPU where Mesa
// has one.

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "ui/scene/vtk/offscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <string>

namespace retractor::ui {

namespace {

    [[noreturn]] void fail(const char* step)
    {
        throw IoError(std::string("EGL without a surface: ") + step + " failed ("
                + formatted("0x%04x", static_cast<unsigned>(eglGetError())) + ")",
            "egl");
    }

    /// The display without a surface. All contexts of the process share it, and it lasts as long as the process,
    /// because ending it would end the contexts of other threads too.
    EGLDisplay surfaceless_display()
    {
        static const EGLDisplay display = [] {
            const auto get_platform_display
                = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
            if (get_platform_display == nullptr)
                fail("finding eglGetPlatformDisplayEXT");
            const EGLDisplay found = get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
            if (found == EGL_NO_DISPLAY)
                fail("eglGetPlatformDisplay");
            if (eglInitialize(found, nullptr, nullptr) == EGL_FALSE)
                fail("eglInitialize");
            return found;
        }();
        return display;
    }

    class EglContext : public OffscreenContext {
    public:
        EglContext()
        {
            try {
                create();
            } catch (...) {
                release();
                throw;
            }
        }
        ~EglContext() override { release(); }

        void make_current() override
        {
            if (!is_current() && eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE)
                fail("eglMakeCurrent");
        }
        bool is_current() const override { return eglGetCurrentContext() == context_; }
        std::string_view backend() const override { return "egl"; }

    protected:
        GlGetString gl_get_string() const override
        {
            return reinterpret_cast<GlGetString>(eglGetProcAddress("glGetString"));
        }

    private:
        void create()
        {
            if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE)
                fail("eglBindAPI");
            const std::array<EGLint, 5> wanted { EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE };
            EGLConfig config = nullptr;
            EGLint count = 0;
            if (eglChooseConfig(display_, wanted.data(), &config, 1, &count) == EGL_FALSE || count < 1)
                fail("eglChooseConfig");
            const std::array<EGLint, 7> attributes { EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 2,
                EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE };
            context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, attributes.data());
            if (context_ == EGL_NO_CONTEXT)
                fail("eglCreateContext");
            make_current();
        }
        void release() noexcept
        {
            eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            if (context_ != EGL_NO_CONTEXT)
                eglDestroyContext(display_, context_);
        }

        const EGLDisplay display_ = surfaceless_display();
        EGLContext context_ = EGL_NO_CONTEXT;
    };

} // namespace

std::unique_ptr<OffscreenContext> make_offscreen_context() { return std::make_unique<EglContext>(); }

} // namespace retractor::ui
