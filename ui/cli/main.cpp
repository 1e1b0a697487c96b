#include "ui/cli/command.h"

int main(int argc, char** argv) { return retractor::cli::run_command_line(argc, argv); }
