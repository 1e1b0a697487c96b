#include "planner/decision/presentation.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/comparison.h"
#include "planner/measures/sight/finger_text.h"
#include "planner/measures/verdict.h"

#include <algorithm>
#include <string_view>

namespace retractor::planner {

namespace {

    std::string percent(double share) { return formatted("%.0f %%", 100.0 * share); }

    std::string incision_text(const Approach& approach)
    {
        return formatted("The incision is %.0f mm long. The target: ", incision_length(approach))
            + readable(target_name(approach.target)) + ".";
    }

    std::string depth_text(const Approach& approach)
    {
        return formatted("The blade goes %.0f mm deep.", approach.depth_mm);
    }

    std::string cut_text(const Approach& approach, const PresentedApproach& known)
    {
        const FieldMetrics* field = known.field;
        std::string text = "The red sheet is the cut.";
        if (!known.divided_bones.empty()) {
            std::vector<std::string> bones;
            for (const std::string& bone : known.divided_bones)
                bones.push_back(readable(bone));
            text += " Sawn through: " + joined(bones) + ".";
        }
        if (field != nullptr && field->division) { // what was done
            const std::string done = field->division->words;
            return done.empty() ? text : text + " Division: " + done + ".";
        }
        if (approach.division.extent == DivisionExtent::full)
            return text + " Intercostal muscle and pleura are to be divided beyond the skin.";
        if (divides_sternum(approach.division.extent))
            return text + " The sternum is to be sawn across under the skin.";
        return text;
    }

    std::string opened_text(const FieldMetrics& field)
    {
        std::string text;
        for (const std::string& sentence : verdict_of(field).sentences)
            text += (text.empty() ? "" : " ") + sentence;
        return text;
    }

    std::string seen_text(const FieldMetrics& field)
    {
        if (const std::string why = why_not_to_use(field); !why.empty())
            return why;
        std::string text = "The best eye sees " + percent(field.seen_best_eye) + " of what an eye would see of the "
            + readable(field.target) + " with the wall removed.";
        if (!field.best_eye.hidden_by.empty()) {
            const SightBlocker& most = field.best_eye.hidden_by.front();
            text += " Most is hidden by " + readable(most.name) + " (" + percent(most.share) + ").";
        }
        if (!field.estimated.empty())
            text += " Estimated, not seen in the image: " + readable(field.estimated.front())
                + (field.estimated.size() > 1 ? " and others." : ".");
        return text;
    }

    std::string reached_text(const FieldMetrics& field)
    {
        if (const std::string why = why_not_to_use(field); !why.empty())
            return why;
        return "Two instruments reach " + percent(field.reached_by_two_instruments)
            + " of what an eye could see of the " + readable(field.target) + ". " + finger_text(field);
    }

    void add_steps(std::vector<PresentationStep>& steps, const Approach& approach, std::size_t index,
        const PresentedApproach& known)
    {
        const std::string name = spoken_name(approach);
        steps.push_back({ PresentedView::incision, index, name, incision_text(approach) });
        if (known.has_slices)
            steps.push_back({ PresentedView::blade, index, name + ": what the blade passes", depth_text(approach) });
        steps.push_back({ PresentedView::cut, index, name + ": what is cut", cut_text(approach, known) });
        if (known.field == nullptr)
            return;
        steps.push_back({ PresentedView::opened, index, name + ": opened", opened_text(*known.field) });
        steps.push_back({ PresentedView::seen, index, name + ": what the surgeon sees", seen_text(*known.field) });
        steps.push_back(
            { PresentedView::reached, index, name + ": what the surgeon reaches", reached_text(*known.field) });
    }

    /// Views of the opened field only where there is one.
    void add_kept_views(std::vector<PresentationStep>& steps, const Approach& approach, std::size_t index,
        bool is_planned, const Decisions& decisions)
    {
        for (const NamedView& view : decisions.views)
            if (view.approach == approach.name && (is_planned || !view.opened))
                steps.push_back({ PresentedView::kept, index, spoken_name(approach) + ": " + view.name, {}, view });
    }

    /// What speaks against a plan most: "B: Objection. Rib 4 on the left would break from 28 mm on."
    std::string worst_of(const std::string& letter, const FieldMetrics& field)
    {
        const Verdict verdict = verdict_of(field);
        std::string text = letter + ": " + words_of(verdict.light) + ".";
        if (verdict.light != Light::clear && !verdict.sentences.empty())
            text += " " + verdict.sentences.front();
        return text;
    }

    /// @param compared index of the approach of each field
    /// @param planned indices of all planned approaches
    /// @return which approach shows most, where one leads beyond the error; what speaks against each; and what is
    /// chosen
    std::string comparison_text(const Case& planned_case, const std::vector<std::size_t>& compared,
        const std::vector<FieldMetrics>& fields, const Decisions& decisions, const std::vector<std::size_t>& planned)
    {
        std::string text = "No approach leads in what is seen by more than the error.";
        if (!have_one_target(fields))
            text = kDifferentTargets;
        else
            for (const ComparedMeasure& measure : compared_measures(fields))
                if (std::string_view(measure.metric->key) == "seen_best_eye" && measure.leader)
                    text = "The target is seen best through "
                        + spoken_name(planned_case.approaches.at(compared.at(*measure.leader))) + " ("
                        + percent(fields.at(*measure.leader).seen_best_eye) + ").";
        std::vector<std::string> others;
        for (std::size_t place = 0; place < planned.size(); ++place) {
            const auto shown = std::ranges::find(compared, planned[place]);
            if (shown == compared.end())
                others.push_back(spoken_name(planned_case.approaches[planned[place]]));
            else
                text += " "
                    + worst_of(compared_letter(place), fields[static_cast<std::size_t>(shown - compared.begin())]);
        }
        if (!others.empty())
            text += " Not shown here: " + joined(others) + ".";
        if (decisions.choices.empty())
            return text + " Nothing is chosen yet.";
        const Choice& choice = decisions.choices.back();
        return text + " " + choice_sentence(choice, chosen_name(planned_case, choice));
    }

} // namespace

std::vector<PresentationStep> presentation_of(
    const Case& planned_case, const std::vector<PresentedApproach>& known, const Decisions& decisions)
{
    RETRACTOR_ASSERT(known.size() == planned_case.approaches.size());
    std::vector<PresentationStep> steps;
    std::vector<std::size_t> planned;
    for (std::size_t index = 0; index < known.size(); ++index) {
        add_steps(steps, planned_case.approaches[index], index, known[index]);
        add_kept_views(steps, planned_case.approaches[index], index, known[index].field != nullptr, decisions);
        if (known[index].field != nullptr)
            planned.push_back(index);
    }
    if (planned.size() >= kLeastCompared) {
        const std::vector<std::size_t> compared = compared_approaches(planned_case, planned, decisions);
        std::vector<FieldMetrics> fields;
        for (const std::size_t index : compared)
            fields.push_back(*known[index].field);
        steps.push_back({ .view = PresentedView::comparison,
            .title = "Comparison",
            .text = comparison_text(planned_case, compared, fields, decisions, planned),
            .compared = compared });
    }
    if (steps.empty())
        steps.push_back({ PresentedView::patient, std::nullopt, "The patient", "There is no approach yet." });
    return steps;
}

} // namespace retractor::planner
