// What can be chosen in this room, with units and reasons; ImproveOptions has what its users may choose.
// Qualities are smallest dihedral sines.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "src/mesh/tuning.h"

namespace overtet {

// Vertices with more tets than this do not spread a layer of what is around a place.
constexpr int kLargestStar = 80;

// --- Parts (improve.cpp) ---

// A mesh that is cut at all is cut for the passes into so many parts at least: what they cost is known only
// afterwards, and a thread that is done early finds another one.
constexpr int kLeastParts = 8;
// Refinement makes do with two: where nothing is inside yet, tets reach from one side to the other, and what
// more cuts leave in between costs more than they save.
constexpr int kRefineParts = 2;
// Where more than this share of the tets is bad, cuts leave too much undone: fewer, larger parts then.
constexpr double kMostlyBad = 0.5;
// Tets in a part, at least: in a round around cuts, and in a look.
constexpr std::int64_t kTetsAroundCuts = 3000, kTetsPerLook = 500;
// What a tet that has to be worked on costs, in tets that have not.
constexpr int kBadTetWeight = 15, kBadToRefineWeight = 10;
// Cuts may be so far from where they give even parts, as a share of the whole. Of two parts one thread waits
// for the other.
constexpr double kSlack = 0.15, kSlackForTwo = 0.03;
// Nothing is cut where parts that hang together differ by less than this factor.
constexpr double kUneven = 1.3;
// Layers of tets around a place that is looked at.
constexpr int kLayers = 2;
// The next round around cuts is the last one when it has more than this part of the tets of the one before.
constexpr double kShrinks = 0.75;

// --- Refinement (refine.cpp) ---

// A pass that inserts fewer vertices than one for so many tets is the last one.
constexpr std::int64_t kTetsPerVertex = 2000;
// Refinement may at most multiply the tets by this.
constexpr std::int64_t kRefinedGrowth = 5;
// Below this quality (3 degrees) vertices inside are taken out where that helps.
constexpr double kLooseQuality = 0.05;

// --- Coarsening (coarsen.cpp) ---

// A pass in which fewer vertices go than one of so many is the last one.
constexpr std::int64_t kVerticesPerGone = 200;
// Tets for each vertex of the surface, beyond which the mesh is overfull. Measured: 3 to 14 in the meshes of
// scans, characters and CAD models, 200 to 1400 where windings of 5 to 10 come from a few hundred faces.
constexpr std::int64_t kOverfull = 40;
// A smallest dihedral sine. Tets that come of thinning out may be this thin, where the old ones were not
// worse: the fewer vertices are left, the more room the passes have. Measured: .05 leaves twice as many tets,
// and four times as many bad ones.
constexpr double kThinnedQuality = 1e-3;

// --- Passes (passes.cpp) ---

// A pass that leaves more than this part of the bad tets calls for stronger means.
constexpr double kSlow = 0.9;
// Qualities below this are hopeless for a while: thin layers grow by a factor per pass, they get more passes.
constexpr double kThin = 1e-2;
// A pass that leaves nearly all bad tets, with fewer collapses and insertions than one for so many bad tets,
// was in vain.
constexpr std::int64_t kIdlePart = 10;
// Factors. Smoothing and looks (below), and insertions, that gain less cost more time and tets than they are
// worth.
constexpr double kPays = 1.05, kInsertionPays = 1.2;

// --- Looks (improve.cpp) ---

// Tets below this part of the target angle are looked at once more after the cuts, with all that is around
// them. Those within a factor of the very worst are after that, by all means, as long as that lifts it by
// another factor.
constexpr double kLookAgain = 0.5;
constexpr double kWorstOfAll = 1.5;

// --- Trades (improve.cpp, trade.cpp) ---

// Where too many tets are bad, some may fall to this part of what is good. Then those below another part are
// raised again, as far as that makes hardly any others bad: that much more they cost.
constexpr double kMayFallTo = 0.47, kRaiseTo = 0.63, kSteep = 5;
// All this leaves about half of the bad tets. Where there are so many times too many, it is not tried; where
// it leaves too many, nothing has been gained by giving some up: it is not done then.
constexpr double kHopeless = 2.5;
// Of the goal, so that rounding does not matter; and of the share, as percentiles are interpolated.
constexpr double kABitMore = 1.0005, kABitLess = 0.998;
// A pass that changes fewer than one in so many bad tets is the last one.
constexpr std::int64_t kTetsPerChange = 50;

// --- Sizes (sizes.cpp, improve.cpp) ---

// The volume of a tet where edges are limited to 1, as a rule: they are about .7 long then.
constexpr double kUsualVolume = 0.035;
// A tet counts as so many when the mesh is cut, at most: one that spans the model must not be a part of its
// own.
constexpr int kMostWeight = 100000;
// More tets than this are not made: their corners' places would overflow.
constexpr double kMostTets = 4e8;
// A round may multiply a part's tets by this: its cuts stay as coarse as they are.
constexpr std::int64_t kGrowthOfRound = 4;

// --- Distinct points (set_apart.cpp) ---

// Of the mean length of a vertex's edges: nearer to another vertex it must not be. Programs that merge points
// do so within 1e-8 of the whole, or less.
constexpr double kApart = 1e-6;
// How far a vertex steps aside, of the same: the first that keeps its tets. The first one is the largest.
constexpr double kAside[] = {1e-3, 1e-4, 1e-5, 2e-6};
// Of the quality of its worst tet: more than this is kept where it can be.
constexpr double kHairWorse = 0.999;

// --- The worst places (worst_places.cpp) ---

// Tets within this factor of the worst are mended with it.
constexpr double kNearWorst = 2;
// Layers around one of the worst tets that are taken out of the mesh with it.
constexpr int kRegionLayers = 5;
// Layers around a tet that is worked on: with more of them where it resists with fewer.
constexpr int kPatchLayers[] = {2, 4};
// A patch is done with when all of its tets are better than its worst tet was by this factor; it has got
// better when its worst tet has by that one.
constexpr double kGoal = 1.3, kBetter = 1.01;
// A change for the worse may leave tets down to this part of the worst one's quality.
constexpr double kChangeMayFallTo = 0.2;
// How far towards the middle of its neighbours the vertex of a star that is built anew goes.
constexpr double kTowardsMiddle[] = {0, 0.5, 1, 1.5};
// What may be tried in a mesh with so many tets.
struct Budget {
  std::int64_t at_first, tets_per_more, most = std::numeric_limits<std::int64_t>::max();

  constexpr std::int64_t of(std::int64_t tets) const {
    return std::min(most, at_first + tets / tets_per_more);
  }
};
// The worst tets that are taken out at the same time: of a mesh with very many, as many as have room in it,
// at some 3000 tets each. So a few passes over the mesh do for all.
constexpr Budget kTaken{60, 2000};
// Attempts to mend a tet in vain by the dear means; successes; and changes made on walks (below).
constexpr Budget kDear{40, 2000}, kLifts{60, 150}, kSteps{300, 300, 2000};
// Changes that are tried at the same time, and places at most, by as many threads as there are.
constexpr std::int64_t kTrials = 8;
// For one tet: tets that are mended after one change; and where no change helps, walks of several chosen at
// random, each mended.
constexpr int kTries = 60;
// Changes of a walk, and draws until one can be made.
constexpr int kWalkLength = 4, kDraws = 8;

}  // namespace overtet
