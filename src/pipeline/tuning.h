// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// --- The unit box (unit_box.cpp) ---

// An exponent of two: extents that differ by more than 2^12 are scaled separately.
constexpr int kUniformUpTo = 12;

// Of a face, its height over the size of its coordinates: so flat it is by the rounding of its corners alone.
constexpr double kRoundedHeight = 4 * 0x1p-53;

// --- Routes ---

// Every part is compared with every group; beyond this number that takes longer than it saves.
constexpr std::size_t kMostParts = 20000;
// A reverse flow that takes more than this (one to a few minutes) has locked; what it has by then is judged
// as it is.
constexpr double kReverseWork = 2e7, kReverseWorkOfFace = 600;
// Of the time that is left, where there is a limit: for the way back of a flow or a repair or for moving
// less, and for a volume map.
constexpr double kHalfTime = 0.5, kMapTime = 0.8;

// --- The way by a surface nearby (nearby_surface.cpp) ---

// Work of the first pull home (src/volume_map/volume_map.h): where it is not enough, another surface may be
// nearer.
constexpr double kHastyWork = 2e7;
// How far vertices move, of the diagonal: far enough for digits, or near enough for small details. And no
// further than this share of the shortest edge.
constexpr double kNudges[] = {1e-3, 1e-4, 1e-6}, kNudgeOfEdge = 0.25;
// --- The repair route (repair_route.cpp). Moves are relative to the diagonal of the surface's box. ---

// A move as far as it takes; the way back is still to come.
constexpr double kFar = 0.6;
// Repairs that follow each other where the next stage finds more to repair, and rounds of moving less.
constexpr int kRounds = 8;
// Degrees that meshes on the way are improved to. Measured: better ones lead no nearer home, and cost a half
// more.
constexpr double kAttemptDegrees = 8;
// Rounds in turn that gain nothing.
constexpr int kIdleTooFar = 4;
// What a round may leave, of the best, to go on from.
constexpr double kWorse = 1.2;
// Times what is allowed: worth the rounds at once; and beyond which eight rounds do not come that far.
constexpr double kPromising = 3, kOutOfReach = 15;
// A round aims at so much of the largest move, where that is too far.
constexpr double kNearer = 0.7;
// Times that a surface is drawn straight back.
constexpr int kStraightBack = 2;
// Work (src/volume_map/volume_map.h) of all rounds, about 10 s on one thread; and of a tet that is made or
// improved, in the same unit.
constexpr double kRoundsWork = 2e8, kTetWork = 1000;

}  // namespace overtet
