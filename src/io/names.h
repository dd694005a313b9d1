// What the names of files say. Internal to src/io.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace overtet::io_detail {

inline std::string lower(std::string_view text) {
  std::string s(text);
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return std::tolower(c); });
  return s;
}

// Without folders.
inline std::string file_name(const std::string& path) {
  if (path == "-") return "standard input";
  return path.substr(path.rfind('/') + 1);
}

// Where the last extension begins, at its dot; the path's length if there is none.
inline std::size_t extension_at(std::string_view path) {
  const auto dot = path.rfind('.'), slash = path.rfind('/');
  if (dot == std::string_view::npos || (slash != std::string_view::npos && dot < slash)) return path.size();
  return dot;
}

inline bool is_gzip_name(std::string_view path) { return lower(path.substr(extension_at(path))) == ".gz"; }

// A path cut in three: what comes before the extension, the extension in lower case without its dot, and
// ".gz" as it is written there, or nothing.
struct NameParts {
  std::string stem, extension, gz;
};
inline NameParts parts_of_name(std::string_view path) {
  NameParts p;
  if (is_gzip_name(path)) {
    p.gz = path.substr(path.size() - 3);
    path.remove_suffix(3);
  }
  const std::size_t at = extension_at(path);
  p.stem = path.substr(0, at);
  if (at < path.size()) p.extension = lower(path.substr(at + 1));
  return p;
}

}  // namespace overtet::io_detail
