#pragma once
// Converts a triangle mesh for VTK's filters and mappers.

#include "mesh/base/geometry.h"

#include <vtkSmartPointer.h>

class vtkPolyData;

namespace retractor::ui {

enum class PointType {
    single_precision, ///< as graphics cards take it
    double_precision, ///< for filters, so that a mesh survives unchanged
};

/// Vertices (mm) and triangles only. @pre triangles name vertices of the mesh
vtkSmartPointer<vtkPolyData> poly_data(const TriMesh& mesh, PointType type);

} // namespace retractor::ui
