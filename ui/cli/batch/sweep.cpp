#include "ui/cli/batch/sweep.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/case_io.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;
    using Json = nlohmann::ordered_json;

    constexpr std::array<std::string_view, 4> kKeys { "cases", "approaches", "variants", "render" };
    /// Options of retractor plan that the batch gives itself.
    constexpr std::array<std::string_view, 5> kOwnOptions { "--approach", "--out", "--render", "--json", "--threads" };

    struct Variant {
        std::string name;
        std::vector<std::string> options;
    };

    Json read_json(const fs::path& file)
    {
        std::ifstream in(file);
        if (!in)
            throw IoError("cannot read the sweep", file.string());
        const std::string text { std::istreambuf_iterator<char>(in), {} };
        Json json = Json::parse(text, nullptr, false);
        if (json.is_discarded() || !json.is_object())
            throw InputError(
                "a sweep is a JSON object with the keys cases, approaches, variants and render", file.string());
        return json;
    }

    std::vector<std::string> texts(const Json& json, const std::string& where)
    {
        if (!json.is_array())
            throw InputError("a list of texts is expected", where);
        std::vector<std::string> list;
        for (std::size_t n = 0; n < json.size(); ++n) {
            if (!json[n].is_string() || json[n].get<std::string>().empty())
                throw InputError("a text is expected", where + "/" + std::to_string(n));
            list.push_back(json[n].get<std::string>());
        }
        return list;
    }

    std::vector<Variant> variants_of(const Json& json, const std::string& file)
    {
        if (!json.contains("variants"))
            return { {} };
        const std::string where = file + "#/variants";
        if (!json["variants"].is_object() || json["variants"].empty())
            throw InputError("an object with one list of options per variant is expected", where);
        std::vector<Variant> variants;
        for (const auto& [name, options] : json["variants"].items()) {
            variants.push_back({ .name = name, .options = texts(options, where + "/" + name) });
            for (const std::string& option : variants.back().options)
                if (std::ranges::find(kOwnOptions, std::string_view(option).substr(0, option.find('=')))
                    != kOwnOptions.end())
                    throw InputError("the batch itself gives the option " + option, where + "/" + name);
        }
        return variants;
    }

    bool renders(const Json& json, const std::string& file)
    {
        if (!json.contains("render"))
            return true;
        if (!json["render"].is_boolean())
            throw InputError("true or false is expected", file + "#/render");
        return json["render"].get<bool>();
    }

    /// A name that any file system takes.
    std::string file_name(std::string text)
    {
        for (char& c : text)
            if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != '.')
                c = '_';
        return text;
    }

    /// "patient7" for ".../patient7/case.json", with as many folders before it as tell the cases apart.
    std::vector<std::string> case_names(const std::vector<fs::path>& files)
    {
        const auto name_of = [](const fs::path& file, int folders) {
            fs::path at = file.filename() == planner::kCaseFileName ? file.parent_path() : file;
            std::string name = at.filename() == file.filename() ? at.stem().string() : at.filename().string();
            for (int n = 0; n < folders && at.has_relative_path(); ++n) {
                at = at.parent_path();
                name = at.filename().string() + "_" + name;
            }
            return name;
        };
        constexpr int kMostFolders = 20;
        std::vector<std::string> names;
        for (const fs::path& file : files) {
            int folders = 0;
            while (folders < kMostFolders && std::ranges::any_of(files, [&](const fs::path& other) {
                return other != file && name_of(other, folders) == name_of(file, folders);
            }))
                ++folders;
            names.push_back(name_of(file, folders));
        }
        return names;
    }

    /// A case with the place of its file.
    planner::Case read_named_case(const fs::path& path, const std::string& text, const std::string& where)
    {
        try {
            return planner::read_case(path);
        } catch (const Error& error) {
            throw InputError(
                text + ": " + error.what() + (error.where().empty() ? "" : " (" + error.where() + ")"), where);
        }
    }

} // namespace

std::vector<BatchJob> read_sweep(const fs::path& file)
{
    const Json json = read_json(file);
    for (const auto& [key, value] : json.items())
        if (std::ranges::find(kKeys, key) == kKeys.end())
            throw InputError(
                "unknown key; the keys are cases, approaches, variants and render", file.string() + "#/" + key);
    if (!json.contains("cases"))
        throw InputError("the sweep names no case", file.string() + "#/cases");
    const std::vector<std::string> cases = texts(json["cases"], file.string() + "#/cases");
    std::vector<std::string> asked;
    if (json.contains("approaches"))
        asked = texts(json["approaches"], file.string() + "#/approaches");
    if (json.contains("approaches") && asked.empty())
        throw InputError("name an approach, or leave the key out for all of them", file.string() + "#/approaches");
    std::vector<Variant> variants = variants_of(json, file.string());
    if (renders(json, file.string()))
        for (Variant& variant : variants)
            variant.options.emplace_back("--render");
    std::vector<planner::Case> opened;
    std::vector<fs::path> files;
    for (std::size_t n = 0; n < cases.size(); ++n) {
        const fs::path path = fs::absolute(file.parent_path() / cases[n]).lexically_normal();
        opened.push_back(read_named_case(path, cases[n], file.string() + "#/cases/" + std::to_string(n)));
        files.push_back(opened.back().file());
    }
    const std::vector<std::string> case_of = case_names(files);
    std::vector<BatchJob> jobs;
    std::set<std::string> names;
    for (std::size_t n = 0; n < cases.size(); ++n) {
        std::vector<std::string> approaches = asked;
        for (const std::string& name : asked)
            try {
                static_cast<void>(planner::find_approach(opened[n], name));
            } catch (const InputError& error) {
                throw InputError(cases[n] + ": " + error.what(), file.string() + "#/cases/" + std::to_string(n));
            }
        if (asked.empty())
            for (const planner::Approach& approach : opened[n].approaches)
                approaches.push_back(approach.name);
        for (const std::string& approach : approaches)
            for (const Variant& variant : variants) {
                const std::string name = file_name(
                    case_of[n] + "-" + approach + (variant.name.empty() ? std::string() : "-" + variant.name));
                if (!names.insert(name).second)
                    throw InputError("two jobs would have the name " + name, file.string());
                jobs.push_back({ .name = name,
                    .case_file = files[n],
                    .approach = approach,
                    .variant = variant.name,
                    .options = variant.options });
            }
    }
    if (jobs.empty())
        throw InputError("the sweep has no job: its cases have no approach", file.string());
    return jobs;
}

} // namespace retractor::ui::cli
