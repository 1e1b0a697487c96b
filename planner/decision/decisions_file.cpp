#include "planner/decision/decisions.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string_view>

namespace retractor::planner {

namespace {

    using Json = nlohmann::ordered_json;
    constexpr int kSchema = 1;

    /// Refuses a value that is not an object with these keys only. @param optional keys that may be missing
    void check_keys(const Json& json, const std::string& where, std::initializer_list<std::string_view> required,
        std::initializer_list<std::string_view> optional = {})
    {
        if (!json.is_object())
            throw InputError("an object is expected", where);
        for (const std::string_view key : required)
            if (!json.contains(key))
                throw InputError("the key is missing", where + "/" + std::string(key));
        for (const auto& [key, value] : json.items())
            if (std::ranges::find(required, std::string_view(key)) == required.end()
                && std::ranges::find(optional, std::string_view(key)) == optional.end())
                throw InputError("unknown key", where + "/" + key);
    }

    const Json& list_in(const Json& json, const std::string& where, const char* key)
    {
        if (!json.at(key).is_array())
            throw InputError("a list is expected", where + "/" + key);
        return json.at(key);
    }

    std::string text_in(const Json& json, const std::string& where, const char* key)
    {
        if (!json.contains(key))
            return {};
        if (!json.at(key).is_string())
            throw InputError("a text is expected", where + "/" + key);
        return json.at(key).get<std::string>();
    }

    Choice choice_of(const Json& json, const std::string& where)
    {
        check_keys(json, where, { "approach", "by", "why", "when" }, { "plan" });
        Choice choice { .approach = text_in(json, where, "approach"),
            .by = text_in(json, where, "by"),
            .why = text_in(json, where, "why"),
            .when = text_in(json, where, "when"),
            .plan = text_in(json, where, "plan") };
        check_choice(choice, where);
        return choice;
    }

    Answers answers_of(const Json& json, const std::string& where)
    {
        check_keys(json, where, { "by", "when", "points" }, { "note" });
        Answers answers {
            .by = text_in(json, where, "by"), .when = text_in(json, where, "when"), .note = text_in(json, where, "note")
        };
        const Json& points = json.at("points");
        const std::string place = where + "/points";
        if (!points.is_object() || points.size() != kQuestions.size())
            throw InputError("six answers are expected", place);
        for (std::size_t q = 0; q < kQuestions.size(); ++q) {
            const char* key = kQuestions.at(q).key;
            if (!points.contains(key))
                throw InputError("the key is missing", place + "/" + key);
            if (!points.at(key).is_number_integer())
                throw InputError("a whole number is expected", place + "/" + key);
            const auto given = points.at(key).get<std::int64_t>();
            if (given < kLeastPoints || given > kMostPoints)
                throw InputError(
                    "an answer has " + std::to_string(kLeastPoints) + " to " + std::to_string(kMostPoints) + " points",
                    place + "/" + key);
            answers.points.at(q) = static_cast<int>(given);
        }
        check_answers(answers, where);
        return answers;
    }

    Vec3 vector_in(const Json& json, const std::string& where, const char* key)
    {
        const Json& list = list_in(json, where, key);
        Vec3 vector = Vec3::Zero();
        for (int axis = 0; axis < 3; ++axis) {
            if (list.size() != 3 || !list.at(static_cast<std::size_t>(axis)).is_number())
                throw InputError("three numbers are expected", where + "/" + key);
            vector[axis] = list.at(static_cast<std::size_t>(axis)).get<double>();
        }
        return vector;
    }

    NamedView view_of(const Json& json, const std::string& where)
    {
        check_keys(json, where, { "name", "approach", "opened", "eye_mm", "aim_mm", "up", "view_angle_deg" });
        if (!json.at("opened").is_boolean())
            throw InputError("true or false is expected", where + "/opened");
        if (!json.at("view_angle_deg").is_number())
            throw InputError("a number is expected", where + "/view_angle_deg");
        NamedView view { .name = text_in(json, where, "name"),
            .approach = text_in(json, where, "approach"),
            .opened = json.at("opened").get<bool>(),
            .eye = vector_in(json, where, "eye_mm"),
            .aim = vector_in(json, where, "aim_mm"),
            .up = vector_in(json, where, "up"),
            .view_angle_deg = json.at("view_angle_deg").get<double>() };
        check_view(view, where);
        return view;
    }

