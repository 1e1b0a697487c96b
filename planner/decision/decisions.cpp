#include "planner/decision/decisions.h"

#include "datasets/dicom/dicom_identity.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/report/html_text.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace retractor::planner {

namespace {

    bool is_blank(std::string_view text) { return text.find_first_not_of(" \t\r\n") == std::string_view::npos; }

} // namespace

std::string folder_name(const Case& planned_case)
{
    const std::filesystem::path folder
        = std::filesystem::absolute(planned_case.file()).lexically_normal().parent_path();
    const std::string name = folder.filename().string();
    return planned_case.patient ? datasets::without_identity(name, { *planned_case.patient }) : name;
}

std::filesystem::path decisions_file(const std::filesystem::path& case_file)
{
    std::filesystem::path file = case_file;
    return file.replace_extension(".decisions.json");
}

std::string note_of(const Decisions& decisions, const std::string& step)
{
    const auto found = std::ranges::find(decisions.notes, step, &StepNote::step);
    return found == decisions.notes.end() ? std::string() : found->text;
}

void set_note(Decisions& decisions, const std::string& step, const std::string& text)
{
    std::erase_if(decisions.notes, [&](const StepNote& note) { return note.step == step; });
    if (!text.empty())
        decisions.notes.push_back({ .step = step, .text = text });
}

std::vector<std::size_t> compared_approaches(
    const Case& planned_case, const std::vector<std::size_t>& planned, const Decisions& decisions)
{
    std::vector<std::size_t> compared;
    for (const std::size_t index : planned)
        if (std::ranges::count(decisions.compared, planned_case.approaches.at(index).name) > 0)
            compared.push_back(index);
    if (compared.size() >= kLeastCompared) {
        compared.resize(std::min(compared.size(), kMostCompared));
        return compared;
    }
    compared.assign(planned.begin(), planned.begin() + std::min<std::ptrdiff_t>(std::ssize(planned), kMostCompared));
    for (const std::size_t index : planned)
        if (!decisions.choices.empty() && planned_case.approaches.at(index).name == decisions.choices.back().approach
            && std::ranges::count(compared, index) == 0)
            compared.back() = index; // the later ones in the case
    return compared;
}

void check_choice(const Choice& choice, const std::string& where)
{
    if (is_blank(choice.approach))
        throw InputError("a choice names an approach", where + "/approach");
    if (is_blank(choice.by))
        throw InputError("a choice names who chose", where + "/by");
    if (is_blank(choice.why))
        throw InputError("a choice gives a reason", where + "/why");
}

void check_view(const NamedView& view, const std::string& where)
{
    if (view.name.empty())
        throw InputError("a kept view needs a name", where + "/name");
    const Vec3 sight = view.aim - view.eye;
    if (!view.eye.allFinite() || !view.aim.allFinite() || !(sight.norm() > 0.0))
        throw InputError("a view needs two different finite places, eye and aim", where + "/eye_mm");
    constexpr double kAlong = 1e-6; // sine of the angle between sight and up
    if (!view.up.allFinite() || !(sight.cross(view.up).norm() > kAlong * sight.norm() * view.up.norm()))
        throw InputError("up must be a direction across the line of sight", where + "/up");
    if (!(view.view_angle_deg > 0.0 && view.view_angle_deg < 180.0))
        throw InputError("the angle of a view lies between 0 and 180 degrees", where + "/view_angle_deg");
}

void check_answers(const Answers& answers, const std::string& where)
{
    if (is_blank(answers.by))
        throw InputError("answers name who gave them", where + "/by");
    for (std::size_t q = 0; q < kQuestions.size(); ++q)
        if (answers.points.at(q) < kLeastPoints || answers.points.at(q) > kMostPoints)
            throw InputError(
                formatted("%d points: an answer has %d to %d", answers.points.at(q), kLeastPoints, kMostPoints),
                where + "/points/" + kQuestions.at(q).key);
}

