#include "tests/support/reports.h"

#include <algorithm>
#include <filesystem>

#include "tests/support/files.h"

namespace overtet::test {

std::string wrong_with_reports(const std::vector<std::string>& files) {
  if (files.empty()) return {};
  std::string command = "/usr/bin/python3 -B " OVERTET_VALIDATE_REPORTS;
  for (const std::string& file : files) command += " '" + file + "'";
  const ShellResult r = shell(command);
  return r.exit_code == 0 ? ""
                          : "not valid (exit code " + std::to_string(r.exit_code) + "): " + r.out + r.err;
}

std::vector<std::string> reports_in(const std::string& folder) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == ".json" &&
        read_text(entry.path().string()).find("\"stages\"") != std::string::npos)
      found.push_back(entry.path().string());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace overtet::test
