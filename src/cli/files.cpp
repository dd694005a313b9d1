#include <sys/stat.h>

#include "src/cli/commands.h"

namespace overtet {

Result<TetFormat> output_format(const std::string& path, const std::string& named, Terminal& terminal) {
  const Result<TetFormat> by_ending = tet_format_of(path);
  if (named.empty()) {
    if (!by_ending && path == "-")
      return Error{ErrorCode::usage, "Name the format of what goes to standard output: --format."};
    return by_ending;
  }
  const Result<TetFormat> format = tet_format_named(named);
  const auto is_gmsh = [](TetFormat f) { return f == TetFormat::gmsh22 || f == TetFormat::gmsh41; };
  if (format && by_ending && format.value() != by_ending.value() &&
      !(is_gmsh(format.value()) && is_gmsh(by_ending.value())))
    terminal.say(path + " is written as " + named + ", as --format says, and not as its ending does.");
  return format;
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat x, y;
  if (a.empty() || b.empty() || a == "-" || b == "-") return false;
  if (a == b) return true;
  return ::stat(a.c_str(), &x) == 0 && ::stat(b.c_str(), &y) == 0 && S_ISREG(x.st_mode) &&
         x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

Status check_names(const std::string& input, const std::string& output, const std::string& report) {
  if (same_file(input, output) || same_file(input, report))
    return Error{ErrorCode::usage,
                 "The output or the report would overwrite the input; choose another name."};
  if (same_file(output, report))
    return Error{ErrorCode::usage,
                 "The output and the report have the same name; choose another for one of them."};
  return success();
}

Status OutputAndReport::open(const std::string& output_path, const std::string& report_path) {
  if (Status s = output.open(output_path); !s) return s;
  return report_path.empty() ? success() : report.open(report_path);
}

}  // namespace overtet
