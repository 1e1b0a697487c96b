#pragma once
// What a team decided on a case: the approach that it chose, by whom, why and when, how surgeons answered six questions
// about the planned field, and the views that it keeps. They are kept in a file of their own beside the case file,
// because they change nothing that is planned. Names of persons are free text. A report shows the choice, and no
// answers.
//
// The questions are those of a field trial with four surgeons (Nakao et al. 2006, J Med Syst 30:371, doi
// 10.1007/s10916-006-9021-4): 1 to 5 points for 3D shape, location and quality of the simulated field, planning effect,
// crisis recognition and necessity. The sentences are ours.

#include "planner/case/case.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

inline constexpr int kLeastPoints = 1, kMostPoints = 5;

struct Question {
    const char* key; ///< in files and options
    const char* title;
    const char* sentence; ///< to agree or disagree with
};

inline constexpr std::array<Question, 6> kQuestions { {
    { "shape", "3D shape", "The three-dimensional shapes of the organs are clear." },
    { "location", "Location", "The positions of the organs and the target in the surgical field are clear." },
    { "quality", "Quality of the field", "The simulated surgical field looks as it will in the theatre." },
    { "planning", "Planning effect", "Planning with it changes or confirms the approach." },
    { "crisis", "Crisis recognition", "It shows in advance what may go wrong." },
    { "necessity", "Necessity", "Such planning is needed before operations like this one." },
} };

/// The choice of an approach.
struct Choice {
    std::string approach; ///< its name in the case
    std::string by; ///< person or team, free text
    std::string why;
    std::string when; ///< UTC, "2026-11-27T09:30:00Z"
    std::string plan {}; ///< what was known of the plan when it was chosen, in one sentence; empty: it was not planned
};

/// The answers of one person.
struct Answers {
    std::string by;
    std::string when; ///< as Choice::when
    std::array<int, kQuestions.size()> points {};
    std::string note {};
};

/// A view of an approach that the team keeps, to come back to it. Units mm, patient LPS.
struct NamedView {
    std::string name; ///< for people
    std::string approach; ///< its name in the case
    bool opened = true; ///< of the opened field, or of the patient before the cut
    Vec3 eye = Vec3::Zero(), aim = Vec3::Zero(), up = Vec3::UnitZ();
    double view_angle_deg = 30.0; ///< over the picture's height
};

/// What the presenter wants to say at a step of the conference.
struct StepNote {
    std::string step; ///< its title (PresentationStep)
    std::string text;
};

struct Decisions {
    std::vector<Choice> choices; ///< the oldest first; the last one holds
    std::vector<Answers> answers; ///< the oldest first
    std::vector<NamedView> views {}; ///< in the order in which they were kept
    std::vector<StepNote> notes {}; ///< one for each step at most
    std::vector<std::string> compared {}; ///< approaches to see side by side; see compared_approaches()
};

/// The note of a step; empty: there is none.
std::string note_of(const Decisions& decisions, const std::string& step);
/// Sets the note of a step; an empty one is taken out.
void set_note(Decisions& decisions, const std::string& step, const std::string& text);

inline constexpr std::size_t kLeastCompared = 2, kMostCompared = 4;

/// The planned approaches that stand side by side, by index: those that the team named, at most kMostCompared. Where
/// fewer than kLeastCompared of them are planned: the first ones, with the one that is chosen for the patient.
/// @param planned by index, in the order of the case
std::vector<std::size_t> compared_approaches(
    const Case& planned_case, const std::vector<std::size_t>& planned, const Decisions& decisions);

/// The name of the folder of a case, without words of the identity that the case keeps.
std::string folder_name(const Case& planned_case);

/// "case.decisions.json" beside "case.json".
std::filesystem::path decisions_file(const std::filesystem::path& case_file);
inline std::filesystem::path decisions_file(const Case& planned_case) { return decisions_file(planned_case.file()); }

/// The decisions of a file; none where there is no file.
/// @throws IoError when the file cannot be read; InputError with the JSON pointer in where() on bad JSON, unknown or
/// missing keys, wrong types and points out of range
Decisions read_decisions(const std::filesystem::path& file);

/// Writes the file in one step. @throws IoError; InputError as check_choice(), check_answers() and check_view()
void write_decisions(const std::filesystem::path& file, const Decisions& decisions);

/// @param where put before the failing key in InputError::where()
/// @throws InputError when nobody or no reason is named, or on points out of range
void check_choice(const Choice& choice, const std::string& where);
void check_answers(const Answers& answers, const std::string& where);
/// @throws InputError on no name, numbers that are not finite, or a camera from which nothing can be drawn
void check_view(const NamedView& view, const std::string& where);

/// "Chosen: left 4th space, by A. Suzuki on 2026-11-27: the shortest way." @param name of the approach, for people
std::string choice_sentence(const Choice& choice, const std::string& name);

/// The approach of a choice, for people.
std::string chosen_name(const Case& planned_case, const Choice& choice);

/// The sentence of the choice that holds; empty: nothing is chosen. @throws as read_decisions()
std::string holding_choice(const Case& planned_case);

/// The answers to one question.
struct QuestionSummary {
    std::array<int, kMostPoints> count {}; ///< of answers with 1, 2 .. 5 points
    int answers = 0;
    double mean = 0.0; ///< 0 without answers
    std::optional<int> least {}, most {};
};

/// Per question. Of several answers of one person (the same `by`) to one case the last one counts.
/// @param cases the answers of each case
std::array<QuestionSummary, kQuestions.size()> summary_of(const std::vector<std::vector<Answers>>& cases);

/// A page to print: the case, the approaches and the questions with boxes to tick. @param chosen as holding_choice()
std::string sheet_html(const Case& planned_case, const std::string& chosen);

} // namespace retractor::planner
