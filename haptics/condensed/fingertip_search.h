#pragma once
// Finds the place where a fingertip meets a surface that moves with the pulse. The search walks from the last place, in
// a time that does not depend on the size of the mesh. Proxy-based contact after Ruspini, Kolarov, Khatib 1997. Units
// mm.

#include "haptics/condensed/contact_node_compliance.h"
#include "haptics/condensed/touch_surface.h"
#include "haptics/servo/tissue_response.h"

#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// Shape of a fingertip at the contact.
enum class FingertipShape {
    pad, ///< soft: the pad follows the surface and displaces all of it within the radius by the same depth; only pushes
    sphere, ///< rigid: touches few contact nodes
    /// The equation of Nakao et al. 2006: the finger holds all contact nodes within its radius; single contact nodes
    /// may pull, the finger as a whole never pulls.
    held,
};

/// The place that a fingertip presses, before the tissue moves.
struct TouchedPlace {
    bool touching = false;
    Vec3 normal = Vec3::Zero(); ///< outward unit normal
    double depth = 0.0; ///< depth of the fingertip under the surface along the normal, mm
    double rest_depth = 0.0; ///< depth under the surface without pulse, mm
    std::int32_t vertex = -1; ///< nearest vertex of the touch surface; -1: none
};

/// A contact node that the fingertip may press.
struct Candidate {
    std::int32_t contact_node = -1;
    /// Required displacement along the normal, mm.
    double demand = 0.0;
};

class FingertipSearch {
public:
    FingertipSearch(const TouchSurface& surface, FingertipShape shape);

    /// Servo thread, when another state of the body is swapped in: continues from the place of `before`.
    /// @pre both surfaces belong to the same body
    void go_on_from(const FingertipSearch& before) noexcept;

    /// Servo thread. A fingertip touches only when it comes from outside. A fingertip that starts within the body,
    /// jumps by more than two diameters or comes round the rim of an open surface is free until it has been outside.
    /// @param pressure MPa
    TouchedPlace find(const Fingertip& finger, const ContactNodeCompliance& body, double pressure) noexcept;

    /// Lists the contact nodes that the fingertip presses or nearly presses, largest demand first, at most `most`. All
    /// contact nodes move along the normal of `place`. Under a sphere the demand follows the sphere's shape. Under a
    /// pad the demand is uniform, and decreases in the last tenth of the radius so that the force does not jump when
    /// the pad slides. For FingertipShape::held the demand is uniform. A contact node that is not ready is left out,
    /// and counted in `missing` when the fingertip presses it.
    /// @return the number of candidates written to `into`
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
    bool outside_ = false; ///< the fingertip's centre was outside at the last tick, or presses from outside
    bool touched_ = false;
    std::int32_t vertex_ = -1;
    Vec3 last_ = Vec3::Constant(1e30); ///< last position of the fingertip
    std::vector<std::uint32_t> seen_; ///< per contact node: number of the last search that met it
    std::uint32_t search_ = 0;
    std::vector<std::int32_t> queue_;
};

} // namespace retractor::haptics
