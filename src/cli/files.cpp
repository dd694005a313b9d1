#include <sys/stat.h>

#include "src/cli/commands.h"

namespace overtet {

bool same_file(const std::string& a, const std::string& b) {
  struct stat x, y;
  if (a.empty() || b.empty() || a == "-" || b == "-") return false;
  if (a == b) return true;
  return ::stat(a.c_str(), &x) == 0 && ::stat(b.c_str(), &y) == 0 && S_ISREG(x.st_mode) &&
         x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

}  // namespace overtet
