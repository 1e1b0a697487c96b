#pragma once
// A proxy that a finger drags over a deforming triangle surface [Zilles, Salisbury 1995: god-object; Ruspini, Kolarov,
// Khatib 1997: virtual proxy, friction, force shading after Morgenbesser, Srinivasan 1996], for tissue responses that
// have no contact of their own. A fingertip is a point at its centre, pushed out by its radius along the shaded normal.
// Units mm; any frame.
//
// Two threads: the simulation publishes deformed vertices with a grid over them; the servo takes the newest. A touch is
// looked for within the fingertip's radius, and along its centre's way since the tick before, so that thin tissue is
// not passed through; in contact the proxy walks from triangle to neighbour, so its cost does not depend on the
// surface's size.

#include "haptics/servo/tissue_response.h"
#include "mesh/base/triple_buffer.h"

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::haptics {

struct SurfaceProxyOptions {
    std::size_t fingers = 1;
    double friction
        = 0.0; ///< coefficient: the proxy sticks while the pull along the surface is at most this times the depth
    bool shaded = true; ///< normals blend between vertices; off: each triangle has its own
};

/// Where one finger's proxy is.
struct ProxyContact {
    bool touching = false;
    Vec3 proxy = Vec3::Zero(); ///< on the surface, mm
    Vec3 normal = Vec3::Zero(); ///< outward, unit; shaded
    double depth = 0.0; ///< of the finger's lowest point below the surface at the proxy, mm
    std::int32_t triangle = -1; ///< that holds it
    Vec3 weights = Vec3::Zero(); ///< of its vertices
};

class SurfaceProxy {
public:
    /// @param surface closed or open, consistently oriented; boundary edges end the walk
    /// @throws InputError on no triangle, an index out of range, an edge with more than two triangles, a number that is
    /// not finite, no fingers, or a friction that is negative
    SurfaceProxy(const TriMesh& surface, const SurfaceProxyOptions& options = {});

    /// Simulation thread: the surface as it is now. Allocates nothing after the first call.
    /// @throws InputError when there are not as many vertices
    void publish(const Points& vertices);

    /// Servo thread: takes the newest surface; once per tick, before the fingers.
    void refresh() noexcept { now_ = &surfaces_.latest(); }
    /// Servo thread: moves one finger. Allocates nothing.
    const ProxyContact& move(std::size_t finger, const Fingertip& tip) noexcept;

private:
    /// A surface at one moment, with a grid of its triangles.
    struct Moment {
        Points vertices, normals; ///< per vertex, unit
        Vec3 low = Vec3::Zero();
        double cell = 1.0;
        std::array<std::int32_t, 3> cells { 1, 1, 1 };
        std::vector<std::int32_t> begin, triangles; ///< triangles of cell c: [begin[c], begin[c + 1])
        std::vector<std::int32_t> fill; ///< while it is built
    };
    struct Finger {
        ProxyContact contact;
        Vec3 last = Vec3::Zero(); ///< its centre at the tick before
        bool started = false;
    };

    template <class What> bool for_triangles_in(const Vec3& low, const Vec3& high, What&& what) const noexcept;
    void build(Moment& moment, const Points& vertices) const;
    [[nodiscard]] Vec3 corner(std::int32_t triangle, int i) const noexcept;
    [[nodiscard]] Vec3 flat_normal(std::int32_t triangle) const noexcept;
    [[nodiscard]] Vec3 normal_at(std::int32_t triangle, const Vec3& weights) const noexcept;
    [[nodiscard]] bool find_crossing(const Vec3& from, const Vec3& to, ProxyContact& contact) const noexcept;
    [[nodiscard]] bool find_near(const Fingertip& tip, ProxyContact& contact) const noexcept;
    void walk(ProxyContact& contact, const Vec3& goal) const noexcept;

    SurfaceProxyOptions options_;
    std::vector<std::array<VertexId, 3>> triangles_;
    std::vector<std::array<std::int32_t, 3>> neighbours_; ///< across the edge opposite corner i; -1: none
    TripleBuffer<Moment> surfaces_;
    const Moment* now_ = nullptr;
    std::vector<Finger> fingers_;
};

} // namespace retractor::haptics
