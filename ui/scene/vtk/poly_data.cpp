#include "ui/scene/vtk/poly_data.h"

#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

namespace retractor::ui {

vtkSmartPointer<vtkPolyData> poly_data(const TriMesh& mesh, PointType type)
{
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataType(type == PointType::single_precision ? VTK_FLOAT : VTK_DOUBLE);
    points->SetNumberOfPoints(mesh.vertices.rows());
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        points->SetPoint(v, mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    cells->AllocateExact(
        static_cast<vtkIdType>(mesh.triangles.size()), static_cast<vtkIdType>(3 * mesh.triangles.size()));
    for (const auto& t : mesh.triangles)
        cells->InsertNextCell({ t[0], t[1], t[2] });
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(cells);
    return data;
}

TriMesh tri_mesh(vtkPolyData& data)
{
    TriMesh surface;
    surface.vertices.resize(data.GetNumberOfPoints(), 3);
    for (vtkIdType v = 0; v < data.GetNumberOfPoints(); ++v)
        surface.vertices.row(v) = Eigen::Map<const Eigen::RowVector3d>(data.GetPoint(v));
    auto corners = vtkSmartPointer<vtkIdList>::New();
    for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
        data.GetCellPoints(c, corners);
        if (corners->GetNumberOfIds() == 3)
            surface.triangles.push_back({ static_cast<VertexId>(corners->GetId(0)),
                static_cast<VertexId>(corners->GetId(1)), static_cast<VertexId>(corners->GetId(2)) });
    }
    return surface;
}

} // namespace retractor::ui
