#include "tests/benchmarks/bench_command.h"

int main(int argc, char** argv)
{
    return retractor::cli::run_command_line(
        { "retractor-bench", "Measure speed and quality; times are medians", retractor::cli::add_benchmarks }, argc,
        argv);
}
