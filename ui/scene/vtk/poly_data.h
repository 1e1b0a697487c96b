#pragma once
// A triangle mesh as VTK's filters and mappers take it.

#include "mesh/base/geometry.h"

#include <vtkSmartPointer.h>

class vtkPolyData;

namespace retractor::ui {

enum class PointType {
    single_precision, ///< what graphics cards take
    double_precision, ///< for filters: what comes back is the mesh again
};

/// Vertices (mm) and triangles alone. @pre triangles name vertices of the mesh.
vtkSmartPointer<vtkPolyData> poly_data(const TriMesh& mesh, PointType type);

} // namespace retractor::ui
