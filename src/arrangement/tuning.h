// What can be chosen in this room, with units and reasons. Distances are relative to the largest coordinate.
#pragma once

#include <cstddef>

namespace overtet {

// Rounding new points to doubles can make pieces cross that did not, where exact points are closer than
// doubles can tell; faces that nearly coincide amplify that by the inverse of the angle between them. Then
// the pieces are cut again, and added points closer than a distance (powers of two) become one (iterated snap
// rounding). If that does not end in some rounds, the distance grows.
constexpr int kDistances[] = {-44, -38, -32, -26};
constexpr int kRoundsPerDistance = 6;
// Points nearer to an edge than this lie on it but for rounding.
constexpr double kOnEdge = 0x1p-40;
// More crossings than this many times those of the input: rounds make them instead of ending them.
constexpr std::size_t kMostCrossings = 4;
// Rounds of cutting with a tolerance: two or three are the rule. After some, each must cut fewer pieces than
// the one before, or features of the tolerance's own size breed ever more of them.
constexpr int kTolerantRounds = 16, kSettlingRounds = 4;
// A place on a segment (0 to 1) computed in doubles is within this many times the errors of the two heights
// it comes from, and of an exact one rounded to doubles this far.
constexpr double kPlaceError = 3, kPlaceRounding = 1e-15;
// Places that doubles do not tell better than this are computed in fractions at once.
constexpr double kToldApart = 1e-9;

}  // namespace overtet
