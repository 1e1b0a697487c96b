#pragma once
// Organs filled with spheres, from phantoms and from files, and how they look. Units mm; frame patient LPS.

#include "haptics/spheres/sphere_motion.h"
#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <filesystem>
#include <span>
#include <utility>
#include <vector>

namespace retractor::benchmarks {

/// The phantom's liver as a closed surface.
TriMesh phantom_liver_surface(const Job& job);

/// Wall, liver and stomach of the abdomen phantom, filled with spheres: 1,880 in the liver, the others alike in size.
/// Stiffness by calibrate_sphere_force() from each tissue's Young's modulus.
std::vector<haptics::SphereOrgan> abdomen_organs(const haptics::SphereLaw& law, const Job& job);

/// One organ of `wanted` spheres with the force of a half-space of this modulus.
haptics::SphereOrgan filled_organ(const std::string& name, const TriMesh& surface, std::size_t wanted,
    const haptics::SphereLaw& law, double modulus_MPa, double ratio);

/// What is shown: the surface coloured or with the tissue's natural texture, or the spheres inside (every
/// `every`th cut away in front of a plane), with fingertips as white balls.
enum class SphereView { textured, colored, spheres };
ui::Scene sphere_scene(const haptics::SphereMotion& motion, SphereView view, std::span<const haptics::Fingertip> tips,
    std::span<const std::size_t> hidden_organs = {});

} // namespace retractor::benchmarks
