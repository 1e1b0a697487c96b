#include "haptics/spheres/sphere_tissue.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wall_shell.h"
#include "planner/session/tissue_choice.h"

namespace retractor::planner {

namespace {

    /// The boundary of the elements with one label (0: all elements).
    TriMesh surface_of(const mesh::TetMesh& body, Label label)
    {
        mesh::TetMesh part;
        part.vertices = body.vertices;
        for (std::size_t t = 0; t < body.tet_count(); ++t)
            if (label == 0 || body.labels[t] == label) {
                const auto nodes = body.tet(static_cast<TetId>(t));
                part.nodes.insert(part.nodes.end(), nodes.begin(), nodes.begin() + 4);
                part.labels.push_back(body.labels[t]);
            }
        return mesh::closed_surfaces(part);
    }

    struct MeanElasticity {
        double modulus = 0.0, ratio = 0.0;
    };

    MeanElasticity mean_elasticity(const datasets::ElasticModel& body, Label label)
    {
        MeanElasticity sum;
        double count = 0.0;
        for (std::size_t t = 0; t < body.mesh.tet_count(); ++t)
            if (label == 0 || body.mesh.labels[t] == label) {
                sum.modulus += body.youngs_modulus[t];
                sum.ratio += body.poissons_ratio[t];
                count += 1.0;
            }
        return { sum.modulus / count, sum.ratio / count };
    }

} // namespace

ChosenTissue make_spheres(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job)
{
    if (datasets::has_inner_wall(scene.body))
        throw InputError(
            "spheres fill solid organs, and this is a vessel with blood pressing in it: use the model fem or "
            "springs",
            scene.name + ", model spheres", { "model" });
    if (choice.fingers > haptics::SphereMotion::kMostFingers)
        throw InputError("spheres take at most " + std::to_string(haptics::SphereMotion::kMostFingers) + " fingers",
            "model spheres", { "model" });
    constexpr double kThinner = 0.75; // share of the first organ's radius, because walls are thin
    constexpr double kNearest = 0.2; // tolerance of the count, because a lattice adds whole layers at once
    haptics::SphereLaw law;
    law.fingers = choice.fingers;
    ChosenTissue chosen;
    std::vector<haptics::SphereOrgan> organs;
    const std::vector<datasets::TouchedOrgan> parts
        = scene.organs.empty() ? std::vector<datasets::TouchedOrgan> { { 0, scene.name } } : scene.organs;
    for (const datasets::TouchedOrgan& part : parts) {
        job.report("fill with spheres", static_cast<double>(organs.size()) / static_cast<double>(parts.size()));
        const TriMesh surface = surface_of(scene.body.mesh, part.label);
        haptics::SphereOrgan organ { part.name, surface,
            organs.empty() ? haptics::fill_with_count(surface, choice.spheres, kNearest)
                           : haptics::fill_with_spheres(surface, kThinner * organs.front().filling.radius),
            1.0 };
        const MeanElasticity mean = mean_elasticity(scene.body, part.label);
        organ.stiffness = haptics::calibrate_sphere_force(
            organ.filling.radius, law, mean.modulus, mean.ratio, choice.radius_mm, 0.5 * choice.radius_mm);
        chosen.notes.push_back(formatted("%s: %zu spheres of %.2f mm, as stiff as a half-space of %.4g MPa",
            part.name.c_str(), organ.filling.count(), organ.filling.radius, mean.modulus));
        organs.push_back(std::move(organ));
    }
    chosen.response = std::make_unique<haptics::SphereTissue>(std::move(organs), law);
    return chosen;
}

} // namespace retractor::planner
