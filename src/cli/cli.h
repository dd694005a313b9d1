// The program's command line. Data goes to the named file (inspect and verify: to standard output),
// everything else to standard error.
#pragma once

namespace overtet {

// Exit codes: 0 done, 2 usage, 3 bad input, 4 unsolved (verify: the mesh is not right), 5 infeasible, 6 time
// or memory limit, 7 I/O, 70 internal error, 130 interrupted (143 by SIGTERM, 129 by SIGHUP). Never throws.
int run_command_line(int argc, char** argv);

}  // namespace overtet
