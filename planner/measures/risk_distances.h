#pragma once
// Distances from the blade to structures that must not be hurt: labels with the role at-risk, and vessels whose places
// are assumed. Units mm; frame patient LPS, at rest.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/image/volume.h"
#include "planner/case/assumed_vessel.h"
#include "planner/measures/field_metrics.h"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Structures farther away than this are not listed.
inline constexpr double kFarthestRiskMm = 50.0;

/// The distance of each label with the role at-risk from the blade, from its start on the skin to its full depth. The
/// nearest structure comes first. A structure that the blade passes through has the distance 0. Distances are taken at
/// the vertices of the structure's surface; they are too long by less than half an edge of the surface (about a voxel).
/// @param surface_of the surface of a label, by name; may be empty
std::vector<RiskDistance> risk_distances(const mesh::Blade& blade, const mesh::LabelVolume& labels,
    const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of);

/// The surface of a saw's cut. @param skin, inner as below @throws as saw_risk_distances()
TriMesh saw_surface(std::span<const Vec3> skin, std::span<const Vec3> inner);

/// The distances of the same labels, mm, from a saw that goes through bone from the skin to the inner side of the wall,
/// and no deeper, because its foot runs there. What lies against the bone is near, and is not sawn (distance 0).
/// @param skin, inner places along the cut, in order, and those on the inner side of the wall below them
/// @param surface_of as above
/// @throws InputError on fewer than two places, not as many on both sides, or places that are not finite
std::vector<RiskDistance> saw_risk_distances(std::span<const Vec3> skin, std::span<const Vec3> inner,
    const mesh::LabelVolume& labels, const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of);

/// The distances of the same labels from an instrument of steel, with its name as RiskDistance::from. An instrument
/// that lies in a structure has a distance near 0. Organs are where the CT shows them.
std::vector<RiskDistance> risk_distances(const TriMesh& instrument, const std::string& name,
    const mesh::LabelTable& table, const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of);

/// The distances of vessels whose places are assumed from a surface in space: a blade, a saw or an instrument.
/// A vessel that the surface meets has the distance 0.
/// @param name RiskDistance::from; empty: the surface cuts
std::vector<RiskDistance> assumed_distances(
    const TriMesh& surface, std::span<const AssumedVessel> vessels, const std::string& name = {});

/// The structure's name for people, with "(assumed place)" where no label shows it.
std::string risk_name(const RiskDistance& risk);

/// Leaves the nearest intercostal bundle and those that are cut: every space has one, and further ones tell nothing.
void keep_nearest_bundle(std::vector<RiskDistance>& nearest_first);

/// The distances from several blades of one approach: each structure once, with its smallest distance, nearest first.
std::vector<RiskDistance> nearest_risks(std::vector<RiskDistance> of_all_blades);

} // namespace retractor::planner
