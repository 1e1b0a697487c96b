#include "ui/workstation/conference/presentation.h"

#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/verdict.h"

#include <algorithm>

namespace retractor::ui {

namespace {

    std::string percent(double share) { return formatted("%.0f %%", 100.0 * share); }

    std::string cut_text(const planner::Approach& approach)
    {
        return formatted("The incision is %.0f mm long. The target: ", planner::incision_length(approach))
            + readable(planner::target_name(approach.target)) + ".";
    }

    std::string depth_text(const planner::Approach& approach)
    {
        std::string text = formatted("The blade goes %.0f mm deep.", approach.depth_mm);
        if (approach.division.extent == planner::DivisionExtent::full)
            text += " Intercostal muscle and pleura are divided beyond the skin.";
        else if (planner::divides_sternum(approach.division.extent))
            text += " The sternum is sawn across under the skin.";
        return text;
    }

    std::string opened_text(const planner::FieldMetrics& field)
    {
        std::string text;
        for (const std::string& sentence : planner::verdict_of(field).sentences)
            if (!sentence.starts_with("Shows")) // the next step says it
                text += (text.empty() ? "" : " ") + sentence;
        return text;
    }

    std::string seen_text(const planner::FieldMetrics& field)
    {
        std::string text = "The best eye sees " + percent(field.seen_best_eye) + " of the " + readable(field.target)
            + "; two instruments reach " + percent(field.reached_by_two_instruments) + ", a finger touches "
            + percent(field.reached_by_finger) + ".";
        if (!field.best_eye.hidden_by.empty()) {
            const planner::SightBlocker& most = field.best_eye.hidden_by.front();
            text += " Most is hidden by " + readable(most.name) + " (" + percent(most.share) + ").";
        }
        if (!field.estimated.empty())
            text += " Estimated, not seen in the image: " + readable(field.estimated.front())
                + (field.estimated.size() > 1 ? " and others." : ".");
        return text;
    }

    void add_steps(std::vector<PresentationStep>& steps, const SessionModel& model, std::size_t index)
    {
        const planner::Approach& approach = model.approach(index);
        const ApproachState& state = model.state(index);
        const std::string name = planner::spoken_name(approach);
        steps.push_back({ index, ViewPreset::overview, false, name, cut_text(approach) });
        if (state.closed != nullptr && !state.closed->incision_slices.empty())
            steps.push_back({ index, ViewPreset::incision, false, name + ": what the blade passes", depth_text(approach) });
        if (state.field == nullptr)
            return;
        const planner::FieldMetrics& field = state.field->metrics;
        steps.push_back({ index, ViewPreset::overview, true, name + ": opened", opened_text(field) });
        steps.push_back(
            { index, ViewPreset::surgeon, true, name + ": what the surgeon sees", seen_text(field) });
    }

    std::string best_of(const SessionModel& model)
    {
        const std::vector<std::size_t> planned = model.planned();
        const auto best = std::max_element(planned.begin(), planned.end(), [&](std::size_t a, std::size_t b) {
            return model.state(a).field->metrics.seen_best_eye < model.state(b).field->metrics.seen_best_eye;
        });
        const planner::FieldMetrics& field = model.state(*best).field->metrics;
        std::string text = "Most of the target is seen through " + planner::spoken_name(model.approach(*best)) + " ("
            + percent(field.seen_best_eye) + ").";
        if (model.decisions().choices.empty())
            return text + " Nothing is chosen yet.";
        const planner::Choice& choice = model.decisions().choices.back();
        return text + " "
            + planner::choice_sentence(choice, planner::chosen_name(model.planned_case(), choice));
    }

} // namespace

std::vector<PresentationStep> presentation_of(const SessionModel& model)
{
    std::vector<PresentationStep> steps;
    for (std::size_t index = 0; index < model.approach_count(); ++index)
        add_steps(steps, model, index);
    if (model.planned().size() > 1)
        steps.push_back({ std::nullopt, ViewPreset::compare, true, "Comparison", best_of(model) });
    if (steps.empty())
        steps.push_back({ std::nullopt, ViewPreset::overview, false, "The patient", "There is no approach yet." });
    return steps;
}

} // namespace retractor::ui
