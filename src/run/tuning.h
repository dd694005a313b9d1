// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>

namespace overtet {

// Bytes a second that a program can take into use at most, about: pages that the kernel clears on some
// threads.
constexpr double kFillRate = 8e9;
// Between two looks at the memory in use where that is about to be full. A look costs some 30 microseconds.
constexpr std::chrono::microseconds kShortestLook{400};

}  // namespace overtet
