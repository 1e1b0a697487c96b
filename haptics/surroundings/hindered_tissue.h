#pragma once
// Tissue that fingers touch through an opening in solid surroundings: a finger that the surroundings stop is not where
// the hand is, but where it fits (finger_access.h), and the tissue is asked there. A spring draws the hand back. Units
// mm, N.

#include "haptics/servo/tissue_response.h"
#include "haptics/surroundings/finger_access.h"

#include <memory>
#include <vector>

namespace retractor::haptics {

/// Stiffness by which surroundings hold a hand back (ours): much stiffer than an aorta under a fingertip, and within
/// what a Touch renders.
inline constexpr double kSurroundingsNPerMm = 1.0;

class HinderedTissue : public TissueResponse {
public:
    /// @param tissue must outlive this one
    HinderedTissue(TissueResponse& tissue, std::shared_ptr<const FingerAccess> access);

    [[nodiscard]] std::string_view name() const noexcept override { return tissue_.name(); }
    [[nodiscard]] std::size_t finger_count() const noexcept override { return tissue_.finger_count(); }
    /// The contacts tell what stopped each finger (FingerContact::stopped_by).
    void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept override;
    [[nodiscard]] const TriMesh& surface() const noexcept override { return tissue_.surface(); }
    void follow(Points& deformed) override { tissue_.follow(deformed); }

private:
    struct Held {
        FingerAccess::Place place;
        Vec3 wanted = Vec3::Zero();
        double radius = 0.0;
        bool begun = false, stopped = false;
        bool jumped = false; ///< the tip is elsewhere without having moved there: the hand came free of what stopped it
    };
    void move(Held& held, const Fingertip& finger) const noexcept;

    TissueResponse& tissue_;
    std::shared_ptr<const FingerAccess> access_;
    std::vector<Held> held_;
    std::vector<Fingertip> asked_;
};

} // namespace retractor::haptics
