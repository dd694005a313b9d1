// What can be chosen in this room, with units and reasons. Nothing here changes what is found.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// Pairs of nodes that threads begin with: enough to keep any number of cores busy to the end.
constexpr std::size_t kTasks = 1024;
// Records: blocks that are counted by themselves, and below how many a range is sorted by comparison.
constexpr std::int64_t kSortGrain = 1 << 16, kRadixSort = 1 << 14;
// Boxes that are made at a time, on the stack.
constexpr std::int32_t kFillBlock = 64;
// Faces of a vertex that is looked at as a whole; with more, their pairs are tested one by one.
constexpr int kMostSectors = 32;

}  // namespace overtet
