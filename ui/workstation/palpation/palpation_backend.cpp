#include "ui/workstation/palpation/palpation_backend.h"

#include "fem/linear_algebra/sparse_cholesky.h"
#include "planner/session/tissue_choice.h"

namespace retractor {

PalpationBackend palpation_backend()
{
    return { tissue_models(), [](const PalpationScene& scene, const TissueWish& wish, const Job& job) {
                TissueChoice choice;
                choice.model = wish.model;
                choice.fingers = wish.fingers;
                choice.radius_mm = wish.radius_mm;
                choice.depth_mm = wish.depth_mm;
                ChosenTissue chosen = make_tissue(scene, choice, job);
                return MadeTissue { std::move(chosen.response), std::move(chosen.notes) };
            } };
}

} // namespace retractor
