#include "ui/scene/vtk/poly_data.h"

#include <vtkCellArray.h>
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

} // namespace retractor::ui
