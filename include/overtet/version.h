// Which Overtet this is. The numbers are those of the headers; version() is the library's, so that a program
// can see when the two do not belong together. They follow semantic versioning; before 1.0.0 the second
// number counts changes that programs may notice.
#pragma once

#include <string>

#define OVERTET_VERSION_MAJOR 0
#define OVERTET_VERSION_MINOR 2
#define OVERTET_VERSION_PATCH 0

namespace overtet {

// Of the library that is linked, for instance "0.2.0".
std::string version();

}  // namespace overtet
