#pragma once
// Which tissue answers the fingers: the one place where a palpation scene becomes a TissueResponse.

#include "datasets/phantoms/elastic_model.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/servo/tissue_response.h"
#include "mesh/base/job.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace retractor::planner {

struct TissueChoice {
    std::string model = "fem";
    std::string element = "p2"; ///< fem: p1, locking-free or p2
    std::string fingertip = "pad"; ///< fem: pad, sphere or held
    std::size_t fingers = 1;
    double radius_mm = 4.0, depth_mm = 2.0; ///< of a fingertip; how deep it is meant to press
    double force_gain = 1.0; ///< fem: its own; the servo's for the others
    double heart_rate_per_min = 0.0; ///< 0: the scene's
    std::filesystem::path pressure_csv = {}; ///< empty: the built-in curve between the scene's pressures
    double calibration = 0.0; ///< springs: factor of their stiffness; 0: measured against ten-node elements
    std::size_t spheres = 1880; ///< spheres in the (first) organ: the source's
};

/// A tissue, and what is to be said of it beside its forces.
struct ChosenTissue {
    std::unique_ptr<haptics::TissueResponse> response;
    std::vector<std::string> notes;
};

/// The models that make_tissue() knows.
const std::vector<std::string>& tissue_models();

/// Of an organ's triangles in the tissue's surface: spheres number their organs from 1, elements keep the scene's
/// labels.
Label surface_label(const datasets::PalpationScene& scene, std::size_t organ, const haptics::TissueResponse& tissue);

haptics::PulsePressure pulse_of(const datasets::PalpationScene& scene, const TissueChoice& choice);
haptics::CondensedOptions condensed_options(const datasets::PalpationScene& scene, const TissueChoice& choice);

/// @throws InputError on a model that is not among tissue_models(), or that cannot serve the scene, saying why; and as
/// the tissues do.
ChosenTissue make_tissue(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);

/// The body's edges as springs, refined until fingertips cannot fall through between particles near the scene's sites;
/// a scene that stands for a sheet of springs is that sheet. Particles are made heavier where a tick would need more
/// than four steps: what is pressed slowly is answered alike.
ChosenTissue make_springs(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);
/// Force of ten-node elements over that of springs (calibration 1) when a rigid fingertip presses the scene's first
/// site, at most by three quarters of its radius.
double measured_calibration(const datasets::PalpationScene& scene, double radius_mm, double depth_mm, const Job& job);

/// The body's organs filled with spheres: `choice.spheres` in the first, three quarters of that radius in the others.
/// Each has the force of a half-space of its mean elasticity. @throws InputError on a vessel that blood presses on.
ChosenTissue make_spheres(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);

} // namespace retractor::planner
