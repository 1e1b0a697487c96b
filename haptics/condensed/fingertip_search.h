#pragma once
// Where a fingertip meets a surface that breathes with the pulse: found by a walk from where it was, in a time that
// does not depend on the size of the mesh. Proxy-based contact after [Ruspini, Kolarov, Khatib 1997]. Units mm.

#include "haptics/condensed/contact_node_compliance.h"
#include "haptics/condensed/touch_surface.h"
#include "haptics/servo/tissue_response.h"

#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// What a fingertip is like where it touches.
enum class FingertipShape {
    pad, ///< soft: it has taken the shape of the surface, and presses all of it within its radius in alike, as far as
         ///< that takes pushing
    sphere, ///< rigid: it touches in few places
    held, ///< the seed's equation as it stands: all within its radius is held where the finger is, some of it by
          ///< pulling; only the finger as a whole never pulls
};

/// What a fingertip presses, before the tissue gives way.
struct TouchedPlace {
    bool touching = false;
    Vec3 normal = Vec3::Zero(); ///< outward
    double depth = 0.0; ///< of the fingertip under the surface along the normal
    double rest_depth = 0.0; ///< the same under the surface without pulse
    std::int32_t vertex = -1; ///< nearest
};

/// A station the fingertip may press, and how far it must give way along the normal.
struct Candidate {
    std::int32_t contact_node = -1;
    double demand = 0.0;
};

class FingertipSearch {
public:
    FingertipSearch(const TouchSurface& surface, FingertipShape shape);

    /// Servo thread, when another state of the body is swapped in: goes on from where `before` was, on the same surface
    /// or one of the same body.
    void go_on_from(const FingertipSearch& before) noexcept;

    /// Servo thread. A fingertip touches only when it comes from outside: one that starts within the body, jumps by
    /// more than two diameters or comes round the rim of an open surface is free until it has been outside. @param
    /// pressure MPa
    TouchedPlace find(const Fingertip& finger, const ContactNodeCompliance& body, double pressure) noexcept;

    /// The stations the fingertip presses or nearly presses, those that must give way most first; `most` at most.
    /// All give way along the place's normal: under a sphere as far as it reaches there; under a pad all alike, less
    /// and less in the last tenth of its radius, so that nothing jumps when it slides (held: all alike). Those not
    /// ready are counted in `missing` where the fingertip presses them, and left out.
    /// @return how many were written.
    std::size_t candidates(const Fingertip& finger, const TouchedPlace& place, const ContactNodeCompliance& body,
        double pressure, std::vector<Candidate>& into, std::size_t most, int& missing) noexcept;

private:
    double demand(const Fingertip& finger, const TouchedPlace& place, std::int32_t contact_node,
        const ContactNodeCompliance& body, double pressure) const noexcept;
    Vec3 position(std::int32_t vertex, const ContactNodeCompliance& body, double pressure) const noexcept;
    std::int32_t walk(
        std::int32_t from, const Vec3& to, const ContactNodeCompliance& body, double pressure) const noexcept;

    const TouchSurface* surface_;
    FingertipShape shape_;
    bool outside_ = false; ///< the fingertip's centre was outside at the last tick, or presses from there
    bool touched_ = false;
    std::int32_t vertex_ = -1;
    Vec3 last_ = Vec3::Constant(1e30); ///< where the fingertip was
    std::vector<std::uint32_t> seen_; ///< per station: the search that met it last
    std::uint32_t search_ = 0;
    std::vector<std::int32_t> queue_;
};

} // namespace retractor::haptics
