#pragma once
// From a frame of a palpation to what is drawn of it.

#include "haptics/hand/hand_model.h"
#include "planner/session/palpation_session.h"
#include "ui/scene/vtk/live_palpation.h"

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace retractor::ui {

struct PalpationWishes {
    bool spheres = false; ///< the spheres inside instead of the surface
    bool hands = false;
    std::set<Label> hidden_organs {};
    std::array<bool, planner::kMostFingers> fingers {}; ///< which are shown
    std::vector<haptics::ElasticTemplate> edits {}; ///< in force, in order
    std::optional<haptics::ElasticTemplate> mark; ///< being placed
    Vec3 sight = -Vec3::UnitZ(), up = Vec3::UnitY(); ///< the camera's: hands reach in from below
};

/// Seen at an angle from where its sites face, whole; with the sites named.
Scene palpation_scene(const datasets::PalpationScene& scene, const std::vector<std::string>& notes);

/// Where the fingers are shown: on the drawn tissue.
std::array<Vec3, haptics::kMaxFingers> shown_fingertips(const planner::PalpationFrame& frame);

/// Right and left.
using ShownHands = std::array<haptics::HandModel, LivePalpation::kHands>;

class PalpationPicture {
public:
    /// @param organs their names, by label from 1; empty: the scene is one body
    PalpationPicture(const datasets::PalpationScene& scene, const std::vector<std::string>& organs);

    void show(const planner::PalpationFrame& frame, const PalpationWishes& wishes);
    /// In place of those built in.
    void set_hands(const ShownHands& hands);
    [[nodiscard]] const LiveProps& props() const { return live_; }

private:
    void show_surface(const planner::PalpationFrame& frame, const PalpationWishes& wishes);
    void show_spheres(const planner::PalpationFrame& frame, const PalpationWishes& wishes);
    void show_hands(const PalpationWishes& wishes, const std::vector<haptics::ShownFinger>& fingers);
    int shade_of(
        const TriMesh& surface, std::size_t triangle, const std::vector<haptics::ElasticTemplate>& edits) const;

    LivePalpation live_;
    std::string name_;
    std::vector<std::string> organs_;
    std::map<Label, double> modulus_of_; ///< MPa, mean by label
    double usual_modulus_ = 1.0; ///< MPa: the median
    ShownHands hands_; ///< made when they are first wanted

    // What the surface was made of.
    std::shared_ptr<const TriMesh> surface_;
    std::set<Label> hidden_;
    std::vector<haptics::ElasticTemplate> edits_;
    bool spheres_ = false;
};

} // namespace retractor::ui
