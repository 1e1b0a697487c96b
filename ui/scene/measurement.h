#pragma once
// Distances and angles that a person measures between places in the patient. Units mm; frame patient LPS.

#include "ui/scene/scene.h"

#include <string>
#include <vector>

namespace retractor::ui {

/// Two places give their distance, three the angle at the second place. One place is a measurement that is begun.
struct Measurement {
    std::vector<Vec3> places {};
    bool area = false; ///< the places are the corners of a polygon
};

/// Area of a closed polygon, mm2: of its vector area, which is exact where the corners lie in a plane.
double polygon_area_mm2(const std::vector<Vec3>& corners);

/// "43.2 mm", or "118° (43.2 and 20.1 mm)", or "12.3 cm² (perimeter 134 mm)"; empty for fewer than two places, or three
/// corners.
std::string measurement_text(const Measurement& measurement);

/// Draws the measurements into scenes: in space all of them, on a slice those that lie in its plane, to half a voxel.
void draw_measurements(std::vector<Scene>& scenes, const std::vector<Measurement>& measurements);

} // namespace retractor::ui
