#include "ui/scene/simplify_surface.h"

#include "mesh/base/error.h"

#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSmartPointer.h>

#include <string>

namespace retractor {

TriMesh simplified(const TriMesh& surface, double share)
{
    if (!(share > 0.0 && share <= 1.0))
        throw InputError("the share of triangles to keep must lie between 0 and 1, not " + std::to_string(share));
    TriMesh result;
    if (share == 1.0 || surface.triangles.empty()) {
        result.vertices = surface.vertices;
        result.triangles = surface.triangles;
        return result;
    }
    if (!surface.vertices.allFinite())
        throw InputError("a coordinate is not finite");
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(surface.vertices.rows());
    for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
        points->SetPoint(v, surface.vertices(v, 0), surface.vertices(v, 1), surface.vertices(v, 2));
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    for (const auto& t : surface.triangles) {
        for (const VertexId v : t)
            if (v < 0 || v >= surface.vertices.rows())
                throw InputError("a corner is out of range", "vertex " + std::to_string(v));
        cells->InsertNextCell({ t[0], t[1], t[2] });
    }
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(cells);
    auto decimation = vtkSmartPointer<vtkQuadricDecimation>::New();
    decimation->SetInputData(data);
    decimation->SetTargetReduction(1.0 - share);
    decimation->VolumePreservationOn();
    decimation->Update();
    vtkPolyData& fewer = *decimation->GetOutput();
    result.vertices.resize(fewer.GetNumberOfPoints(), 3);
    for (vtkIdType v = 0; v < fewer.GetNumberOfPoints(); ++v)
        result.vertices.row(v) = Eigen::Map<const Eigen::RowVector3d>(fewer.GetPoint(v));
    auto corners = vtkSmartPointer<vtkIdList>::New();
    for (vtkIdType c = 0; c < fewer.GetNumberOfCells(); ++c) {
        fewer.GetCellPoints(c, corners);
        if (corners->GetNumberOfIds() == 3)
            result.triangles.push_back({ static_cast<VertexId>(corners->GetId(0)),
                static_cast<VertexId>(corners->GetId(1)), static_cast<VertexId>(corners->GetId(2)) });
    }
    return result;
}

} // namespace retractor
