// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Elements named in a message.
constexpr std::size_t kNamed = 4;
// Bins of cosines, 16 KiB a thread.
constexpr int kBins = 2048;

}  // namespace overtet
