#include "ui/cli/batch/job_status.h"

#include "mesh/base/atomic_file.h"

#include <nlohmann/json.hpp>

#include <array>
#include <fstream>

namespace retractor::ui::cli {

namespace {

    using Json = nlohmann::ordered_json;
    constexpr const char* kFile = "status.json";
    constexpr std::array<JobStatus::State, 3> kStates { JobStatus::State::running, JobStatus::State::done,
        JobStatus::State::failed };

} // namespace

std::string to_string(JobStatus::State state)
{
    switch (state) {
    case JobStatus::State::running:
        return "running";
    case JobStatus::State::done:
        return "done";
    case JobStatus::State::failed:
        break;
    }
    return "failed";
}

std::optional<JobStatus> read_job_status(const std::filesystem::path& folder)
{
    std::ifstream in(folder / kFile);
    const Json json = in ? Json::parse(in, nullptr, false) : Json();
    if (!json.is_object())
        return std::nullopt;
    try {
        JobStatus status;
        const std::string word = json.at("state");
        for (const JobStatus::State state : kStates)
            if (to_string(state) == word)
                status.state = state;
        json.at("inputs").get_to(status.inputs);
        json.at("reason").get_to(status.reason);
        json.at("lasting").get_to(status.lasting);
        json.at("seconds").get_to(status.seconds);
        json.at("peak_bytes").get_to(status.peak_bytes);
        json.at("disk_bytes").get_to(status.disk_bytes);
        return status;
    } catch (const Json::exception&) { // another program's file
        return std::nullopt;
    }
}

void write_job_status(const std::filesystem::path& folder, const JobStatus& status)
{
    const Json json { { "state", to_string(status.state) }, { "inputs", status.inputs }, { "reason", status.reason },
        { "lasting", status.lasting }, { "seconds", status.seconds }, { "peak_bytes", status.peak_bytes },
        { "disk_bytes", status.disk_bytes } };
    write_file_atomically(folder / kFile, json.dump(2) + "\n");
}

} // namespace retractor::ui::cli
