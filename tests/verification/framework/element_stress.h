#pragma once
// The tension of a whole body, before any wall is cut out of it.

#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace retractor::verification {

/// The pre-stress of each element, MPa.
/// @param material_of_label, tension_of_label by label; labels without an entry in tension_of_label have no tension.
/// @throws InputError naming the label.
inline std::vector<Mat3> stress_of_elements(const mesh::TetMesh& mesh, std::span<const fem::Material> material_of_label,
    std::span<const fem::PreStrain> tension_of_label)
{
    const auto tension_of
        = [&](Label label) { return label < tension_of_label.size() ? tension_of_label[label] : fem::PreStrain {}; };
    const bool needs_normals = std::any_of(mesh.labels.begin(), mesh.labels.end(), [&](Label label) {
        const fem::PreStrain t = tension_of(label);
        return t.kind != fem::PreStrainKind::none && t.kind != fem::PreStrainKind::isotropic && t.normal.isZero();
    });
    const std::vector<Vec3> normals
        = needs_normals ? fem::surface_normals(mesh) : std::vector<Vec3>(mesh.tet_count(), Vec3::Zero());
    std::vector<Mat3> stresses;
    stresses.reserve(mesh.tet_count());
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
        const Label label = mesh.labels[t];
        const fem::PreStrain tension = tension_of(label);
        if (tension.kind == fem::PreStrainKind::none) {
            stresses.push_back(Mat3::Zero());
            continue;
        }
        if (label >= material_of_label.size())
            throw InputError("there is no material for tissue under tension", "label " + std::to_string(label));
        stresses.push_back(fem::pre_stress(tension, material_of_label[label], normals[t]));
    }
    return stresses;
}

} // namespace retractor::verification
