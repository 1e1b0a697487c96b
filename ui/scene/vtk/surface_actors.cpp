#include "ui/scene/vtk/surface_actors.h"

#include "ui/scene/vtk/poly_data.h"
#include "ui/scene/vtk/surface_shader.h"

#include <Eigen/Core>

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

namespace retractor::ui {

namespace {

    /// Edges sharper than this angle stay sharp: a lip against the skin, the cut end of a bone.
    constexpr double kFeatureAngleDeg = 40.0;
    constexpr const char* kPartArray = "part";
    /// Normals are averaged over these radii, so that voxels and slices of the image do not show as rings in the
    /// shading. The skin is smooth over wide areas; ribs and vessels are not.
    constexpr double kSkinShadingMm = 7.0, kOrganShadingMm = 2.5;
    constexpr int kMostRounds = 40; ///< of averaging; more would take long and change little

    double shading_radius(const Look& look)
    {
        if (look.finish == Finish::metal || look.finish == Finish::unlit)
            return 0.0;
        return look.finish == Finish::skin ? kSkinShadingMm : kOrganShadingMm;
    }

    using Triangles = std::vector<std::array<vtkIdType, 3>>;

    Triangles triangles_of(vtkPolyData& data)
    {
        data.BuildCells();
        Triangles triangles(static_cast<std::size_t>(data.GetNumberOfCells()));
        auto corners = vtkSmartPointer<vtkIdList>::New();
        for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
            data.GetCellPoints(c, corners);
            triangles[static_cast<std::size_t>(c)] = { corners->GetId(0), corners->GetId(1), corners->GetId(2) };
        }
        return triangles;
    }

    /// How often the normal of each point is averaged with its neighbours' to cover the radius of its look: a walk of n
    /// edges comes sqrt(n) edges far. Large triangles are not made of voxels, and hardly averaged.
    /// @param radius_mm of each triangle
    std::vector<int> rounds_of(vtkPolyData& data, const Triangles& triangles, const std::vector<double>& radius_mm)
    {
        const auto points = static_cast<std::size_t>(data.GetNumberOfPoints());
        std::vector<double> edges(points, 0.0), radius(points, kSkinShadingMm);
        std::vector<int> count(points, 0), rounds(points, 0);
        const auto at = [&](vtkIdType point) { return Eigen::Vector3d(data.GetPoint(point)); };
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto a = static_cast<std::size_t>(triangles[t][k]);
                edges[a] += (at(triangles[t][k]) - at(triangles[t][(k + 1) % 3])).norm();
                ++count[a];
                radius[a] = std::min(radius[a], radius_mm[t]);
            }
        for (std::size_t p = 0; p < points; ++p)
            if (edges[p] > 0.0)
                rounds[p] = std::min(
                    kMostRounds, static_cast<int>(std::lround(std::pow(radius[p] * count[p] / edges[p], 2))));
        return rounds;
    }

    /// Averages the normals. Points on sharp edges are double, and each half keeps to its side.
    void smooth_normals(vtkPolyData& data, const std::vector<double>& radius_mm)
    {
        auto* normals = vtkFloatArray::SafeDownCast(data.GetPointData()->GetNormals());
        if (normals == nullptr)
            return;
        const Triangles triangles = triangles_of(data);
        const std::vector<int> rounds = rounds_of(data, triangles, radius_mm);
        Eigen::Map<Eigen::Matrix<float, 3, Eigen::Dynamic>> now(
            normals->GetPointer(0), 3, static_cast<Eigen::Index>(data.GetNumberOfPoints()));
        Eigen::Matrix<float, 3, Eigen::Dynamic> next(3, now.cols());
        for (int round = 0; round < *std::max_element(rounds.begin(), rounds.end()); ++round) {
            next = now;
            for (const auto& t : triangles) {
                const Eigen::Vector3f sum = now.col(t[0]) + now.col(t[1]) + now.col(t[2]);
                for (const vtkIdType point : t)
                    next.col(point) += sum;
            }
            for (Eigen::Index point = 0; point < now.cols(); ++point)
                if (round < rounds[static_cast<std::size_t>(point)])
                    now.col(point) = next.col(point).normalized();
        }
    }

    vtkSmartPointer<vtkPolyData> with_normals(vtkPolyData* data)
    {
        auto normals = vtkSmartPointer<vtkPolyDataNormals>::New();
        normals->SetInputData(data);
        normals->SetFeatureAngle(kFeatureAngleDeg);
        normals->SplittingOn();
        normals->ConsistencyOff(); // keeps our orientation
        normals->AutoOrientNormalsOff();
        normals->Update();
        return normals->GetOutput();
    }

    /// The triangles of one part, with their points only.
    vtkSmartPointer<vtkPolyData> part_of(vtkPolyData& whole, int part)
    {
        auto* parts = vtkIntArray::SafeDownCast(whole.GetCellData()->GetArray(kPartArray));
        auto* normals = whole.GetPointData()->GetNormals();
        auto points = vtkSmartPointer<vtkPoints>::New();
        auto part_normals = vtkSmartPointer<vtkFloatArray>::New();
        part_normals->SetNumberOfComponents(3);
        auto cells = vtkSmartPointer<vtkCellArray>::New();
        std::vector<vtkIdType> new_id(static_cast<std::size_t>(whole.GetNumberOfPoints()), -1);
        auto corners = vtkSmartPointer<vtkIdList>::New();
        for (vtkIdType c = 0; c < whole.GetNumberOfCells(); ++c) {
            if (parts->GetValue(c) != part)
                continue;
            whole.GetCellPoints(c, corners);
            cells->InsertNextCell(3);
            for (int k = 0; k < 3; ++k) {
                vtkIdType& id = new_id[static_cast<std::size_t>(corners->GetId(k))];
                if (id < 0) {
                    id = points->InsertNextPoint(whole.GetPoint(corners->GetId(k)));
                    if (normals != nullptr)
                        part_normals->InsertNextTuple(corners->GetId(k), normals);
                }
                cells->InsertCellPoint(id);
            }
        }
        auto data = vtkSmartPointer<vtkPolyData>::New();
        data->SetPoints(points);
        data->SetPolys(cells);
        if (normals != nullptr)
            data->GetPointData()->SetNormals(part_normals);
        return data;
    }

    vtkSmartPointer<vtkActor> actor_of(vtkPolyData* data)
    {
        auto mapper = vtkSmartPointer<vtkOpenGLPolyDataMapper>::New();
        mapper->SetInputData(data);
        // Our shader needs coordinates in mm; VTK would shift and scale them.
        mapper->SetVBOShiftScaleMethod(0);
        auto actor = vtkSmartPointer<vtkActor>::New();
        actor->SetMapper(mapper);
        return actor;
    }

    using LookKey = std::array<double, 5>;
    LookKey key_of(const Look& look)
    {
        return { look.color.r, look.color.g, look.color.b, static_cast<double>(look.finish), look.texture };
    }

    /// Marks each triangle with the number of its look. Labels with the same look share one actor. @returns the looks
    std::vector<Look> mark_parts(vtkPolyData& data, const SurfaceItem& item)
    {
        auto parts = vtkSmartPointer<vtkIntArray>::New();
        parts->SetName(kPartArray);
        parts->SetNumberOfTuples(static_cast<vtkIdType>(item.mesh->triangles.size()));
        std::vector<Look> looks;
        std::map<LookKey, int> number_of;
        const bool by_label = !item.look_of_label.empty();
        for (std::size_t t = 0; t < item.mesh->triangles.size(); ++t) {
            const Look& look = by_label ? item.look_of_label.at(item.mesh->labels[t]) : item.look;
            const auto [entry, is_new] = number_of.try_emplace(key_of(look), static_cast<int>(looks.size()));
            if (is_new)
                looks.push_back(look);
            parts->SetValue(static_cast<vtkIdType>(t), entry->second);
        }
        data.GetCellData()->AddArray(parts);
        return looks;
    }

    /// The radius of shading for each triangle.
    std::vector<double> shading_radii(vtkPolyData& whole, const std::vector<Look>& looks)
    {
        auto* parts = vtkIntArray::SafeDownCast(whole.GetCellData()->GetArray(kPartArray));
        std::vector<double> radii;
        for (vtkIdType c = 0; c < whole.GetNumberOfCells(); ++c)
            radii.push_back(shading_radius(looks[static_cast<std::size_t>(parts->GetValue(c))]));
        return radii;
    }

} // namespace

