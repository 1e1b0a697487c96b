#include "fem/model/pre_strain.h"

#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::fem {

namespace {

    constexpr double kParallel = 1e-6; // sine of the angle below which a pull lies along the normal

    Vec3 unit(const Vec3& v, const char* what)
    {
        const double length = v.norm();
        if (!(length > 0.0 && std::isfinite(length)))
            throw InputError(std::string(what) + " of a pre-strain is needed and must be finite", "pre-strain");
        return v / length;
    }

    /// The pull as a unit vector, projected into the plane when there is a normal.
    Vec3 pull_in_plane(const PreStrain& tension, const Vec3& normal)
    {
        const Vec3 pull = unit(tension.pull, "the pull");
        if (normal.isZero())
            return pull;
        const Vec3 flat = pull - normal * normal.dot(pull);
        if (flat.norm() < kParallel)
            throw InputError("the pull of a pre-strain lies along the normal of the tissue", "pre-strain");
        return flat.normalized();
    }

    /// Hooke's law in plane stress, with strains `along` the pull and `across` the pull.
    Mat3 plane_stress(
        const PreStrain& tension, double along, double across, const Material& material, const Vec3& normal)
    {
        const double E = material.youngs_modulus_MPa, nu = material.poissons_ratio;
        const Vec3 n = unit(normal, "the normal");
        const Mat3 plane = Mat3::Identity() - n * n.transpose();
        const double stiffness = E / (1.0 - nu * nu), s1 = stiffness * (along + nu * across),
                     s2 = stiffness * (across + nu * along);
        if (along == across)
            return s1 * plane;
        const Vec3 pull = pull_in_plane(tension, n);
        return s2 * plane + (s1 - s2) * pull * pull.transpose();
    }

    std::vector<std::vector<TetId>> elements_round_corners(const mesh::TetMesh& mesh)
    {
        std::vector<std::vector<TetId>> around(mesh.vertex_count());
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (std::size_t i = 0; i < 4; ++i)
                around[static_cast<std::size_t>(mesh.tet(t)[i])].push_back(t);
        return around;
    }

    void must_match(const mesh::TetMesh& mesh, std::span<const Mat3> stresses)
    {
        if (stresses.size() != mesh.tet_count())
            throw InputError("there must be one pre-stress per element: " + std::to_string(stresses.size()) + " for "
                    + std::to_string(mesh.tet_count()),
                "pre-stress");
        for (std::size_t t = 0; t < stresses.size(); ++t)
            if (!stresses[t].allFinite())
                throw InputError("a tension must be finite", "tension of element " + std::to_string(t));
    }

} // namespace

bool needs_pull(const PreStrain& tension)
{
    return tension.kind == PreStrainKind::uniaxial_stress || tension.kind == PreStrainKind::held_width
        || (tension.kind == PreStrainKind::biaxial && tension.strain != tension.across);
}

void check_pre_strain(const PreStrain& tension)
{
    const auto in_range = [](double strain, const char* where) {
        if (!(strain >= 0.0 && strain <= kLargestPreStrain))
            throw InputError("a pre-strain must lie between 0 and " + std::to_string(kLargestPreStrain) + ", not "
                    + std::to_string(strain),
                where);
    };
    const auto direction = [](const Vec3& v, const char* where) {
        if (!v.allFinite())
            throw InputError("a direction must be finite", where);
    };
    if (tension.kind == PreStrainKind::none)
        return;
    in_range(tension.strain, "along");
    if (tension.kind == PreStrainKind::biaxial)
        in_range(tension.across, "across");
    direction(tension.pull, "direction");
    direction(tension.normal, "normal");
    if (needs_pull(tension) && tension.pull.isZero(0.0))
        throw InputError("the pull of a pre-strain is needed: a direction that is not zero", "direction");
    if (needs_pull(tension) && !tension.normal.isZero(0.0))
        try {
            (void)pull_in_plane(tension, tension.normal.normalized());
        } catch (const InputError& error) {
            throw InputError(error.what(), "normal");
        }
}

