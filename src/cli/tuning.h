// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>
#include <cstddef>

namespace overtet {

// Of what is free, without --memory-limit: the rest is for others.
constexpr double kFreeMemory = 0.9;
// Elements of each kind in the text of `inspect`.
constexpr std::size_t kListed = 20;
// How long a run may take to notice that it was interrupted or that its memory is full.
constexpr auto kGrace = std::chrono::milliseconds(700);
// The same at the end of its time; and how long anything may take after an interrupt, a watchdog included:
// what is blocked in a write to a pipe that is not read notices nothing, and neither does who waits for it.
constexpr auto kLastGrace = std::chrono::milliseconds(1100);
// Between two looks whether a run is to end, and between two changes of the bar.
constexpr auto kWatchPeriod = std::chrono::milliseconds(50);

}  // namespace overtet
