// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// Tolerances of the arrangement, relative to the largest coordinate, tried one after the other where exact
// cuts lead nowhere; where parts of the surface nearly coincide, the first of them before exact cuts. The
// smallest leaves room for rounding, the largest is still far below what anyone can have modelled.
constexpr double kTolerances[] = {0x1p-40, 0x1p-32, 0x1p-24};
constexpr std::ptrdiff_t kCoincidentFirst = 2;
// Sine of the angle below which faces nearly lie in one plane, and of the least dihedral angle of a flat tet.
constexpr double kFlat = 1e-6;

// --- The search for a gluing (sheets.cpp, sheet_search.cpp) ---

// Rings of faces around the wound edges given within which others may be wound, before all may.
constexpr int kFreeRings[] = {1, 6};
// Steps before a search, or conflicts before a formula, counts as unsolved; natural inputs need about one a
// region.
constexpr std::int64_t kMostNodes = 2'000'000;
// Gluings held against the fans before it does, too; natural inputs need about ten a region. Where the solid
// covers itself nine times a single step may need millions.
constexpr std::int64_t kMostGluingLooks = 20'000'000;
// Regions with more gluings than this (windings beyond 4) have none listed beforehand: those that can be
// right are made from the gluings around them.
constexpr double kMostListed = 150;
// Where that must do, and nothing around is known, beyond this number the search gives up. No more are made
// from what is around.
constexpr double kMostOptions = 50'000;
// To make a gluing takes about as long as to look at so many.
constexpr std::int64_t kLooksToMake = 20;
// No gluings are made at fans where sheets have more extra turns than this.
constexpr int kMostTurnsMade = 2;
// Of all steps, the first attempt at some regions takes so many, and so many a region. So many conflicts,
// too, before an edge stays wound that perhaps need not be.
constexpr std::int64_t kFirstNodes = 1000, kFirstNodesEach = 10;
// Where options have to be made each step takes much longer: so many a region, and a few attempts.
constexpr std::int64_t kMostNodesMade = 3;
// Copies at a vertex whose pairings are all gone through: their number is the factorial.
constexpr std::size_t kMostOpen = 6;

// --- The gluing as a formula (gluing_formula.cpp) ---

// Literals in all its clauses, some 50 bytes each in the solver: 2.6 GB. Random growth of 160 to 390 faces
// with windings of 7 to 10 has 3 million to more than this.
constexpr std::int64_t kMostLiterals = 50'000'000;

// --- Boundary recovery (boundary_recovery.cpp) ---

// A point is asked to move at most this share of the way to the other side of its star: the rest of the
// neighbourhood needs room as well.
constexpr double kReach = 0.5;
// A point that could move only a hair would stand in its neighbours' way, so it waits while they move first:
// each round asks for less clearance (relative to the size of the star), the last ones for any.
constexpr double kClearances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 0, 0, 0};
// What is left then is held fast by flat tets: better ones take their place, so many of them around a point.
constexpr int kMostFlat = 200;
// So often, at the end, all points look for more room: thin tets cost the quality pass far more.
constexpr int kSweeps = 3;
// Beyond this angle (radians) between the two faces at an edge, a point on it makes way for several.
constexpr double kWideWedge = 1.9 * 3.14159265358979323846;
// Corners closer to a slitting plane than this (sine) make the slit try another angle.
constexpr double kOffPlane = 1e-4;
// For what is left then more slits are tried: at so many sectors from each other, on both sides of the
// middle.
constexpr double kSlitStep = 0.02;

}  // namespace overtet
