#pragma once
// Organs filled with spheres, from phantoms and from files, and pictures of these organs. Units mm; frame patient
// LPS.

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

/// Wall, liver and stomach of the abdomen phantom, filled with spheres. The liver has 1,880 spheres, as in [Suzuki
/// and others, Performing virtual surgery with a force feedback system]; spheres of the other organs have a similar
/// size. calibrate_sphere_force() sets the stiffness from each tissue's Young's modulus.
std::vector<haptics::SphereOrgan> abdomen_organs(const haptics::SphereLaw& law, const Job& job);

/// One organ of `wanted` spheres with the force of a half-space of this modulus.
haptics::SphereOrgan filled_organ(const std::string& name, const TriMesh& surface, std::size_t wanted,
    const haptics::SphereLaw& law, double modulus_MPa, double ratio);

/// Content of the picture: the surface with its natural texture, the coloured surface, or the spheres inside with the
/// front cut away. Fingertips are white balls.
enum class SphereView { textured, colored, spheres };
ui::Scene sphere_scene(const haptics::SphereMotion& motion, SphereView view, std::span<const haptics::Fingertip> tips,
    std::span<const std::size_t> hidden_organs = {});

} // namespace retractor::benchmarks
