// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>
#include <cstddef>

namespace overtet {

// Of what is free, without --memory-limit: the rest is for others.
constexpr double kFreeMemory = 0.9;
// Elements of each kind in the text of `inspect`.
constexpr std::size_t kListed = 20;
// How long a run may take to notice that it is to end, and between two looks whether it is.
constexpr auto kInterruptGrace = std::chrono::milliseconds(1500);
constexpr auto kDeadlineGrace = std::chrono::milliseconds(2500);
constexpr auto kMemoryGrace = std::chrono::milliseconds(1000);
constexpr auto kWatchPeriod = std::chrono::milliseconds(50);
// How long anything may take, a watchdog included: what is blocked in a write to a pipe that is not read
// notices nothing, and neither does who waits for it.
constexpr auto kLastGrace = std::chrono::milliseconds(3000);
// Between two changes of the bar, and its cells.
constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr int kBarCells = 24;

}  // namespace overtet
