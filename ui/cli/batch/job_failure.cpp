#include "ui/cli/batch/job_failure.h"

#include "mesh/base/text_format.h"

namespace retractor::ui::cli {

JobFailure failure_in(const Json& printed, int exit_code)
{
    constexpr int kBadInput = 2;
    if (printed.contains("error")) {
        const std::string where = printed.value("where", std::string());
        return { printed["error"].get<std::string>() + (where.empty() ? "" : " (" + where + ")"),
            exit_code == kBadInput };
    }
    if (printed.contains("refused") && !printed["refused"].empty())
        return { printed["refused"][0].value("message", std::string()) };
    for (const Json& approach : printed.value("approaches", Json::array())) {
        const Json verdict = approach.value("verdict", Json::object());
        if (verdict.value("light", std::string()) == "unknown")
            return { verdict["sentences"][0].get<std::string>() };
        if (approach.contains("second_opinion") && approach["second_opinion"].value("status", "") != "agrees")
            return { "the second opinion does not agree" };
    }
    return { "exit code " + std::to_string(exit_code), false };
}

JobFailure failure_of(const ProgramRun& run, double limit_s)
{
    if (run.timed_out)
        return { "took longer than " + in_words(limit_s) + " s" };
    const Json printed = Json::parse(run.out, nullptr, false);
    if (!printed.is_object())
        return { "the program ended without an answer: it crashed, was killed or had no memory", false };
    return failure_in(printed, run.exit_code);
}

} // namespace retractor::ui::cli
