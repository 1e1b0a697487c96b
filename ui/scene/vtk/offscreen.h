#pragma once
// The OpenGL context of pictures without a window. An executable links one provider of make_offscreen_context(): OSMesa
// (retractor::osmesa_context) or EGL (retractor::egl_context).

#include "mesh/base/assert.h"

#include <memory>
#include <string>
#include <string_view>

namespace retractor::ui {

/// An OpenGL context without a window. Use it from one thread at a time.
class OffscreenContext {
public:
    OffscreenContext() = default;
    OffscreenContext(const OffscreenContext&) = delete;
    OffscreenContext& operator=(const OffscreenContext&) = delete;
    virtual ~OffscreenContext() = default;

    /// @throws IoError when the driver refuses
    virtual void make_current() = 0;
    virtual bool is_current() const = 0;
    /// "osmesa" or "egl".
    virtual std::string_view backend() const = 0;
    /// The driver's name of the renderer, e.g. "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5". @pre is_current()
    std::string renderer() const;

protected:
    using GlGetString = const unsigned char* (*)(unsigned);
    /// The driver's glGetString; null when the driver has none.
    virtual GlGetString gl_get_string() const = 0;
};

inline std::string OffscreenContext::renderer() const
{
    RETRACTOR_ASSERT(is_current());
    constexpr unsigned kRenderer = 0x1F01, kVersion = 0x1F02; // GL_RENDERER, GL_VERSION
    const GlGetString get_string = gl_get_string();
    const auto text = [&](unsigned name) {
        const auto* const found = get_string == nullptr ? nullptr : get_string(name);
        return std::string(found == nullptr ? "unknown" : reinterpret_cast<const char*>(found));
    };
    return text(kRenderer) + ", OpenGL " + text(kVersion);
}

/// Defined by the linked provider. @throws IoError naming the failing step when no context can be made
std::unique_ptr<OffscreenContext> make_offscreen_context();

} // namespace retractor::ui
