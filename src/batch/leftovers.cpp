#include "src/batch/leftovers.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <vector>

namespace overtet {

namespace {

bool all_digits(const std::string& s) {
  return !s.empty() && std::all_of(s.begin(), s.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

std::string finished_name(const std::string& name) {
  if (name.size() < 3 || name[0] != '.') return {};
  const std::size_t last = name.rfind('.');
  if (last == 0) return {};
  const std::string ending = name.substr(last + 1);
  const std::size_t before = name.rfind('.', last - 1);
  if (all_digits(ending) && before != std::string::npos && before > 0 &&
      all_digits(name.substr(before + 1, last - before - 1)))
    return name.substr(1, before - 1);
  const bool random = ending.size() == 6 && std::all_of(ending.begin(), ending.end(),
                                                        [](unsigned char c) { return std::isalnum(c) != 0; });
  return random ? name.substr(1, last - 1) : std::string();
}

void remove_leftovers(const std::string& folder, const std::set<std::string>& files) {
  namespace fs = std::filesystem;
  std::error_code code;
  std::vector<fs::path> leftovers;
  for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, code), end;
       !code && at != end; at.increment(code)) {
    const std::string finished = finished_name(at->path().filename());
    std::error_code none;
    if (!finished.empty() && at->is_regular_file(none) && files.contains(at->path().parent_path() / finished))
      leftovers.push_back(at->path());
  }
  for (const fs::path& path : leftovers) fs::remove(path, code);
}

}  // namespace overtet
