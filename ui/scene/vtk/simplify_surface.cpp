#include "ui/scene/vtk/simplify_surface.h"

#include "mesh/base/error.h"
#include "ui/scene/vtk/poly_data.h"

#include <vtkAdaptiveSubdivisionFilter.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSmartPointer.h>

#include <limits>
#include <string>

namespace retractor::ui {

namespace {

    vtkSmartPointer<vtkPolyData> checked(const TriMesh& surface)
    {
        if (!surface.vertices.allFinite())
            throw InputError("a coordinate is not finite");
        for (const auto& t : surface.triangles)
            for (const VertexId v : t)
                if (v < 0 || v >= surface.vertices.rows())
                    throw InputError("a corner is out of range", "vertex " + std::to_string(v));
        return poly_data(surface, PointType::double_precision);
    }

} // namespace

TriMesh simplified(const TriMesh& surface, double share)
{
    if (!(share > 0.0 && share <= 1.0))
        throw InputError("the share of triangles to keep must lie between 0 and 1, not " + std::to_string(share));
    if (share == 1.0 || surface.triangles.empty()) {
        TriMesh result;
        result.vertices = surface.vertices;
        result.triangles = surface.triangles;
        return result;
    }
    auto decimation = vtkSmartPointer<vtkQuadricDecimation>::New();
    decimation->SetInputData(checked(surface));
    decimation->SetTargetReduction(1.0 - share);
    decimation->VolumePreservationOn();
    decimation->Update();
    return tri_mesh(*decimation->GetOutput());
}

TriMesh with_edges_at_most(const TriMesh& surface, double longest_mm)
{
    if (!(longest_mm > 0.0))
        throw InputError("the longest edge must be positive, not " + std::to_string(longest_mm));
    auto subdivision = vtkSmartPointer<vtkAdaptiveSubdivisionFilter>::New();
    subdivision->SetInputData(checked(surface));
    subdivision->SetMaximumEdgeLength(longest_mm);
    subdivision->SetMaximumTriangleArea(std::numeric_limits<double>::max());
    subdivision->Update();
    return tri_mesh(*subdivision->GetOutput());
}

} // namespace retractor::ui
