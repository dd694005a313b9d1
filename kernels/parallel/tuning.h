// Grain sizes of all loops, so that they are chosen in one place.
#pragma once

#include <cstdint>

namespace overtet {

// Indices a block of a loop has, by what one costs. A block should take 10 to 100 microseconds: well more
// than the scheduler needs, well less than threads can afford to wait for the last one. Light: a few loads,
// or a formula of some nanoseconds. Medium: a small optimisation, or a test of two triangles. Heavy: a
// search, or exact numbers. Where doubles are summed the grain is part of the result's last bits: those loops
// take the multiple that they always took.
constexpr std::int64_t kLightGrain = 4096, kMediumGrain = 256, kHeavyGrain = 32;

}  // namespace overtet
