// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstdint>

namespace overtet {

// Points in a leaf of the tree: to look at so many is cheaper than to go down further.
constexpr std::int64_t kPointsPerLeaf = 8;

}  // namespace overtet
