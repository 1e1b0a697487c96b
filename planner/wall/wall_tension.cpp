#include "planner/wall/wall_tension.h"

#include "fem/model/pre_strain.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::planner {

namespace {

    std::vector<Label> skin_labels(const mesh::LabelTable& table)
    {
        std::vector<Label> labels;
        for (const mesh::LabelInfo& info : table)
            if (info.material == "skin")
                labels.push_back(info.id);
        return labels;
    }

    std::vector<Vec3> tissue_normals(
        const mesh::TetMesh& uncut, const mesh::LabelTable& table, std::span<const VertexId> held, const Vec3& outward)
    {
        const std::vector<Label> skin = skin_labels(table);
        std::vector<Vec3> normals = skin.empty() ? std::vector<Vec3>(uncut.tet_count(), Vec3::Zero())
                                                 : fem::surface_normals(uncut, skin, held);
        for (Vec3& normal : normals)
            if (normal.isZero())
                normal = outward;
        return normals;
    }

    /// An isotropic pre-strain also pulls through the tissue.
    bool lies_in_a_plane(const fem::PreStrain& tension) { return tension.kind != fem::PreStrainKind::isotropic; }

    bool points_through(const fem::PreStrain& tension, const Vec3& normal)
    {
        const double sine = std::sin(kThroughTissueDeg * std::numbers::pi / 180.0);
        return fem::needs_pull(tension)
            && tension.pull.cross(normal).norm() < sine * tension.pull.norm() * normal.norm();
    }

    /// The mean of the two stresses in the tissue's plane, along and across any pull, acting in all directions of the
    /// plane.
    Mat3 mean_stress(fem::PreStrain tension, const fem::Material& material, const Vec3& normal)
    {
        tension.pull = normal.unitOrthogonal();
        const Mat3 stress = fem::pre_stress(tension, material, normal);
        const Vec3 n = normal.normalized();
        return 0.5 * stress.trace() * (Mat3::Identity() - n * n.transpose());
    }

    std::string vector_text(const Vec3& v)
    {
        return "(" + in_words(v.x(), 3) + ", " + in_words(v.y(), 3) + ", " + in_words(v.z(), 3) + ")";
    }

} // namespace

bool under_tension(const fem::Material& material)
{
    const fem::PreStrain& tension = material.pre_strain;
    return tension.kind != fem::PreStrainKind::none && (tension.strain != 0.0 || tension.across != 0.0);
}

bool under_tension(std::span<const fem::Material> materials)
{
    return std::any_of(
        materials.begin(), materials.end(), [](const fem::Material& material) { return under_tension(material); });
}

WallTension wall_tension(const mesh::TetMesh& uncut, std::span<const fem::Material> material_of_label,
    const mesh::LabelTable& table, std::span<const VertexId> held, const Vec3& outward)
{
    WallTension tension;
    if (!under_tension(material_of_label))
        return tension;
    const std::vector<Vec3> normals = tissue_normals(uncut, table, held, outward);
    RETRACTOR_ASSERT(normals.size() == uncut.tet_count());
    const bool no_skin = skin_labels(table).empty();
    tension.stress_of_element.reserve(uncut.tet_count());
    tension.without_direction.assign(uncut.tet_count(), 0);
    for (std::size_t t = 0; t < uncut.tet_count(); ++t) {
        if (uncut.labels[t] >= material_of_label.size())
            throw InputError("there is no material for it", "label " + std::to_string(uncut.labels[t]));
        const fem::Material& material = material_of_label[uncut.labels[t]];
        const fem::PreStrain& strain = material.pre_strain;
        const bool own_normal = !strain.normal.isZero(0.0);
        const Vec3& normal = own_normal ? strain.normal : normals[t];
        const bool through = points_through(strain, normal);
        tension.without_direction[t] = through ? 1 : 0;
        tension.without_skin |= no_skin && under_tension(material) && !own_normal && lies_in_a_plane(strain);
        tension.stress_of_element.push_back(
            through ? mean_stress(strain, material, normal) : fem::pre_stress(strain, material, normal));
    }
    return tension;
}

ReleasedTension released_tension(const mesh::TetMesh& wall, std::span<const TetId> origin,
    std::span<const mesh::TetFace> wound, const WallTension& tension)
{
    ReleasedTension released;
    if (tension.stress_of_element.empty())
        return released;
    RETRACTOR_ASSERT(origin.size() == wall.tet_count());
    RETRACTOR_ASSERT(tension.without_direction.size() == tension.stress_of_element.size());
    std::vector<Mat3> stresses;
    stresses.reserve(origin.size());
    for (const TetId t : origin)
        stresses.push_back(tension.stress_of_element.at(static_cast<std::size_t>(t)));
    released.tractions = fem::released_tractions(wall, wound, stresses);
    for (const mesh::TetFace& face : wound)
        released.without_direction
            += tension.without_direction[static_cast<std::size_t>(origin[static_cast<std::size_t>(face.tet)])];
    return released;
}

std::string pre_strain_text(const fem::PreStrain& tension)
{
    const auto percent = [](double strain) { return in_words(100.0 * strain, 1) + " %"; };
    const std::string along = percent(tension.strain);
    switch (tension.kind) {
    case fem::PreStrainKind::none:
        return "none";
    case fem::PreStrainKind::uniaxial_stress:
        return along + " along " + vector_text(tension.pull) + ", free to narrow";
    case fem::PreStrainKind::held_width:
        return along + " along " + vector_text(tension.pull) + ", 0 % across";
    case fem::PreStrainKind::biaxial:
        if (tension.strain == tension.across)
            return along + " both ways";
        return along + " along " + vector_text(tension.pull) + ", " + percent(tension.across) + " across";
    case fem::PreStrainKind::equibiaxial:
        return along + " both ways";
    case fem::PreStrainKind::isotropic:
        return along + " every way";
    }
    return {};
}

} // namespace retractor::planner
