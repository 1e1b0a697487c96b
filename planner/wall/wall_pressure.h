#pragma once
// Pressure on the wall from neighbouring labels: gas in the chest or abdomen, or blood in a vessel whose wall is cut.
// Units mm, N, MPa inside; kPa in texts and files. Frame patient LPS.
//
// The scanned shape is taken as stress-free, so a pressure that acted in the scanner would act twice. Enter the
// pressure change since the scan, or the whole pressure on tissue that had none.

#include "fem/model/loads.h"
#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/case/case.h"

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// How one pressure acts on the wall.
struct PressureMetrics {
    std::string label;
    double pressure_kPa = 0.0;
    double area_mm2 = 0.0; ///< area at rest of the modelled wall that borders on the label
    /// Area of wall without pressure, because voxels without a label lie between the wall and the label.
    double behind_gap_mm2 = 0.0;
    Vec3 force_N = Vec3::Zero(); ///< sum of the forces at rest
    /// True: the pressure follows the deforming surface; false: it acts as at rest, because linear elasticity knows no
    /// other shape.
    bool follows = true;
};

/// Reads a label and a pressure: "cavity=1.6". @throws InputError on other text
PressureSpec pressure_from_text(const std::string& text);

/// The boundary faces that border on a label. The label is the first label along the face's normal that is no wall. The
/// search reaches two voxels, measured along the normal, or as far as the mesher lets a face of this size stand off the
/// voxels.
struct BorderingFaces {
    std::vector<mesh::TetFace> faces;
    std::vector<mesh::TetFace> behind_gap; ///< faces with voxels without a label between wall and label
};

/// @param cut faces bared by cuts; these border on air and are left out
BorderingFaces faces_bordering(
    const mesh::TetMesh& wall, const mesh::LabelVolume& labels, Label label, std::span<const mesh::TetFace> cut);

struct WallPressure {
    fem::SurfacePressure acts;
    std::vector<mesh::TetFace> behind_gap; ///< see BorderingFaces
};

/// The case's pressures on the cut wall. @throws InputError naming a label on which the wall does not border
std::vector<WallPressure> wall_pressures(const mesh::TetMesh& wall, const mesh::LabelVolume& labels,
    const Case& planned_case, std::span<const mesh::TetFace> cut);

PressureMetrics pressure_metrics(const mesh::TetMesh& wall, const WallPressure& pressure, bool follows);

/// Text for people: "pressure of cavity: 1.60 kPa on 52.1 cm2, following the moving surface; total force 8.10 N at
/// rest, along (0.00, -1.00, 0.00)".
std::string pressure_text(const PressureMetrics& pressure);

} // namespace retractor::planner
