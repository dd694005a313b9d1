// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Other directions or places that are tried where a ray grazes an edge: nearly always the second one is good.
constexpr int kRayAttempts = 12;
// Of numbers around 1: determinants of three directions of length 1, and places on a segment, in doubles are
// wrong by far less.
constexpr double kSure = 1e-13;

// Exponent of two: coordinates up to this size, or down to its inverse, are taken as they are.
constexpr int kOrdinary = 64;

}  // namespace overtet
