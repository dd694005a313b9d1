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
// Sine of the angle below which faces nearly lie in one plane.
constexpr double kParallel = 1e-6;

// --- The search for a gluing (sheets.cpp, sheet_search.cpp) ---

// Rounds of the search with free edges; each but the last has found edges whose parts did not agree.
constexpr int kFreeRounds = 4;
// Rings of faces around the wound edges given within which others take part first, and how many steps such a
// search may take: most take a few hundred.
constexpr int kFreeRings = 6;
constexpr std::int64_t kMostNodesNear = 50'000;
// Steps before a search counts as unsolved; natural inputs need about one a region.
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
// At an edge that may be wound all numbers of turns are tried where a region has no more gluings than the
// first of these numbers (windings of 5 and 6), else as many turns as the second one.
constexpr double kMostTurned = 6000;
constexpr int kMostTurnsMade = 2;
// Of all steps, the first attempt at some regions takes so many, and so many a region.
constexpr std::int64_t kFirstNodes = 1000, kFirstNodesEach = 10;
// Where options have to be made each step takes much longer: so many a region, and as many attempts at most.
constexpr std::int64_t kMostNodesMade = 3, kAttemptsMade = 2;
// A wound edge that other faces pierce counts like this many others: its points are hard to take off the
// boundary.
constexpr double kPiercedWeight = 50;
// Copies at a vertex whose pairings are all gone through: their number is the factorial.
constexpr std::size_t kMostOpen = 6;

// --- Boundary recovery (boundary_recovery.cpp) ---

// A point is asked to move at most this share of the way to the other side of its star: the rest of the
// neighbourhood needs room as well.
constexpr double kReach = 0.5;
// A point that could move only a hair would stand in its neighbours' way, so it waits while they move first:
// each round asks for less clearance (relative to the size of the star), the last ones for any.
constexpr double kClearances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 0, 0, 0};
// What is left then is held fast by tets flatter than this (sine of the least dihedral angle): their edges
// go, so many of them around a point, and so often.
constexpr double kFlat = 1e-6;
constexpr int kMostFlat = 200, kReconnections = 3;
// At the end all of them look for more room this many times: thin tets cost the quality pass far more.
constexpr int kSweeps = 3;
// The search for a place ends with steps of this share of the star's size, or of the clearance found.
constexpr double kLeastStep = 1e-14, kLeastGain = 1e-3;
// Beyond this angle (radians) between the two faces at an edge, a point on it makes way for several.
constexpr double kWideWedge = 1.9 * 3.14159265358979323846;
// Corners closer to a slitting plane than this (sine) make the slit try another angle.
constexpr double kOffPlane = 1e-4;
// Edges of the star of a point that are halved to make way for one slit.
constexpr int kShrinkings = 64;
// Rounds for what is left then, with the kernels' centres and more slits: on both sides of the middle, up to
// this share of a sector away from it, with corners this close to the plane (sine).
constexpr int kThoroughRounds = 4, kMoreSlits = 14;
constexpr double kWidestSlit = 0.3, kBarelyOffPlane = 1e-13;
// The way to a kernel's centre is halved down to this share where a tet would not be positive.
constexpr double kLeastShare = 1e-3;
// --- The centre of a kernel (kernel_centre.cpp), in units of the star's size ---

// A start this far inside needs no first phase; and what opens less than this is closed.
constexpr double kFarFromWalls = 1e-3, kLeastOpen = 1e-17;
// Newton steps of one maximisation, the squared decrement that ends it, the share of the way to a wall that
// one step may take, and the least length of a step.
constexpr int kNewtonSteps = 60;
constexpr double kNewtonDecrement = 1e-3, kTowardsWall = 0.95, kLeastNewtonStep = 1e-10;

// Rounds in which the surface's vertices return to their places; one is the rule.
constexpr int kHomeRounds = 16;

}  // namespace overtet
