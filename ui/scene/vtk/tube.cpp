#include "ui/scene/vtk/tube.h"

#include "mesh/base/error.h"
#include "ui/scene/vtk/poly_data.h"

#include <vtkCellArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>
#include <vtkTubeFilter.h>

#include <string>

namespace retractor::ui {

TriMesh tube(const std::vector<Vec3>& line, double radius_mm)
{
    constexpr int kSides = 10;
    constexpr double kSamePlaceMm = 1e-6;
    if (!(radius_mm > 0.0))
        throw InputError("the radius of a tube must be positive, not " + std::to_string(radius_mm));
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataType(VTK_DOUBLE);
    Vec3 last = Vec3::Zero();
    for (const Vec3& p : line) {
        if (!p.allFinite())
            throw InputError("a coordinate is not finite");
        if (points->GetNumberOfPoints() > 0 && (p - last).norm() < kSamePlaceMm)
            continue;
        points->InsertNextPoint(p.data());
        last = p;
    }
    if (points->GetNumberOfPoints() < 2)
        return {};
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    cells->InsertNextCell(static_cast<int>(points->GetNumberOfPoints()));
    for (vtkIdType n = 0; n < points->GetNumberOfPoints(); ++n)
        cells->InsertCellPoint(n);
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetLines(cells);
    auto filter = vtkSmartPointer<vtkTubeFilter>::New();
    filter->SetInputData(data);
    filter->SetRadius(radius_mm);
    filter->SetNumberOfSides(kSides);
    filter->CappingOn();
    auto triangles = vtkSmartPointer<vtkTriangleFilter>::New();
    triangles->SetInputConnection(filter->GetOutputPort());
    triangles->Update();
    return tri_mesh(*triangles->GetOutput());
}

} // namespace retractor::ui