Mat3 pre_stress(const PreStrain& tension, const Material& material, const Vec3& normal_there)
{
    if (tension.kind == PreStrainKind::none)
        return Mat3::Zero();
    check_material(material);
    try {
        check_pre_strain(tension);
    } catch (const InputError& error) {
        throw InputError(error.what(), "material '" + material.name + "', pre-strain, " + error.where());
    }
    const double e = tension.strain, E = material.youngs_modulus_MPa, nu = material.poissons_ratio;
    const Vec3 given = tension.normal.isZero() ? normal_there : tension.normal;
    const Vec3 normal = given.isZero() ? Vec3(Vec3::Zero()) : unit(given, "the normal");
    switch (tension.kind) {
    case PreStrainKind::uniaxial_stress: {
        const Vec3 pull = pull_in_plane(tension, normal);
        return E * e * pull * pull.transpose();
    }
    case PreStrainKind::held_width:
        return plane_stress(tension, e, 0.0, material, normal);
    case PreStrainKind::biaxial:
        return plane_stress(tension, e, tension.across, material, normal);
    case PreStrainKind::equibiaxial:
        return plane_stress(tension, e, e, material, normal);
    default:
        return E * e / (1.0 - 2.0 * nu) * Mat3::Identity();
    }
}

std::vector<Vec3> surface_normals(
    const mesh::TetMesh& mesh, std::span<const Label> seeds, std::span<const VertexId> held)
{
    std::vector<bool> is_held(mesh.vertex_count(), false);
    for (const VertexId v : held)
        is_held.at(static_cast<std::size_t>(v)) = true;
    const auto is_free = [&](const mesh::TetFace& face) {
        const auto corners = mesh::face_vertices(mesh, face);
        return std::any_of(
            corners.begin(), corners.end(), [&](VertexId v) { return !is_held[static_cast<std::size_t>(v)]; });
    };
    const auto seeded = [&](TetId t) {
        const Label label = mesh.labels[static_cast<std::size_t>(t)];
        return seeds.empty() || std::find(seeds.begin(), seeds.end(), label) != seeds.end();
    };
    const auto carries = [&](TetId from, TetId to) {
        return !seeds.empty()
            || mesh.labels[static_cast<std::size_t>(from)] == mesh.labels[static_cast<std::size_t>(to)];
    };
    std::vector<Vec3> sum(mesh.tet_count(), Vec3::Zero());
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
        if (seeded(face.tet) && is_free(face))
            sum[static_cast<std::size_t>(face.tet)] += area_vector(mesh.vertices, mesh::face_vertices(mesh, face));
    const auto around = elements_round_corners(mesh);
    std::vector<bool> known(mesh.tet_count());
    std::vector<TetId> front;
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (sum[static_cast<std::size_t>(t)].norm() > 0.0)
            front.push_back(t);
    const auto settle = [&](const std::vector<TetId>& ring) {
        for (const TetId t : ring) {
            known[static_cast<std::size_t>(t)] = true;
            if (Vec3& s = sum[static_cast<std::size_t>(t)]; s.norm() > 0.0)
                s.normalize();
        }
    };
    settle(front);
    while (!front.empty()) { // ring by ring: an element of a ring takes the mean of its known neighbours
        std::vector<TetId> next;
        for (const TetId t : front)
            for (std::size_t i = 0; i < 4; ++i)
                for (const TetId other : around[static_cast<std::size_t>(mesh.tet(t)[i])]) {
                    const auto o = static_cast<std::size_t>(other);
                    if (known[o] || !carries(t, other))
                        continue;
                    if (sum[o].isZero())
                        next.push_back(other);
                    sum[o] += sum[static_cast<std::size_t>(t)];
                }
        std::sort(next.begin(), next.end()); // an element whose sum became zero again is listed twice
        next.erase(std::unique(next.begin(), next.end()), next.end());
        settle(next);
        front = std::move(next);
    }
    return sum;
}

std::vector<FaceTraction> released_tractions(
    const mesh::TetMesh& mesh, std::span<const mesh::TetFace> lips, std::span<const Mat3> stresses)
{
    must_match(mesh, stresses);
    std::vector<FaceTraction> tractions;
    tractions.reserve(lips.size());
    for (const mesh::TetFace& face : lips) {
        if (face.tet < 0 || static_cast<std::size_t>(face.tet) >= mesh.tet_count() || face.corner < 0
            || face.corner > 3)
            throw InputError("the lip has a face that is not in the mesh", "element " + std::to_string(face.tet));
        const Mat3& stress = stresses[static_cast<std::size_t>(face.tet)];
        if (!stress.isZero(0.0))
            tractions.push_back({ face, -(stress * unit_normal(mesh.vertices, mesh::face_vertices(mesh, face))) });
    }
    return tractions;
}

} // namespace retractor::fem
