#pragma once
// Why a plan of a batch has no answer.

#include "ui/cli/framework/command.h"
#include "ui/cli/framework/run_program.h"

#include <string>

namespace retractor::ui::cli {

/// Why a job has no answer.
struct JobFailure {
    std::string reason;
    bool lasting = true; ///< JobStatus::lasting
};

/// From what `retractor plan` prints with --json.
JobFailure failure_in(const Json& printed, int exit_code);

/// From a program that ended. @param limit_s time that it had
JobFailure failure_of(const ProgramRun& run, double limit_s);

} // namespace retractor::ui::cli
