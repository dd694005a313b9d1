// What can be chosen and several rooms share, with units and reasons.
#pragma once

#include <chrono>

namespace overtet {

// Between two looks at what another process, thread or program does, and at what is in use: nobody notices so
// short a time, and the looks cost nothing.
constexpr auto kLookPeriod = std::chrono::milliseconds(25);

// So many times in a row, or altogether where each takes long, something is tried in vain: after that it
// seldom succeeds.
constexpr int kInVain = 3;
// Rounds, steps or passes of what nearly always ends by itself after a few, so that nothing goes on for ever.
constexpr int kMostRounds = 40;
// Full looks at a surface that moves: one for so many that look only at what was found before.
constexpr int kFullLookEvery = 4;
// Of a length that is searched for: steps below this share of it make no difference that counts.
constexpr double kPrecise = 1e-3;
// Relative, and radians: far more than the rounding of a computation in doubles, far less than what anyone
// has modelled.
constexpr double kRounding = 1e-9;

// Rings of elements around a place that take part in what is done there.
constexpr int kRings = 3;

// Of the size of what is looked at: lengths below that are nothing but rounding.
constexpr double kRoundedLength = 1e-14;

}  // namespace overtet
