#include "planner/wall/wall_pressure.h"

#include "fem/model/loads.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    double longest_edge(const std::array<Vec3, 3>& corners)
    {
        return std::max(
            { (corners[1] - corners[0]).norm(), (corners[2] - corners[1]).norm(), (corners[0] - corners[2]).norm() });
    }

    double area_of(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces)
    {
        double area = 0.0;
        for (const mesh::TetFace& face : faces)
            area += triangle_area(mesh.vertices, mesh::face_vertices(mesh, face));
        return area;
    }

} // namespace

PressureSpec pressure_from_text(const std::string& text)
{
    const std::size_t at = text.rfind('=');
    PressureSpec spec;
    if (at != std::string::npos && at > 0) {
        spec.label = text.substr(0, at);
        const char *begin = text.data() + at + 1, *end = text.data() + text.size();
        if (const auto [rest, error] = std::from_chars(begin, end, spec.pressure_kPa);
            begin != end && rest == end && error == std::errc())
            return spec;
    }
    throw InputError("must be a label and a pressure in kPa, as in lung_left=1.3, not \"" + text + "\"", "pressure",
        { "pressures" });
}

BorderingFaces faces_bordering(
    const mesh::TetMesh& wall, const mesh::LabelVolume& labels, Label label, std::span<const mesh::TetFace> cut)
{
    // The smooth surface stands off the surface of the voxels by up to one voxel, and a face stands off the smooth
    // surface by up to 0.12 of an edge, the limit in the mesh's size field.
    constexpr double kVoxels = 2.0, kVoxelsOff = 1.0, kEdgesOff = 0.12, kStepVoxels = 0.25;
    const mesh::LabelFlags is_wall = mesh::flagged_labels(labels.table, mesh::is_wall);
    std::set<std::pair<TetId, int>> bared;
    for (const mesh::TetFace& face : cut)
        bared.insert({ face.tet, face.corner });
    BorderingFaces bordering;
    for (const mesh::TetFace& face : mesh::boundary_faces(wall)) {
        if (bared.contains({ face.tet, face.corner }))
            continue;
        const auto corners = triangle_corners(wall.vertices, mesh::face_vertices(wall, face));
        const Vec3 outward = unit_normal(corners), middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        const double voxel
            = 1.0 / (labels.grid.direction.transpose() * outward).cwiseQuotient(labels.grid.spacing).norm();
        const double farthest = std::max(kVoxels * voxel, kVoxelsOff * voxel + kEdgesOff * longest_edge(corners));
        bool gap = false;
        for (double reach = 0.0; reach <= farthest; reach += kStepVoxels * voxel) {
            const Label there = mesh::label_at(labels, middle + reach * outward);
            if (there == label)
                (gap ? bordering.behind_gap : bordering.faces).push_back(face);
            if (there != 0 && (gap || is_wall[there] == 0))
                break;
            gap = there == 0;
        }
    }
    return bordering;
}

std::vector<WallPressure> wall_pressures(const mesh::TetMesh& wall, const mesh::LabelVolume& labels,
    const Case& planned_case, std::span<const mesh::TetFace> cut)
{
    std::vector<WallPressure> pressures;
    for (const PressureSpec& spec : planned_case.pressures) {
        if (spec.pressure_kPa == 0.0)
            continue;
        BorderingFaces bordering
            = faces_bordering(wall, labels, mesh::find_label(planned_case.label_table, spec.label)->id, cut);
        if (bordering.faces.empty())
            throw InputError("the wall that is modelled, within the region round the incision, does not border on \""
                    + spec.label + "\": there is nothing that it could press on"
                    + (bordering.behind_gap.empty() ? "" : "; voxels without a label lie between the two"),
                "pressures");
        pressures.push_back({ { spec.label, std::move(bordering.faces), fem::kKiloPascal * spec.pressure_kPa },
            std::move(bordering.behind_gap) });
    }
    return pressures;
}

PressureMetrics pressure_metrics(const mesh::TetMesh& wall, const WallPressure& pressure, bool follows)
{
    const fem::SurfacePressure& acts = pressure.acts;
    PressureMetrics metrics { .label = acts.name,
        .pressure_kPa = acts.pressure / fem::kKiloPascal,
        .area_mm2 = area_of(wall, acts.faces),
        .behind_gap_mm2 = area_of(wall, pressure.behind_gap),
        .follows = follows };
    for (const mesh::TetFace& face : acts.faces)
        metrics.force_N -= acts.pressure * area_vector(wall.vertices, mesh::face_vertices(wall, face));
    return metrics;
}

std::string pressure_text(const PressureMetrics& pressure)
{
    const double force = pressure.force_N.norm();
    const Vec3 along = force > 0.0 ? Vec3(pressure.force_N / force) : Vec3(Vec3::Zero());
    std::string said = (pressure.pressure_kPa < 0.0 ? "suction of " : "pressure of ") + readable(pressure.label)
        + formatted(": %.2f kPa on %.1f cm2, %s; total force %.2f N at rest, along (%.2f, %.2f, %.2f)",
            pressure.pressure_kPa, pressure.area_mm2 / 100.0,
            pressure.follows ? "following the moving surface" : "on the surface at rest (linear elasticity)", force,
            along.x(), along.y(), along.z());
    if (pressure.behind_gap_mm2 > 0.0)
        said += "; no pressure on a further " + in_words(pressure.behind_gap_mm2 / 100.0, 1)
            + " cm2, because voxels without a label lie between the wall and " + readable(pressure.label);
    return said;
}

} // namespace retractor::planner
