#include "ui/workstation/palpation/palpation_backend.h"

#include "fem/linear_algebra/sparse_cholesky.h"
#include "planner/session/tissue_choice.h"

namespace retractor::ui {

planner::PalpationBackend palpation_backend()
{
    return { planner::tissue_models(),
        [](const datasets::PalpationScene& scene, const planner::TissueWish& wish, const Job& job) {
            planner::TissueChoice choice;
            choice.model = wish.model;
            choice.fingers = wish.fingers;
            choice.radius_mm = wish.radius_mm;
            choice.depth_mm = wish.depth_mm;
            planner::ChosenTissue chosen = make_tissue(scene, choice, job);
            return planner::MadeTissue { std::move(chosen.response), std::move(chosen.notes) };
        } };
}

} // namespace retractor::ui
