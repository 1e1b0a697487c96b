#pragma once
// Pressure on the wall from what it borders on: gas in the chest or abdomen, blood in a vessel whose wall is cut. Units
// mm, N, MPa inside; kPa where people write it. Frame patient LPS.
//
// The images are taken as free of stress: a pressure that the patient was under in the scanner acts once more. What
// acts is what has changed since, or all of it on tissue that was without.

#include "fem/model/loads.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/case/case.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// How it acts.
struct PressureMetrics {
    std::string label;
    double pressure_kPa = 0.0;
    double area_mm2 = 0.0; ///< at rest, of the modelled wall that borders on it
    double behind_gap_mm2 = 0.0; ///< of wall left out: between the label and it lie voxels without one
    Vec3 force_N = Vec3::Zero(); ///< at rest, in sum
    bool follows
        = true; ///< the deforming surface; false: it acts as at rest, for linear elasticity knows no other shape
};

/// "cavity=1.6". @throws InputError on text that is no such pair.
PressureSpec pressure_from_text(const std::string& text);

/// What borders on a label: boundary faces from which along the normal, within reach, it is the first label that is no
/// wall. The reach is two voxels, as they lie along the normal, or what a face of that size may stand off them.
struct BorderingFaces {
    std::vector<mesh::TetFace> faces;
    std::vector<mesh::TetFace> behind_gap; ///< it is the first but for voxels without a label
};

/// @param cut faces that are left out: what cuts have bared borders on air.
BorderingFaces faces_bordering(
    const mesh::TetMesh& wall, const mesh::LabelVolume& labels, Label label, std::span<const mesh::TetFace> cut);

struct WallPressure {
    fem::SurfacePressure acts;
    std::vector<mesh::TetFace> behind_gap; ///< faces_bordering()
};

/// The case's pressures on the cut wall. @throws InputError naming the label that the wall does not border on.
std::vector<WallPressure> wall_pressures(const mesh::TetMesh& wall, const mesh::LabelVolume& labels,
    const Case& planned_case, std::span<const mesh::TetFace> cut);

PressureMetrics pressure_metrics(const mesh::TetMesh& wall, const WallPressure& pressure, bool follows);

/// "pressure of cavity: 1.60 kPa on 52.1 cm2, which it follows; 8.1 N in sum at rest, along (0.0, -1.0, 0.0)".
std::string pressure_text(const PressureMetrics& pressure);

} // namespace retractor::planner
