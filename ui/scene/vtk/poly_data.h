#pragma once
// Converts triangle meshes for VTK's filters and mappers, and back.

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

/// The vertices and the triangles of the data; other cells are left out.
TriMesh tri_mesh(vtkPolyData& data);

} // namespace retractor::ui
