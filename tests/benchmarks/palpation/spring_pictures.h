#pragma once
// Pictures and measured curves of mass-spring tissue, as by a camera and a rheometer.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <filesystem>
#include <memory>
#include <span>
#include <utility>

namespace retractor::benchmarks {

/// A scene of the sheet with the net of its springs, and the fingertips as spheres.
ui::Scene sheet_scene(std::shared_ptr<const TriMesh> sheet, std::span<const std::pair<Vec3, double>> tips);

/// Writes tissue_curves.png and tissue_curves.csv (force and displacement, relaxation, creep, each with its closed
/// form or published range), and sheet.png (untouched, pressed, pulled, released, under gravity, as a curtain, loaded
/// at a point, on a ring).
void write_spring_pictures(const std::filesystem::path& folder, const Job& job);

} // namespace retractor::benchmarks
