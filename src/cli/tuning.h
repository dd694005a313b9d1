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
// How long anything may take after an interrupt, a watchdog included: what is blocked in a write to a pipe
// that is not read notices nothing, and neither does who waits for it.
constexpr auto kLastGrace = std::chrono::milliseconds(1100);
// Of the time limit, and at most: by so much a run may be late. What is left of the 5 % that the limit holds
// within is for the report, and for the system, which takes a second to take 5 GB back.
constexpr double kTimeOver = 0.015;
constexpr auto kMostTimeOver = std::chrono::milliseconds(2000);
// One part in so many of the memory limit may be in use above it: the rest is for what is taken meanwhile.
// Two such parts below it, allocations that would break it begin to fail.
constexpr std::size_t kMemoryOver = 64;
// How long saying that a limit was reached, and writing it down, may take: some milliseconds if nobody else
// wants the processor.
constexpr auto kLateTime = std::chrono::milliseconds(300);
// Between two looks whether a run is to end, and between two changes of the bar.
constexpr auto kWatchPeriod = std::chrono::milliseconds(50);

}  // namespace overtet
