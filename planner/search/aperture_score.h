#pragma once
// What a hole in the wall at rest shows of the target and costs, for the search. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/approach/intercostal_space.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"
#include "planner/measures/ranking.h"
#include "planner/measures/sight/aperture.h"
#include "planner/measures/sight/ray_scene.h"

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// What an incision divides or holds apart, and the side that is operated on.
enum class ApertureKind {
    left_space, ///< the ribs are held apart, the left lung is held aside
    right_space,
    sternum, ///< the sternum is sawn through, both lungs are held aside
    skin, ///< no bone gives way, both lungs are held aside
};
inline constexpr std::size_t kApertureKinds = 4;

/// The kind of an incision over a space.
inline ApertureKind kind_over(const SpaceNumber& space)
{
    return space.left ? ApertureKind::left_space : ApertureKind::right_space;
}

/// The organs that are held aside for a target: lungs of the operated side, fat of the mediastinum and pericardium, and
/// others that are asked for. @throws InputError on an asked label that is not in the table or is wall
std::vector<std::string> organs_aside(
    const mesh::LabelTable& table, const TargetSpec& target, ApertureKind kind, const std::vector<std::string>& asked);

/// The patient, the target and all that stays where it is, for many holes. Safe to use from several threads.
class ApertureScorer {
public:
    /// @param aside organs that are held aside besides the usual ones
    /// @throws InputError as Patient::target() and organs_aside() do
    ApertureScorer(Patient& patient, TargetSpec target, ViewSpec view, std::vector<std::string> aside, const Job& job);

    /// What rays tell of a hole: shares seen and reached, angle, length, structures at risk, bones that are sawn.
    /// @param samples on the target
    /// @throws InputError as Aperture, and where the target lies in the hole
    Candidate score(const std::vector<ApertureSection>& sections, const ApertureWidth& width, ApertureKind kind,
        const std::vector<SurfaceSample>& samples);

    std::vector<SurfaceSample> samples(int count) const;

    /// Builds what score() needs for this kind, so that its failures come before thousands of trials.
    /// @throws InputError, IoError as Patient does for a surface that is missing
    void prepare(ApertureKind kind) { static_cast<void>(scene_of(kind)); }

    /// Distances of structures at risk from a knife's blade, as risk_distances() measures them on whole surfaces.
    /// score() takes points 3 mm apart for a knife, and whole surfaces for the one saw.
    std::vector<RiskDistance> exact_risks(const std::vector<ApertureSection>& sections) const;
    /// Distances of assumed vessels from the same blade, or from a saw; of the intercostal bundles the nearest and
    /// those that are cut.
    std::vector<RiskDistance> assumed_risks(const std::vector<ApertureSection>& sections, ApertureKind kind) const;

private:
    struct RiskPoint {
        Vec3 at = Vec3::Zero();
        std::size_t label = 0; ///< index into risk_names_
    };

    const RayScene& scene_of(ApertureKind kind);
    std::vector<RiskDistance> risks_beside(const std::vector<ApertureSection>& sections) const;
    std::vector<RiskDistance> risks_of_saw(const std::vector<ApertureSection>& sections) const;
    std::shared_ptr<const TriMesh> surface_of(std::string_view organ) const;
    std::set<Label> labels_on_blade(const std::vector<ApertureSection>& sections) const;

    Patient& patient_;
    TargetSpec target_;
    ViewSpec view_;
    std::vector<std::string> aside_;
    const Job& job_;
    std::shared_ptr<const TriMesh> target_surface_;
    std::shared_ptr<const mesh::LabelVolume> labels_;
    std::mutex mutex_; ///< of the scenes, which are built when first needed
    std::array<std::unique_ptr<RayScene>, kApertureKinds> scenes_;
    std::vector<std::string> risk_names_;
    std::vector<Label> risk_labels_; ///< in the same order
    std::vector<RiskPoint> risk_points_;
};

} // namespace retractor::planner
