#include "tests/benchmarks/bench_command.h"

int main(int argc, char** argv)
{
    return retractor::ui::cli::run_command_line(
        { "retractor-bench", "Measure speed and quality; times are medians", retractor::benchmarks::add_benchmarks },
        argc, argv);
}
