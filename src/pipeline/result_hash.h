// The hash that reports carry and that saved stages are recognised by.
#pragma once

#include <string>

#include "overtet/types.h"

namespace overtet {

// FNV-1a over the numbers of vertices and tets (faces) and their bytes, as 16 hexadecimal digits.
std::string hash_of(const TetMesh& mesh);
std::string hash_of(const Surface& surface);

}  // namespace overtet
