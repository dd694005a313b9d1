// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Of the way on which the first tet becomes flat, the part that is gone at most: what is left is room for the
// next step, which is limited in the same way.
constexpr double kWayToFlat = 0.9;

// Parts that a frame of an elastic body is cut into at most, doubled each time: what a 64th of a frame does
// not bring about, a smaller part seldom does.
constexpr int kMostParts = 64;

// Pairs of steps and changes of the gradient that L-BFGS remembers [Liu, Bouaziz, Kavan 2017 take 5].
constexpr int kRemembered = 5;

}  // namespace overtet
