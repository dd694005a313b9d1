// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>
#include <cstddef>

namespace overtet {

// Of the usable memory, for all workers together: the rest is for the batch itself and for others.
constexpr double kSharedMemory = 0.9;
// How much longer than its time limit a worker may live before it is killed: it keeps the limit itself within
// 5 %.
constexpr double kLateFactor = 1.1;
constexpr double kLateSeconds = 3;
// How long interrupted workers have to take back what they were writing: less than the two seconds that an
// interrupted batch may take.
constexpr auto kWorkerGrace = std::chrono::milliseconds(1200);
// Between two looks at the clock and at the interrupt flag, while workers run.
constexpr auto kBatchPeriod = std::chrono::milliseconds(50);
// Of what a worker prints, the end is kept, in bytes: enough for its last sentences.
constexpr std::size_t kKeptOutput = 8192;
// How often a model is tried whose worker crashed or whose file changed meanwhile.
constexpr int kMostTries = 2;
// Bytes of a file that are hashed at a time: large enough that reading costs little, small beside any cache.
constexpr std::size_t kHashBlock = 1 << 18;
// Bars of a histogram, about: enough to show a shape, few enough for numbers above them.
constexpr double kHistogramBars = 12;
// Models without a mesh in a summary's text; the tables have all.
constexpr std::size_t kShownModels = 20;

}  // namespace overtet