std::string choice_sentence(const Choice& choice, const std::string& name)
{
    const std::string day = choice.when.substr(0, choice.when.find('T'));
    const std::string why = choice.why.substr(0, choice.why.find_last_not_of(" \t\r\n") + 1);
    const bool ends = why.ends_with('.') || why.ends_with('!') || why.ends_with('?');
    return "Chosen: " + name + ", by " + choice.by + " on " + day + ": " + why + (ends ? "" : ".");
}

std::string holding_choice(const Case& planned_case)
{
    const Decisions decisions = read_decisions(decisions_file(planned_case));
    if (decisions.choices.empty())
        return {};
    const Choice& choice = decisions.choices.back();
    return choice_sentence(choice, chosen_name(planned_case, choice));
}

std::string chosen_name(const Case& planned_case, const Choice& choice)
{
    for (const Approach& approach : planned_case.approaches)
        if (approach.name == choice.approach)
            return spoken_name(approach);
    return readable(choice.approach) + " (no longer in the case)";
}

std::array<QuestionSummary, kQuestions.size()> summary_of(const std::vector<std::vector<Answers>>& cases)
{
    std::array<QuestionSummary, kQuestions.size()> summary;
    for (const std::vector<Answers>& answers : cases) {
        std::map<std::string, const Answers*> last;
        for (const Answers& one : answers)
            last[one.by] = &one;
        for (const auto& [by, one] : last)
            for (std::size_t q = 0; q < kQuestions.size(); ++q) {
                QuestionSummary& of = summary.at(q);
                const int points = one->points.at(q);
                ++of.count.at(static_cast<std::size_t>(points - kLeastPoints));
                ++of.answers;
                of.mean += points; // the sum, divided below
                of.least = std::min(of.least.value_or(points), points);
                of.most = std::max(of.most.value_or(points), points);
            }
    }
    for (QuestionSummary& of : summary)
        if (of.answers > 0)
            of.mean /= of.answers;
    return summary;
}

std::string sheet_html(const Case& planned_case, const std::string& chosen)
{
    std::string page
        = "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Six questions</title><style>"
          "body { font: 16px/1.4 system-ui, \"DejaVu Sans\", sans-serif; max-width: 760px; margin: 24px auto; } "
          "table { border-collapse: collapse; width: 100%; } td, th { border: 1px solid #888; padding: 10px; "
          "text-align: left; } .points { text-align: center; width: 3.2em; font-size: 20px; } "
          ".line { border-bottom: 1px solid #888; display: inline-block; min-width: 16em; } "
          "p { margin: 14px 0; }</style></head><body><h1>Six questions on a planned surgical field</h1>";
    page += "<p>Case: " + escaped(folder_name(planned_case)) + "</p>";
    std::vector<std::string> names;
    for (const Approach& approach : planned_case.approaches)
        names.push_back(spoken_name(approach));
    page += "<p>Approaches: " + escaped(names.empty() ? "none" : joined(names)) + "</p>";
    page += "<p>Approach that I would choose: <span class=\"line\">&nbsp;</span></p>";
    if (!chosen.empty())
        page += "<p>" + escaped(chosen) + "</p>";
    page += formatted(
        "<p>Tick one box in each row: %d, I do not agree at all; %d, I agree fully.</p><table><tr><th></th>",
        kLeastPoints, kMostPoints);
    for (int points = kLeastPoints; points <= kMostPoints; ++points)
        page += formatted("<th class=\"points\">%d</th>", points);
    page += "</tr>";
    for (const Question& question : kQuestions) {
        page += "<tr><td><b>" + escaped(question.title) + ".</b> " + escaped(question.sentence) + "</td>";
        for (int points = kLeastPoints; points <= kMostPoints; ++points)
            page += "<td class=\"points\">&#9744;</td>";
        page += "</tr>";
    }
    page += "</table><p>What is missing or wrong:</p><p style=\"height: 6em; border: 1px solid #888\"></p>"
            "<p>Name: <span class=\"line\">&nbsp;</span> Date: <span class=\"line\">&nbsp;</span></p>"
            "<p>Not a medical device.</p></body></html>\n";
    return page;
}

} // namespace retractor::planner
