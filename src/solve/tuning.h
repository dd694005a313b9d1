// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Unknowns of a field from which on multigrid solves faster than a factor (perf/README.md).
constexpr std::ptrdiff_t kMultigridUnknowns = 500;

// Time of the heat method, in squares of the mean edge length, below which heat falls so much along an edge
// that linear elements lose its direction: at a quarter, distances on graded meshes of 10^5 to 10^6 tets were
// wrong.
constexpr double kLeastSmoothing = 0.5;

// Interior point method: the share of the way to the border that a step goes, as it must not arrive there;
// most steps (20 to 40 are usual); and the gaps, parts of the energy, at which the active set method has a
// try. At 1e-12 it mostly succeeds, on 31,000 tets in the least time of several choices; the second gap is
// what doubles allow.
constexpr double kInteriorShare = 0.995;
constexpr int kInteriorSteps = 80;
constexpr double kInteriorGaps[] = {1e-12, 1e-14};

// Active set method: steps without a new low of the unknowns at fault, after which it goes round in circles;
// and what an unknown, or its multiplier scaled as the unknown, may be beyond a bound and not be at fault:
// weights are numbers of order 1.
constexpr int kActiveSetChances = 8;
constexpr double kFault = 1e-10;

// How far a point may be outside a tet, in barycentric coordinates, and count as inside: roundings of the
// coordinates, of tets that are not too flat.
constexpr double kInTet = 1e-9;
// Barycentric coordinate from which on a corner is held by what goes through its tet: more than kInTet can
// make of a tet that is only touched.
constexpr double kHeldCorner = 1e-6;

// Of the way on which the first tet becomes flat, the part that is gone at most: what is left is room for the
// next step, which is limited in the same way.
constexpr double kWayToFlat = 0.9;

// Parts that a frame of an elastic body is cut into at most, doubled each time: what a 64th of a frame does
// not bring about, a smaller part seldom does.
constexpr int kMostFrameParts = 64;

// Pairs of steps and changes of the gradient that L-BFGS remembers [Liu, Bouaziz, Kavan 2017 take 5].
constexpr int kRemembered = 5;

}  // namespace overtet
