// What can be chosen in this room, with units and reasons. Nothing here changes what is found.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// Pairs of nodes that threads begin with: enough to keep any number of cores busy to the end.
constexpr std::size_t kTasks = 1024;
// Elements that are worked on at a time on the stack: boxes that are made, and faces of a vertex that is
// looked at as a whole (bits of a word; of a vertex with more, pairs are tested one by one).
constexpr std::int32_t kAtATime = 32;

}  // namespace overtet
