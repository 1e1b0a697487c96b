#include "mesh/surface/wound_surface.h"

#include "mesh/base/error.h"

#include <string>

namespace retractor::mesh {

namespace {

    void check_displacement(const TetMesh& mesh, const Points& displacement)
    {
        if (displacement.rows() == 0)
            return;
        if (displacement.rows() != mesh.vertices.rows())
            throw InputError("the displacement has " + std::to_string(displacement.rows()) + " rows, the mesh "
                + std::to_string(mesh.vertices.rows()) + " vertices");
        for (Eigen::Index v = 0; v < displacement.rows(); ++v)
            if (!displacement.row(v).allFinite())
                throw InputError("the displacement is not finite", "vertex " + std::to_string(v));
    }

    TetSurface surface_of_faces(const TetMesh& mesh, const Points& displacement, const std::vector<TetFace>& faces)
    {
        TetSurface out;
        std::vector<VertexId> number(mesh.vertex_count(), -1);
        for (const TetFace& face : faces)
            for (auto triangle : face_triangles(mesh, face)) {
                for (VertexId& v : triangle) {
                    VertexId& n = number[static_cast<std::size_t>(v)];
                    if (n < 0) {
                        n = static_cast<VertexId>(out.vertex_of.size());
                        out.vertex_of.push_back(v);
                    }
                    v = n;
                }
                out.surface.triangles.push_back(triangle);
                out.surface.labels.push_back(mesh.labels[static_cast<std::size_t>(face.tet)]);
            }
        out.surface.vertices.resize(static_cast<Eigen::Index>(out.vertex_of.size()), 3);
        for (std::size_t i = 0; i < out.vertex_of.size(); ++i) {
            auto row = out.surface.vertices.row(static_cast<Eigen::Index>(i));
            row = mesh.vertices.row(out.vertex_of[i]);
            if (displacement.rows() > 0)
                row += displacement.row(out.vertex_of[i]);
        }
        return out;
    }

} // namespace

TetSurface boundary_surface(const TetMesh& mesh, const Points& displacement)
{
    check_displacement(mesh, displacement);
    return surface_of_faces(mesh, displacement, boundary_faces(mesh));
}

TriMesh deformed_boundary(const TetMesh& mesh, const Points& displacement)
{
    return boundary_surface(mesh, displacement).surface;
}

TetSurface tissue_surface(const TetMesh& mesh, const Points& displacement, std::span<const Label> labels)
{
    check_displacement(mesh, displacement);
    std::vector<TetId> kept;
    std::vector<TetFace> faces = boundary_faces(part_with_labels(mesh, labels, &kept));
    for (TetFace& face : faces)
        face.tet = kept[static_cast<std::size_t>(face.tet)];
    return surface_of_faces(mesh, displacement, faces);
}

} // namespace retractor::mesh
