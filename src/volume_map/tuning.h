// What can be chosen in this room, with units and reasons; VolumeMapOptions has what its users may choose.
#pragma once

#include <cstddef>

namespace overtet {

// --- Patches (patch.cpp) ---

// Of the linear model: what a step has to gain at least (Armijo).
constexpr double kArmijo = 1e-4;
// Of a step, in the search along it.
constexpr int kHalvings = 14;
// What a tet costs in a step, in entries of a factor.
constexpr double kTetCost = 100;

// --- The pull (potential.h) ---

// At the reach the pull is so much stronger than in proportion; and so much at most. It grows with this power
// of the squared distance.
constexpr double kFarPull = 10, kMostFarPull = 1e4;
constexpr int kFarPower = 8;

// --- The rounds (volume_map.cpp) ---

// Free vertices of a patch; a factor of three times as many rows takes about 10 s and 4 GB.
constexpr std::size_t kLargestPatch = 30000;
constexpr int kNewtonSteps = 4;
// Local remeshing looks at tets below this smallest dihedral sine.
constexpr double kRemeshBelow = 0.3;
// In mean edges: nearer vertices go home in one move, unless a neighbour is farther than the other.
constexpr double kSnapReach = 0.5, kHeldBack = 1;
// Radians. Angles closer to their goals than this are on the right branch (half a turn apart would be pi).
constexpr double kBranchReached = 2.5;
// Surface rings around wound edges whose angles are driven, and that are free, in the branch stage.
constexpr int kGoalRings = 1, kBranchRings = 4;
constexpr int kBranchRefinements = 2;

// --- Spreading (volume_map.cpp) ---

// The part of what is allowed that is aimed at, where that is near; the first force; rings that may move.
constexpr double kWithin = 0.95, kSpreadPull = 3;
constexpr int kSpreadRings = 8;
// It ends when, going on as in the last so many rounds, it would not come to what is allowed.
constexpr std::size_t kSpreadCourse = 8;

}  // namespace overtet
