#include "overtet/version.h"

namespace overtet {

std::string version() {
  return std::to_string(OVERTET_VERSION_MAJOR) + "." + std::to_string(OVERTET_VERSION_MINOR) + "." +
         std::to_string(OVERTET_VERSION_PATCH);
}

}  // namespace overtet
