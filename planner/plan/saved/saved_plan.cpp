#include "planner/plan/saved/saved_plan.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "planner/case/approach_file.h"
#include "planner/case/case_io.h"
#include "planner/case/checked_bytes.h"
#include "planner/measures/provenance.h"
#include "planner/plan/saved/metrics_archive.h"

#include <cereal/archives/portable_binary.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    namespace fs = std::filesystem;

    // A change of what is stored, or of how plans are made, needs another mark.
    constexpr std::string_view kMark = "retractor plan 20\n";
    constexpr std::string_view kEnding = ".plan";

    constexpr std::string_view kProgram = "retractor " RETRACTOR_VERSION;

    std::string hexadecimal(std::uint32_t number)
    {
        std::array<char, 9> text {};
        std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(number));
        return text.data();
    }

    /// Removes the oldest plans of the approach whose plan was just written. A plan that cannot be removed stays.
    void remove_oldest(const fs::path& written)
    {
        constexpr std::size_t kSum = 8;
        const std::string name = written.filename().string();
        const std::string begin = name.substr(0, name.size() - kEnding.size() - kSum);
        const auto is_of_it = [&](const std::string& other) {
            return other.size() == name.size() && other.starts_with(begin) && other.ends_with(kEnding)
                && other.find_first_not_of("0123456789abcdef", begin.size()) == begin.size() + kSum;
        };
        std::error_code code;
        std::vector<std::pair<fs::file_time_type, fs::path>> plans;
        for (const fs::directory_entry& entry : fs::directory_iterator(written.parent_path(), code))
            if (is_of_it(entry.path().filename().string()))
                plans.emplace_back(entry.last_write_time(code), entry.path());
        std::sort(plans.rbegin(), plans.rend());
        for (std::size_t n = kKeptPlans; n < plans.size(); ++n)
            fs::remove(plans[n].second, code);
    }

    /// What a plan's pictures, tables and reports are made from.
    template <class Archive, class Field> void archive_field(Archive& archive, Field& field)
    {
        archive(field.status, field.message, field.approach, field.contact_was_lost, field.wall, field.hooks,
            field.opening.displacement, field.opening.strain, field.geometry, field.best_eye, field.exposure.cone,
            field.exposure.eyes, field.exposure.sample_points, field.exposure.sample_seen, field.remaining_wall,
            field.metrics);
    }

    std::string content_of(const fs::path& file)
    {
        std::ifstream in(file, std::ios::binary);
        std::string content(std::istreambuf_iterator<char>(in), {});
        if (in.bad() || !in.is_open())
            throw IoError("cannot be read", file.string());
        return content;
    }

} // namespace

std::string plan_inputs(const Case& planned_case, std::string_view approach)
{
    Case alone = planned_case;
    alone.approaches = { find_approach(planned_case, approach) };
    alone.approaches.front().title.clear(); // no number depends on it
    alone.patient.reset();
    alone.views = Case {}.views;
    alone.sizing = {};
    const SizingSpec& sizing = alone.approaches.front().sizing;
    // Once through a file, as the case is when it is read again: reading makes directions unit vectors.
    const std::string text = case_to_json(case_from_json(case_to_json(alone), alone.folder));
    return text + "mesh seed " + std::to_string(sizing.mesh_seed) + ", coarse beyond "
        + std::to_string(sizing.coarse_beyond_mm) + "\n" + std::string(kProgram) + "\n";
}

fs::path plan_file(const Case& planned_case, std::string_view approach)
{
    const std::string inputs = plan_inputs(planned_case, approach);
    const fs::path plain = approach_file(planned_case.file(), "plans", approach, "");
    return plain.parent_path() / (plain.filename().string() + "-" + hexadecimal(crc32(inputs)) + std::string(kEnding));
}

void save_plan(const Case& planned_case, const PlannedField& field)
{
    const std::string& name = field.approach.name;
    std::ostringstream archived(std::ios::binary);
    {
        cereal::PortableBinaryOutputArchive archive(archived);
        archive(plan_inputs(planned_case, name),
            provenance_of(planned_case, std::string(kProgram), std::chrono::system_clock::now()).date);
        archive_field(archive, field);
    }
    const fs::path file = plan_file(planned_case, name);
    std::error_code code;
    fs::create_directories(file.parent_path(), code);
    if (code)
        throw IoError("cannot be made: " + code.message(), file.parent_path().string());
    write_file_atomically(file, with_sum(kMark, archived.str()));
    remove_oldest(file);
}

std::optional<SavedPlan> read_saved_plan(const Case& planned_case, std::string_view approach)
{
    const auto has_name = [&](const Approach& one) { return one.name == approach; };
    if (std::none_of(planned_case.approaches.begin(), planned_case.approaches.end(), has_name))
        return std::nullopt;
    const fs::path file = plan_file(planned_case, approach);
    std::error_code code;
    if (!fs::exists(file, code))
        return std::nullopt;
    const std::string content = content_of(file);
    if (!content.starts_with(kMark) && content.starts_with("retractor plan "))
        return std::nullopt; // by another version
    const std::optional<std::string_view> bytes = without_sum(kMark, content);
    if (!bytes)
        throw InputError("this saved plan is damaged: plan the approach again", file.string());
    std::istringstream archived(std::string(*bytes), std::ios::binary);
    try {
        cereal::PortableBinaryInputArchive archive(archived);
        std::string inputs;
        SavedPlan saved;
        archive(inputs, saved.date);
        if (inputs != plan_inputs(planned_case, approach))
            return std::nullopt;
        archive_field(archive, saved.field);
        saved.field.approach.title = find_approach(planned_case, approach).title;
        return saved;
    } catch (const cereal::Exception& exception) {
        throw InputError(std::string("this saved plan is damaged (") + exception.what() + "): plan the approach again",
            file.string());
    }
}

} // namespace retractor::planner
