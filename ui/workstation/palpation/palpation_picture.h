#pragma once
// Draws a frame of a palpation.

#include "haptics/hand/hand_model.h"
#include "haptics/surroundings/finger_access.h"
#include "planner/session/palpation_session.h"
#include "ui/scene/vtk/live_palpation.h"

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace retractor::ui {

struct PalpationViewOptions {
    bool spheres = false; ///< show the spheres inside instead of the surface
    bool hands = false;
    std::set<Label> hidden_organs {};
    std::array<bool, planner::kMostFingers> fingers {}; ///< fingers that are shown
    std::vector<haptics::ElasticTemplate> edits {}; ///< edits in force, in order
    std::optional<haptics::ElasticTemplate> mark; ///< edit that is being placed
    Vec3 sight = -Vec3::UnitZ(), up = Vec3::UnitY(); ///< directions of the camera; hands reach in from below
    /// The finger that is put through an opening; not set: nothing is round the tissue.
    std::optional<haptics::StraightRod> through_opening {};
};

/// The whole tissue with its named sites, seen at an angle from the side to which the sites face.
Scene palpation_scene(const datasets::PalpationScene& scene, const std::vector<std::string>& notes);

/// The places of the fingertips in the picture, on the drawn tissue.
std::array<Vec3, haptics::kMaxFingers> shown_fingertips(const planner::PalpationFrame& frame);

/// The right and the left hand.
using ShownHands = std::array<haptics::HandModel, LivePalpation::kHands>;

class PalpationPicture {
public:
    /// @param organs names of the organs by label, from 1; empty: the scene is one body
    PalpationPicture(const datasets::PalpationScene& scene, const std::vector<std::string>& organs);

    void show(const planner::PalpationFrame& frame, const PalpationViewOptions& options);
    /// Replaces the built-in hands.
    void set_hands(const ShownHands& hands);
    [[nodiscard]] const LiveProps& props() const { return live_; }

private:
    void show_surface(const planner::PalpationFrame& frame, const PalpationViewOptions& options);
    void show_spheres(const planner::PalpationFrame& frame, const PalpationViewOptions& options);
    void show_hands(const PalpationViewOptions& options, const std::vector<haptics::ShownFinger>& fingers);
    int shade_of(
        const TriMesh& surface, std::size_t triangle, const std::vector<haptics::ElasticTemplate>& edits) const;

    LivePalpation live_;
    std::string name_;
    std::vector<std::string> organs_;
    std::map<Label, double> modulus_of_; ///< mean modulus of each label, MPa
    double usual_modulus_ = 1.0; ///< median modulus, MPa
    ShownHands hands_; ///< made on first use

    // The data from which the surface was made.
    std::shared_ptr<const TriMesh> surface_;
    std::shared_ptr<const std::vector<std::uint8_t>> reached_;
    std::set<Label> hidden_;
    std::vector<haptics::ElasticTemplate> edits_;
    bool spheres_ = false;
};

} // namespace retractor::ui
