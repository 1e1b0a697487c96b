#pragma once
// Which tissue answers the fingers: the one place where a palpation scene becomes a TissueResponse.

#include "datasets/elastic_model.h"
#include "haptics/condensed_tissue.h"
#include "haptics/tissue_response.h"
#include "mesh/base/job.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace retractor::cli {

struct TissueChoice {
    std::string model = "fem";
    std::string element = "p2"; ///< fem: p1, locking-free or p2
    std::string fingertip = "pad"; ///< fem: pad, sphere or held
    std::size_t fingers = 1;
    double force_gain = 1.0;
    double heart_rate_per_min = 0.0; ///< 0: the scene's
    std::filesystem::path pressure_csv; ///< empty: the built-in curve between the scene's pressures
};

/// The models that make_tissue() knows.
const std::vector<std::string>& tissue_models();

PulsePressure pulse_of(const PalpationScene& scene, const TissueChoice& choice);
CondensedOptions condensed_options(const PalpationScene& scene, const TissueChoice& choice);

/// @throws InputError on a model that is not among tissue_models(), and as the tissues do.
std::unique_ptr<TissueResponse> make_tissue(const PalpationScene& scene, const TissueChoice& choice, const Job& job);

} // namespace retractor::cli
