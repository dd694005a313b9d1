// What can be chosen in this room, with units and reasons. Distances are relative to the largest coordinate.
#pragma once

#include <cstddef>

namespace overtet {

// Rounding new points to doubles can make pieces cross that did not, where exact points are closer than
// doubles can tell; faces that nearly coincide amplify that by the inverse of the angle between them. Then
// the pieces are cut again, and added points closer than a distance (powers of two) become one (iterated snap
// rounding). If that does not end in some rounds, the distance grows. Points nearer to an edge than the
// second of them lie on it but for rounding.
constexpr int kDistances[] = {-44, -38, -32, -26};
constexpr int kRoundsPerDistance = 6;
// More crossings than this many times those of the input: rounds make them instead of ending them.
constexpr std::size_t kMostCrossings = 4;
// A place on a segment (0 to 1) computed in doubles is within this many times the errors of the two heights
// it comes from, and of an exact one rounded to doubles (kSure).
constexpr double kPlaceError = 3;

}  // namespace overtet
