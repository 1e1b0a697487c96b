// OSMesa: software rendering without any display server.
//
// VTK finds its OpenGL functions through GLEW, which calls glXGetProcAddressARB. This file defines glXGetProcAddressARB
// and answers from OSMesa, so the whole process is bound to OSMesa. Link this file only into executables that open no
// window, with -rdynamic (so that GLEW finds the symbol here) and -lOSMesa before -lGL (so that plain gl* calls go to
// OSMesa too).

#include "mesh/base/error.h"
#include "ui/scene/vtk/offscreen.h"

#include <GL/osmesa.h>

#include <array>

extern "C" {
using GlFunction = void (*)();
GlFunction glXGetProcAddressARB(const unsigned char* name);
GlFunction glXGetProcAddress(const unsigned char* name);

__attribute__((visibility("default"), used)) GlFunction glXGetProcAddressARB(const unsigned char* name)
{
    return OSMesaGetProcAddress(reinterpret_cast<const char*>(name));
}
__attribute__((visibility("default"), used)) GlFunction glXGetProcAddress(const unsigned char* name)
{
    return OSMesaGetProcAddress(reinterpret_cast<const char*>(name));
}
}

namespace retractor::ui {

namespace {

    /// VTK draws into its own frame buffers, so the context's frame buffer only has to exist.
    constexpr int kBufferSize = 16;

    class OsmesaContext : public OffscreenContext {
    public:
        OsmesaContext()
        {
            const std::array<int, 15> attributes { OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 24,
                OSMESA_STENCIL_BITS, 8, OSMESA_PROFILE, OSMESA_CORE_PROFILE, OSMESA_CONTEXT_MAJOR_VERSION, 3,
                OSMESA_CONTEXT_MINOR_VERSION, 2, 0, 0, 0 };
            context_ = OSMesaCreateContextAttribs(attributes.data(), nullptr);
            if (context_ == nullptr)
                throw IoError("OSMesa cannot make an OpenGL 3.2 core context (is Mesa older than 12?)", "osmesa");
            try {
                make_current();
            } catch (...) {
                OSMesaDestroyContext(context_);
                throw;
            }
        }
        ~OsmesaContext() override
        {
            if (is_current())
                OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
            OSMesaDestroyContext(context_);
        }
        void make_current() override
        {
            if (is_current())
                return;
            if (!OSMesaMakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, kBufferSize, kBufferSize))
                throw IoError("OSMesa refuses to make its context current", "osmesa");
        }
        bool is_current() const override { return OSMesaGetCurrentContext() == context_; }
        std::string_view backend() const override { return "osmesa"; }

    protected:
        GlGetString gl_get_string() const override
        {
            return reinterpret_cast<GlGetString>(OSMesaGetProcAddress("glGetString"));
        }

    private:
        OSMesaContext context_ = nullptr;
        std::array<unsigned char, 4UL * kBufferSize * kBufferSize> buffer_ {};
    };

} // namespace

std::unique_ptr<OffscreenContext> make_offscreen_context() { return std::make_unique<OsmesaContext>(); }

} // namespace retractor::ui