std::vector<vtkSmartPointer<vtkActor>> surface_actors(const SurfaceItem& item)
{
    std::vector<vtkSmartPointer<vtkActor>> actors;
    if (item.mesh->triangles.empty() || item.opacity <= 0.0)
        return actors;
    vtkSmartPointer<vtkPolyData> whole = poly_data(*item.mesh, PointType::single_precision);
    const std::vector<Look> looks = mark_parts(*whole, item);
    if (item.smooth)
        whole = with_normals(whole);
    if (item.smooth)
        smooth_normals(*whole, shading_radii(*whole, looks));
    whole->BuildCells();
    for (std::size_t i = 0; i < looks.size(); ++i) {
        const vtkSmartPointer<vtkPolyData> part = looks.size() == 1 ? whole : part_of(*whole, static_cast<int>(i));
        vtkSmartPointer<vtkActor> actor = actor_of(part);
        actor->GetMapper()->SetScalarVisibility(0);
        apply_look(*actor, looks[i], item.target);
        vtkProperty& property = *actor->GetProperty();
        property.SetOpacity(item.opacity);
        property.SetBackfaceCulling(item.on_top ? 1 : 0); // a surface over everything is not sorted by depth
        property.SetInterpolation(item.smooth ? VTK_PHONG : VTK_FLAT);
        property.SetEdgeVisibility(item.show_edges ? 1 : 0);
        property.SetEdgeColor(0.15, 0.15, 0.15);
        actors.push_back(std::move(actor));
    }
    return actors;
}

vtkSmartPointer<vtkActor> line_actor(const LineItem& item, double picture_height_px)
{
    auto points = vtkSmartPointer<vtkPoints>::New();
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    cells->InsertNextCell(static_cast<int>(item.points.size()));
    for (const Vec3& p : item.points)
        cells->InsertCellPoint(points->InsertNextPoint(p.data()));
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetLines(cells);
    vtkSmartPointer<vtkActor> actor = actor_of(data);
    apply_look(*actor, { .color = item.color, .finish = Finish::unlit }, false);
    actor->GetProperty()->SetLineWidth(static_cast<float>(std::max(1.0, item.width_px * picture_height_px / 960.0)));
    actor->GetMapper()->SetResolveCoincidentTopologyToPolygonOffset();
    // Draws a line before the skin on which it lies.
    actor->GetMapper()->SetRelativeCoincidentTopologyLineOffsetParameters(-4.0, -4.0);
    return actor;
}

} // namespace retractor::ui
