#pragma once
// Chooses the tissue model: turns a palpation scene into a TissueResponse. Units mm, N, MPa, s.

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
    double radius_mm = 4.0, depth_mm = 2.0; ///< radius of a fingertip, and intended depth of a press
    double force_gain = 1.0; ///< fem: applied by the tissue; other models: applied by the servo
    double heart_rate_per_min = 0.0; ///< 0: the scene's
    std::filesystem::path pressure_csv = {}; ///< empty: the built-in curve between the scene's pressures
    double calibration = 0.0; ///< springs: factor on their stiffness; 0: measured against ten-node elements
    std::size_t spheres = 1880; ///< number of spheres in the first organ; 1880 as in Suzuki et al.
};

/// A tissue, and remarks about it for the user.
struct ChosenTissue {
    std::unique_ptr<haptics::TissueResponse> response;
    std::vector<std::string> notes;
};

/// The models that make_tissue() knows.
const std::vector<std::string>& tissue_models();

/// Label of an organ's triangles in the tissue's surface. Spheres number their organs from 1; elements keep the scene's
/// labels.
Label surface_label(const datasets::PalpationScene& scene, std::size_t organ, const haptics::TissueResponse& tissue);

haptics::PulsePressure pulse_of(const datasets::PalpationScene& scene, const TissueChoice& choice);
haptics::CondensedOptions condensed_options(const datasets::PalpationScene& scene, const TissueChoice& choice);

/// @throws InputError on a model that is not in tissue_models(), or naming the reason when the model cannot serve the
/// scene; and as the tissues
ChosenTissue make_tissue(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);

/// Makes springs of the body's edges, refined until fingertips cannot fall through between particles near the scene's
/// sites. A scene that represents a sheet of springs becomes this sheet. Where a tick would need more than four steps,
/// the particles are made heavier; slow presses feel the same.
ChosenTissue make_springs(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);
/// Calibration factor of springs: the force of ten-node elements divided by the force of springs with calibration 1,
/// when a rigid fingertip presses the scene's first site by at most three quarters of its radius.
double measured_calibration(const datasets::PalpationScene& scene, double radius_mm, double depth_mm, const Job& job);

/// Fills the body's organs with spheres: `choice.spheres` in the first organ, and spheres of three quarters of that
/// radius in the others. Each organ has the force of a half-space with its mean elasticity.
/// @throws InputError on a vessel under blood pressure
ChosenTissue make_spheres(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job);

} // namespace retractor::planner
