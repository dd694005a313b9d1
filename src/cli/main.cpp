#include "src/cli/cli.h"

int main(int argc, char** argv) { return overtet::run_command_line(argc, argv); }
