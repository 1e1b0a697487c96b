#include "mesh/surface/surface_normals.h"

#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

namespace retractor::mesh {

Points vertex_normals(const TriMesh& surface)
{
    Points normals = Points::Zero(surface.vertices.rows(), 3);
    for (const auto& t : surface.triangles) {
        const Vec3 area = area_vector(surface.vertices, t);
        for (const VertexId v : t)
            normals.row(v) += area.transpose();
    }
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
        if (const double length = normals.row(v).norm(); length > 0.0)
            normals.row(v) /= length;
    return normals;
}

} // namespace retractor::mesh
