#include "tests/verification/cli/verify_command.h"

int main(int argc, char** argv)
{
    return retractor::ui::cli::run_command_line(
        { "retractor-verify",
            "Solve problems with known answers: error against run time, for each "
            "element and law; extreme cases; solvers "
            "beside each other",
            retractor::verification::add_verification },
        argc, argv);
}