    Json json_of(const Vec3& vector) { return { vector.x(), vector.y(), vector.z() }; }

    Json json_of(const NamedView& view)
    {
        return { { "name", view.name }, { "approach", view.approach }, { "opened", view.opened },
            { "eye_mm", json_of(view.eye) }, { "aim_mm", json_of(view.aim) }, { "up", json_of(view.up) },
            { "view_angle_deg", view.view_angle_deg } };
    }

    Json json_of(const Choice& choice)
    {
        Json json { { "approach", choice.approach }, { "by", choice.by }, { "why", choice.why },
            { "when", choice.when } };
        if (!choice.plan.empty())
            json["plan"] = choice.plan;
        return json;
    }

    Json json_of(const Answers& answers)
    {
        Json points = Json::object();
        for (std::size_t q = 0; q < kQuestions.size(); ++q)
            points[kQuestions.at(q).key] = answers.points.at(q);
        Json json { { "by", answers.by }, { "when", answers.when }, { "points", points } };
        if (!answers.note.empty())
            json["note"] = answers.note;
        return json;
    }

} // namespace

Decisions read_decisions(const std::filesystem::path& file)
{
    if (!std::filesystem::exists(file))
        return {};
    std::ifstream in(file);
    const std::string text { std::istreambuf_iterator<char>(in), {} };
    if (!in)
        throw IoError("cannot read the decisions", file.string());
    const Json json = Json::parse(text, nullptr, false);
    const std::string where = file.string() + "#";
    if (json.is_discarded())
        throw InputError("this is not JSON", file.string());
    check_keys(json, where, { "schema", "choices", "answers" }, { "views", "notes", "compared" });
    if (json.at("schema") != kSchema)
        throw InputError("another schema of decisions than " + std::to_string(kSchema), where + "/schema");
    Decisions decisions;
    for (const Json& one : list_in(json, where, "choices"))
        decisions.choices.push_back(choice_of(one, where + "/choices/" + std::to_string(decisions.choices.size())));
    for (const Json& one : list_in(json, where, "answers"))
        decisions.answers.push_back(answers_of(one, where + "/answers/" + std::to_string(decisions.answers.size())));
    if (json.contains("views"))
        for (const Json& one : list_in(json, where, "views"))
            decisions.views.push_back(view_of(one, where + "/views/" + std::to_string(decisions.views.size())));
    if (json.contains("notes"))
        for (const Json& one : list_in(json, where, "notes")) {
            const std::string place = where + "/notes/" + std::to_string(decisions.notes.size());
            check_keys(one, place, { "step", "text" });
            decisions.notes.push_back({ .step = text_in(one, place, "step"), .text = text_in(one, place, "text") });
        }
    if (json.contains("compared"))
        for (const Json& name : list_in(json, where, "compared")) {
            if (!name.is_string())
                throw InputError(
                    "a text is expected", where + "/compared/" + std::to_string(decisions.compared.size()));
            decisions.compared.push_back(name.get<std::string>());
        }
    return decisions;
}

void write_decisions(const std::filesystem::path& file, const Decisions& decisions)
{
    Json json { { "schema", kSchema }, { "choices", Json::array() }, { "answers", Json::array() } };
    for (const Choice& choice : decisions.choices) {
        check_choice(choice, "/choices/" + std::to_string(json["choices"].size()));
        json["choices"].push_back(json_of(choice));
    }
    for (const Answers& answers : decisions.answers) {
        check_answers(answers, "/answers/" + std::to_string(json["answers"].size()));
        json["answers"].push_back(json_of(answers));
    }
    if (!decisions.views.empty())
        json["views"] = Json::array();
    for (const NamedView& view : decisions.views) {
        check_view(view, "/views/" + std::to_string(json["views"].size()));
        json["views"].push_back(json_of(view));
    }
    for (const StepNote& note : decisions.notes)
        json["notes"].push_back({ { "step", note.step }, { "text", note.text } });
    if (!decisions.compared.empty())
        json["compared"] = decisions.compared;
    write_file_atomically(file, json.dump(2) + "\n");
}

} // namespace retractor::planner
