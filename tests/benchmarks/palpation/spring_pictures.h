#pragma once
// What a rheometer and a camera would see of mass-spring tissue.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <filesystem>
#include <memory>
#include <span>
#include <utility>

namespace retractor::benchmarks {

/// The sheet with its springs' net and the fingertips as spheres.
ui::Scene sheet_scene(std::shared_ptr<const TriMesh> sheet, std::span<const std::pair<Vec3, double>> tips);

/// tissue_curves.png and .csv (force and displacement, relaxation, creep, each beside its closed form or published
/// range) and sheet.png (untouched, pressed, pulled, let go, under gravity, as a curtain, loaded at a point, on a
/// ring).
void write_spring_pictures(const std::filesystem::path& folder, const Job& job);

} // namespace retractor::benchmarks
