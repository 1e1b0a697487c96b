#include "ui/workstation/conference/presentation.h"

#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/comparison.h"
#include "planner/measures/verdict.h"

#include <string_view>

namespace retractor::ui {

namespace {

    std::string percent(double share) { return formatted("%.0f %%", 100.0 * share); }

    std::string cut_text(const planner::Approach& approach)
    {
        return formatted("The incision is %.0f mm long. The target: ", planner::incision_length(approach))
            + readable(planner::target_name(approach.target)) + ".";
    }

    std::string depth_text(const planner::Approach& approach, const FieldPictures* field)
    {
        const std::string depth = formatted("The blade goes %.0f mm deep.", approach.depth_mm);
        if (field != nullptr && field->metrics.division) { // what was done
            const std::string done = field->metrics.division->words;
            return done.empty() ? depth : depth + " Division: " + done + ".";
        }
        if (approach.division.extent == planner::DivisionExtent::full)
            return depth + " Intercostal muscle and pleura are to be divided beyond the skin.";
        if (planner::divides_sternum(approach.division.extent))
            return depth + " The sternum is to be sawn across under the skin.";
        return depth;
    }

    std::string opened_text(const planner::FieldMetrics& field)
    {
        std::string text;
        for (const std::string& sentence : planner::verdict_of(field).sentences)
            text += (text.empty() ? "" : " ") + sentence;
        return text;
    }

    std::string seen_text(const planner::FieldMetrics& field)
    {
        if (const std::string why = planner::why_not_to_use(field); !why.empty())
            return why;
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
            steps.push_back({ index, ViewPreset::incision, false, name + ": what the blade passes",
                depth_text(approach, state.field.get()) });
        if (state.field == nullptr)
            return;
        const planner::FieldMetrics& field = state.field->metrics;
        steps.push_back({ index, ViewPreset::overview, true, name + ": opened", opened_text(field) });
        steps.push_back({ index, ViewPreset::surgeon, true, name + ": what the surgeon sees", seen_text(field) });
    }

    /// Which approach shows most, where one leads beyond the error; and what is chosen.
    std::string comparison_text(const SessionModel& model)
    {
        const std::vector<std::size_t> planned = model.planned();
        std::vector<planner::FieldMetrics> fields;
        for (const std::size_t index : planned)
            fields.push_back(model.state(index).field->metrics);
        std::string text = "No approach leads in what is seen by more than the error.";
        if (!planner::have_one_target(fields))
            text = planner::kDifferentTargets;
        else
            for (const planner::ComparedMeasure& measure : planner::compared_measures(fields))
                if (std::string_view(measure.metric->key) == "seen_best_eye" && measure.leader)
                    text = "Most of the target is seen through "
                        + planner::spoken_name(model.approach(planned.at(*measure.leader))) + " ("
                        + percent(fields.at(*measure.leader).seen_best_eye) + ").";
        if (model.decisions().choices.empty())
            return text + " Nothing is chosen yet.";
        const planner::Choice& choice = model.decisions().choices.back();
        return text + " " + planner::choice_sentence(choice, planner::chosen_name(model.planned_case(), choice));
    }

} // namespace

std::vector<PresentationStep> presentation_of(const SessionModel& model)
{
    std::vector<PresentationStep> steps;
    for (std::size_t index = 0; index < model.approach_count(); ++index)
        add_steps(steps, model, index);
    if (model.planned().size() > 1)
        steps.push_back({ std::nullopt, ViewPreset::compare, true, "Comparison", comparison_text(model) });
    if (steps.empty())
        steps.push_back({ std::nullopt, ViewPreset::overview, false, "The patient", "There is no approach yet." });
    return steps;
}

} // namespace retractor::ui
